"""Solution of M x = b for positive definite M, without pivoting.

``M = L^T D L``, eliminated from the leaves of the tree inward, has an entry only where one speed carries the
other (Featherstone 2008, section 6.5 and table 6.3; Golub & Van Loan 2013, algorithm 4.1.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.expr.expression import Expr

# The entries of a symmetric matrix at and left of the diagonal, row by row from the root to the leaves.
Rows = list[dict[int, Expr]]


class LinearSolution(NamedTuple):
    """Unknowns, and the pivots that were divided by, one an unknown; a pivot that is 0 divided nothing."""

    values: list[Expr]
    pivots: list[Expr]


class TreeFactors(NamedTuple):
    """``M = L^T D L``.

    Attributes
    ----------
    lower : list of mapping
        What is left of the diagonal of each row of L.
    pivots : list of Expr
        D; one that is the constant 0 counts as 1.
    inverse : list of Expr
        ``D^-1``, worth its operations where many columns are solved for; empty: each is divided by D.
    """

    lower: Rows
    pivots: list[Expr]
    inverse: list[Expr]

    def divide(self, x: Expr, k: int) -> Expr:
        """Return ``x / D_k``."""
        if self.inverse:
            return x * self.inverse[k]
        return x if self.pivots[k].is_zero else x / self.pivots[k]


def factor(rows: Rows, *, invert: bool = True) -> TreeFactors:
    """Return the factors of a positive definite matrix (table 6.3), with the inverse pivots if `invert`."""
    entries = [dict(row) for row in rows]
    pivots = [row[k] for k, row in enumerate(rows)]
    inverse = pivots.copy() if invert else []
    factors = TreeFactors([{} for _ in rows], pivots, inverse)
    for k in reversed(range(len(rows))):
        pivot = pivots[k] = entries[k].pop(k)
        if invert:
            inverse[k] = pivot + 1 if pivot.is_zero else 1 / pivot
        carriers = sorted((i for i, entry in entries[k].items() if not entry.is_zero), reverse=True)
        for i in carriers:
            share = factors.lower[k][i] = factors.divide(entries[k][i], k)
            for j in carriers:
                if j <= i:
                    product = share * entries[k][j]
                    entries[i][j] = entries[i][j] - product if j in entries[i] else -product
    return factors


def solve_factored(factors: TreeFactors, right: Sequence[Expr]) -> list[Expr]:
    """Return x with ``M x = right``, both from the root to the leaves."""
    x = list(right)
    for k in reversed(range(len(x))):
        for i, share in factors.lower[k].items():
            x[i] = x[i] - share * x[k]
    for k, row in enumerate(factors.lower):
        x[k] = factors.divide(x[k], k)
        for i in sorted(row):  # the last that is computed is needed last
            x[k] = x[k] - row[i] * x[i]
    return x


def solve_positive_definite(
    matrix: Sequence[Sequence[Expr]], right: Sequence[Expr], order: Sequence[int]
) -> LinearSolution:
    """Return ``x`` with ``M x = b``; one entry of each symmetric pair is read.

    Parameters
    ----------
    order : sequence of int
        The unknowns from the root to the leaves of the tree.
    """
    rows = [
        {j: matrix[max(a, b)][min(a, b)] for j, b in enumerate(order[: i + 1])} for i, a in enumerate(order)
    ]
    factors = factor(rows, invert=False)
    x = solve_factored(factors, [right[unknown] for unknown in order])
    place = {unknown: k for k, unknown in enumerate(order)}
    n = len(order)
    return LinearSolution([x[place[i]] for i in range(n)], [factors.pivots[place[i]] for i in range(n)])
