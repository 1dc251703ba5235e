"""Frames placed by hand as frames of the kinematics: each step is a frame in the one before it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from symbody.equations.by_hand.mechanism import MechanismByHand, PlacedBody, PlacedForce
from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.graph import Graph
from symbody.spatial.moving import spin_of_step
from symbody.spatial.placed import PlacedFrame, PlacedPoint, PlacedStep, PlacedVector, Shift
from symbody.spatial.rotation import AxisRotation
from symbody.spatial.vector import ZERO, Vector, vector

Chain = tuple[PlacedStep, ...]


def frame_names(mechanism: MechanismByHand) -> dict[Chain, str]:
    """Return a name for each frame on the way to those of the mechanism; bodies on one way share it."""
    names: dict[Chain, str] = {(): "ground"}
    for frame in _frames(mechanism):
        for count in range(1, len(frame.steps) + 1):
            names.setdefault(frame.steps[:count], f"placed#{len(names)}")
    return names


def frame_steps(
    graph: Graph, names: Mapping[Chain, str], bodies: Iterable[PlacedBody]
) -> tuple[list[RotationStep], list[TranslationStep]]:
    """Return the steps to all frames, each after the one it stands in, and to those of the bodies.

    The frame of a body has its origin in the centre of mass and the axes of the frame that it was placed in.
    """
    rotations, translations = [], []
    for steps, name in names.items():
        if steps:
            near, step = names[steps[:-1]], steps[-1]
            rotations.append(_rotation(graph, name, near, step))
            shift = vector(near, step.by) if isinstance(step, Shift) else ZERO
            translations.append(TranslationStep(name, near, near, shift))
    for body in bodies:
        near = names[body.centre.frame.steps]
        rotations.append(RotationStep(body.name, near, ()))
        place = vector(near, body.centre.coordinates)
        translations.append(TranslationStep(body.name, near, near, place))
    return rotations, translations


def position_of(
    kinematics: Kinematics, names: Mapping[Chain, str], body: PlacedBody, point: PlacedPoint
) -> Vector:
    """Return the vector from a body's centre of mass to a point."""
    near = names[point.frame.steps]
    return kinematics.position(body.name, near) + vector(near, point.coordinates)


def convert_vector(names: Mapping[Chain, str], placed: PlacedVector) -> Vector:
    """Return a vector placed by hand as one of the kinematics."""
    return vector(names[placed.frame.steps], placed.components)


def _frames(mechanism: MechanismByHand) -> Iterator[PlacedFrame]:
    for body in mechanism.bodies:
        yield body.centre.frame
    for load in mechanism.loads:
        yield load.vector.frame
        if isinstance(load, PlacedForce):
            yield load.point.frame
    if mechanism.gravity is not None:
        yield mechanism.gravity.frame


def _rotation(graph: Graph, name: str, near: str, step: PlacedStep) -> RotationStep:
    if isinstance(step, Shift):
        return RotationStep(name, near, ())
    if isinstance(step, AxisRotation):
        return RotationStep(name, near, (step,))
    spin = spin_of_step(step)
    assert spin is not None
    return RotationStep(name, near, (step,), vector(near, step.matrix(graph) @ spin))
