"""The local error of the generalized-alpha method: its distance from a rule of order 3."""

from __future__ import annotations

from symbody.kernels.block import Run
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.newton_matrix import place_of
from symbody.kernels.language import INFINITY, is_finite, sqrt
from symbody.kernels.linear.dense_factors import solve_dense
from symbody.kernels.runge_kutta import error_scale


def raw_errors(run: Run, implicit: ImplicitStep, h: float) -> None:
    """Set `error_1` to how far a rule of order 3 through the slopes leads from the new state."""
    n = run.states
    K = run.slopes
    past = implicit.slopes_before
    change = implicit.slopes_change
    before = implicit.length_before
    for i in range(n):
        ahead = (K[n + i] - K[i]) / h
        bend = (ahead - change[i]) / h
        if before != 0.0:
            bend = (ahead - (K[i] - past[i]) / before) / (h + before)
        moved = run.state_new[i] - run.state_old[i]
        run.error_1[i] = 0.5 * h * (K[i] + K[n + i]) - moved - h * h * h * bend / 6.0


def filter_errors(run: Run, implicit: ImplicitStep, h: float) -> None:
    """Divide the errors by the matrix of Newton's method, so that fast damped motions count little."""
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    size = n_v + n_q
    e = run.error_1
    y = implicit.correction
    D = implicit.derivatives
    share = h * implicit.gamma * (1.0 - implicit.alpha_f) / (1.0 - implicit.alpha_m)
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        total = 0.0
        for j in range(n_u, n_u + n_q):
            total = total + D[place * size + j] * e[j]
        y[i] = e[place] + share * total
    solve_dense(n_v, implicit.factors, implicit.pivots, y)
    for i in range(n_v):
        e[place_of(i, n_u, n_q)] = y[i]
    for i in range(n_u, n_u + n_q):
        total = 0.0
        for j in range(n_u):
            total = total + D[i * size + j] * y[j]
        e[i] = e[i] + share * total


def local_error(run: Run, implicit: ImplicitStep, h: float) -> float:
    """Return the local error over its tolerance, infinite if it is not finite."""
    n = run.states
    raw_errors(run, implicit, h)
    filter_errors(run, implicit, h)
    total = 0.0
    for i in range(n):
        share = run.error_1[i] / error_scale(run, n, i)
        total = total + share * share
    error = sqrt(total / max(n, 1))
    if not is_finite(error):
        return INFINITY
    return error
