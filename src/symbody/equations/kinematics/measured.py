"""Coordinates of joints that are cut: measured on the frames they connect."""

from __future__ import annotations

from symbody.equations.kinematics.joint_axes import free_directions, perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use, turns_of
from symbody.expr.expression import Expr, atan2
from symbody.model.joint import Joint
from symbody.vectors.euler_angles import measured_angles
from symbody.vectors.matrix import Triple
from symbody.vectors.vector import cross, dot, vector


def measured_coordinates(names: Names, kinematics: Kinematics, use: Use) -> dict[str, Expr]:
    """Return the coordinates of a joint that are neither in q nor prescribed, their first and second rates.

    Angles are in (-pi, pi]; a quaternion is not measured, because its sign is free.
    """
    found: dict[str, Expr] = {}
    if not use.slides:
        found |= _displacements(names, kinematics, use.joint)
    if not use.turns and use.joint.quaternion is None:
        found |= _angles(names, kinematics, use.joint)
    seconds = {
        f"{name}_ddot": kinematics.rate(found[f"{name}_dot"]) for name in found if f"{name}_dot" in found
    }
    return found | seconds


def _displacements(names: Names, kinematics: Kinematics, joint: Joint) -> dict[str, Expr]:
    tree = kinematics.tree
    start, end = joint.start.frame, joint.end.frame
    arm = kinematics.arm(start, end)
    swing = cross(tree, kinematics.angular_velocities[start].value, arm)
    slide = kinematics.velocities[end].value - kinematics.velocities[start].value - swing
    found = {}
    turning = set(joint.rotation_coordinates)
    coordinates = [name for name in joint.translation_coordinates if name not in turning]
    for name, direction in zip(coordinates, free_directions(names, joint), strict=True):
        along = vector(tree.home(start), direction)
        found[name], found[f"{name}_dot"] = dot(tree, along, arm), dot(tree, along, slide)
    return found


def _angles(names: Names, kinematics: Kinematics, joint: Joint) -> dict[str, Expr]:
    tree = kinematics.tree
    start, end = tree.home(joint.start.frame), tree.home(joint.end.frame)
    turns = turns_of(names, joint.turns(), f"joint {joint.name}")
    turning = kinematics.angular_velocities[end].value - kinematics.angular_velocities[start].value
    if len(turns) == 1:
        axis = turns[0].axis
        first, second = perpendiculars(tree.graph, axis)
        seen = vector(end, first)
        sine, cosine = dot(tree, vector(start, second), seen), dot(tree, vector(start, first), seen)
        name = joint.rotation_coordinates[0]
        return {name: atan2(sine, cosine), f"{name}_dot": dot(tree, vector(start, axis), turning)}
    letters = [_letter(turn.axis) for turn in turns]
    if len(turns) != 3 or None in letters:
        return {}
    angles = measured_angles(tree.matrix(start, end), "".join(letter or "" for letter in letters))
    # In the order of the turns, which a sequence about space axes reverses.
    ordered = [turn.angle.names[0] for turn in joint.turns()]
    found = dict(zip(ordered, angles, strict=True))
    return found | {f"{name}_dot": kinematics.rate(angle) for name, angle in found.items()}


def _letter(axis: Triple) -> str | None:
    numbers = [component.number for component in axis]
    return "xyz"[numbers.index(1)] if sorted(x is not None and x == 1 for x in numbers)[-1] else None
