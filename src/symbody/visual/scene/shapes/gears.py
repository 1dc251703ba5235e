"""Gears and racks: wheels whose teeth mesh at every configuration that fulfils their equation.

Two wheels are looked at from the body that both joints have in common (a case, or the carrier of planets):
there their axes stand still, and radii follow from the distance of the axes and the ratio. A wheel that is in
mesh twice keeps its teeth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from symbody.model.constraints.couplings import Belt, Gear, RackPinion
from symbody.visual.scene.basis import SAME_POINT, SceneBasis
from symbody.visual.scene.fixed_shape import FixedShape, mesh_shape
from symbody.visual.scene.freedoms import are_parallel
from symbody.visual.scene.poses import RigidTransform, axes_along
from symbody.visual.scene.scene import Floats, SceneMesh
from symbody.visual.scene.shapes.belts import belt_shapes
from symbody.visual.scene.shapes.gear_profile import DEDENDUM, rack_tooth
from symbody.visual.scene.shapes.meshes import join_meshes, prism
from symbody.visual.scene.shapes.toothed_wheels import (
    ToothedWheel,
    draft_wheel,
    find_wheel,
    place_teeth,
    tooth_share,
    toothed_shapes,
)
from symbody.visual.scene.shapes.wheel_sites import WheelSite, wheel_sites

# The smaller wheel of a pair has at least so many teeth, the larger one at most.
_FEWEST, _MOST = 15, 240
# Length of the edge of pitch cones as a share of the size, where no wheel has a place of its own.
_CONE = 0.2
_ONE_POINT = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class PitchPair:
    """How two wheels touch, in the axes of the case.

    Attributes
    ----------
    radii : (float, float)
        Of the pitch circles [m].
    contacts : ((3,) array, (3,) array)
        Directions from the centres to where they touch.
    rings : (bool, bool)
        Whether a wheel has its teeth inside.
    centres : ((3,) array, (3,) array)
    apexes : (float, float)
        Heights of the tips of cones over the wheels, along their axes [m]; 0 of cylinders.
    """

    radii: tuple[float, float]
    contacts: tuple[Floats, Floats]
    rings: tuple[bool, bool]
    centres: tuple[Floats, Floats]
    apexes: tuple[float, float] = (0.0, 0.0)


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
            shapes += belt_shapes(basis, element)
    return [*shapes, *(shape for wheel in wheels for shape in toothed_shapes(wheel))]


def _with_pair(basis: SceneBasis, element: Gear, wheels: list[ToothedWheel]) -> list[ToothedWheel]:
    """Return the wheels with those of a pair that are not among them."""
    sites = wheel_sites(basis, element.coupled, (basis.numbers.number(element.offset), 0.0))
    ratio = basis.numbers.number(element.ratio)
    if sites is None or ratio == 0.0:
        return wheels
    is_parallel = are_parallel(sites[0].axis, sites[1].axis)
    pair = _cylinders(basis, sites, ratio) if is_parallel else _cones(basis, sites, ratio)
    if pair is None:
        return wheels
    drafts = [
        replace(
            draft_wheel(basis, element.name, site, pair.radii[k], count, min(pair.radii), pair.rings[k]),
            centre=site.placed.inverse().point(pair.centres[k]),
            apex=pair.apexes[k],
        )
        for k, (site, count) in enumerate(zip(sites, _numbers_of_teeth(pair), strict=True))
    ]
    present = [find_wheel(wheels, draft) for draft in drafts]
    lead = 1 if present[0] is None and present[1] is not None else 0
    follow = 1 - lead
    if present[follow] is not None:
        return wheels
    site, contact = sites[lead], pair.contacts[lead]
    leader = present[lead] or replace(drafts[lead], direction=site.placed.axes.T @ contact)
    wheel = drafts[follow]
    if is_parallel:  # in the plane of the other
        other = sites[follow]
        plane = (site.placed.point(leader.centre) - other.centre) @ site.axis
        wheel = replace(wheel, centre=other.placed.inverse().point(other.centre + plane * site.axis))
    follower = place_teeth(leader, site, contact, wheel, sites[follow], pair.contacts[follow])
    return [*(each for each in wheels if each is not leader), leader, follower]


def _cylinders(basis: SceneBasis, sites: tuple[WheelSite, WheelSite], ratio: float) -> PitchPair | None:
    """Return how wheels on parallel axes touch: outside, or the smaller inside the larger."""
    first, second = sites
    across = second.centre - first.centre
    across = across - (across @ first.axis) * first.axis
    distance = float(np.linalg.norm(across))
    turns = ratio if first.axis @ second.axis > 0.0 else -ratio
    if distance < SAME_POINT * basis.size or abs(turns - 1.0) < _ONE_POINT:
        return None
    scale = distance / abs(1.0 - turns)
    radii = (scale, scale * abs(turns))
    e = across / distance
    # Where they touch: between the centres, or beyond that of the smaller one, which is inside the other.
    contacts = (e, -e) if turns < 0.0 else (e, e) if radii[0] > radii[1] else (-e, -e)
    rings = (turns > 0.0 and radii[0] > radii[1], turns > 0.0 and radii[1] > radii[0])
    return PitchPair(radii, contacts, rings, (first.centre, second.centre))


def _cones(basis: SceneBasis, sites: tuple[WheelSite, WheelSite], ratio: float) -> PitchPair | None:
    """Return how wheels on axes that intersect touch: cones with one tip; None for axes that pass by."""
    first, second = sites
    between = np.column_stack([first.axis, -second.axis])
    places, *_ = np.linalg.lstsq(between, second.centre - first.centre, rcond=None)
    tip = first.centre + places[0] * first.axis
    if np.linalg.norm(tip - second.centre - places[1] * second.axis) > _ONE_POINT * basis.size:
        return None
    # Axes that point away from the tip; about these the wheels turn against each other.
    sense = 1.0 if places[0] <= 0.0 else -1.0
    senses = (sense, sense if ratio < 0.0 else -sense)
    d1, d2 = senses[0] * first.axis, senses[1] * second.axis
    angle = math.acos(float(np.clip(d1 @ d2, -1.0, 1.0)))
    half = math.atan2(math.sin(angle), abs(ratio) + math.cos(angle))
    other = angle - half
    if min(half, other) < 0.05 or max(half, other) > 1.5:  # a wheel would be flat, or hollow
        return None
    height = abs(float(places[0]))
    edge = height / math.cos(half) if height > SAME_POINT * basis.size else _CONE * basis.size
    normal = np.cross(d1, d2) / math.sin(angle)
    heights = (edge * math.cos(half), edge * math.cos(other))
    return PitchPair(
        (edge * math.sin(half), edge * math.sin(other)),
        (np.cross(normal, d1), -np.cross(normal, d2)),
        (False, False),
        (tip + heights[0] * d1, tip + heights[1] * d2),
        (-senses[0] * heights[0], -senses[1] * heights[1]),
    )


def _numbers_of_teeth(pair: PitchPair) -> tuple[int, int]:
    """Return numbers of teeth whose quotient is that of the radii, or near to it."""
    share = Fraction(pair.radii[1] / pair.radii[0]).limit_denominator(60) or Fraction(1, 60)
    p, q = share.numerator, share.denominator
    factor = max(1, min(-(-_FEWEST // min(p, q)), _MOST // max(p, q)))
    return factor * q, factor * p


def _with_rack(
    basis: SceneBasis, element: RackPinion, wheels: list[ToothedWheel]
) -> tuple[list[ToothedWheel], list[FixedShape]]:
    """Return the wheels with the pinion of a rack, and the rack."""
    sites = wheel_sites(basis, element.coupled, (basis.numbers.number(element.offset), 0.0))
    radius = basis.numbers.number(element.radius)
    if sites is None or radius == 0.0 or abs(sites[0].axis @ sites[1].axis) > 1e-6:
        return wheels, []
    rack, wheel = sites
    # The rim moves along the rack where the arm, the axis and the rack are a right-handed set.
    contact = math.copysign(1.0, radius) * np.cross(rack.axis, wheel.axis)
    draft = draft_wheel(basis, element.name, wheel, abs(radius), 2 * _FEWEST - 6, abs(radius))
    pinion = find_wheel(wheels, draft) or replace(draft, direction=wheel.placed.axes.T @ contact)
    share = tooth_share(pinion, wheel, contact)
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
