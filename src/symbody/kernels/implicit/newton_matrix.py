"""The matrix of Newton's method for the generalized-alpha method, and its factors."""

from __future__ import annotations

from symbody.kernels.block import Run
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.language import Function, Reals
from symbody.kernels.linear.dense_factors import factor_dense
from symbody.kernels.runge_kutta import all_finite, call


def place_of(i: int, n_u: int, n_q: int) -> int:
    """Return where entry i of v = (u, s) lies in x = (u, q, s)."""
    place = i
    if i >= n_u:
        place = i + n_q
    return place


def make_derivatives(d: Function, run: Run, implicit: ImplicitStep, t: float, x: Reals) -> int:
    """Compute the derivatives of the slopes at a state; return 0 if they are not finite, else 1."""
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    size = n_v + n_q
    D = implicit.derivatives
    P = implicit.through_q
    implicit.derivatives_made = implicit.derivatives_made + 1.0
    implicit.factored_for = 0.0
    if call(d, n_u, implicit.derivative_numbers, t, x, D) != 0:
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
    implicit.has_derivatives = 1.0
    return 1


def make_factors(run: Run, implicit: ImplicitStep, h: float) -> int:
    """Factor the matrix of Newton's method for steps of length h; return 0 if it is singular, else 1."""
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    size = n_v + n_q
    D = implicit.derivatives
    P = implicit.through_q
    S = implicit.factors
    share = (1.0 - implicit.alpha_f) / (1.0 - implicit.alpha_m)
    first = share * implicit.gamma * h
    second = share * implicit.beta * h * h
    for i in range(n_v):
        row = place_of(i, n_u, n_q) * size
        for j in range(n_v):
            S[i * n_v + j] = -first * D[row + place_of(j, n_u, n_q)]
        for j in range(n_u):
            S[i * n_v + j] = S[i * n_v + j] - second * P[i * n_u + j]
        S[i * n_v + i] = S[i * n_v + i] + 1.0
    implicit.factors_made = implicit.factors_made + 1.0
    implicit.factored_for = h
    implicit.contraction = 1.0
    return factor_dense(n_v, S, implicit.pivots)
