"""The directions a joint leaves free, and unit vectors that complete them."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import axis_rotations
from symbody.expr.calculus import derivative, gradient
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.graph import Graph
from symbody.expr.rewrite import substitute
from symbody.expr.trigonometry.normal_form import trigonometric_form
from symbody.graph.curved_shifts import is_curved
from symbody.model.joint import Joint
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Triple, Vector3
from symbody.spatial.rotation import AxisRotation, compose_steps, rotation_matrix
from symbody.spatial.vector import ZERO, Vector, cross, vector


def free_directions(names: Names, joint: Joint) -> list[Triple]:
    """Return perpendicular unit vectors, in the axes of the shift, along which end's origin can move.

    Coordinates that turn end as well have none.
    """
    curved = is_curved(joint)
    directions: list[Triple] = []
    for name in joint.translation_coordinates:
        if name not in joint.rotation_coordinates:
            slope = _shift_slope(names, joint, name)
            directions.append(_perpendicular_unit(slope, directions) if curved else slope)
    return directions


def _perpendicular_unit(direction: Triple, others: Sequence[Triple]) -> Triple:
    """Return the unit vector of the part of a direction across perpendicular unit vectors."""
    across = Vector3(direction)
    for other in map(Vector3, others):
        across = across - other * other.dot(across)
    square = across.dot(across)
    (shown,) = trigonometric_form(square.graph, [square.index])
    is_unit = square.graph.number(shown) == 1  # sin(a)^2 + cos(a)^2
    x, y, z = across if is_unit else across * (1 / sqrt(square))
    return (x, y, z)


def free_displacements(names: Names, tree: FrameTree, joint: Joint) -> list[Vector]:
    """Return the unit vectors along which a joint lets the end's origin move."""
    home = tree.orientation_frame((joint.end if joint.shift_in == "end" else joint.start).full_name)
    return [vector(home, direction) for direction in free_directions(names, joint)]


def coordinate_angular_velocity(names: Names, tree: FrameTree, joint: Joint, coordinate: str) -> Vector:
    """Return the angular velocity of end relative to start for a unit rate of a coordinate.

    The first turn is about an axis of start, the last about one of end.
    """
    where = f"joint {joint.name}"
    turns = axis_rotations(names, joint.turns(), where)
    symbols = Names(names.graph, names.symbols, {})  # also of coordinates that are prescribed
    by = symbols.value(coordinate).index
    angular_velocity = ZERO
    for k, turn in enumerate(axis_rotations(symbols, joint.turns(), where)):
        slope = Expr(names.graph, gradient(names.graph, turn.angle.index, [by])[0])
        angular_velocity = angular_velocity + _axis(tree, joint, turns, k) * slope
    return angular_velocity


def coordinate_velocity(names: Names, kinematics: Kinematics, joint: Joint, coordinate: str) -> Vector:
    """Return the velocity of end's origin, as seen from start, for a unit rate of a coordinate."""
    tree = kinematics.tree
    start, end = joint.start.full_name, joint.end.full_name
    x, y, z = _shift_slope(names, joint, coordinate)
    if joint.shift_in == "start":
        return vector(tree.orientation_frame(start), (x, y, z))
    turn = coordinate_angular_velocity(names, tree, joint, coordinate)
    return vector(tree.orientation_frame(end), (x, y, z)) + cross(tree, turn, kinematics.position(start, end))


def _shift_slope(names: Names, joint: Joint, coordinate: str) -> Triple:
    """Return the derivative of a joint's shift by a coordinate, at the values that its coordinates have."""
    graph = names.graph
    values = {
        graph.symbol(names.symbols[name]): names.value(name).index
        for name in joint.coordinates
        if name in names.values
    }
    slopes = [slope.index for slope in _symbolic_slope(names, joint, coordinate)]
    x, y, z = (Expr(graph, slope) for slope in substitute(graph, slopes, values))
    return (x, y, z)


def _symbolic_slope(names: Names, joint: Joint, coordinate: str) -> Triple:
    """Return the derivative of a joint's shift by a coordinate, in symbols of prescribed coordinates too."""
    graph = names.graph
    symbols = Names(graph, names.symbols, {})
    shift = [x.index for x in symbols.triple(joint.shift(), f"joint {joint.name}")]
    x, y, z = (Expr(graph, slope) for slope in derivative(graph, shift, symbols.value(coordinate).index))
    return (x, y, z)


def unit_axes(graph: Graph) -> tuple[Triple, Triple, Triple]:
    """Return the unit vectors along x, y and z."""
    zero, one = number(graph, 0), number(graph, 1)
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def _axis(tree: FrameTree, joint: Joint, turns: Sequence[AxisRotation], k: int) -> Vector:
    """Return the axis of one of several successive turns."""
    if 0 < k < len(turns) - 1:
        before = rotation_matrix(tree.graph, compose_steps(turns[:k]))
        return vector(tree.orientation_frame(joint.start.full_name), before @ turns[k].axis)
    return vector(tree.orientation_frame((joint.start if k == 0 else joint.end).full_name), turns[k].axis)


def complete_axes(graph: Graph, directions: Sequence[Triple]) -> list[Triple]:
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
