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
    """Unknowns, and the pivots that were divided by, one an unknown.

    If a pivot is the constant 0 there are no values, and the pivots not reached are 1.
    """

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
    place = {unknown: k for k, unknown in enumerate(order)}
    for k in reversed(range(n)):
        if a[k][k].is_zero:
            return Solution([], [a[place[i]][place[i]] if place[i] >= k else a[k][k] + 1 for i in range(n)])
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
    return Solution([x[place[i]] for i in range(n)], [a[place[i]][place[i]] for i in range(n)])
