"""Speeds that no mass and no constraint resists."""

from __future__ import annotations

from symbody.kernels.language import Reals, part
from symbody.kernels.saddle_factors import (
    count_massless,
    factor_mass,
    factor_rows,
    multiply_q,
    permute_back,
    rotate_mass,
    scale_matrices,
)


def find_null_vector(
    n: int, m: int, M: Reals, J: Reals, rank_cut: float, negligible: float, u: Reals, work: Reals
) -> int:
    """Set u (n,) != 0 to a solution of ``M u = 0``, ``J u = 0``; return 1, or 0 if there is none.

    Entries below the share `negligible` of the largest, in scaled speeds, become exactly 0. `work` is scratch
    of ``6 n + 4 m + n (m + n)`` numbers. J that is not finite has no solution.
    """
    d = part(work, 0, n)
    inverse = part(work, n, n)
    beta = part(work, 2 * n, n)
    columns = part(work, 3 * n, n)
    v = part(work, 4 * n, n)
    p = part(work, 5 * n, n)
    r = part(work, 6 * n, m)
    rows = part(work, 6 * n + m, m)
    weight = part(work, 6 * n + 2 * m, m)
    share = part(work, 6 * n + 3 * m, m)
    A = part(work, 6 * n + 4 * m, m * n)
    B = part(work, 6 * n + 4 * m + m * n, n * n)
    scale_matrices(n, m, count_massless(n, M), M, J, d, r, v, weight, A, B)
    rank = factor_rows(n, m, rank_cut, A, rows, r, inverse, beta, weight, share)
    if rank < 0:
        return 0
    rotate_mass(n, rank, A, beta, B, p)
    pivots = factor_mass(n, rank, B, columns, inverse)
    if pivots >= n:
        return 0
    for j in range(n):
        v[j] = 0.0
    v[pivots] = 1.0
    for k in range(pivots - 1, rank - 1, -1):
        total = 0.0
        for c in range(k + 1, pivots + 1):
            total = total - B[k * n + c] * v[c]
        v[k] = total * inverse[k]
    permute_back(n, rank, columns, v)
    multiply_q(n, rank, A, beta, v)
    top = 0.0
    for j in range(n):
        top = max(top, abs(v[j]))
    for j in range(n):
        u[j] = 0.0
        if abs(v[j]) > negligible * top:
            u[j] = d[j] * v[j]
    return 1
