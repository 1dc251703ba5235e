"""What the coordinates of gears and belts move, seen from the body that both joints have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symbody.model.joint import Joint
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.poses import RigidTransform, joint_transform
from symbody.visual.scene.scene import Floats


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


def wheel_sites(
    basis: SceneBasis, coordinates: Sequence[str], values: Sequence[float]
) -> tuple[WheelSite, WheelSite] | None:
    """Return the wheels that two coordinates move, seen from their common body, where they have values."""
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
    """Return the wheel that a joint moves, seen from a body with a given pose."""
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
