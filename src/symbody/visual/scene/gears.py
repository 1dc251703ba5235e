"""Gears, racks and belts: wheels whose teeth mesh at every configuration that fulfils their equation.

Two wheels are looked at from the body that both joints have in common (a case, or the carrier of planets):
there their axes stand still, and radii follow from the distance and the ratio. A wheel that is in mesh twice
keeps its teeth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

import numpy as np

from symbody.model.constraints.couplings import Belt, Gear, RackPinion
from symbody.model.joint import Joint
from symbody.visual.scene.basis import SAME_POINT, SceneBasis
from symbody.visual.scene.fixed_shape import (
    MARK,
    RUBBER,
    FixedShape,
    along,
    fixed_shape,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.freedoms import are_parallel
from symbody.visual.scene.gear_profile import DEDENDUM, gear_outline, rack_tooth, ring_outlines
from symbody.visual.scene.meshes import hollow_prism, join_meshes, prism, tube
from symbody.visual.scene.poses import RigidTransform, axes_along, axis_rotation, joint_transform
from symbody.visual.scene.scene import Floats, SceneMesh

# The smaller wheel of a pair has at least so many teeth, the larger one at most.
_FEWEST, _MOST = 15, 240
_WIDTH: Final = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class WheelSite:
    """A wheel seen from the body that carries it.

    Attributes
    ----------
    body : str
        That turns, or slides.
    case : str
        From which it is seen.
    centre, axis : (3,) array
        In the case's axes; a positive angle turns about `axis`, or shifts along it.
    placed : RigidTransform
        The body in the case where the coordinate has the value of the equation.
    """

    joint: str
    body: str
    case: str
    centre: Floats
    axis: Floats
    placed: RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class ToothedWheel:
    """A wheel with its teeth.

    Attributes
    ----------
    direction : (3,) array
        In the body's axes, from the centre through a tooth, or through a gap of a ring.
    """

    joint: str
    body: str
    element: str
    centre: Floats
    axis: Floats
    direction: Floats
    radius: float
    teeth: int
    width: float
    is_ring: bool


def gear_shapes(basis: SceneBasis) -> list[FixedShape]:
    """Return all wheels, racks and belts of a model."""
    wheels: list[ToothedWheel] = []
    shapes: list[FixedShape] = []
    for element in basis.model.constraints:
        if isinstance(element, Gear):
            wheels = _with_pair(basis, element, wheels)
        elif isinstance(element, RackPinion):
            wheels, rack = _with_rack(basis, element, wheels)
            shapes += rack
        elif isinstance(element, Belt):
            shapes += _belt(basis, element)
    return [*shapes, *(shape for wheel in wheels for shape in _wheel_shapes(wheel))]


def geared_bodies(shapes: Sequence[FixedShape]) -> frozenset[str]:
    """Return the bodies that have such shapes."""
    return frozenset(shape.body for shape in shapes)


def wheel_mesh(wheel: ToothedWheel) -> SceneMesh:
    """Return the mesh of a wheel about z; a tooth, or a gap of a ring, is on the x axis."""
    if wheel.is_ring:
        return hollow_prism(*ring_outlines(wheel.radius, wheel.teeth), wheel.width)
    return prism(gear_outline(wheel.radius, wheel.teeth), wheel.width)


def _wheel_shapes(wheel: ToothedWheel) -> list[FixedShape]:
    """Return a wheel and a mark that shows how it turns."""
    where = along(wheel.centre, wheel.axis, wheel.direction)
    shapes = [mesh_shape(wheel.body, wheel.element, wheel_mesh(wheel), where)]
    at = wheel.radius * (1.0 + 4.0 / wheel.teeth if wheel.is_ring else 0.7)
    size = (0.07 * wheel.radius, 1.06 * wheel.width)
    return [*shapes, fixed_shape(wheel.body, wheel.element, "cylinder", size, shift_frame(where, x=at), MARK)]


def _with_pair(basis: SceneBasis, element: Gear, wheels: list[ToothedWheel]) -> list[ToothedWheel]:
    """Return the wheels with those of a pair that are not among them."""
    offset = basis.numbers.number(element.offset)
    sites = _sites(basis, element.coupled, (offset, 0.0))
    ratio = basis.numbers.number(element.ratio)
    if sites is None or ratio == 0.0 or not are_parallel(sites[0].axis, sites[1].axis):
        return wheels
    first, second = sites
    across = second.centre - first.centre
    across = across - (across @ first.axis) * first.axis
    distance = float(np.linalg.norm(across))
    turns = ratio if first.axis @ second.axis > 0.0 else -ratio
    if distance < SAME_POINT * basis.size or abs(turns - 1.0) < 1e-9:
        return wheels
    scale = distance / abs(1.0 - turns)
    radii = (scale, scale * abs(turns))
    e = across / distance
    # Where they touch: between the centres, or beyond that of the smaller one, which is inside the other.
    contact = (e, -e) if turns < 0.0 else (e, e) if radii[0] > radii[1] else (-e, -e)
    rings = (turns > 0.0 and radii[0] > radii[1], turns > 0.0 and radii[1] > radii[0])
    teeth = _numbers_of_teeth(abs(turns))
    drafts = [
        _draft(basis, element.name, site, radius, count, is_ring, min(radii))
        for site, radius, count, is_ring in zip(sites, radii, teeth, rings, strict=True)
    ]
    known = [_in_mesh(wheels, draft) for draft in drafts]
    if known[0] is None and known[1] is not None:
        order = (1, 0)
    else:
        order = (0, 1)
    lead, follow = order
    leader = known[lead] or replace(drafts[lead], direction=sites[lead].placed.axes.T @ contact[lead])
    if known[follow] is not None:
        return wheels
    follower = _follow(leader, sites[lead], contact[lead], drafts[follow], sites[follow], contact[follow])
    return [*(wheel for wheel in wheels if wheel is not leader), leader, follower]


def _follow(
    leader: ToothedWheel, site: WheelSite, contact: Floats,
    wheel: ToothedWheel, other: WheelSite, touched: Floats,
) -> ToothedWheel:  # fmt: skip
    """Return a wheel with teeth that mesh with those of another, and in its plane."""
    share = _tooth_share(leader, site, contact)
    teeth = max(4, round(leader.teeth * wheel.radius / leader.radius))
    is_inside = leader.is_ring or wheel.is_ring
    sense = 1.0 if site.axis @ other.axis > 0.0 else -1.0
    if is_inside:  # a tooth stands in a gap of the ring, and both move alike
        offset = sense * share
    else:
        offset = 0.5 - sense * share
    turned = axis_rotation(other.axis, -2.0 * math.pi * offset / teeth) @ touched
    plane = (site.placed.point(leader.centre) - other.centre) @ site.axis
    centre = other.placed.inverse().point(other.centre + plane * site.axis)
    return replace(wheel, teeth=teeth, direction=other.placed.axes.T @ turned, centre=centre)


def _tooth_share(wheel: ToothedWheel, site: WheelSite, contact: Floats) -> float:
    """Return how far, in pitches, a direction is ahead of a tooth (or of a gap of a ring)."""
    direction = site.placed.axes @ wheel.direction
    angle = math.atan2(np.cross(direction, contact) @ site.axis, direction @ contact)
    return (angle * wheel.teeth / (2.0 * math.pi)) % 1.0


def _draft(
    basis: SceneBasis, element: str, site: WheelSite, radius: float, teeth: int, is_ring: bool, least: float
) -> ToothedWheel:
    """Return a wheel whose teeth are not placed yet."""
    back = site.placed.inverse()
    width = float(np.clip(_WIDTH * least, 1.5 * basis.rod, 5.0 * basis.rod))
    return ToothedWheel(
        site.joint, site.body, element, back.point(site.centre), back.axes @ site.axis, np.zeros(3), radius,
        teeth, width, is_ring,
    )  # fmt: skip


def _in_mesh(wheels: Sequence[ToothedWheel], draft: ToothedWheel) -> ToothedWheel | None:
    """Return the wheel of the same body, axis and radius, if there is one."""
    for wheel in wheels:
        is_same = (wheel.joint, wheel.body, wheel.is_ring) == (draft.joint, draft.body, draft.is_ring)
        if is_same and abs(wheel.radius - draft.radius) < 1e-6 * draft.radius:
            return wheel
    return None


def _numbers_of_teeth(ratio: float) -> tuple[int, int]:
    """Return numbers of teeth whose quotient, second by first, is a ratio, or near to it."""
    share = Fraction(ratio).limit_denominator(60) or Fraction(1, 60)
    p, q = share.numerator, share.denominator
    factor = max(1, min(-(-_FEWEST // min(p, q)), _MOST // max(p, q)))
    return factor * q, factor * p


def _with_rack(
    basis: SceneBasis, element: RackPinion, wheels: list[ToothedWheel]
) -> tuple[list[ToothedWheel], list[FixedShape]]:
    """Return the wheels with the pinion of a rack, and the rack."""
    sites = _sites(basis, element.coupled, (basis.numbers.number(element.offset), 0.0))
    radius = basis.numbers.number(element.radius)
    if sites is None or radius == 0.0 or abs(sites[0].axis @ sites[1].axis) > 1e-6:
        return wheels, []
    rack, wheel = sites
    # The rim moves along the rack where the arm, the axis and the rack are a right-handed set.
    contact = math.copysign(1.0, radius) * np.cross(rack.axis, wheel.axis)
    draft = _draft(basis, element.name, wheel, abs(radius), 2 * _FEWEST - 6, False, abs(radius))
    pinion = _in_mesh(wheels, draft) or replace(draft, direction=wheel.placed.axes.T @ contact)
    share = _tooth_share(pinion, wheel, contact)
    pitch = 2.0 * math.pi * abs(radius) / pinion.teeth
    at = wheel.placed.point(pinion.centre) + abs(radius) * contact
    forward = np.cross(wheel.axis, contact)  # of the rim
    shift = (0.5 - share) * pitch
    name = element.coupled[0]
    low, high = basis.travel.get(name, (basis.coordinates[name],) * 2)
    value = basis.numbers.number(element.offset)
    margin = 3.0 * pitch if name in basis.travel else max(0.6 * math.pi * abs(radius), 0.2 * basis.size)
    first = math.floor(-(high - value + margin) / pitch)
    last = math.ceil((margin - low + value) / pitch)
    mesh = _rack_mesh(pitch, first, last, pinion.width)
    sense = 1.0 if forward @ rack.axis > 0.0 else -1.0
    where = RigidTransform(at + shift * forward, axes_along(sense * wheel.axis, rack.axis))
    if where.axes[:, 1] @ contact > 0.0:  # teeth point to the wheel
        where = RigidTransform(where.at, where.axes @ np.diag([1.0, -1.0, -1.0]))
    inside = rack.placed.inverse() @ where
    shapes = [mesh_shape(rack.body, element.name, mesh, inside)]
    return [*(each for each in wheels if each is not pinion), pinion], shapes


def _rack_mesh(pitch: float, first: int, last: int, width: float) -> SceneMesh:
    """Return a rack along x whose teeth point along y, from one tooth to another."""
    tooth = rack_tooth(pitch)
    teeth = [prism(tooth + [k * pitch, 0.0], width) for k in range(first, last + 1)]
    left, right = (first - 0.5) * pitch, (last + 0.5) * pitch
    module = pitch / math.pi
    top, bottom = -DEDENDUM * module, -3.0 * module
    bar = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    return join_meshes([*teeth, prism(bar, width)])


def _belt(basis: SceneBasis, element: Belt) -> list[FixedShape]:
    """Return two pulleys with marks, and the belt round them."""
    sites = _sites(basis, element.coupled, (0.0, 0.0))
    radii = np.abs(basis.numbers.vector(element.radii))
    if sites is None or not np.all(radii) or not are_parallel(sites[0].axis, sites[1].axis):
        return []
    width = float(np.clip(0.3 * radii.min(), 1.5 * basis.rod, 5.0 * basis.rod))
    first, second = sites
    across = second.centre - first.centre
    across = across - (across @ first.axis) * first.axis
    distance = float(np.linalg.norm(across))
    shapes: list[FixedShape] = []
    for site, radius in zip(sites, radii, strict=True):
        plane = (first.centre - site.centre) @ first.axis
        back = site.placed.inverse()
        where = along(back.point(site.centre + plane * first.axis), back.axes @ site.axis)
        shapes.append(fixed_shape(site.body, element.name, "cylinder", (radius, width), where))
        mark = shift_frame(where, x=0.7 * radius)
        size = (0.1 * radius, 1.06 * width)
        shapes.append(fixed_shape(site.body, element.name, "cylinder", size, mark, MARK))
    is_apart = distance > (radii.sum() if element.crossed else abs(radii[0] - radii[1]))
    if not is_apart:
        return shapes
    line = belt_line(radii[0] + 0.15 * width, radii[1] + 0.15 * width, distance, element.crossed)
    where = RigidTransform(first.centre, axes_along(first.axis, across))
    points = np.column_stack([line, np.zeros(len(line))])
    loop = tube(points, 0.22 * width, is_closed=True, sides=8)
    return [*shapes, mesh_shape(first.case, element.name, loop, where, RUBBER)]


def belt_line(first: float, second: float, distance: float, is_crossed: bool) -> Floats:
    """Return points (N, 2) of a belt round wheels about the origin and about (distance, 0)."""
    sense = -1.0 if is_crossed else 1.0
    angle = math.acos(float(np.clip((first - sense * second) / distance, -1.0, 1.0)))
    left = np.linspace(angle, 2.0 * math.pi - angle, 33)
    around = first * np.stack([np.cos(left), np.sin(left)], axis=1)
    if is_crossed:  # the belt passes from the lower side of one to the upper side of the other
        right = np.linspace(math.pi - angle, -math.pi + angle, 33)
    else:
        right = np.linspace(-angle, angle, 33)
    beyond = np.array([distance, 0.0]) + second * np.stack([np.cos(right), np.sin(right)], axis=1)
    return np.vstack([around, beyond])


def _sites(
    basis: SceneBasis, coordinates: Sequence[str], values: Sequence[float]
) -> tuple[WheelSite, WheelSite] | None:
    """Return what two coordinates move, seen from a body that both have in common, where they have values."""
    joints = [_joint_of(basis, name) for name in coordinates[:2]]
    if joints[0] is None or joints[1] is None:
        return None
    pairs = [
        (first, second)
        for first in (joints[0].start.body, joints[0].end.body)
        for second in (joints[1].start.body, joints[1].end.body)
        if _are_welded(basis, first, second)
    ]
    if not pairs or joints[0] is joints[1]:
        return None
    first, second = pairs[0]
    home = basis.bodies[first].inverse() @ basis.bodies[second]
    return (
        _site(basis, joints[0], first, values[0], RigidTransform(), first),
        _site(basis, joints[1], second, values[1], home, first),
    )


def _site(
    basis: SceneBasis, joint: Joint, case: str, value: float, home: RigidTransform, seen_from: str
) -> WheelSite:
    """Return what a joint moves, seen from a body that stands so in another."""
    freedoms = basis.freedoms[joint.name]
    step = joint_transform(joint, basis.numbers, dict.fromkeys(joint.coordinates, value))
    start, end = basis.frames[joint.start], basis.frames[joint.end]
    placed = start @ step @ end.inverse()
    direction = (freedoms.axes or freedoms.slides)[0]
    if joint.start.body == case:
        frame, body, axis = start, joint.end.body, direction
    else:
        frame, body, axis, placed = end, joint.start.body, -direction, placed.inverse()
    seen = home @ RigidTransform(frame.at, frame.axes)
    return WheelSite(joint.name, body, seen_from, seen.at, seen.axes @ axis, home @ placed)


def _joint_of(basis: SceneBasis, coordinate: str) -> Joint | None:
    """Return the joint of a coordinate, if it has a single freedom."""
    for joint in basis.model.joints:
        freedoms = basis.freedoms[joint.name]
        if joint.coordinates == (coordinate,) and not freedoms.is_screw:
            return joint
    return None


def _are_welded(basis: SceneBasis, first: str, second: str) -> bool:
    """Return whether two bodies never move relative to each other."""
    reached, waiting = {first}, [first]
    while waiting:
        body = waiting.pop()
        for joint in basis.model.joints:
            ends = (joint.start.body, joint.end.body)
            if not joint.coordinates and body in ends:
                other = ends[1] if ends[0] == body else ends[0]
                if other not in reached:
                    reached.add(other)
                    waiting.append(other)
    return second in reached
