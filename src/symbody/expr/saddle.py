"""The one kernel with pivots: accelerations and multipliers of a constrained system.

``solve_saddle`` solves ``M udot = F + J^T lambda``, ``J udot = gamma`` by the null-space method, where M is
symmetric and positive definite on the null space of J only (massless bodies) and rows of J may depend on
each other; ``docs/derivations/solve_saddle.md`` derives every step. The loops here and in `saddle_factors`
are the definition: the kernels in `codegen.texts.saddle_c` and `codegen.llvm.saddle` repeat them operation by
operation and return the same bits. All matrices are flat, row-major sequences; entries are floats, or
``mpmath.mpf`` together with ``sqrt=mpmath.sqrt``.

Sources: [GVL] Golub and Van Loan, Matrix Computations, 4th ed.; [H] Higham, Accuracy and Stability of
Numerical Algorithms, 2nd ed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from symbody.expr.saddle_factors import (
    CUT_FACTOR,
    EPSILON,
    Factors,
    SquareRoot,
    apply_reflection,
    factor,
    multiply_q,
)

NEGLIGIBLE: Final = 1e-8  # entries of a null vector below this share of the largest are zero


class SaddleSolution(NamedTuple):
    """What `solve_saddle` returns.

    Attributes
    ----------
    udot : list of float
        (n,) accelerations; NaN if not `ok`.
    multipliers : list of float
        (m,) multipliers lambda, 0 for rows that were dropped; NaN if not `ok`.
    rank : int
        How many rows of J were kept.
    ok : bool
        False if M is not positive definite on the null space of J, or J is not finite.
    """

    udot: list[float]
    multipliers: list[float]
    rank: int
    ok: bool


def default_rank_cut(m: int) -> float:
    """Return the cut that drops rows which depend on others to rounding."""
    return CUT_FACTOR * m * EPSILON


def solve_saddle(
    M: Sequence[float],
    J: Sequence[float],
    F: Sequence[float],
    gamma: Sequence[float],
    *,
    rank_cut: float | None = None,
    sqrt: SquareRoot = math.sqrt,
) -> SaddleSolution:
    """Solve ``M udot = F + J^T lambda``, ``J udot = gamma``.

    A row is dropped, its equation ignored and its multiplier set to 0, if its distance from the span of the
    rows kept is at most `rank_cut` times its length, both measured with scaled columns (about
    ``J M^(-1/2)``). Rows are kept in the order of their relative distance, but an earlier row goes before a
    later one of less than four times its distance; so the first of several equal rows stays.

    Parameters
    ----------
    M : (n, n) symmetric; only zeros in rows of massless coordinates.
    J : (m, n) rows in any units, also zero, repeated or dependent.
    F, gamma : (n,) and (m,)
    rank_cut : ``1000 m eps`` by default. About 1e-3 passes change points of a mechanism.
    sqrt : square root for the type of the entries.

    Notes
    -----
    With S = diag(d, r), K = S [[M, -J^T], [J, 0]] S (kept rows), x = S^-1 (udot, lambda), b = S (F, gamma),

        cond = max_j (|K^-1| (|K| |x| + |b|))_j / max_j |x_j|,  j = 1 .. n,

    is the largest relative change of the scaled accelerations, in units of eps, when every entry of M, J, F
    and gamma changes by one relative eps [H section 7.2]. One step of refinement in the same precision makes
    the error a small multiple of eps cond [H section 12.1]; the derivation has the measured figures.
    """
    n, m = len(F), len(gamma)
    cut = default_rank_cut(m) if rank_cut is None else rank_cut
    factors, rank, definite = factor(n, m, M, J, cut, sqrt)
    if definite < n:
        return SaddleSolution([math.nan] * n, [math.nan] * m, rank, ok=False)
    udot, multipliers = [0.0] * n, [0.0] * m
    for _ in range(2):  # the solution, then its refinement
        f, g = _scaled_residual(factors, rank, M, J, F, gamma, udot, multipliers)
        _add_solution(factors, rank, f, g, udot, multipliers)
    return SaddleSolution(udot, multipliers, rank, ok=True)


def null_vector(
    M: Sequence[float],
    J: Sequence[float],
    n: int,
    m: int,
    *,
    rank_cut: float | None = None,
    sqrt: SquareRoot = math.sqrt,
) -> list[float] | None:
    """Return speeds u != 0 with ``M u = 0`` and ``J u = 0``, or None if there are none.

    The largest entry is 1 and entries negligible beside it are exactly 0, so the coordinates that move
    without mass are those with ``u[j] != 0``. None is also returned if J is not finite.
    """
    cut = default_rank_cut(m) if rank_cut is None else rank_cut
    factors, rank, definite = factor(n, m, M, J, cut, sqrt)
    if not rank <= definite < n:
        return None
    order, B = factors.order, factors.B
    v = [0.0] * n
    v[order[definite]] = 1.0
    for k in range(definite - 1, rank - 1, -1):
        i = order[k]
        total = 0.0
        for c in range(k + 1, definite + 1):
            total = total - B[order[c] * n + i] * v[order[c]]
        v[i] = total / B[i * n + i]
    multiply_q(factors, rank, v)
    top = max(abs(entry) for entry in v)
    u = [factors.d[j] * v[j] if abs(v[j]) > NEGLIGIBLE * top else 0.0 for j in range(n)]
    largest = max(u, key=abs)
    return [entry / largest if entry != 0.0 else 0.0 for entry in u]


def _scaled_residual(
    factors: Factors,
    rank: int,
    M: Sequence[float],
    J: Sequence[float],
    F: Sequence[float],
    gamma: Sequence[float],
    udot: list[float],
    multipliers: list[float],
) -> tuple[list[float], list[float]]:
    """Return the residuals of F (n,) and, in kept rows, of gamma (m,)."""
    n, m = factors.n, factors.m
    f, g = [0.0] * n, [0.0] * m
    for j in range(n):
        total = F[j]
        for k in range(rank):
            i = factors.order[k]
            total = total + J[i * n + j] * multipliers[i]
        for i in range(n):
            total = total - M[j * n + i] * udot[i]
        f[j] = total * factors.d[j]
    for k in range(rank):
        i = factors.order[k]
        total = gamma[i]
        for j in range(n):
            total = total - J[i * n + j] * udot[j]
        g[i] = total * factors.r[i]
    return f, g


def _add_solution(
    factors: Factors, rank: int, f: list[float], g: list[float], udot: list[float], multipliers: list[float]
) -> None:
    """Solve the scaled system for f and g, which are overwritten, and add its solution."""
    for k in range(rank):
        apply_reflection(factors, k, f)
    y = _rotated_acceleration(factors, rank, f, g)
    _scaled_multipliers(factors, rank, f, y, g)
    multiply_q(factors, rank, y)
    for j in range(factors.n):
        udot[j] = udot[j] + factors.d[j] * y[j]
    for k in range(rank):
        i = factors.order[k]
        multipliers[i] = multipliers[i] + factors.r[i] * g[i]


def _rotated_acceleration(factors: Factors, rank: int, f: list[float], g: list[float]) -> list[float]:
    """Return y = Q^T v from R^T y1 = g and B22 y2 = f2 - B21 y1, with f already rotated."""
    n, order, A, B = factors.n, factors.order, factors.A, factors.B
    y = [0.0] * n
    for k in range(rank):
        total = g[order[k]]
        for j in range(k):
            total = total - A[order[k] * n + j] * y[j]
        y[k] = total / factors.diagonal[k]
    for i in range(rank, n):
        total = f[i]
        for j in range(rank):
            total = total - B[i * n + j] * y[j]
        y[i] = total
    _solve_mass(factors, rank, y)
    return y


def _scaled_multipliers(factors: Factors, rank: int, f: list[float], y: list[float], g: list[float]) -> None:
    """Overwrite g, in kept rows, with the solution of R lambda = B11 y1 + B12 y2 - f1."""
    n, order, A, B = factors.n, factors.order, factors.A, factors.B
    for k in range(rank - 1, -1, -1):
        total = -f[k]
        for j in range(n):
            total = total + B[k * n + j] * y[j]
        for c in range(k + 1, rank):
            total = total - A[order[c] * n + k] * g[order[c]]
        g[order[k]] = total / factors.diagonal[k]


def _solve_mass(factors: Factors, rank: int, y: list[float]) -> None:
    """Solve with the Cholesky factor by columns, then by rows of its transpose [GVL 3.1]."""
    n, B, order = factors.n, factors.B, factors.order
    for k in range(rank, n):
        i = order[k]
        y[i] = y[i] / B[i * n + i]
        for c in range(k + 1, n):
            y[order[c]] = y[order[c]] - B[order[c] * n + i] * y[i]
    for k in range(n - 1, rank - 1, -1):
        i = order[k]
        total = y[i]
        for c in range(k + 1, n):
            total = total - B[order[c] * n + i] * y[order[c]]
        y[i] = total / B[i * n + i]
