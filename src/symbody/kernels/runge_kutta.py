"""One step of an explicit Runge-Kutta method: stages, local error, the length of the next step.

Sections are those of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., and from
IV on of Hairer and Wanner, part II.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FunctionNumbers, Method, Run
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.power import power
from symbody.kernels.record_layout import exists
from symbody.kernels.tables import read_tables

SAFETY: Final = 0.9


def call(f: Function, n_u: int, numbers: FunctionNumbers, t: float, x: Reals, out: Reals) -> int:
    """Call a function at a time and a state x = (u, q), with its other numbers; return its status."""
    numbers.time = t
    if exists(numbers.tables):
        read_tables(numbers, t)
    r = numbers.inputs
    return f(numbers, part(x, n_u, 1), x, r, numbers.parameters, numbers.constants, out, numbers.work)


def evaluate(f: Function, run: Run, t: float, x: Reals, slope: Reals) -> None:
    """Set `slope` to the derivative at a state x, and note which kernel failed."""
    run.counts.evaluations = run.counts.evaluations + 1
    status = call(f, run.speeds, run.numbers, t, x, slope)
    if status != 0:
        run.counts.failed_kernel = status


def combine(n: int, row: int, method: Method, K: Reals, factor: float, base: Reals, target: Reals) -> None:
    """Set `target` to `base` plus `factor` times a row of the method times K, four states at a time.

    Their sums stay in registers; the last four may be computed twice, to the same values.
    """
    if n < 4:
        combine_few(n, row, method, K, factor, base, target)
        return
    rows = method.rows
    weights = method.weights
    first = int(rows[row])
    stop = int(rows[row + 1])
    place = 0
    while place < n:
        i = min(place, n - 4)
        a = 0.0
        b = 0.0
        c = 0.0
        d = 0.0
        for entry in range(first, stop):
            at = int(weights[2 * entry]) + i
            weight = weights[2 * entry + 1]
            a = a + weight * K[at]
            b = b + weight * K[at + 1]
            c = c + weight * K[at + 2]
            d = d + weight * K[at + 3]
        a = base[i] + factor * a
        b = base[i + 1] + factor * b
        c = base[i + 2] + factor * c
        d = base[i + 3] + factor * d
        target[i] = a
        target[i + 1] = b
        target[i + 2] = c
        target[i + 3] = d
        place = place + 4


def combine_few(
    n: int, row: int, method: Method, K: Reals, factor: float, base: Reals, target: Reals
) -> None:
    """Do what `combine` does for less than four states; at the end one stands for those that lack."""
    if n == 0:
        return
    j = min(1, n - 1)
    k = min(2, n - 1)
    a = 0.0
    b = 0.0
    c = 0.0
    rows = method.rows
    weights = method.weights
    for entry in range(int(rows[row]), int(rows[row + 1])):
        at = int(weights[2 * entry])
        weight = weights[2 * entry + 1]
        a = a + weight * K[at]
        b = b + weight * K[at + j]
        c = c + weight * K[at + k]
    target[0] = base[0] + factor * a
    target[j] = base[j] + factor * b
    target[k] = base[k] + factor * c


def copy(n: int, source: Reals, target: Reals) -> None:
    """Copy an array."""
    for i in range(n):
        target[i] = source[i]


def all_finite(n: int, x: Reals) -> int:
    """Return 1 if an array holds no infinity and no NaN, else 0."""
    for i in range(n):
        if not is_finite(x[i]):
            return 0
    return 1


def error_scale(run: Run, n: int, i: int) -> float:
    """Return how large a local error of state i may be."""
    size = max(abs(run.state_old[i]), abs(run.state_new[i]))
    return run.tolerances[i] + run.goal.rtol * size


def error_size(first: float, second: float, h: float, n: int) -> float:
    """Return the local error from the sums of squares of both estimates: section II.10."""
    if first == 0.0:
        return 0.0
    return abs(h) * first / sqrt((first + 0.01 * second) * n)


def error_norm(run: Run, h: float) -> float:
    """Return the local error over its tolerance: section II.4."""
    n = run.states
    method = run.method
    row = method.stage_rows
    K = run.slopes
    old = run.state_old
    new = run.state_new
    error_1 = run.error_1
    error_2 = run.error_2
    tolerances = run.tolerances
    combine(n, row, method, K, 1.0, run.zero_state, error_1)
    combine(n, row + 1, method, K, 1.0, run.zero_state, error_2)
    rtol = run.goal.rtol
    first = 0.0
    second = 0.0
    for i in range(n):
        size = max(abs(old[i]), abs(new[i]))
        share = 1.0 / (tolerances[i] + rtol * size)
        a = error_1[i] * share
        b = error_2[i] * share
        first = first + a * a
        second = second + b * b
    return error_size(first, second, h, n)


def attempt(f: Function, run: Run, t: float, h: float) -> float:
    """Compute the stages of one step and the new state; return the error norm, infinite if not finite."""
    n = run.states
    n_u = run.speeds
    method = run.method
    end = method.stages
    K = run.slopes
    old = run.state_old
    stage = run.stage
    new = run.state_new
    nodes = method.nodes
    run.counts.failed_kernel = 0
    for k in range(1, end):
        combine(n, k, method, K, h, old, stage)
        if method.split != 0.0:
            copy(n - n_u, part(old, n_u, n - n_u), part(stage, n_u, n - n_u))
        evaluate(f, run, t + nodes[k] * h, stage, part(K, k * n, n))
    combine(n, end, method, K, h, old, new)
    if method.split != 0.0:
        copy(n_u, stage, new)
    if method.error_reads_end != 0.0:
        evaluate(f, run, t + h, new, part(K, end * n, n))
    error = error_norm(run, h)
    if error <= 1.0 and method.error_reads_end == 0.0:
        evaluate(f, run, t + h, new, part(K, end * n, n))
    if error != error or run.counts.failed_kernel != 0:
        return INFINITY
    if error <= 1.0:
        if all_finite(n, part(K, end * n, n)) == 0:
            return INFINITY
    return error


def accept(run: Run, t_new: float, h: float, error: float) -> None:
    """Go on to the end of a step and choose the next one: sections II.4 and IV.2."""
    method = run.method
    factor = method.growth
    if error > 0.0:
        factor = SAFETY / power(error, method.exponent)
        if method.memory != 0.0:
            factor = factor * power(run.error, method.memory)
    factor = min(max(factor, method.shrink), method.growth)
    if run.after_rejection != 0.0:
        factor = min(factor, 1.0)
    run.time = t_new
    run.step = run.goal.direction * min(abs(h) * factor, run.goal.max_step)
    if method.growth == 1.0:  # steps of one length, whatever a jump took from this one
        run.step = run.goal.direction * run.goal.max_step
    run.error = max(error, 1e-4)
    run.counts.accepted = run.counts.accepted + 1
    run.after_rejection = 0.0


def reject(run: Run, h: float, error: float) -> None:
    """Choose a shorter step."""
    method = run.method
    factor = method.shrink
    if is_finite(error):
        factor = max(factor, SAFETY / power(error, method.exponent))
    run.step = h * factor
    run.counts.rejected = run.counts.rejected + 1
    run.after_rejection = 1.0


def count_stiff_votes(run: Run, h: float) -> int:
    """Count steps at the stability bound as section IV.2 does; return 1 if there are too many, else 0."""
    run.unjudged = run.unjudged + 1
    if run.unjudged == 1000:
        run.unjudged = 0
    elif run.stiff_votes == 0:
        return 0
    n = run.states
    stages = run.method.stages
    K = run.slopes
    slope = 0.0
    distance = 0.0
    for i in range(n):
        a = K[stages * n + i] - K[(stages - 1) * n + i]
        b = run.state_new[i] - run.stage[i]
        slope = slope + a * a
        distance = distance + b * b
    bound = run.method.stiff_bound * run.method.stiff_bound
    if h * h * slope > bound * distance and distance > 0.0:
        run.other_votes = 0
        run.stiff_votes = run.stiff_votes + 1
    else:
        run.other_votes = run.other_votes + 1
        if run.other_votes == 6:
            run.stiff_votes = 0
            run.other_votes = 0
    if run.stiff_votes >= 15:
        return 1
    return 0
