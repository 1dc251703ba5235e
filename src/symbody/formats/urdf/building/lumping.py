"""Links that fixed joints hold together: one body, with its centre of mass and inertia."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.placement import (
    HERE,
    FramePlacement,
    Numbers,
    Rows,
    apply,
    product,
    total,
    transpose,
)
from symbody.formats.urdf.file.robot import Robot, UrdfJoint, UrdfLink
from symbody.formats.urdf.file.structure import outward


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
