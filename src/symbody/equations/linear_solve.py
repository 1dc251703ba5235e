"""Solution of M x = b on the graph for positive definite M, without pivots.

LDL^T, Golub & Van Loan, Matrix Computations (2013), algorithm 4.1.2. Rows are eliminated from the last
up, because the last speeds belong to the leaves of the tree: that keeps the zeros of M (Featherstone
2008, section 6.5).
"""

from __future__ import annotations

from collections.abc import Sequence

from symbody.expr.expression import Expr


def solve_positive_definite(matrix: Sequence[Sequence[Expr]], right: Sequence[Expr]) -> list[Expr]:
    """Return ``x`` with ``M x = b``; only the lower triangle of `matrix` is read."""
    n = len(right)
    a = [list(row) for row in matrix]
    x = list(right)
    for k in reversed(range(n)):
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
    return x
