"""Solution of M x = b on the graph for positive definite M, without pivots.

LDL^T, Golub & Van Loan, Matrix Computations (2013), algorithm 4.1.2. Rows are eliminated from the last
up, because the last speeds belong to the leaves of the tree: that keeps the zeros of M (Featherstone
2008, section 6.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.expr.expression import Expr


class Solution(NamedTuple):
    """Unknowns, and the pivots that were divided by, one an unknown; a pivot that is 0 divided nothing."""

    values: list[Expr]
    pivots: list[Expr]


def solve_positive_definite(
    matrix: Sequence[Sequence[Expr]], right: Sequence[Expr], order: Sequence[int]
) -> Solution:
    """Return ``x`` with ``M x = b``; only the lower triangle of `matrix` is read.

    Parameters
    ----------
    order : sequence of int
        The unknowns from the root to the leaves of the tree.
    """
    n = len(right)
    a = [[matrix[max(i, j)][min(i, j)] for j in order] for i in order]
    x = [right[i] for i in order]
    pivots = x.copy()
    for k in reversed(range(n)):
        pivots[k] = a[k][k]
        if pivots[k].is_zero:
            a[k][k] = pivots[k] + 1
        for i in range(k):
            if a[k][i].is_zero:
                continue
            factor = a[k][i] / a[k][k]
            for j in range(i + 1):
                a[i][j] = a[i][j] - factor * a[k][j]
            x[i] = x[i] - factor * x[k]
    for i in range(n):
        for j in range(i):
            x[i] = x[i] - a[i][j] * x[j]
        x[i] = x[i] / a[i][i]
    place = {unknown: k for k, unknown in enumerate(order)}
    return Solution([x[place[i]] for i in range(n)], [pivots[place[i]] for i in range(n)])
