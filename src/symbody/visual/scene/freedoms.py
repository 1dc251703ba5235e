"""The freedoms of a joint as directions, read off its law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.model.joint import Joint
from symbody.visual.scene.numbers import ModelNumbers, unit
from symbody.visual.scene.scene import Floats

# Unit vectors with a cross product shorter than this are parallel.
PARALLEL: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class JointFreedoms:
    """How end moves relative to start.

    Attributes
    ----------
    rotations, translations : int
        Numbers of freedoms; a screw has a rotation alone.
    axes : tuple of (3,) array
        Of the simple rotations that coordinates turn, in their order; each is fixed in the frame that those
        before it have turned.
    slides : tuple of (3,) array
        Directions of the translations, in axes of `slides_in`.
    slides_in : str
        "start" or "end".
    is_screw : bool
        Whether a rotation brings a translation along its axis with it.
    is_untwisted : bool
        Whether end never turns about its shaft.
    """

    rotations: int
    translations: int
    axes: tuple[Floats, ...]
    slides: tuple[Floats, ...]
    slides_in: str
    is_screw: bool
    is_untwisted: bool


def joint_freedoms(joint: Joint, numbers: ModelNumbers) -> JointFreedoms:
    """Return the freedoms of a joint by its law, whatever its class."""
    moving = set(joint.coordinates)
    axes = tuple(numbers.axis(turn.axis) for turn in joint.turns() if moving.intersection(turn.angle.names))
    coupled = set(joint.coupled_coordinates)
    zero = dict.fromkeys(joint.coordinates, 0.0)
    origin = numbers.vector(joint.shift(), **zero)
    slides = []
    for name in joint.translation_coordinates:
        direction = numbers.vector(joint.shift(), **{**zero, name: 1.0}) - origin
        if name not in coupled and np.any(direction):
            slides.append(unit(direction))
    return JointFreedoms(
        3 - joint.locked_rotations,
        3 - joint.locked_translations,
        axes,
        tuple(slides),
        joint.shift_in,
        bool(coupled) and _rises(joint, numbers, axes),
        joint.is_untwisted,
    )


def _rises(joint: Joint, numbers: ModelNumbers, axes: tuple[Floats, ...]) -> bool:
    """Return whether the shift has parts along the first axis that change with the coupled coordinates."""
    zero = dict.fromkeys(joint.coordinates, 0.0)
    origin = numbers.vector(joint.shift(), **zero)
    return any(
        abs(axes[0] @ (numbers.vector(joint.shift(), **{**zero, name: value}) - origin)) > PARALLEL
        for name in joint.coupled_coordinates
        for value in (1.0, 2.0)
    )


def are_parallel(first: Floats, second: Floats) -> bool:
    """Return whether two unit vectors have one direction, or opposite ones."""
    return float(np.linalg.norm(np.cross(first, second))) < PARALLEL
