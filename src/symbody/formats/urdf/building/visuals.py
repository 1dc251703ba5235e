"""Visuals of links as shapes of bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.meshes import find_mesh
from symbody.formats.urdf.file.placement import numeral
from symbody.formats.urdf.file.robot import Robot, Shape
from symbody.model.frame import Frame
from symbody.model.shapes import BodyShape, Box, Capsule, Cylinder, Mesh, Sphere

_MAKERS: Final[Mapping[str, Callable[..., BodyShape]]] = MappingProxyType(
    {"cylinder": Cylinder, "capsule": Capsule, "sphere": Sphere}
)


def visual_shape(robot: Robot, visual: Shape, frame: Frame) -> BodyShape | None:
    """Return a visual as a shape that stands where a frame does; None if it cannot be drawn."""
    sizes = [numeral(size) for size in visual.sizes]
    color, opacity = _color(visual.color)
    looks: dict[str, Any] = {"at": frame.at, "rotate": frame.rotate, "color": color, "opacity": opacity}
    if visual.kind == "mesh":
        folder = Path(robot.where).absolute().parent
        if not visual.mesh.strip() or not visual.mesh.isprintable():
            return None
        return Mesh(_path(robot, visual, folder), sizes, folder=str(folder), **looks)
    if any(size < 0 for size in visual.sizes):
        return None
    if visual.kind == "box":
        return Box(sizes, **looks)
    return _MAKERS[visual.kind](*sizes, **looks)


def _path(robot: Robot, visual: Shape, folder: Path) -> str:
    """Return where the file of a mesh is, from the robot's folder if it is below; if none, as written."""
    path = find_mesh(robot, visual)
    if path is None:
        return visual.mesh
    try:
        return path.relative_to(folder).as_posix()
    except ValueError:
        return path.as_posix()


def _color(rgba: tuple[Constant, ...] | None) -> tuple[str, str]:
    """Return a colour in hexadecimal, and its opacity."""
    if rgba is None or len(rgba) != 4:
        return "", "1"
    red, green, blue, alpha = (min(1.0, max(0.0, float(share))) for share in rgba)
    digits = "".join(f"{round(255 * share):02x}" for share in (red, green, blue))
    return f"#{digits}", numeral(alpha)
