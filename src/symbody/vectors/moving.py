"""Velocities of frames and points placed by hand, by differentiating on the graph."""

from __future__ import annotations

from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr, common_graph, number
from symbody.expr.graph import Graph, Kind
from symbody.expr.rewrite import dependence
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, inner, transpose
from symbody.vectors.placed import (
    GROUND_FRAME,
    PlacedFrame,
    PlacedPoint,
    PlacedStep,
    PlacedVector,
    Shift,
    plus,
)
from symbody.vectors.rotation import DirectionCosines, Turn, turn_matrix


def rate(x: Triple) -> Triple:
    """Return the time derivatives of three expressions."""
    graph, nodes = common_graph(x)
    a, b, c = (Expr(graph, node) for node in time_derivative(graph, nodes))
    return (a, b, c)


def velocity(point: PlacedPoint) -> PlacedVector:
    """Return the velocity of a point relative to ground, in the point's frame [m/s]."""
    return PlacedVector(GROUND_FRAME, rate(point.position)).projected(point.frame)


def acceleration(point: PlacedPoint) -> PlacedVector:
    """Return the acceleration of a point relative to ground, in the point's frame [m/s^2]."""
    return PlacedVector(GROUND_FRAME, rate(rate(point.position))).projected(point.frame)


def angular_velocity(graph: Graph, frame: PlacedFrame, other: PlacedFrame = GROUND_FRAME) -> PlacedVector:
    """Return the angular velocity of a frame relative to another, in the first [rad/s]."""
    own = PlacedVector(frame, _spin_of(graph, frame))
    if not other.steps:
        return own
    return own + -PlacedVector(other, _spin_of(graph, other))


def turned_by(graph: Graph, axis: Triple, angle: Expr) -> PlacedStep:
    """Return the turn about a unit vector; as a matrix where the axis itself moves."""
    turn = Turn(axis, angle)
    kinds = dependence(graph, [x.index for x in axis])
    if all(kinds[x.index] <= {Kind.PARAMETER} for x in axis):
        return turn
    return DirectionCosines(turn_matrix(graph, turn))


def spin_of_step(step: PlacedStep) -> Triple | None:
    """Return the angular velocity of a step's end relative to its start, in the end's axes; None for a shift.

    Of a matrix it is read from ``R^T R' = w~``, above the diagonal: where the columns are no unit vectors, as
    natural coordinates away from their constraint, it is a smooth extension of the angular velocity.
    """
    if isinstance(step, Shift):
        return None
    if isinstance(step, Turn):
        (speed, _, _) = rate((step.angle, step.angle, step.angle))
        x, y, z = step.axis
        return (x * speed, y * speed, z * speed)
    columns, rates = transpose(step.cosines), transpose(_rates(step.cosines))
    return (inner(columns[2], rates[1]), inner(columns[0], rates[2]), inner(columns[1], rates[0]))


def _rates(a: Matrix) -> Matrix:
    return (rate(a[0]), rate(a[1]), rate(a[2]))


def _spin_of(graph: Graph, frame: PlacedFrame) -> Triple:
    zero = number(graph, 0)
    total = (zero, zero, zero)
    for step in frame.steps:
        own = spin_of_step(step)
        if own is not None and not isinstance(step, Shift):
            total = plus(apply_matrix(transpose(step.matrix(graph)), total), own)
    return total
