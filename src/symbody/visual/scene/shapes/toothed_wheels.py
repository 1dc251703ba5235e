"""Wheels with teeth, and how the teeth of one are placed by those of another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    MARK,
    FixedShape,
    fixed_shape,
    frame_along,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.poses import axis_rotation
from symbody.visual.scene.scene import Floats, SceneMesh
from symbody.visual.scene.shapes.gear_profile import gear_outline, ring_outlines
from symbody.visual.scene.shapes.meshes import cone_prism, hollow_prism, prism
from symbody.visual.scene.shapes.wheel_sites import WheelSite

# Width of wheels as a share of the smaller radius; of cones along their edge, of its length.
_WIDTH, _CONE_WIDTH = 0.3, 0.3
_FEWEST_OF_ALL: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class ToothedWheel:
    """A wheel with its teeth.

    Attributes
    ----------
    direction : (3,) array
        In the body's axes, from the centre through a tooth, or through a gap of a ring.
    apex : float
        Of a cone: the height of its tip over the wheel, along `axis`, of either sign [m]; else 0.
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
    apex: float = 0.0


def toothed_shapes(wheel: ToothedWheel) -> list[FixedShape]:
    """Return a wheel and a mark that shows how it turns."""
    where = frame_along(wheel.centre, wheel.axis, wheel.direction)
    shapes = [mesh_shape(wheel.body, wheel.element, wheel_mesh(wheel), where)]
    at = wheel.radius * (1.0 + 4.0 / wheel.teeth if wheel.is_ring else 0.7)
    size = (0.07 * wheel.radius, 0.08 * wheel.radius if wheel.apex else 1.06 * wheel.width)
    return [*shapes, fixed_shape(wheel.body, wheel.element, "cylinder", size, shift_frame(where, x=at), MARK)]


def wheel_mesh(wheel: ToothedWheel) -> SceneMesh:
    """Return the mesh of a wheel about z; a tooth, or a gap of a ring, is on the x axis."""
    if wheel.is_ring:
        return hollow_prism(*ring_outlines(wheel.radius, wheel.teeth), wheel.width)
    outline = gear_outline(wheel.radius, wheel.teeth)
    return cone_prism(outline, wheel.apex, _CONE_WIDTH) if wheel.apex else prism(outline, wheel.width)


def draft_wheel(
    basis: SceneBasis, element: str, site: WheelSite, radius: float, teeth: int, least: float,
    is_ring: bool = False,
) -> ToothedWheel:  # fmt: skip
    """Return a wheel whose teeth are not placed yet; `least` is the smaller radius of the pair."""
    back = site.placed.inverse()
    width = float(np.clip(_WIDTH * least, 1.5 * basis.rod, 5.0 * basis.rod))
    return ToothedWheel(
        site.joint, site.body, element, back.point(site.centre), back.axes @ site.axis, np.zeros(3), radius,
        teeth, width, is_ring,
    )  # fmt: skip


def find_wheel(wheels: Sequence[ToothedWheel], draft: ToothedWheel) -> ToothedWheel | None:
    """Return the wheel of the same body, axis and radius, if there is one."""
    for wheel in wheels:
        is_same = (wheel.joint, wheel.body, wheel.is_ring) == (draft.joint, draft.body, draft.is_ring)
        is_same = is_same and abs(wheel.apex - draft.apex) < 1e-6 * draft.radius
        if is_same and abs(wheel.radius - draft.radius) < 1e-6 * draft.radius:
            return wheel
    return None


def tooth_share(wheel: ToothedWheel, site: WheelSite, contact: Floats) -> float:
    """Return how far, in pitches, a direction is ahead of a tooth (or of a gap of a ring)."""
    direction = site.placed.axes @ wheel.direction
    angle = math.atan2(np.cross(direction, contact) @ site.axis, direction @ contact)
    return (angle * wheel.teeth / (2.0 * math.pi)) % 1.0


def place_teeth(
    leader: ToothedWheel, site: WheelSite, contact: Floats,
    wheel: ToothedWheel, other: WheelSite, touched: Floats,
) -> ToothedWheel:  # fmt: skip
    """Return a wheel with teeth that mesh with those of another.

    Parameters
    ----------
    contact, touched : (3,) array
        In the case's axes, from the centre of each wheel to where they touch.
    """
    share = tooth_share(leader, site, contact)
    teeth = max(_FEWEST_OF_ALL, round(leader.teeth * wheel.radius / leader.radius))
    forward, backward = np.cross(site.axis, contact), np.cross(other.axis, touched)
    sense = 1.0 if forward @ backward > 0.0 else -1.0
    # A tooth stands in a gap: half a pitch on, but for a ring, whose gaps are counted.
    offset = sense * share + (0.0 if leader.is_ring or wheel.is_ring else 0.5)
    turned = axis_rotation(other.axis, -2.0 * math.pi * offset / teeth) @ touched
    return replace(wheel, teeth=teeth, direction=other.placed.axes.T @ turned)
