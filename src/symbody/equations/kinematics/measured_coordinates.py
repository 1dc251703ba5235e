"""Coordinates of joints that are cut: measured on the frames they connect."""

from __future__ import annotations

from symbody.equations.kinematics.joint_axes import free_displacements, perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, axis_rotations
from symbody.expr.expression import Expr, atan2, cos, sin, sqrt
from symbody.model.joint import Joint, QuasiSpeeds
from symbody.spatial.euler_angles import angles_of_matrix
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Triple, Vector3, identity
from symbody.spatial.rotation import angle_about
from symbody.spatial.vector import Vector, cross, dot, vector


def measure_coordinates(names: Names, kinematics: Kinematics, role: JointRole) -> dict[str, Expr]:
    """Return the coordinates of a joint that are neither in q nor prescribed, their first and second rates.

    An angle is the sum of angles of the tree where all turn about its axis; other angles are in (-pi, pi].
    A quaternion is not measured, because its sign is free. Speeds that are components of velocities are
    measured too, with their rates.
    """
    values: dict[str, Expr] = {}
    if not role.has_displacements:
        values |= _displacements(names, kinematics, role.joint)
    if not role.has_angles and role.joint.quaternion is None:
        values |= _angles(names, kinematics, role.joint)
    seconds = {
        f"{name}_ddot": kinematics.rate(values[f"{name}_dot"]) for name in values if f"{name}_dot" in values
    }
    speeds = _speeds(kinematics, role)
    return values | seconds | speeds | {f"{name}_dot": kinematics.rate(u) for name, u in speeds.items()}


def _speeds(kinematics: Kinematics, role: JointRole) -> dict[str, Expr]:
    """Return the speeds of a joint that are components of velocities, of its parts that are not in u."""
    joint, tree = role.joint, kinematics.tree
    start, end = joint.start.full_name, joint.end.full_name
    values: dict[str, Expr] = {}
    if not role.has_displacements and joint.translation_speeds is not None:
        swing = cross(tree, kinematics.angular_velocities[start].value, kinematics.position(start, end))
        slide = kinematics.velocities[end].value - kinematics.velocities[start].value - swing
        values |= _components(tree, joint, joint.translation_speeds, slide)
    if not role.has_angles and joint.rotation_speeds is not None:
        values |= _components(
            tree, joint, joint.rotation_speeds, _relative_angular_velocity(kinematics, joint)
        )
    return values


def _components(tree: FrameTree, joint: Joint, speeds: QuasiSpeeds, velocity: Vector) -> dict[str, Expr]:
    frame = tree.orientation_frame(
        joint.end.full_name if speeds.resolved_in == "end" else joint.start.full_name
    )
    axes = [vector(frame, axis) for axis in identity(tree.graph)]
    return {name: dot(tree, axis, velocity) for name, axis in zip(speeds.names, axes, strict=True)}


def _displacements(names: Names, kinematics: Kinematics, joint: Joint) -> dict[str, Expr]:
    tree = kinematics.tree
    start, end = joint.start.full_name, joint.end.full_name
    arm = kinematics.position(start, end)
    carrier = end if joint.shift_in == "end" else start
    swing = cross(tree, kinematics.angular_velocities[carrier].value, arm)
    slide = kinematics.velocities[end].value - kinematics.velocities[start].value - swing
    values = {}
    coordinates = [name for name in joint.translation_coordinates if name not in joint.coupled_coordinates]
    for name, along in zip(coordinates, free_displacements(names, tree, joint), strict=True):
        values[name], values[f"{name}_dot"] = dot(tree, along, arm), dot(tree, along, slide)
    return values


def _angles(names: Names, kinematics: Kinematics, joint: Joint) -> dict[str, Expr]:
    turns = axis_rotations(names, joint.turns(), f"joint {joint.name}")
    if len(turns) == 1:
        return _single_angle(kinematics, joint, turns[0].axis)
    if len(turns) == 2:
        return _two_angles(kinematics, joint, turns[0].axis, turns[1].axis)
    if joint.is_untwisted:
        return _bend(kinematics, joint, turns[0].axis)
    letters = [_axis_letter(turn.axis) for turn in turns]
    if len(turns) != 3 or None in letters:
        return {}
    tree = kinematics.tree
    start, end = tree.orientation_frame(joint.start.full_name), tree.orientation_frame(joint.end.full_name)
    angles = angles_of_matrix(tree.matrix(start, end), "".join(letter or "" for letter in letters))
    # In the order of the turns, which a sequence about space axes reverses.
    ordered = [turn.angle.names[0] for turn in joint.turns()]
    values = dict(zip(ordered, angles, strict=True))
    return values | {f"{name}_dot": kinematics.rate(angle) for name, angle in values.items()}


def wrapped_angles(names: Names, kinematics: Kinematics, role: JointRole) -> tuple[str, ...]:
    """Return the angles that `measure_coordinates` measures in (-pi, pi]."""
    joint = role.joint
    if joint.quaternion is not None:
        return ()
    turns = axis_rotations(names, joint.turns(), f"joint {joint.name}")
    if len(turns) == 1 and _angle_of_tree(kinematics, joint, turns[0].axis) is not None:
        return ()
    return tuple(name for name in joint.rotation_coordinates if name not in role.coordinates)


def _angle_of_tree(kinematics: Kinematics, joint: Joint, axis: Triple) -> Expr | None:
    """Return the angle between the frames of a joint where the tree turns about its axis alone, else None."""
    rotation = kinematics.tree.rotation(joint.start.full_name, joint.end.full_name)
    return angle_about(kinematics.graph, rotation, axis)


def _single_angle(kinematics: Kinematics, joint: Joint, axis: Triple) -> dict[str, Expr]:
    tree = kinematics.tree
    start, end = tree.orientation_frame(joint.start.full_name), tree.orientation_frame(joint.end.full_name)
    first, second = perpendiculars(tree.graph, axis)
    seen = vector(end, first)
    sine, cosine = dot(tree, vector(start, second), seen), dot(tree, vector(start, first), seen)
    name = joint.rotation_coordinates[0]
    turning = _relative_angular_velocity(kinematics, joint)
    counted = _angle_of_tree(kinematics, joint, axis)
    angle = atan2(sine, cosine) if counted is None else counted
    return {name: angle, f"{name}_dot": dot(tree, vector(start, axis), turning)}


def _two_angles(kinematics: Kinematics, joint: Joint, a: Triple, b: Triple) -> dict[str, Expr]:
    """Return the angles about an axis of start and an axis of end, which stay perpendicular."""
    tree = kinematics.tree
    start, end = tree.orientation_frame(joint.start.full_name), tree.orientation_frame(joint.end.full_name)
    first, second = vector(start, a), vector(end, b)
    across = Vector3(a).cross(b)
    turning = _relative_angular_velocity(kinematics, joint)
    values = {}
    for name, axis, seen, line, side in (
        (joint.coordinates[0], first, second, vector(start, b), vector(start, across)),
        (joint.coordinates[1], second, first, vector(end, a), vector(end, across)),
    ):
        values[name] = atan2(dot(tree, side, seen), dot(tree, line, seen))
        values[f"{name}_dot"] = dot(tree, axis, turning)
    return values


def _bend(kinematics: Kinematics, joint: Joint, axis: Triple) -> dict[str, Expr]:
    """Return the angle between two shafts, in [0, pi], and its azimuth; that has no rate where they align."""
    tree = kinematics.tree
    start, end = tree.orientation_frame(joint.start.full_name), tree.orientation_frame(joint.end.full_name)
    x, y = (vector(start, across) for across in perpendiculars(tree.graph, axis))
    near, far = vector(start, axis), vector(end, axis)
    turning = _relative_angular_velocity(kinematics, joint)
    east, north = dot(tree, x, far), dot(tree, y, far)
    azimuth = atan2(north, east)
    bend, direction = joint.coordinates
    lean = sqrt(east * east + north * north)
    apart = near - far
    square = dot(tree, apart, apart)
    values = {
        bend: atan2(lean, dot(tree, near, far)),
        direction: azimuth,
        f"{bend}_dot": dot(tree, y * cos(azimuth) - x * sin(azimuth), turning),
    }
    # Shafts in line whatever the coordinates have no azimuth that could change.
    return values if square.is_zero else values | {f"{direction}_dot": dot(tree, apart, turning) / square}


def _relative_angular_velocity(kinematics: Kinematics, joint: Joint) -> Vector:
    angular = kinematics.angular_velocities
    return angular[joint.end.full_name].value - angular[joint.start.full_name].value


def _axis_letter(axis: Triple) -> str | None:
    numbers = [component.number for component in axis]
    return "xyz"[numbers.index(1)] if sorted(x is not None and x == 1 for x in numbers)[-1] else None
