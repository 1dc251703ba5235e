"""Velocities of frames and points placed by hand, by differentiating on the graph."""

from __future__ import annotations

from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr, common_graph
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.rewrite import dependence
from symbody.spatial.matrix import Triple, Vector3, matrix3, zero_vector
from symbody.spatial.placed import (
    GROUND_FRAME,
    PlacedFrame,
    PlacedPoint,
    PlacedStep,
    PlacedVector,
    Shift,
)
from symbody.spatial.rotation import AxisRotation, DirectionCosines, axis_rotation_matrix, spin


def rate(x: Triple) -> Vector3[Expr]:
    """Return the time derivatives of three expressions."""
    graph, nodes = common_graph(x)
    a, b, c = (Expr(graph, node) for node in time_derivative(graph, nodes))
    return Vector3((a, b, c))


def velocity(point: PlacedPoint) -> PlacedVector:
    """Return the velocity of a point relative to ground, in the point's frame [m/s]."""
    return PlacedVector(GROUND_FRAME, rate(point.position)).express_in(point.frame)


def acceleration(point: PlacedPoint) -> PlacedVector:
    """Return the acceleration of a point relative to ground, in the point's frame [m/s^2]."""
    return PlacedVector(GROUND_FRAME, rate(rate(point.position))).express_in(point.frame)


def angular_velocity(graph: Graph, frame: PlacedFrame, other: PlacedFrame = GROUND_FRAME) -> PlacedVector:
    """Return the angular velocity of a frame relative to another, in the first [rad/s]."""
    absolute = PlacedVector(frame, _angular_velocity(graph, frame))
    if not other.steps:
        return absolute
    return absolute + -PlacedVector(other, _angular_velocity(graph, other))


def axis_rotation_step(graph: Graph, axis: Triple, angle: Expr) -> PlacedStep:
    """Return the turn about a unit vector; as a matrix where the axis itself moves."""
    turn = AxisRotation(axis, angle)
    kinds = dependence(graph, [x.index for x in axis])
    if all(kinds[x.index] <= {SymbolKind.PARAMETER} for x in axis):
        return turn
    return DirectionCosines(axis_rotation_matrix(graph, turn))


def spin_of_step(step: PlacedStep) -> Vector3[Expr] | None:
    """Return the angular velocity of a step's end relative to its start, in the end's axes; None for a shift.

    Of a matrix it is read from ``R^T R' = w~``, above the diagonal: where the columns are no unit vectors, as
    natural coordinates away from their constraint, it is a smooth extension of the angular velocity.
    """
    if isinstance(step, Shift):
        return None
    if isinstance(step, AxisRotation):
        (speed, _, _) = rate((step.angle, step.angle, step.angle))
        return Vector3(step.axis) * speed
    return spin(step.cosines, matrix3(*(rate(row) for row in step.cosines)))


def _angular_velocity(graph: Graph, frame: PlacedFrame) -> Vector3[Expr]:
    total = zero_vector(graph)
    for step in frame.steps:
        spin = spin_of_step(step)
        if spin is not None and not isinstance(step, Shift):
            total = step.matrix(graph).T @ total + spin
    return total
