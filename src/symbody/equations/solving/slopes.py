"""Derivatives of accelerations without differentiating their solution.

``M u' = F`` says that the inverse dynamics ``D(q, u, u', r) = M u' - F`` vanish, so ``du'/dx = -M^-1 dD/dx``
with u' held fixed in D and the factors of M at hand. [Carpentier & Mansard, Analytical derivatives of rigid
body dynamics algorithms, RSS 2018]
"""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.formed import Formed
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.solving.columns import columns_side_by_side
from symbody.equations.solving.solution import solve
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import forward, jacobian
from symbody.expr.canonical import ONE, ZERO
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol
from symbody.expr.rewrite import substitute


def acceleration_slopes(
    formed: Formed, by: Sequence[Symbol], *, side_by_side: bool = False
) -> list[list[Expr]]:
    """Return the derivatives of u' by symbols, one row a speed, all other symbols held fixed.

    Equations of a tree by recursion take the derivatives of their inverse dynamics; others those of the
    solution.

    Parameters
    ----------
    side_by_side : bool
        Whether programs for several columns may be among the nodes: faster as code, but for nothing else.
    """
    graph, nodes = formed.graph, [formed.graph.symbol(symbol) for symbol in by]
    udot, _ = solve(formed)
    recursion = formed.projection
    if not isinstance(recursion, Recursion) or formed.rows or formed.friction:
        rows = jacobian(graph, [rate.index for rate in udot], nodes)
        return [[Expr(graph, entry) for entry in row] for row in rows]
    if side_by_side:
        found = columns_side_by_side(formed, recursion, by, udot)
        if found is not None:
            return found
    symbols = formed.expressions([u.derivative for u in formed.u])
    missing = recursion.inverse_dynamics(symbols)
    roots = [x.index for x in missing]
    entries = [entry for column in columns_of_slopes(graph, roots, nodes) for entry in column]
    known = {symbol.index: value.index for symbol, value in zip(symbols, udot, strict=True)}
    slopes = [-Expr(graph, entry) for entry in substitute(graph, entries, known)]
    n = len(roots)
    columns = recursion.solve_columns([slopes[k : k + n] for k in range(0, len(slopes), n)])
    return [list(row) for row in zip(*columns, strict=True)] if columns else [[] for _ in udot]


def columns_of_slopes(graph: Graph, roots: Sequence[int], by: Sequence[int]) -> list[list[int]]:
    """Return the derivatives of inverse dynamics by symbols, one column a symbol.

    Forward, whatever the numbers of both: what turns with one joint changes few links, while each root is
    reached from all.
    """
    still = dict.fromkeys(by, ZERO)
    return [forward(graph, roots, {**still, node: ONE}) for node in by]


def inverse_dynamics(formed: Formed) -> list[Expr]:
    """Return ``M u' - F``, what is missing along each speed for accelerations given as the symbols u'.

    Raises
    ------
    FormulationError
        If there is friction, which follows from accelerations only together with the forces that are asked.
    """
    if formed.friction:
        names = ", ".join(sorted({law.joint.name for law in formed.friction}))
        raise FormulationError(
            Problem("equations.inverse_friction", "inverse_dynamics", f"there is friction in {names}",
                    "it depends on the forces that are to be found",
                    "use inverse_dynamics(eqs, motion, unknowns, times), which solves for both")
        )  # fmt: skip
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
