"""Moves back onto the constraints: what a compiled loop adds to a state that has drifted.

Of all moves that close the constraints to first order the one with the least kinetic energy is taken: the
same `solve_saddle` as for accelerations, with no force. Quaternions are brought to unit norm beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.expr.expression import Expr, number, saddle_entry, sqrt
from symbody.expr.graph import KernelNode
from symbody.expr.rewrite import substitute


def position_residual(formed: EquationsOfMotion) -> list[Expr]:
    """Return the constraints Phi, then by how much the norm of each quaternion exceeds 1."""
    norms = [sqrt(_square(formed, quaternion)) - 1 for quaternion in formed.variables.quaternions]
    return [*(row.value for row in formed.holonomic), *norms]


def position_move(formed: EquationsOfMotion) -> list[Expr]:
    """Return what to add to q so that the position residual vanishes to first order."""
    graph = formed.graph
    holonomic = formed.holonomic
    moves = _coordinate_change(formed, _least_move(formed, holonomic, [-row.value for row in holonomic]))
    place = {graph.symbol(symbol): k for k, symbol in enumerate(formed.q)}
    for quaternion in formed.variables.quaternions:
        norm = sqrt(_square(formed, quaternion))
        for node in quaternion:
            moves[place[node]] = moves[place[node]] + (Expr(graph, node) / norm - Expr(graph, node))
    return moves


def velocity_residual(formed: EquationsOfMotion) -> list[Expr]:
    """Return ``J u + b``."""
    drift = []
    for row in formed.rows:
        total = row.drift
        for u, slope in row.jacobian.items():
            total = total + slope * Expr(formed.graph, u)
        drift.append(total)
    return drift


def velocity_move(formed: EquationsOfMotion) -> list[Expr]:
    """Return what to add to u so that the velocity residual vanishes."""
    return _least_move(formed, formed.rows, [-x for x in velocity_residual(formed)])


def _least_move(
    formed: EquationsOfMotion, rows: Sequence[ConstraintEquation], gamma: Sequence[Expr]
) -> list[Expr]:
    """Return the move of the speeds with ``J move = gamma`` for some rows, least in the mass matrix."""
    zero = number(formed.graph, 0)
    n, m = len(formed.u), len(rows)
    if m == 0:
        return [zero] * n
    mass = [entry for row in formed.dynamics.mass_matrix for entry in row]
    slopes = [row.jacobian.get(u, zero) for row in rows for u in formed.kinematics.speeds]
    operands = tuple(x.index for x in (*mass, *slopes, *[zero] * n, *gamma))
    kernel = formed.graph.kernel(KernelNode(n, m))
    return [saddle_entry(formed.graph, kernel, operands, k) for k in range(n)]


def _coordinate_change(formed: EquationsOfMotion, speeds: list[Expr]) -> list[Expr]:
    """Return the change of q for a small motion ``u dt``: N times it, without explicit time."""
    graph, rates = formed.graph, formed.variables.rates
    nodes = [rates[graph.symbol(q)] for q in formed.q]
    own = formed.kinematics.speeds
    moved = substitute(graph, nodes, {u: x.index for u, x in zip(own, speeds, strict=True)})
    rest = substitute(graph, nodes, dict.fromkeys(own, 0))
    return [Expr(graph, node) - Expr(graph, other) for node, other in zip(moved, rest, strict=True)]


def _square(formed: EquationsOfMotion, nodes: tuple[int, ...]) -> Expr:
    total = number(formed.graph, 0)
    for node in nodes:
        total = total + Expr(formed.graph, node) ** 2
    return total
