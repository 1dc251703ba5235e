"""Placements as plain expressions, and motion as their derivatives on the graph.

The position r of an origin and the matrix R of a frame follow from the laws of the joints. Everything else is
differentiation with ``q' = N u + nu``: velocity r', angular velocity from ``R^T R' = w~``, partial
velocities by u, accelerations with u' = 0 by a second derivative. None of the vector formulas of `motion`
takes part, so what is formed on this and what is formed there are two derivations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.velocity import Velocity
from symbody.expr.calculus import forward, jacobian
from symbody.expr.expression import Expr, number
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import TIME, Graph
from symbody.expr.rewrite import substitute
from symbody.spatial.matrix import Matrix, Triple
from symbody.spatial.rotation import spin as spin
from symbody.spatial.vector import ZERO, Vector, components, vector


@dataclass(frozen=True, slots=True)
class GroundPlacement:
    """Where a frame stands relative to ground.

    Attributes
    ----------
    r : (3,) Expr
        From ground's origin to the frame's, in ground axes [m].
    R : (3, 3) Expr
        Components in the frame to components in ground. Of Euler parameters the entries are quadratic: off
        the unit sphere R is a rotation times the square of their norm.
    """

    r: Triple
    R: Matrix


def ground_placement(kinematics: Kinematics, frame: str) -> GroundPlacement:
    """Return the placement of a frame, in coordinates, parameters and time."""
    tree = kinematics.tree
    r = components(tree, kinematics.position("ground", frame), "ground")
    return GroundPlacement(r, tree.matrix("ground", frame))


def flow(kinematics: Kinematics) -> dict[int, int]:
    """Return the tangents of time with u' = 0: q' = N u + nu, and t' = 1."""
    graph = kinematics.graph
    return {**kinematics.rates, graph.symbol(TIME): graph.constant(1)}


def differentiate(graph: Graph, values: Sequence[Expr], tangents: Mapping[int, int]) -> list[Expr]:
    """Return the derivatives of expressions along a direction, as expressions."""
    return [Expr(graph, node) for node in forward(graph, [value.index for value in values], tangents)]


def differentiate_matrix(graph: Graph, R: Matrix, tangents: Mapping[int, int]) -> Matrix:
    """Return the derivative of a matrix along a direction."""
    flat = differentiate(graph, [entry for row in R for entry in row], tangents)
    return (_triple(flat, 0), _triple(flat, 3), _triple(flat, 6))


def differentiate_placements(kinematics: Kinematics) -> Kinematics:
    """Return the same frames with all velocities found by differentiating placements.

    Velocities of origins are in ground axes, angular velocities in the axes of their frame.
    """
    graph, tree = kinematics.graph, kinematics.tree
    tangents = flow(kinematics)
    origins = list(kinematics.velocities)
    homes = list(dict.fromkeys(tree.orientation_frame(frame) for frame in kinematics.angular_velocities))
    places = [
        x for frame in origins for x in components(tree, kinematics.position("ground", frame), "ground")
    ]
    values = differentiate(graph, places, tangents)
    for home in homes:
        R = tree.matrix("ground", home)
        values += spin(R, differentiate_matrix(graph, R, tangents))
    velocities = _motions(kinematics, values, ["ground"] * len(origins) + homes)
    at = dict(zip(homes, velocities[len(origins) :], strict=True))
    return replace(
        kinematics,
        velocities=dict(zip(origins, velocities[: len(origins)], strict=True)),
        angular_velocities={
            frame: at[tree.orientation_frame(frame)] for frame in kinematics.angular_velocities
        },
    )


def differentiate_constraints(
    kinematics: Kinematics, rows: Sequence[ConstraintEquation]
) -> list[ConstraintEquation]:
    """Return constraints with J and gamma found by differentiating Phi twice; others as they are."""
    equations = [
        scalar_equation(kinematics, row.name, row.element, row.value) if row.is_holonomic else row
        for row in rows
    ]
    slopes = [slope for row in equations for slope in row.jacobian.values()]
    kept = iter(fold_zeros(kinematics.graph, slopes))
    result = []
    for row, raw in zip(rows, equations, strict=True):
        pairs = {u: next(kept) for u in raw.jacobian}
        nonzero = {u: slope for u, slope in pairs.items() if not slope.is_zero}
        result.append(replace(row, jacobian=nonzero, drift=raw.drift, gamma=raw.gamma))
    return result


def fold_zeros(graph: Graph, values: Sequence[Expr]) -> list[Expr]:
    """Return expressions, those that vanish identically as the constant 0; by fingerprint."""
    nodes = [value.index for value in values]
    marks = fingerprints(graph, list(graph.reachable(nodes)))
    return [Expr(graph, 0) if marks[node] == (0, 0) else Expr(graph, node) for node in nodes]


def _motions(kinematics: Kinematics, values: Sequence[Expr], frames: Sequence[str]) -> list[Velocity]:
    """Return velocities given three by three, each in the axes of its frame."""
    graph, speeds = kinematics.graph, kinematics.speeds
    nodes = [value.index for value in values]
    biases = differentiate(graph, values, flow(kinematics))
    rests = [Expr(graph, node) for node in substitute(graph, nodes, dict.fromkeys(speeds, 0))]
    slopes = [Expr(graph, node) for row in jacobian(graph, nodes, speeds) for node in row]
    n, count = len(values), len(speeds)
    clean = fold_zeros(graph, [*values, *rests, *biases, *slopes])
    whole, rests, biases, slopes = clean[:n], clean[n : 2 * n], clean[2 * n : 3 * n], clean[3 * n :]
    velocities = []
    for k, frame in enumerate(frames):
        at = 3 * k
        partials: dict[int, Vector] = {}
        for j, u in enumerate(speeds):
            column = [slopes[(at + i) * count + j] for i in range(3)]
            if any(not x.is_zero for x in column):
                partials[u] = vector(frame, _triple(column, 0))
        velocities.append(
            Velocity(
                partials,
                vector(frame, _triple(rests, at)),
                vector(frame, _triple(whole, at)),
                vector(frame, _triple(biases, at)),
            )
        )
    return velocities


def unit(graph: Graph, frame: str, k: int) -> Vector:
    """Return the unit vector along axis k of a frame."""
    zero, one = number(graph, 0), number(graph, 1)
    x, y, z = (one if i == k else zero for i in range(3))
    return vector(frame, (x, y, z)) if 0 <= k < 3 else ZERO


def _triple(values: Sequence[Expr], at: int) -> Triple:
    return (values[at], values[at + 1], values[at + 2])
