"""`FixedShape`: a solid with the body that it is fixed on, before a scene numbers its meshes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.visual.scene.poses import RigidTransform, axes_along
from symbody.visual.scene.scene import Floats, SceneMesh, Solid, SolidKind

# Colours that mean a kind of thing, not a body.
STEEL: Final = "#59616d"
RUBBER: Final = "#2b2d33"
GROUND_COLOR: Final = "#8d96a3"
MARK: Final = "#f4f4f2"
SPRING_COLOR: Final = "#3f7f4f"
# What is looked through.
GLASS: Final = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class FixedShape:
    """A solid on a body; one of kind "mesh" or "line" has its mesh with it."""

    body: str
    solid: Solid
    mesh: SceneMesh | None = None


def fixed_shape(
    body: str,
    element: str,
    kind: SolidKind,
    size: tuple[float, ...],
    where: RigidTransform,
    color: str = "",
    opacity: float = 1.0,
) -> FixedShape:
    """Return a solid at a place on a body."""
    sizes = tuple(float(edge) for edge in size)
    return FixedShape(
        body, Solid(element, kind, sizes, where.place, where.quaternion, color=color, opacity=opacity)
    )


def mesh_shape(
    body: str,
    element: str,
    mesh: SceneMesh,
    where: RigidTransform,
    color: str = "",
    opacity: float = 1.0,
) -> FixedShape:
    """Return a mesh at a place on a body."""
    solid = Solid(
        element, "mesh", (1.0, 1.0, 1.0), where.place, where.quaternion, color=color, opacity=opacity
    )
    return FixedShape(body, solid, mesh)


def rod(body: str, element: str, start: Floats, end: Floats, radius: float, color: str = "") -> FixedShape:
    """Return a capsule whose axis ends in two points of a body."""
    length = float(np.linalg.norm(end - start))
    where = frame_along(0.5 * (start + end), (end - start) / length if length else np.array([0.0, 0.0, 1.0]))
    return fixed_shape(body, element, "capsule", (radius, length), where, color)


def ball(
    body: str, element: str, at: Floats, radius: float, color: str = "", opacity: float = 1.0
) -> FixedShape:
    """Return a sphere about a point of a body."""
    return fixed_shape(body, element, "sphere", (radius,), RigidTransform(at), color, opacity)


def frame_along(at: Floats, direction: Floats, sideways: Floats | None = None) -> RigidTransform:
    """Return a frame on a body whose z axis has a direction."""
    return RigidTransform(at, axes_along(direction, sideways))


def shift_frame(where: RigidTransform, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> RigidTransform:
    """Return a frame moved along its own axes."""
    return RigidTransform(where.point(np.array([x, y, z])), where.axes)
