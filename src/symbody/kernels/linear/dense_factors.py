"""Factors of a dense matrix with exchanges of rows: Golub and Van Loan, Matrix Computations, section 3.4."""

from __future__ import annotations

from symbody.kernels.language import Reals


def factor_dense(n: int, S: Reals, pivots: Reals) -> int:
    """Overwrite S (n, n) by its factors, `pivots` (n,) by rows to exchange; return 0 if it is singular."""
    for k in range(n):
        best = k
        largest = abs(S[k * n + k])
        for i in range(k + 1, n):
            size = abs(S[i * n + k])
            if size > largest:
                largest = size
                best = i
        pivots[k] = float(best)
        if not largest > 0.0:
            return 0
        if best != k:
            exchange_rows(n, k, best, S)
        inverse = 1.0 / S[k * n + k]
        for i in range(k + 1, n):
            factor = S[i * n + k] * inverse
            S[i * n + k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    S[i * n + j] = S[i * n + j] - factor * S[k * n + j]
    return 1


def exchange_rows(n: int, a: int, b: int, S: Reals) -> None:
    """Exchange two rows of a matrix (n, n)."""
    for j in range(n):
        kept = S[a * n + j]
        S[a * n + j] = S[b * n + j]
        S[b * n + j] = kept


def solve_dense(n: int, S: Reals, pivots: Reals, y: Reals) -> None:
    """Overwrite y (n,) by the solution, from what `factor_dense` left."""
    for k in range(n):
        best = int(pivots[k])
        kept = y[best]
        y[best] = y[k]
        y[k] = kept
    for i in range(1, n):
        total = y[i]
        for j in range(i):
            total = total - S[i * n + j] * y[j]
        y[i] = total
    for i in range(n - 1, -1, -1):
        total = y[i]
        for j in range(i + 1, n):
            total = total - S[i * n + j] * y[j]
        y[i] = total / S[i * n + i]
