"""Factors of a symmetric positive matrix, without exchanges: Golub and Van Loan, section 4.2."""

from __future__ import annotations

from symbody.kernels.language import Reals, sqrt


def factor_positive(n: int, A: Reals) -> int:
    """Overwrite the lower half of A (n, n) by its factor; return 0 if A is not positive definite."""
    for i in range(n):
        for j in range(i + 1):
            total = A[i * n + j]
            for k in range(j):
                total = total - A[i * n + k] * A[j * n + k]
            if j < i:
                A[i * n + j] = total / A[j * n + j]
            elif total > 0.0:
                A[i * n + i] = sqrt(total)
            else:
                return 0
    return 1


def solve_positive(n: int, A: Reals, y: Reals) -> None:
    """Overwrite y (n,) by the solution, from what `factor_positive` left."""
    for i in range(n):
        total = y[i]
        for k in range(i):
            total = total - A[i * n + k] * y[k]
        y[i] = total / A[i * n + i]
    for i in range(n - 1, -1, -1):
        total = y[i]
        for k in range(i + 1, n):
            total = total - A[k * n + i] * y[k]
        y[i] = total / A[i * n + i]
