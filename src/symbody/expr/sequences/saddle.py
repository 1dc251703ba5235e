"""Accelerations and multipliers of a constrained system: the kernel `solve_saddle`, run by Python.

``solve_saddle`` solves ``M udot = F + J^T lambda``, ``J udot = gamma`` by the null-space method, where M is
symmetric and positive definite on the null space of J only (massless bodies) and rows of J may depend on
each other; ``docs/derivations/solve_saddle.md`` derives every step. The kernel stands in
`kernels.linear.solve_saddle`; here are its answers as values. All matrices are flat, row-major sequences;
entries are floats or numbers of `mpmath`.

Sources: [H] Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.kernels.language import Reals
from symbody.kernels.linear.saddle_factors import CUT_FACTOR, EPSILON
from symbody.kernels.linear.solve_saddle import solve_saddle_cut, work_size


class SaddleSolution(NamedTuple):
    """The solution of a constrained system.

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
    result, work = Reals.zeros(n + m + 1), Reals.zeros(work_size(n, m))
    status = solve_saddle_cut(n, m, Reals(M), Reals(J), Reals(F), Reals(gamma), cut, result, work)
    values = [result[k] for k in range(n + m)]
    return SaddleSolution(values[:n], values[n:], int(result[n + m]), ok=status == 0)
