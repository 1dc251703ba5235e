"""The matrix of Newton's method for the generalized-alpha method, and its factors."""

from __future__ import annotations

from symbody.kernels.block import N_U
from symbody.kernels.implicit.implicit_block import (
    ALPHA_F,
    ALPHA_M,
    BETA,
    CONTRACTION,
    COORDINATES,
    DERIVATIVE_FUNCTION,
    DERIVATIVES,
    DERIVATIVES_MADE,
    FACTORED_FOR,
    FACTORS,
    FACTORS_MADE,
    GAMMA,
    HAS_DERIVATIVES,
    PIVOTS,
    THROUGH_Q,
    UNKNOWNS,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.linear.dense_factors import factor_dense
from symbody.kernels.runge_kutta import all_finite, call


def place_of(i: int, n_u: int, n_q: int) -> int:
    """Return where entry i of v = (u, s) lies in x = (u, q, s)."""
    place = i
    if i >= n_u:
        place = i + n_q
    return place


def make_derivatives(d: Function, B: Reals, A: Reals, t: float, x: Reals) -> int:
    """Compute the derivatives of the slopes at a state; return 0 if they are not finite, else 1."""
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    size = n_v + n_q
    D = part(A, int(A[DERIVATIVES]), size * size)
    P = part(A, int(A[THROUGH_Q]), n_v * n_u)
    A[DERIVATIVES_MADE] = A[DERIVATIVES_MADE] + 1.0
    A[FACTORED_FOR] = 0.0
    if call(d, n_u, part(A, int(A[DERIVATIVE_FUNCTION]), 1), t, x, D) != 0:
        return 0
    if all_finite(size * size, D) == 0:
        return 0
    for i in range(n_v):
        row = place_of(i, n_u, n_q) * size
        for j in range(n_u):
            P[i * n_u + j] = 0.0
        for k in range(n_u, n_u + n_q):
            slope = D[row + k]
            if slope != 0.0:
                for j in range(n_u):
                    P[i * n_u + j] = P[i * n_u + j] + slope * D[k * size + j]
    A[HAS_DERIVATIVES] = 1.0
    return 1


def make_factors(B: Reals, A: Reals, h: float) -> int:
    """Factor the matrix of Newton's method for steps of length h; return 0 if it is singular, else 1."""
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    size = n_v + n_q
    D = part(A, int(A[DERIVATIVES]), size * size)
    P = part(A, int(A[THROUGH_Q]), n_v * n_u)
    S = part(A, int(A[FACTORS]), n_v * n_v)
    share = (1.0 - A[ALPHA_F]) / (1.0 - A[ALPHA_M])
    first = share * A[GAMMA] * h
    second = share * A[BETA] * h * h
    for i in range(n_v):
        row = place_of(i, n_u, n_q) * size
        for j in range(n_v):
            S[i * n_v + j] = -first * D[row + place_of(j, n_u, n_q)]
        for j in range(n_u):
            S[i * n_v + j] = S[i * n_v + j] - second * P[i * n_u + j]
        S[i * n_v + i] = S[i * n_v + i] + 1.0
    A[FACTORS_MADE] = A[FACTORS_MADE] + 1.0
    A[FACTORED_FOR] = h
    A[CONTRACTION] = 1.0
    return factor_dense(n_v, S, part(A, int(A[PIVOTS]), n_v))
