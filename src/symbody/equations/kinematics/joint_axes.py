"""The directions a joint leaves free, and unit vectors that complete them."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import turns_of
from symbody.expr.calculus import derivative, gradient
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.graph import Graph
from symbody.model.joint import Joint
from symbody.vectors.frame import FrameTree
from symbody.vectors.matrix import Triple, Vector3
from symbody.vectors.rotation import AxisRotation, rotation_matrix, rotation_of
from symbody.vectors.vector import NULL, Vector, cross, vector


def free_directions(names: Names, joint: Joint) -> list[Triple]:
    """Return the unit vectors, in the axes it shifts in, along which a joint lets the end's origin move."""
    graph = names.graph
    symbols = Names(graph, names.symbols, {})  # also of coordinates that are prescribed or measured
    shift = [x.index for x in symbols.triple(joint.shift(), f"joint {joint.name}")]
    turning = set(joint.rotation_coordinates)
    directions = []
    for name in joint.translation_coordinates:
        if name not in turning:
            x, y, z = (Expr(graph, slope) for slope in derivative(graph, shift, symbols.value(name).index))
            directions.append((x, y, z))
    return directions


def free_slides(names: Names, tree: FrameTree, joint: Joint) -> list[Vector]:
    """Return the unit vectors along which a joint lets the end's origin move."""
    home = tree.home((joint.end if joint.shift_in == "end" else joint.start).frame)
    return [vector(home, direction) for direction in free_directions(names, joint)]


def coordinate_turn(names: Names, tree: FrameTree, joint: Joint, coordinate: str) -> Vector:
    """Return the angular velocity of end relative to start for a unit rate of a coordinate.

    The first turn is about an axis of start, the last about one of end.
    """
    where = f"joint {joint.name}"
    turns = turns_of(names, joint.turns(), where)
    symbols = Names(names.graph, names.symbols, {})  # also of coordinates that are prescribed
    by = symbols.value(coordinate).index
    angular_velocity = NULL
    for k, turn in enumerate(turns_of(symbols, joint.turns(), where)):
        slope = Expr(names.graph, gradient(names.graph, turn.angle.index, [by])[0])
        angular_velocity = angular_velocity + _axis(tree, joint, turns, k) * slope
    return angular_velocity


def coordinate_slide(names: Names, kinematics: Kinematics, joint: Joint, coordinate: str) -> Vector:
    """Return the velocity of end's origin, as seen from start, for a unit rate of a coordinate."""
    tree, graph = kinematics.tree, names.graph
    start, end = joint.start.frame, joint.end.frame
    symbols = Names(graph, names.symbols, {})
    shift = [x.index for x in symbols.triple(joint.shift(), f"joint {joint.name}")]
    x, y, z = (Expr(graph, slope) for slope in derivative(graph, shift, symbols.value(coordinate).index))
    if joint.shift_in == "start":
        return vector(tree.home(start), (x, y, z))
    turn = coordinate_turn(names, tree, joint, coordinate)
    return vector(tree.home(end), (x, y, z)) + cross(tree, turn, kinematics.arm(start, end))


def unit_axes(graph: Graph) -> tuple[Triple, Triple, Triple]:
    """Return the unit vectors along x, y and z."""
    zero, one = number(graph, 0), number(graph, 1)
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def _axis(tree: FrameTree, joint: Joint, turns: Sequence[AxisRotation], k: int) -> Vector:
    """Return the axis of one of several successive turns."""
    if 0 < k < len(turns) - 1:
        before = rotation_matrix(tree.graph, rotation_of(turns[:k]))
        return vector(tree.home(joint.start.frame), before @ turns[k].axis)
    return vector(tree.home((joint.start if k == 0 else joint.end).frame), turns[k].axis)


def completed(graph: Graph, directions: Sequence[Triple]) -> list[Triple]:
    """Return unit vectors perpendicular to the given ones and to each other, so that all make three."""
    if not directions:
        return list(unit_axes(graph))
    if len(directions) == 1:
        return list(perpendiculars(graph, directions[0]))
    return [Vector3(directions[0]).cross(directions[1])] if len(directions) == 2 else []


def perpendiculars(graph: Graph, axis: Triple) -> tuple[Triple, Triple]:
    """Return two unit vectors that make a right-handed set with a unit vector: (first, second, axis).

    For an axis of coordinates they are the next two axes. Otherwise the first stands on the plane of the
    axis and the coordinate axis farthest from it.
    """
    sizes = [abs(float(x.number)) if x.number is not None else 0.5 for x in axis]
    units = unit_axes(graph)
    if sorted(sizes) == [0, 0, 1] and max(float(x.number or 0) for x in axis) == 1:
        k = sizes.index(1)
        return units[(k + 1) % 3], units[(k + 2) % 3]
    k = sizes.index(min(sizes))
    first = units[k]
    if sizes[k] != 0:
        length = sqrt(1 - axis[k] * axis[k])
        x, y, z = (part / length for part in Vector3(axis).cross(units[k]))
        first = (x, y, z)
    return first, Vector3(axis).cross(first)
