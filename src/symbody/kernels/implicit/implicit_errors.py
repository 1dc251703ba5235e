"""The local error of the generalized-alpha method: its distance from a rule of order 3."""

from __future__ import annotations

from symbody.kernels.block import ERROR_1, N_U, STATE_NEW, STATE_OLD, VECTOR_ROWS, VECTORS, N
from symbody.kernels.implicit.implicit_block import (
    ALPHA_F,
    ALPHA_M,
    COORDINATES,
    CORRECTION,
    DERIVATIVES,
    FACTORS,
    GAMMA,
    LENGTH_BEFORE,
    PIVOTS,
    SLOPES_BEFORE,
    SLOPES_CHANGE,
    UNKNOWNS,
)
from symbody.kernels.implicit.newton_matrix import place_of
from symbody.kernels.language import INFINITY, Reals, is_finite, part, sqrt
from symbody.kernels.linear.dense_factors import solve_dense
from symbody.kernels.runge_kutta import error_scale


def raw_errors(B: Reals, A: Reals, h: float) -> None:
    """Set `ERROR_1` to how far a rule of order 3 through the slopes leads from the new state."""
    n = int(B[N])
    V = part(B, VECTORS, VECTOR_ROWS * n)
    K = part(B, VECTORS + VECTOR_ROWS * n, 2 * n)
    past = part(A, int(A[SLOPES_BEFORE]), n)
    change = part(A, int(A[SLOPES_CHANGE]), n)
    before = A[LENGTH_BEFORE]
    for i in range(n):
        ahead = (K[n + i] - K[i]) / h
        bend = (ahead - change[i]) / h
        if before != 0.0:
            bend = (ahead - (K[i] - past[i]) / before) / (h + before)
        moved = V[STATE_NEW * n + i] - V[STATE_OLD * n + i]
        V[ERROR_1 * n + i] = 0.5 * h * (K[i] + K[n + i]) - moved - h * h * h * bend / 6.0


def filter_errors(B: Reals, A: Reals, h: float) -> None:
    """Divide the errors by the matrix of Newton's method, so that fast damped motions count little."""
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    size = n_v + n_q
    e = part(B, VECTORS + ERROR_1 * n, n)
    y = part(A, int(A[CORRECTION]), n_v)
    D = part(A, int(A[DERIVATIVES]), size * size)
    share = h * A[GAMMA] * (1.0 - A[ALPHA_F]) / (1.0 - A[ALPHA_M])
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        total = 0.0
        for j in range(n_u, n_u + n_q):
            total = total + D[place * size + j] * e[j]
        y[i] = e[place] + share * total
    solve_dense(n_v, part(A, int(A[FACTORS]), n_v * n_v), part(A, int(A[PIVOTS]), n_v), y)
    for i in range(n_v):
        e[place_of(i, n_u, n_q)] = y[i]
    for i in range(n_u, n_u + n_q):
        total = 0.0
        for j in range(n_u):
            total = total + D[i * size + j] * y[j]
        e[i] = e[i] + share * total


def local_error(B: Reals, A: Reals, h: float) -> float:
    """Return the local error over its tolerance, infinite if it is not finite."""
    n = int(B[N])
    raw_errors(B, A, h)
    filter_errors(B, A, h)
    total = 0.0
    for i in range(n):
        share = B[VECTORS + ERROR_1 * n + i] / error_scale(B, n, i)
        total = total + share * share
    error = sqrt(total / max(n, 1))
    if not is_finite(error):
        return INFINITY
    return error
