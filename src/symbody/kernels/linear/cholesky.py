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


def solve_lower(n: int, width: int, L: Reals, x: Reals) -> None:
    """Overwrite x (n,) by the solution of ``L L^T x = b``; L has rows of some width."""
    for i in range(n):
        total = x[i]
        for j in range(i):
            total = total - L[i * width + j] * x[j]
        x[i] = total / L[i * width + i]
    for i in range(n - 1, -1, -1):
        rest = x[i]
        for j in range(i + 1, n):
            rest = rest - L[j * width + i] * x[j]
        x[i] = rest / L[i * width + i]
