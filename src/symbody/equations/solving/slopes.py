"""Derivatives of accelerations without differentiating their solution.

``M u' = F`` says that the inverse dynamics ``D(q, u, u', r) = M u' - F`` vanish, so ``du'/dx = -M^-1 dD/dx``
with u' held fixed in D and the factors of M at hand. [Carpentier & Mansard, Analytical derivatives of rigid
body dynamics algorithms, RSS 2018]
"""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.formed import Formed
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.solving.solution import solve
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.expr.rewrite import substitute


def acceleration_slopes(formed: Formed, by: Sequence[Symbol]) -> list[list[Expr]]:
    """Return the derivatives of u' by symbols, one row a speed, all other symbols held fixed.

    Equations of a tree by recursion take the derivatives of their inverse dynamics; others those of the
    solution.
    """
    graph, nodes = formed.graph, [formed.graph.symbol(symbol) for symbol in by]
    udot, _ = solve(formed)
    recursion = formed.projection
    if not isinstance(recursion, Recursion) or formed.rows or formed.friction:
        rows = jacobian(graph, [rate.index for rate in udot], nodes)
        return [[Expr(graph, entry) for entry in row] for row in rows]
    symbols = formed.expressions([u.derivative for u in formed.u])
    missing = recursion.inverse_dynamics(symbols)
    entries = [entry for row in jacobian(graph, [x.index for x in missing], nodes) for entry in row]
    known = {symbol.index: value.index for symbol, value in zip(symbols, udot, strict=True)}
    slopes = [-Expr(graph, entry) for entry in substitute(graph, entries, known)]
    columns = [recursion.solve(slopes[k :: len(nodes)]).values for k in range(len(nodes))]
    return [list(row) for row in zip(*columns, strict=True)]


def inverse_dynamics(formed: Formed) -> list[Expr]:
    """Return ``M u' - F``, what is missing along each speed for accelerations given as the symbols u'."""
    symbols = formed.expressions([u.derivative for u in formed.u])
    if isinstance(formed.projection, Recursion):
        return formed.projection.inverse_dynamics(symbols)
    found = []
    for row, force in zip(formed.projection.mass_matrix, formed.projection.forcing, strict=True):
        total = -force
        for entry, rate in zip(row, symbols, strict=True):
            total = total + entry * rate
        found.append(total)
    return found
