"""Bodies of the model from lumps of links: mass, inertia and the frames of links and joints."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.meshes import find_mesh
from symbody.formats.urdf.file.placement import (
    HERE,
    FramePlacement,
    Numbers,
    Rows,
    apply,
    numeral,
    product,
    total,
    transpose,
)
from symbody.formats.urdf.file.robot import Robot, Shape, UrdfJoint, UrdfLink
from symbody.formats.urdf.file.structure import outward
from symbody.model.body import Body
from symbody.model.declarations.arguments import Value
from symbody.model.frame import Frame
from symbody.model.inertia import is_possible_inertia
from symbody.model.naming import GROUND
from symbody.model.shapes import BodyShape, Box, Capsule, Cylinder, Mesh, Sphere

ENTRIES = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")


@dataclass(frozen=True, slots=True)
class BodyPlan:
    """A body before its frames are placed.

    Attributes
    ----------
    name : str
        Its name, which the frame of its first link has too.
    values : mapping of parameter to value
        Of a symbolic link.
    centre : (3,) number or name
        Of mass, from the frame of the first link.
    unphysical : bool
        Whether no body has its inertia.
    """

    name: str
    values: Mapping[str, str]
    mass: Value
    centre: tuple[Constant | str, ...]
    inertia: tuple[Value, ...]
    unphysical: bool

    def frame(self, place: FramePlacement) -> Frame:
        """Return the frame at a place given from the frame of the first link."""
        at = [_difference(x, c) for x, c in zip(place.at, self.centre, strict=True)]
        return Frame(at=at, rotate=rotation(place))

    def body(self, frames: Mapping[str, Frame], shapes: Sequence[BodyShape]) -> Body:
        """Return the body."""
        moments, products = self.inertia[:3], self.inertia[3:]
        return Body(self.name, self.mass, moments, products, frames, self.unphysical, shapes)


def rotation(place: FramePlacement) -> list[tuple[str, str]]:
    """Return the turns of a placement as a frame takes them."""
    return [(letter, angle.text) for letter, angle in place.turns]


# The ground, which the root link is unless it floats.
GROUND_PLAN: Final = BodyPlan(GROUND, {}, 0, (0, 0, 0), (0,) * 6, False)


def plan_body(robot: Robot, lump: Lump, name: str, symbols: Sequence[str] | None) -> BodyPlan:
    """Return a body of a lump; `symbols` are the names of m, cx, cy, cz, Ixx .. Iyz, where they stay."""
    unphysical = not possible(lump.inertia)
    if symbols is None:
        inertia = tuple(numeral(i) for i in lump.inertia)
        return BodyPlan(name, {}, numeral(lump.mass), lump.centre, inertia, unphysical)
    link = robot.links[lump.root]
    I = in_link_axes(link)
    tensor = (I[0][0], I[1][1], I[2][2], I[0][1], I[0][2], I[1][2])
    values = (link.mass, *link.centre.at, *tensor)
    known = {symbol: numeral(value) for symbol, value in zip(symbols, values, strict=True)}
    return BodyPlan(name, known, symbols[0], tuple(symbols[1:4]), tuple(symbols[4:]), unphysical)


def symbol_names(name: str) -> list[str]:
    """Return how the parameters of a symbolic link are called."""
    return [f"{name}_{part}" for part in ("m", "cx", "cy", "cz", *ENTRIES)]


def possible(inertia: Sequence[Constant]) -> bool:
    """Return whether a body has these tensor entries."""
    numbers = [float(entry) for entry in inertia]
    return is_possible_inertia(numbers[:3], numbers[3:])


def _difference(x: Constant, c: Constant | str) -> Value:
    """Return x less a number or a parameter."""
    if isinstance(c, str):
        return f"{numeral(x)} - {c}" if x else f"-{c}"
    return numeral(total((x, -c)))


@dataclass(frozen=True, slots=True)
class Lump:
    """Links that move as one body, in axes and from the origin of the first.

    Attributes
    ----------
    places : mapping of link to FramePlacement
        Where their frames are; the first is the link nearest to the root.
    mass : number
    centre : (3,) number
        Of mass.
    inertia : (6,) number
        xx, yy, zz, xy, xz, yz about the centre of mass.
    """

    places: Mapping[str, FramePlacement]
    mass: Constant
    centre: Numbers
    inertia: tuple[Constant, ...]

    @property
    def root(self) -> str:
        """The link nearest to the robot's root."""
        return next(iter(self.places))


def lump_links(robot: Robot, apart: Collection[str]) -> tuple[list[Lump], list[UrdfJoint]]:
    """Return the lumps in outward order, and the joints between them.

    Parameters
    ----------
    apart : collection of str
        Links that stay bodies of their own, whatever holds them.
    """
    places: dict[str, dict[str, FramePlacement]] = {robot.root: {robot.root: HERE}}
    home = {robot.root: robot.root}
    between: list[UrdfJoint] = []
    for joint in outward(robot.joints.values(), robot.root):
        root = home[joint.parent]
        if joint.moves or joint.child in apart or joint.parent in apart:
            home[joint.child] = joint.child
            places[joint.child] = {joint.child: HERE}
            between.append(joint)
        else:
            home[joint.child] = root
            places[root][joint.child] = places[root][joint.parent].then(joint.origin)
    return [_lump(robot.links, group) for group in places.values()], between


def in_link_axes(link: UrdfLink) -> Rows:
    """Return the inertia of a link about its centre of mass, in the axes of its frame."""
    R = link.centre.rows
    return product(product(R, _tensor(link.inertia)), transpose(R))


def _lump(links: Mapping[str, UrdfLink], places: Mapping[str, FramePlacement]) -> Lump:
    heavy = {name: place for name, place in places.items() if links[name].mass or any(links[name].inertia)}
    mass = total(links[name].mass for name in heavy)
    centres = {name: place.then(FramePlacement(links[name].centre.at)).at for name, place in heavy.items()}
    x, y, z = (_mean([(links[name].mass, at[k]) for name, at in centres.items()], mass) for k in range(3))
    centre = (x, y, z)
    parts = []
    for name, place in heavy.items():
        R = place.rows
        parts.append(product(product(R, in_link_axes(links[name])), transpose(R)))
        parts.append(_parallel_axis_term(links[name].mass, centres[name], centre))
    entries = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return Lump(places, mass, centre, tuple(total(part[i][j] for part in parts) for i, j in entries))


def _mean(weighted: Iterable[tuple[Constant, Constant]], mass: Constant) -> Constant:
    listed = list(weighted)
    if len(listed) == 1:
        return listed[0][1]
    return total(m * x for m, x in listed) / mass if mass else 0


def _parallel_axis_term(mass: Constant, at: Numbers, centre: Numbers) -> Rows:
    """Return what a mass away from the centre adds to the inertia (parallel axis theorem)."""
    d = apply(((1, 0, 0), (0, 1, 0), (0, 0, 1)), [a - c for a, c in zip(at, centre, strict=True)])
    square = sum(x * x for x in d)
    x, y, z = (tuple(mass * ((square if i == j else 0) - d[i] * d[j]) for j in range(3)) for i in range(3))
    return ((x[0], x[1], x[2]), (y[0], y[1], y[2]), (z[0], z[1], z[2]))


def _tensor(entries: tuple[Constant, ...]) -> Rows:
    xx, yy, zz, xy, xz, yz = entries
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


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
    if rgba is None or len(rgba) != 4:
        return "", "1"
    red, green, blue, alpha = (min(1.0, max(0.0, float(share))) for share in rgba)
    digits = "".join(f"{round(255 * share):02x}" for share in (red, green, blue))
    return f"#{digits}", numeral(alpha)
