"""The directions a joint leaves free, and unit vectors that complete them."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.kinematics.naming import Names
from symbody.expr.calculus import derivative
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.graph import Graph
from symbody.model.joint import Joint
from symbody.vectors.matrix import Triple, outer


def free_directions(names: Names, joint: Joint) -> list[Triple]:
    """Return the unit vectors, in start axes, along which a joint lets the end's origin move."""
    graph = names.graph
    symbols = Names(graph, names.symbols, {})  # also of coordinates that are prescribed or measured
    shift = [x.index for x in symbols.triple(joint.shift(), f"joint {joint.name}")]
    turning = set(joint.rotation_coordinates)
    found = []
    for name in joint.translation_coordinates:
        if name not in turning:
            x, y, z = (Expr(graph, slope) for slope in derivative(graph, shift, symbols.value(name).index))
            found.append((x, y, z))
    return found


def unit_axes(graph: Graph) -> tuple[Triple, Triple, Triple]:
    """Return the unit vectors along x, y and z."""
    zero, one = number(graph, 0), number(graph, 1)
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def completed(graph: Graph, directions: Sequence[Triple]) -> list[Triple]:
    """Return unit vectors perpendicular to the given ones and to each other, so that all make three."""
    if not directions:
        return list(unit_axes(graph))
    if len(directions) == 1:
        return list(perpendiculars(graph, directions[0]))
    return [outer(directions[0], directions[1])] if len(directions) == 2 else []


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
        x, y, z = (part / length for part in outer(axis, units[k]))
        first = (x, y, z)
    return first, outer(axis, first)
