"""Frames placed by hand as frames of the kinematics: each step is a frame in the one before it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from symbody.equations.by_hand.mechanism import HandPlaced, PlacedBody, PlacedForce
from symbody.equations.kinematics.motion import (
    Kinematics,
    Shifting,
    Turning,
    enter_axes,
    enter_origin,
    enter_turning,
)
from symbody.vectors.moving import spin_of_step
from symbody.vectors.placed import PlacedFrame, PlacedPoint, PlacedStep, PlacedVector, Shift
from symbody.vectors.rotation import Turn
from symbody.vectors.vector import NULL, Vector, vector

Chain = tuple[PlacedStep, ...]


def frame_names(mechanism: HandPlaced) -> dict[Chain, str]:
    """Return a name for each frame on the way to those of the mechanism; bodies on one way share it."""
    names: dict[Chain, str] = {(): "ground"}
    for frame in _frames(mechanism):
        for count in range(1, len(frame.steps) + 1):
            names.setdefault(frame.steps[:count], f"placed#{len(names)}")
    return names


def place_frames(kinematics: Kinematics, names: Mapping[Chain, str]) -> Kinematics:
    """Enter all frames, each after the one it stands in; return the kinematics they were entered in."""
    for steps, name in names.items():
        if steps:
            _enter(kinematics, name, names[steps[:-1]], steps[-1])
    return kinematics


def body_frames(kinematics: Kinematics, names: Mapping[Chain, str], bodies: Iterable[PlacedBody]) -> None:
    """Enter the frame of each body: its centre of mass, with the axes of the frame that it was placed in."""
    for body in bodies:
        near = names[body.centre.frame.steps]
        enter_turning(kinematics, Turning(body.name, near, ()))
        enter_origin(kinematics, Shifting(body.name, near, near, vector(near, body.centre.coordinates)))


def arm_to(
    kinematics: Kinematics, names: Mapping[Chain, str], body: PlacedBody, point: PlacedPoint
) -> Vector:
    """Return the vector from a body's centre of mass to a point."""
    near = names[point.frame.steps]
    return kinematics.arm(body.name, near) + vector(near, point.coordinates)


def vector_in(names: Mapping[Chain, str], placed: PlacedVector) -> Vector:
    """Return a vector placed by hand as one of the kinematics."""
    return vector(names[placed.frame.steps], placed.components)


def _frames(mechanism: HandPlaced) -> Iterator[PlacedFrame]:
    for body in mechanism.bodies:
        yield body.centre.frame
    for load in mechanism.loads:
        yield load.vector.frame
        if isinstance(load, PlacedForce):
            yield load.point.frame
    if mechanism.gravity is not None:
        yield mechanism.gravity.frame


def _enter(kinematics: Kinematics, name: str, near: str, step: PlacedStep) -> None:
    if isinstance(step, Shift):
        enter_turning(kinematics, Turning(name, near, ()))
        enter_origin(kinematics, Shifting(name, near, near, vector(near, step.by)))
        return
    if isinstance(step, Turn):
        enter_turning(kinematics, Turning(name, near, (step,)))
    else:
        own = spin_of_step(step)
        assert own is not None
        enter_axes(kinematics, name, near, step.cosines, vector(near, step.matrix(kinematics.graph) @ own))
    enter_origin(kinematics, Shifting(name, near, near, NULL))
