"""The motion inside a step as a polynomial.

With s the share of the step that has passed and F its rows, the state is
``F0 + s (F1 + (1 - s) (F2 + s (F3 + (1 - s) (F4 + ...))))``: Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, 2nd ed., section II.6.
"""

from __future__ import annotations

from symbody.kernels.block import Run
from symbody.kernels.language import Function, Reals, half, part
from symbody.kernels.runge_kutta import all_finite, combine, evaluate


def form_dense_output(f: Function, run: Run, t: float, h: float, F: Reals) -> int:
    """Fill F (rows, n) for the step just tried; return 1 if all of it is finite, else 0."""
    n = run.states
    method = run.method
    end = method.stages
    stage_rows = method.stage_rows
    K = run.slopes
    old = run.state_old
    new = run.state_new
    scratch = run.error_1  # the last stage is still needed to judge stiffness
    for k in range(end + 1, stage_rows):
        combine(n, k, method, K, h, old, scratch)
        evaluate(f, run, t + method.nodes[k] * h, scratch, part(K, k * n, n))
    for i in range(n):
        move = new[i] - old[i]
        F[i] = old[i]
        F[n + i] = move
        F[2 * n + i] = h * K[i] - move
        F[3 * n + i] = 2.0 * move - h * (K[i] + K[end * n + i])
    for row in range(4, method.dense_rows):
        combine(n, stage_rows + row - 2, method, K, h, run.zero_state, part(F, row * n, n))
    return all_finite(n * (method.dense_rows - 4), part(F, 4 * n, n))


def interpolate(n: int, rows: int, F: Reals, s: float, x: Reals) -> None:
    """Set x (n,) to the dense output F (rows, n) at the share s of the step, four states at a time."""
    place = 0
    while place < n:
        i = max(min(place, n - 4), 0)
        j = min(i + 1, n - 1)
        k = min(i + 2, n - 1)
        m = min(i + 3, n - 1)
        a = 0.0
        b = 0.0
        c = 0.0
        d = 0.0
        factor = s
        other = 1.0 - s
        if rows != 2 * half(rows):
            factor = 1.0 - s
            other = s
        for row in range(rows - 1, 0, -1):
            at = row * n
            a = (a + F[at + i]) * factor
            b = (b + F[at + j]) * factor
            c = (c + F[at + k]) * factor
            d = (d + F[at + m]) * factor
            before = factor
            factor = other
            other = before
        x[i] = F[i] + a
        x[j] = F[j] + b
        x[k] = F[k] + c
        x[m] = F[m] + d
        place = place + 4
