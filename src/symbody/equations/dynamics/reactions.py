"""Reactions: what each joint transmits, from multipliers where it is cut, by balance where it is a branch.

The total wrench of a joint is that on its end body by its start body, at the origin of the end frame. Its
part along the joint's free directions is the effort of its drive or of its prescribed motion; the rest is
the reaction.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from symbody.equations.dynamics.balance import NOTHING, Wrench, balanced
from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.load import Load
from symbody.equations.dynamics.virtual_work import inertial, without_loads
from symbody.equations.kinematics.closings import Row
from symbody.equations.kinematics.joint_axes import free_directions
from symbody.equations.kinematics.motion import Kinematics, Velocity
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import turns_of
from symbody.expr.expression import Expr, symbol
from symbody.expr.graph import Graph, Kind, Symbol
from symbody.graph.topology import Topology
from symbody.model.joint import Joint
from symbody.vectors.vector import NULL, Vector, cross, dot, vector


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
        What joints transmit where they are cut, in any number of parts.
    """
    parts: dict[str, Wrench] = {}
    for name, part in cut:
        other = parts.get(name, NOTHING)
        parts[name] = Wrench(other.force + part.force, other.moment + part.moment)
    needed = {}
    for body in bodies:
        v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
        needed[body.frame] = inertial(
            kinematics, body, acceleration(kinematics, v), acceleration(kinematics, w)
        )
    found = balanced(topology, kinematics, without_loads(topology, kinematics, needed, loads), parts)
    return {joint.name: found.get(joint.name, NOTHING) for joint in topology.joints}


def row_wrenches(graph: Graph, rows: Iterable[Row]) -> Iterator[tuple[str, Wrench]]:
    """Return what the multipliers of rows give at the joints the rows belong to."""
    for row in rows:
        multiplier = symbol(graph, Symbol(row.name, Kind.MULTIPLIER))
        yield row.element, Wrench(row.force * multiplier, row.moment * multiplier)


def drive_wrench(names: Names, kinematics: Kinematics, joint: Joint, coordinate: str, effort: Expr) -> Wrench:
    """Return the wrench of an effort along a coordinate that is measured, not a variable."""
    start = kinematics.tree.home(joint.start.frame)
    if coordinate in joint.rotation_coordinates:
        return Wrench(NULL, free_turns(names, kinematics, joint)[0] * effort)
    k = joint.translation_coordinates.index(coordinate)
    return Wrench(vector(start, free_directions(names, joint)[k]) * effort, NULL)


def reaction(names: Names, kinematics: Kinematics, joint: Joint, total: Wrench) -> Wrench:
    """Return the part of a joint's wrench that does no work in any of its motions."""
    start = kinematics.tree.home(joint.start.frame)
    slides = [vector(start, direction) for direction in free_directions(names, joint)]
    turning = 3 if joint.quaternion is not None else 0
    turns = free_turns(names, kinematics, joint)
    return Wrench(
        _without(kinematics, total.force, slides, len(slides)),
        _without(kinematics, total.moment, turns, turning or len(turns)),
    )


def free_turns(names: Names, kinematics: Kinematics, joint: Joint) -> list[Vector]:
    """Return the axes about which a joint turns; of two, the first in start and the second in end."""
    tree = kinematics.tree
    turns = turns_of(names, joint.turns(), f"joint {joint.name}")
    if len(turns) == 1:
        return [vector(tree.home(joint.start.frame), turns[0].axis)]
    ends = (joint.start.frame, joint.end.frame)
    if len(turns) == 2:
        return [vector(tree.home(frame), turn.axis) for frame, turn in zip(ends, turns, strict=True)]
    return [vector(tree.home(joint.end.frame), turn.axis) for turn in turns]


def acceleration(kinematics: Kinematics, velocity: Velocity) -> Vector:
    """Return the time derivative of a velocity as seen from ground, with u' as symbols."""
    graph = kinematics.graph
    total = velocity.bias
    for u, partial in velocity.partials.items():
        total = total + partial * symbol(graph, graph.symbols[graph.left[u]].derivative)
    return total


def _without(kinematics: Kinematics, total: Vector, free: list[Vector], count: int) -> Vector:
    """Return the part of a vector that stands on all free directions."""
    tree = kinematics.tree
    if count == 0:
        return total
    if count == 1:
        return total - free[0] * dot(tree, free[0], total)
    if count == 2:
        normal = cross(tree, free[0], free[1])
        return normal * (dot(tree, normal, total) / dot(tree, normal, normal))
    return NULL


def effort_along(kinematics: Kinematics, total: Wrench, slide: Vector | None, turn: Vector | None) -> Expr:
    """Return the generalized force of a wrench along a free direction."""
    tree = kinematics.tree
    if slide is not None:
        return dot(tree, slide, total.force)
    assert turn is not None
    return dot(tree, turn, total.moment)
