"""The one kernel with pivots: accelerations and multipliers of a constrained system.

``docs/derivations/solve_saddle.md`` derives every step. All matrices are flat, by rows.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import NAN, Reals, part
from symbody.kernels.linear.saddle_factors import (
    CUT_FACTOR,
    EPSILON,
    apply_reflection,
    count_massless,
    factor_mass,
    factor_rows,
    multiply_q,
    permute,
    permute_back,
    rotate_mass,
    scale_matrices,
)

# Of the inverses of both factors' diagonals; below, refinement finds nothing to do. Where rows depend on
# others it does: accelerations that are 0 come out as rounding, which error control would follow.
STEEPEST: Final = 16.0


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
    rank = factor_constraints(n, m, count_massless(n, M), M, J, rank_cut, work)
    return solve_factored(n, m, rank, M, J, F, gamma, result, work)


def solve_independent(
    n: int, m: int, M: Reals, J: Reals, F: Reals, gamma: Reals, result: Reals, work: Reals
) -> int:
    """Solve as `solve_saddle` if all coordinates have mass and no row of J is left out; else return 2.

    For sizes known when compiling: then the rank is known, too. Where it returns 2 there is no result.
    """
    if count_massless(n, M) > 0:
        return 2
    rank = factor_constraints(n, m, 0, M, J, CUT_FACTOR * m * EPSILON, work)
    if rank < m:
        return 2
    return solve_factored(n, m, m, M, J, F, gamma, result, work)


def factor_constraints(
    n: int, m: int, massless: int, M: Reals, J: Reals, rank_cut: float, work: Reals
) -> int:
    """Scale M and J and factor J; return its rank, or -1 if J is not finite."""
    d = part(work, 0, n)
    inverse = part(work, n, n)
    beta = part(work, 2 * n, n)
    r = part(work, 6 * n, m)
    rows = part(work, 6 * n + m, m)
    weight = part(work, 6 * n + 2 * m, m)
    share = part(work, 6 * n + 3 * m, m)
    A = part(work, 6 * n + 4 * m, m * n)
    B = part(work, 6 * n + 4 * m + m * n, n * n)
    scale_matrices(n, m, massless, M, J, d, r, inverse, weight, A, B)
    return factor_rows(n, m, rank_cut, A, rows, r, inverse, beta, weight, share)


def solve_factored(
    n: int, m: int, rank: int, M: Reals, J: Reals, F: Reals, gamma: Reals, result: Reals, work: Reals
) -> int:
    """Solve with what `factor_constraints` left in `work`."""
    d = part(work, 0, n)
    inverse = part(work, n, n)
    beta = part(work, 2 * n, n)
    columns = part(work, 3 * n, n)
    f = part(work, 4 * n, n)
    y = part(work, 5 * n, n)
    r = part(work, 6 * n, m)
    rows = part(work, 6 * n + m, m)
    g = part(work, 6 * n + 2 * m, m)
    multipliers = part(work, 6 * n + 3 * m, m)
    A = part(work, 6 * n + 4 * m, m * n)
    B = part(work, 6 * n + 4 * m + m * n, n * n)
    pivots = -1
    if rank >= 0:
        rotate_mass(n, rank, A, beta, B, y)
        pivots = factor_mass(n, rank, B, columns, inverse)
    if pivots < n:
        refuse(n, m, rank, result)
        return 1
    for j in range(n):
        f[j] = F[j] * d[j]
    for k in range(rank):
        g[k] = gamma[int(rows[k])] * r[k]
    solve_scaled(n, rank, A, B, columns, inverse, beta, f, g, y)
    for j in range(n):
        result[j] = d[j] * y[j]
    for k in range(rank):
        multipliers[k] = r[k] * g[k]
    if rank < m or not steepness(n, inverse) < STEEPEST:
        scale_residual(n, rank, M, J, F, gamma, d, r, rows, result, multipliers, f, g)
        solve_scaled(n, rank, A, B, columns, inverse, beta, f, g, y)
        for j in range(n):
            result[j] = result[j] + d[j] * y[j]
        for k in range(rank):
            multipliers[k] = multipliers[k] + r[k] * g[k]
    put_multipliers(n, m, rank, rows, multipliers, result)
    return 0


def refuse(n: int, m: int, rank: int, result: Reals) -> None:
    """Set all results but the rank to NaN."""
    for i in range(n + m):
        result[i] = NAN
    result[n + m] = float(max(rank, 0))


def steepness(n: int, inverse: Reals) -> float:
    """Return the largest inverse of an entry of the diagonals of both factors."""
    steepest = 0.0
    for k in range(n):
        steepest = max(steepest, abs(inverse[k]))
    return steepest


def put_multipliers(n: int, m: int, rank: int, rows: Reals, multipliers: Reals, result: Reals) -> None:
    """Store the multipliers where their rows stand in J, 0 for rows that were left out, and the rank."""
    for k in range(rank):
        result[n + int(rows[k])] = multipliers[k]
    for k in range(rank, m):
        result[n + int(rows[k])] = 0.0
    result[n + m] = float(rank)


def scale_residual(
    n: int, rank: int, M: Reals, J: Reals, F: Reals, gamma: Reals, d: Reals, r: Reals,
    rows: Reals, udot: Reals, multipliers: Reals, f: Reals, g: Reals,
) -> None:  # fmt: skip
    """Set f (n,) and, in kept rows, g (m,) to the scaled residuals of F and gamma."""
    for j in range(n):
        f[j] = F[j]
    for k in range(rank):
        row = int(rows[k])
        total = gamma[row]
        for j in range(n):
            f[j] = f[j] + J[row * n + j] * multipliers[k]
            total = total - J[row * n + j] * udot[j]
        g[k] = total * r[k]
    for c in range(n):
        for j in range(n):
            f[j] = f[j] - M[c * n + j] * udot[c]
    for j in range(n):
        f[j] = f[j] * d[j]


def solve_scaled(
    n: int, rank: int, A: Reals, B: Reals, columns: Reals, inverse: Reals, beta: Reals,
    f: Reals, g: Reals, y: Reals,
) -> None:  # fmt: skip
    """Solve the scaled system: y (n,) from f and g, and g overwritten with the multipliers."""
    for k in range(rank):
        apply_reflection(n, k, A, beta, f)
    permute(n, rank, columns, f)
    solve_accelerations(n, rank, A, B, inverse, f, g, y)
    solve_multipliers(n, rank, A, B, inverse, f, y, g)
    permute_back(n, rank, columns, y)
    multiply_q(n, rank, A, beta, y)


def solve_accelerations(
    n: int, rank: int, A: Reals, B: Reals, inverse: Reals, f: Reals, g: Reals, y: Reals
) -> None:
    """Set y = Q^T v from R^T y1 = g and B22 y2 = f2 - B21 y1, with f already rotated."""
    for k in range(rank):
        total = g[k]
        for j in range(k):
            total = total - A[k * n + j] * y[j]
        y[k] = total * inverse[k]
    for i in range(rank, n):
        y[i] = f[i]
    for k in range(rank):
        for i in range(rank, n):
            y[i] = y[i] - B[k * n + i] * y[k]
    for k in range(rank, n):
        factor = y[k] * inverse[k]
        for i in range(k + 1, n):
            y[i] = y[i] - factor * B[k * n + i]
    for k in range(n - 1, rank - 1, -1):
        total = y[k]
        for i in range(k + 1, n):
            total = total - B[k * n + i] * y[i]
        y[k] = total * inverse[k]


def solve_multipliers(
    n: int, rank: int, A: Reals, B: Reals, inverse: Reals, f: Reals, y: Reals, g: Reals
) -> None:
    """Overwrite g, in kept rows, with the solution of R lambda = B11 y1 + B12 y2 - f1."""
    for k in range(rank - 1, -1, -1):
        total = B[k * n] * y[0] - f[k]
        for j in range(1, n):
            total = total + B[k * n + j] * y[j]
        for c in range(k + 1, rank):
            total = total - A[c * n + k] * g[c]
        g[k] = total * inverse[k]
