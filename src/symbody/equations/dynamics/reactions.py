"""Reactions of joints: from multipliers where a joint is cut, by balance where it is a branch.

The total wrench of a joint is that on its end body by its start body, at the origin of the end frame. Its
part along the joint's free directions is the effort of its drive or of its prescribed motion; the rest is
the reaction.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench, balance_wrenches
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.inertial_wrenches import inertial_wrench, subtract_loads
from symbody.equations.dynamics.load import Load
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.joint_axes import (
    coordinate_angular_velocity,
    coordinate_velocity,
    free_displacements,
)
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import axis_rotations
from symbody.equations.kinematics.velocity import Velocity
from symbody.expr.expression import Expr, symbol
from symbody.graph.topology import Topology
from symbody.model.joint import Joint
from symbody.spatial.vector import ZERO, Vector, cross, dot, vector


def joint_wrenches(
    topology: Topology,
    kinematics: Kinematics,
    bodies: Iterable[Inertia],
    loads: Iterable[Load],
    cut: Iterable[tuple[str, Wrench]],
) -> dict[str, Wrench]:
    """Return the total wrench of every joint, in terms of u' and the multipliers.

    Parameters
    ----------
    cut : iterable of (joint name, Wrench)
        Wrenches of joints that are cut, in any number of parts.
    """
    parts = sum_wrenches(cut)
    needed = {}
    for body in bodies:
        v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
        needed[body.frame] = inertial_wrench(
            kinematics, body, acceleration(kinematics, v), acceleration(kinematics, w)
        )
    total = balance_wrenches(topology, kinematics, subtract_loads(topology, kinematics, needed, loads), parts)
    return {joint.name: total.get(joint.name, NO_WRENCH) for joint in topology.joints}


def sum_wrenches(parts: Iterable[tuple[str, Wrench]]) -> dict[str, Wrench]:
    """Return the sum of the parts of each joint's wrench."""
    total: dict[str, Wrench] = {}
    for name, part in parts:
        other = total.get(name, NO_WRENCH)
        total[name] = Wrench(other.force + part.force, other.moment + part.moment)
    return total


def row_wrenches(rows: Iterable[tuple[ConstraintEquation, Expr]]) -> Iterator[tuple[str, Wrench]]:
    """Return the wrenches of constraints with their multipliers, by the joint each belongs to."""
    for row, multiplier in rows:
        yield row.element, Wrench(row.force * multiplier, row.moment * multiplier)


def drive_wrench(names: Names, kinematics: Kinematics, joint: Joint, coordinate: str, effort: Expr) -> Wrench:
    """Return the wrench of an effort along a coordinate that is measured, not a variable."""
    tree = kinematics.tree
    if coordinate in joint.rotation_coordinates:
        return Wrench(ZERO, coordinate_angular_velocity(names, tree, joint, coordinate) * effort)
    k = joint.translation_coordinates.index(coordinate)
    return Wrench(free_displacements(names, tree, joint)[k] * effort, ZERO)


def reaction(names: Names, kinematics: Kinematics, joint: Joint, total: Wrench) -> Wrench:
    """Return the part of a joint's wrench that does no work in any of its motions.

    What is left out are forces along its displacements and moments in the plane of its turns.
    """
    slides = free_displacements(names, kinematics.tree, joint)
    force = _subtract_components(kinematics, total.force, slides)
    return Wrench(force, _moment_without_work(names, kinematics, joint, Wrench(force, total.moment)))


def effort_on_coordinate(
    names: Names, kinematics: Kinematics, joint: Joint, coordinate: str, total: Wrench
) -> Expr:
    """Return the generalized force of a joint's wrench along one of its coordinates."""
    tree = kinematics.tree
    turn = coordinate_angular_velocity(names, tree, joint, coordinate)
    slide = coordinate_velocity(names, kinematics, joint, coordinate)
    return dot(tree, slide, total.force) + dot(tree, turn, total.moment)


def _moment_without_work(names: Names, kinematics: Kinematics, joint: Joint, total: Wrench) -> Vector:
    """Return the moment without that in the plane of a joint's turns; with the force, it does no work."""
    tree = kinematics.tree
    angles = joint.rotation_coordinates
    if not angles:
        return total.moment
    if len(angles) == 1:
        axis = coordinate_angular_velocity(names, tree, joint, angles[0])
        return total.moment - axis * effort_on_coordinate(names, kinematics, joint, angles[0], total)
    if len(angles) == 2:
        normal = _locked_direction(names, kinematics, joint)
        return normal * (dot(tree, normal, total.moment) / dot(tree, normal, normal))
    if joint.shift_in == "end":  # the force acts through the origin of start
        return cross(tree, total.force, kinematics.position(joint.start.full_name, joint.end.full_name))
    return ZERO


def _locked_direction(names: Names, kinematics: Kinematics, joint: Joint) -> Vector:
    """Return the direction about which a joint with two angles cannot turn."""
    tree = kinematics.tree
    if joint.is_untwisted:  # the bisector of both shafts, also where they are in line
        shaft = axis_rotations(names, joint.turns(), f"joint {joint.name}")[0].axis
        start, end = (
            tree.orientation_frame(joint.start.full_name),
            tree.orientation_frame(joint.end.full_name),
        )
        return vector(start, shaft) + vector(end, shaft)
    first, second = (
        coordinate_angular_velocity(names, tree, joint, name) for name in joint.rotation_coordinates
    )
    return cross(tree, first, second)


def acceleration(kinematics: Kinematics, velocity: Velocity) -> Vector:
    """Return the time derivative of a velocity as seen from ground, with u' as symbols."""
    graph = kinematics.graph
    total = velocity.bias
    for u, partial in velocity.partials.items():
        total = total + partial * symbol(graph, graph.symbols[graph.left[u]].derivative)
    return total


def _subtract_components(kinematics: Kinematics, total: Vector, free: Sequence[Vector]) -> Vector:
    """Return the part of a vector across free directions, which are perpendicular unit vectors."""
    if len(free) == 3:
        return ZERO
    for direction in free:
        total = total - direction * dot(kinematics.tree, direction, total)
    return total
