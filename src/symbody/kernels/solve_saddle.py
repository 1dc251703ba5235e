"""The one kernel with pivots: accelerations and multipliers of a constrained system.

``docs/derivations/solve_saddle.md`` derives every step. All matrices are flat, by rows.
"""

from __future__ import annotations

from symbody.kernels.language import NAN, Reals, part
from symbody.kernels.saddle_factors import (
    CUT_FACTOR,
    EPSILON,
    apply_reflection,
    factor_mass,
    factor_rows,
    multiply_q,
    rotate_mass,
    scale_matrices,
)


def work_size(n: int, m: int) -> int:
    """Return how many numbers of scratch `solve_saddle` needs."""
    return 6 * n + 4 * m + n * (m + n)


def solve_saddle(
    n: int, m: int, M: Reals, J: Reals, F: Reals, gamma: Reals, result: Reals, work: Reals
) -> int:
    """Solve ``M udot = F + J^T lambda``, ``J udot = gamma``; return 0, or 1 if that is impossible.

    `result` (n + m + 1,) becomes udot, lambda and the rank of J. Rows of J that depend on others to rounding
    are left out, and their multipliers 0. All but the rank are NaN where M is not positive definite on the
    null space of J, or J is not finite. `work` is scratch of `work_size` numbers.
    """
    return solve_saddle_cut(n, m, M, J, F, gamma, CUT_FACTOR * m * EPSILON, result, work)


def solve_saddle_cut(
    n: int, m: int, M: Reals, J: Reals, F: Reals, gamma: Reals, rank_cut: float, result: Reals, work: Reals
) -> int:
    """Solve as `solve_saddle`; a row is left out if its relative distance from others is at most the cut."""
    d = part(work, 0, n)
    order = part(work, n, n)
    diagonal = part(work, 2 * n, n)
    beta = part(work, 3 * n, n)
    f = part(work, 4 * n, n)
    y = part(work, 5 * n, n)
    r = part(work, 6 * n, m)
    size = part(work, 6 * n + m, m)
    share = part(work, 6 * n + 2 * m, m)
    g = part(work, 6 * n + 3 * m, m)
    A = part(work, 6 * n + 4 * m, m * n)
    B = part(work, 6 * n + 4 * m + m * n, n * n)
    scale_matrices(n, m, M, J, d, r, A, B)
    rank = factor_rows(n, m, rank_cut, A, order, diagonal, beta, size, share)
    pivots = -1
    if rank >= 0:
        rotate_mass(n, rank, A, order, beta, B, y)
        pivots = factor_mass(n, rank, B, order)
    if pivots < n:
        for i in range(n + m):
            result[i] = NAN
        result[n + m] = float(max(rank, 0))
        return 1
    for i in range(n + m):
        result[i] = 0.0
    result[n + m] = float(rank)
    for _step in range(2):  # the solution, then its refinement
        scale_residual(n, rank, M, J, F, gamma, d, r, order, result, f, g)
        add_solution(n, rank, d, r, A, B, order, diagonal, beta, f, g, y, result)
    return 0


def scale_residual(
    n: int, rank: int, M: Reals, J: Reals, F: Reals, gamma: Reals, d: Reals, r: Reals,
    order: Reals, result: Reals, f: Reals, g: Reals,
) -> None:  # fmt: skip
    """Set f (n,) and, in kept rows, g (m,) to the scaled residuals of F and gamma."""
    for j in range(n):
        total = F[j]
        for k in range(rank):
            i = int(order[k])
            total = total + J[i * n + j] * result[n + i]
        for c in range(n):
            total = total - M[j * n + c] * result[c]
        f[j] = total * d[j]
    for k in range(rank):
        i = int(order[k])
        total = gamma[i]
        for j in range(n):
            total = total - J[i * n + j] * result[j]
        g[i] = total * r[i]


def add_solution(
    n: int, rank: int, d: Reals, r: Reals, A: Reals, B: Reals, order: Reals, diagonal: Reals,
    beta: Reals, f: Reals, g: Reals, y: Reals, result: Reals,
) -> None:  # fmt: skip
    """Solve the scaled system for f and g, which are overwritten, and add its solution."""
    for k in range(rank):
        apply_reflection(n, k, A, order, beta, f)
    solve_accelerations(n, rank, A, B, order, diagonal, f, g, y)
    solve_multipliers(n, rank, A, B, order, diagonal, f, y, g)
    multiply_q(n, rank, A, order, beta, y)
    for j in range(n):
        result[j] = result[j] + d[j] * y[j]
    for k in range(rank):
        i = int(order[k])
        result[n + i] = result[n + i] + r[i] * g[i]


def solve_accelerations(
    n: int, rank: int, A: Reals, B: Reals, order: Reals, diagonal: Reals, f: Reals, g: Reals, y: Reals
) -> None:
    """Set y = Q^T v from R^T y1 = g and B22 y2 = f2 - B21 y1, with f already rotated."""
    for k in range(rank):
        row = int(order[k])
        total = g[row]
        for j in range(k):
            total = total - A[row * n + j] * y[j]
        y[k] = total / diagonal[k]
    for i in range(rank, n):
        total = f[i]
        for j in range(rank):
            total = total - B[i * n + j] * y[j]
        y[i] = total
    solve_mass(n, rank, B, order, y)


def solve_multipliers(
    n: int, rank: int, A: Reals, B: Reals, order: Reals, diagonal: Reals, f: Reals, y: Reals, g: Reals
) -> None:
    """Overwrite g, in kept rows, with the solution of R lambda = B11 y1 + B12 y2 - f1."""
    for k in range(rank - 1, -1, -1):
        total = -f[k]
        for j in range(n):
            total = total + B[k * n + j] * y[j]
        for c in range(k + 1, rank):
            i = int(order[c])
            total = total - A[i * n + k] * g[i]
        g[int(order[k])] = total / diagonal[k]


def solve_mass(n: int, rank: int, B: Reals, order: Reals, y: Reals) -> None:
    """Solve with the Cholesky factor by columns, then by rows of its transpose [GVL 3.1]."""
    for k in range(rank, n):
        i = int(order[k])
        y[i] = y[i] / B[i * n + i]
        for c in range(k + 1, n):
            row = int(order[c])
            y[row] = y[row] - B[row * n + i] * y[i]
    for k in range(n - 1, rank - 1, -1):
        i = int(order[k])
        total = y[i]
        for c in range(k + 1, n):
            row = int(order[c])
            total = total - B[row * n + i] * y[row]
        y[i] = total / B[i * n + i]
