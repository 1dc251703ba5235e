"""Whether a constraint on velocities is the rate of one on positions, times some factor.

A row ``sum a_i x_i' = 0``, time among the x with x' = 1, is integrable by itself if and only if
``a_i (d_j a_k - d_k a_j) + a_j (d_k a_i - d_i a_k) + a_k (d_i a_j - d_j a_i) = 0`` for all i < j < k
(Frobenius; Neimark & Fufaev 1972, chapter 1).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import TIME, SymbolKind
from symbody.expr.rewrite import symbols_of


def is_integrable(kinematics: Kinematics, row: ConstraintEquation) -> bool:
    """Return whether a row alone holds the mechanism on a family of positions.

    Rows in quasi-speeds, and in more than a dozen variables, are not judged: False.
    """
    graph = kinematics.graph
    factors: dict[int, Expr] = {}
    for u, slope in row.jacobian.items():
        symbol = graph.symbols[graph.left[u]]
        if symbol.kind is not SymbolKind.COORDINATE:
            return False
        factors[graph.symbol(replace(symbol, order=0))] = slope
    if not row.drift.is_zero:
        factors[graph.symbol(TIME)] = row.drift
    inside = symbols_of(graph, [factor.index for factor in factors.values()])
    kinds = (SymbolKind.COORDINATE, SymbolKind.TIME)
    by = sorted({*factors, *(x for x in inside if graph.symbols[graph.left[x]].kind in kinds)})
    if len(by) > 12:
        return False
    zero = Expr(graph, 0)
    a = [factors.get(x, zero) for x in by]
    d = [[Expr(graph, node) for node in gradient(graph, factor.index, by)] for factor in a]
    curls = [
        a[i] * (d[k][j] - d[j][k]) + a[j] * (d[i][k] - d[k][i]) + a[k] * (d[j][i] - d[i][j])
        for i, j, k in combinations(range(len(by)), 3)
    ]
    return all(find_zeros(graph, [curl.index for curl in curls]))
