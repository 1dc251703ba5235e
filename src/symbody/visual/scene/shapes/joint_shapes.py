"""Marks of joints, by their axes and freedoms: hinges, guides, balls, crosses, screws, pins in slots."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from symbody.model.joint import Joint
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    GLASS,
    STEEL,
    FixedShape,
    ball,
    fixed_shape,
    frame_along,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.freedoms import JointFreedoms, are_parallel
from symbody.visual.scene.poses import RigidTransform
from symbody.visual.scene.scene import Floats
from symbody.visual.scene.shapes.meshes import helix, tube

# Sizes in radii of rods.
_HINGE, _PIN, _BALL, _RAIL = 2.0, 1.25, 2.2, 0.9
# Half the length of a guide beyond what is known of its motion, as a share of the mechanism's size.
_REACH: Final = 0.3
_MARGIN: Final = 9.0


@dataclass(frozen=True, slots=True, eq=False)
class JointSite:
    """A joint with what its marks are made from.

    Attributes
    ----------
    start, end : RigidTransform
        Its frames on their bodies.
    """

    joint: Joint
    basis: SceneBasis
    freedoms: JointFreedoms
    start: RigidTransform
    end: RigidTransform

    @property
    def rod(self) -> float:
        """The radius of rods [m]."""
        return self.basis.rod

    def on_start(self, direction: Floats, sideways: Floats | None = None) -> RigidTransform:
        """Return a frame on the start body at the joint, with z along a direction of the start frame."""
        across = None if sideways is None else self.start.axes @ sideways
        return frame_along(self.start.at, self.start.axes @ direction, across)

    def on_end(self, direction: Floats, sideways: Floats | None = None) -> RigidTransform:
        """Return a frame on the end body at the joint, with z along a direction of the end frame."""
        across = None if sideways is None else self.end.axes @ sideways
        return frame_along(self.end.at, self.end.axes @ direction, across)

    def range_of(self, number: int) -> tuple[float, float]:
        """Return the lowest and highest displacement of a guide along its slide of this number [m]."""
        name = self.joint.translation_coordinates[number]
        low, high = self.basis.travel.get(name, (self.basis.coordinates[name],) * 2)
        if self.joint.name in self.basis.doubtful and self.freedoms.slides_in == "start":
            course = self.basis.course(self.joint.start, self.joint.end) @ self.freedoms.slides[number]
            low, high = float(course.min()), float(course.max())
        margin = _MARGIN * self.rod
        if high - low < margin:
            extent = self.basis.extent(self.joint.start.body)
            margin = max(margin, min(_REACH * self.basis.size, 0.5 * extent if extent else np.inf))
        return low - margin, high + margin


def joint_shapes(basis: SceneBasis, joint: Joint) -> list[FixedShape]:
    """Return the marks of a joint on both bodies; none of a weld, and none of bodies that move freely."""
    freedoms = basis.freedoms[joint.name]
    site = JointSite(joint, basis, freedoms, basis.frames[joint.start], basis.frames[joint.end])
    if freedoms.is_screw:
        return _screw(site)
    make = _MARKS.get((freedoms.rotations, min(freedoms.translations, 2)))
    return make(site) if make is not None and freedoms.translations < 3 else []


def _hinge(site: JointSite) -> list[FixedShape]:
    """Return the pin on start and the sleeve round it on end."""
    axis = site.freedoms.axes[0]
    rod, name = site.rod, site.joint.name
    pin, sleeve = (_PIN * rod, 5.0 * rod), (_HINGE * rod, 2.6 * rod)
    return [
        fixed_shape(site.joint.start.body, name, "cylinder", pin, site.on_start(axis), STEEL),
        fixed_shape(site.joint.end.body, name, "cylinder", sleeve, site.on_end(axis)),
    ]


def _guide(site: JointSite) -> list[FixedShape]:
    """Return the rail on start and the block on end; a round bar and a sleeve if end turns about it."""
    freedoms, rod, name = site.freedoms, site.rod, site.joint.name
    if freedoms.rotations == 1 and not are_parallel(freedoms.axes[0], freedoms.slides[0]):
        return _pin_in_slot(site)
    slide = freedoms.slides[0]
    low, high = site.range_of(0)
    sideways = _direction_across(slide)
    rail = shift_frame(site.on_start(slide, sideways), z=0.5 * (low + high))
    block = site.on_end(slide, sideways)
    start, end = site.joint.start.body, site.joint.end.body
    if freedoms.rotations == 1:
        bar = (_RAIL * rod, high - low)
        return [
            fixed_shape(start, name, "cylinder", bar, rail, STEEL),
            fixed_shape(end, name, "cylinder", (_HINGE * rod, 6.0 * rod), block),
        ]
    return [
        fixed_shape(start, name, "box", (1.4 * rod, 1.4 * rod, high - low), rail, STEEL),
        fixed_shape(end, name, "box", (4.0 * rod, 4.0 * rod, 7.0 * rod), block),
    ]


def _pin_in_slot(site: JointSite) -> list[FixedShape]:
    """Return two rails on start and the pin of end between them."""
    axis, slide = site.freedoms.axes[0], site.freedoms.slides[0]
    rod, name, start = site.rod, site.joint.name, site.joint.start.body
    low, high = site.range_of(0)
    middle = shift_frame(site.on_start(slide, axis), z=0.5 * (low + high))
    edges = (2.0 * rod, 0.7 * rod, high - low)
    ends = (2.0 * rod, 4.7 * rod, 0.7 * rod)
    return [
        *(fixed_shape(start, name, "box", edges, shift_frame(middle, y=y * rod), STEEL) for y in (-2.0, 2.0)),
        *(
            fixed_shape(start, name, "box", ends, shift_frame(middle, z=z * (high - low)), STEEL)
            for z in (-0.5, 0.5)
        ),
        fixed_shape(site.joint.end.body, name, "cylinder", (1.6 * rod, 5.0 * rod), site.on_end(axis)),
    ]


def _cross(site: JointSite) -> list[FixedShape]:
    """Return the two arms of a cross, each on the body whose fork it turns in."""
    rod, name = site.rod, site.joint.name
    first, last = site.freedoms.axes[0], site.freedoms.axes[-1]
    arm = (0.9 * rod, 5.6 * rod)
    return [
        fixed_shape(site.joint.start.body, name, "cylinder", arm, site.on_start(first), STEEL),
        fixed_shape(site.joint.end.body, name, "cylinder", arm, site.on_end(last)),
        ball(site.joint.end.body, name, site.end.at, 1.5 * rod, STEEL),
    ]


def _ball_joint(site: JointSite) -> list[FixedShape]:
    """Return the ball on end and the socket round it on start."""
    rod, name = site.rod, site.joint.name
    return [
        ball(site.joint.end.body, name, site.end.at, _BALL * rod),
        ball(site.joint.start.body, name, site.start.at, 1.3 * _BALL * rod, STEEL, GLASS),
    ]


def _untwisted_or_cross(site: JointSite) -> list[FixedShape]:
    """Return a cross; of a joint that passes on a shaft's turns evenly a ball in a bell."""
    if not site.freedoms.is_untwisted:
        return _cross(site)
    axis, rod = site.freedoms.axes[0], site.rod
    bell = shift_frame(site.on_start(axis), z=-1.5 * rod)
    size = (2.4 * rod, 3.0 * rod)
    shape = fixed_shape(site.joint.start.body, site.joint.name, "cylinder", size, bell, STEEL)
    return [*_ball_joint(site), shape]


def _guided_ball(site: JointSite) -> list[FixedShape]:
    """Return a ball that slides along a bar: on the bar's body the bar, on the other the ball."""
    slide, rod, name = site.freedoms.slides[0], site.rod, site.joint.name
    low, high = site.range_of(0)
    bodies = (site.joint.start.body, site.joint.end.body)
    if site.freedoms.slides_in == "end":  # end's origin is ahead of the ball, which is on start
        low, high = -high, -low
        bar = shift_frame(site.on_end(slide), z=0.5 * (low + high))
        owner, other, at = bodies[1], bodies[0], site.start.at
    else:
        bar = shift_frame(site.on_start(slide), z=0.5 * (low + high))
        owner, other, at = bodies[0], bodies[1], site.end.at
    return [
        fixed_shape(owner, name, "cylinder", (_RAIL * rod, high - low), bar, STEEL),
        ball(other, name, at, _BALL * rod),
    ]


def _cross_slide(site: JointSite) -> list[FixedShape]:
    """Return a rail on start along one translation and one on end along the other."""
    first, second = site.freedoms.slides[:2]
    rod, name = site.rod, site.joint.name
    low, high = site.range_of(0)
    left, right = site.range_of(1)
    rail = shift_frame(site.on_start(first), z=0.5 * (low + high))
    shapes = [
        fixed_shape(site.joint.start.body, name, "box", (1.4 * rod, 1.4 * rod, high - low), rail, STEEL)
    ]
    if site.freedoms.rotations == 0:
        arm = shift_frame(site.on_end(second), z=-0.5 * (left + right))
        size = (1.4 * rod, 1.4 * rod, right - left)
        shapes.append(fixed_shape(site.joint.end.body, name, "box", size, arm, STEEL))
    return shapes


def _plane(site: JointSite) -> list[FixedShape]:
    """Return the disc of a body that slides in a plane and turns about its normal."""
    rod, name = site.rod, site.joint.name
    where = site.on_end(site.freedoms.axes[0])
    return [fixed_shape(site.joint.end.body, name, "cylinder", (_HINGE * rod, 1.2 * rod), where)]


def _screw(site: JointSite) -> list[FixedShape]:
    """Return the threaded bar on start and the nut on end."""
    axis, rod, name = site.freedoms.axes[0], site.rod, site.joint.name
    reach = 2.0 * _REACH * site.basis.size
    bar = site.on_start(axis)
    pitch = max(1.6 * rod, reach / 60.0)
    thread = tube(helix(rod, reach, pitch, 12), 0.35 * rod, sides=6)
    return [
        fixed_shape(site.joint.start.body, name, "cylinder", (rod, reach), bar, STEEL),
        mesh_shape(site.joint.start.body, name, thread, bar, STEEL),
        fixed_shape(site.joint.end.body, name, "cylinder", (2.2 * rod, 4.0 * rod), site.on_end(axis)),
    ]


def _direction_across(slide: Floats) -> Floats:
    """Return the direction of the start frame across a guide that is nearest to a main axis."""
    return np.asarray(np.eye(3)[int(np.argmin(np.abs(slide)))])


# By rotations and translations; two or three translations are one.
_MARKS: Final[Mapping[tuple[int, int], Callable[[JointSite], list[FixedShape]]]] = MappingProxyType(
    {
        (1, 0): _hinge,
        (2, 0): _untwisted_or_cross,
        (3, 0): _ball_joint,
        (0, 1): _guide,
        (1, 1): _guide,
        (3, 1): _guided_ball,
        (0, 2): _cross_slide,
        (1, 2): _plane,
    }
)
