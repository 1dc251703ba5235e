"""Rows of points held at a distance, on a line, a plane, a curve or a surface."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from symbody.equations.constraints.frame_constraints import pair_equation, time_partial
from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.joint_axes import perpendiculars, unit_axes
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr, sqrt
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.rewrite import substitute
from symbody.model.constraint import FrameConstraint
from symbody.model.constraints import Distance, PointOnCurve, PointOnLine, PointOnPlane, PointOnSurface
from symbody.model.simple_rotation import Axis, unit_axis
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import Vector, components, dot, vector


def direction(names: Names, contact: FrameConstraint, axis: Axis) -> Triple:
    """Return the unit vector of a direction of a constraint."""
    return names.triple(unit_axis(axis), f"constraint {contact.name}")


def distance_equations(names: Names, kinematics: Kinematics, rod: Distance) -> Iterator[ConstraintEquation]:
    """Return ``|r_end - r_start| - L = 0``; the force is along the line, pushing apart."""
    start, end = rod.start.full_name, rod.end.full_name
    tree, arm = kinematics.tree, kinematics.position(start, end)
    length = sqrt(dot(tree, arm, arm))
    along = arm * (1 / length)
    closing = kinematics.velocities[end].value - kinematics.velocities[start].value
    turning = (closing - along * dot(tree, along, closing)) * (1 / length)
    target = names.expression(rod.value, f"constraint {rod.name}")
    row = pair_equation(kinematics, rod, value=length, force=along, force_rate=turning, target=target)
    yield replace(row, sense=-1) if rod.rope else row


def line_equations(names: Names, kinematics: Kinematics, line: PointOnLine) -> Iterator[ConstraintEquation]:
    """Return a row for each of two directions across the line."""
    for across in perpendiculars(names.graph, direction(names, line, line.axis)):
        yield _distance_equation(kinematics, line, across)


def plane_equations(
    names: Names, kinematics: Kinematics, plane: PointOnPlane
) -> Iterator[ConstraintEquation]:
    """Return the row along the normal."""
    yield _distance_equation(kinematics, plane, direction(names, plane, plane.axis))


def curve_equations(
    names: Names, kinematics: Kinematics, curve: PointOnCurve
) -> Iterator[ConstraintEquation]:
    """Return a row along each axis of start: the point stands where the parameter says."""
    places = names.triple(curve.curve, f"constraint {curve.name}")
    for axis, place in zip(unit_axes(names.graph), places, strict=True):
        yield _distance_equation(kinematics, curve, axis, place)


def surface_equations(
    names: Names, kinematics: Kinematics, surface: PointOnSurface
) -> Iterator[ConstraintEquation]:
    """Return a row an equation; the force is its gradient by the place of the point."""
    graph, start = names.graph, surface.start.full_name
    point = components(kinematics.tree, kinematics.position(start, surface.end.full_name), start)
    # The place has names of its own while the gradient is taken.
    local = {x: Expr(graph, graph.symbol(Symbol(f"{surface.name} {x}", SymbolKind.PARAMETER))) for x in "xyz"}
    inside = names.with_values(local)
    here = {symbol.index: value.index for symbol, value in zip(local.values(), point, strict=True)}
    by = [symbol.index for symbol in local.values()]
    for equation in surface.equations:
        formula = inside.expression(equation, f"constraint {surface.name}")
        slopes = gradient(graph, formula.index, by)
        nodes = substitute(graph, [formula.index, time_partial(formula).index, *slopes], here)
        value, change, x, y, z = (Expr(graph, node) for node in nodes)
        row = scalar_equation(kinematics, "", surface.name, value)
        yield replace(row, force=vector(kinematics.tree.orientation_frame(start), (x, y, z)), driven=-change)


def _distance_equation(
    kinematics: Kinematics, contact: FrameConstraint, axis: Triple, place: Expr | None = None
) -> ConstraintEquation:
    """Return the row of the distance of end from start along a direction fixed in start."""
    start = contact.start.full_name
    normal: Vector = vector(kinematics.tree.orientation_frame(start), axis)
    value = dot(kinematics.tree, normal, kinematics.position(start, contact.end.full_name))
    return pair_equation(kinematics, contact, value=value, force=normal, target=place)
