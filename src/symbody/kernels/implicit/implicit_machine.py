"""The integrator by the generalized-alpha method: steps of one motion, as `step_machine` takes explicit ones.

The functions are f, slopes of all states; k, rates of coordinates; d, derivatives of the slopes by the
states; g, which closes the constraints. `implicit` is what the method keeps, the other arrays are those of
`step_machine`.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import RUNNING, Run
from symbody.kernels.configurations.projection import project_new_state
from symbody.kernels.implicit.generalized_alpha import finish_step, renew_turn, solve_step
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.implicit_errors import local_error
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part
from symbody.kernels.power import power
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import all_finite, copy, evaluate
from symbody.kernels.step_bounds import behind_jump, plan_trial
from symbody.kernels.step_machine import begin, failure, keep_step, reached_limit

# The share of the first step over which the change of the slopes is measured.
PROBE: Final = 1e-3
SAFETY: Final = 0.8
# Within these bounds the next step is as long as the last, and the factors stay.
NEARLY: Final = 0.9
WORTHWHILE: Final = 1.2
# Where Newton's method fails.
QUARTER: Final = 0.25


def set_out(f: Function, run: Run, implicit: ImplicitStep) -> None:
    """Forget the steps before, and measure how the slopes change at the state from which motion starts."""
    n = run.states
    K = run.slopes
    change = implicit.slopes_change
    h = PROBE * run.step
    implicit.length_before = 0.0
    implicit.has_derivatives = 0.0
    implicit.factored_for = 0.0
    implicit.contraction = 1.0
    for i in range(n):
        change[i] = 0.0
        run.stage[i] = run.state_old[i] + h * K[i]
    if h == 0.0:
        return
    evaluate(f, run, run.time + h, run.stage, part(K, n, n))
    if run.counts.failed_kernel == 0 and all_finite(n, part(K, n, n)) == 1:
        for i in range(n):
            change[i] = (K[n + i] - K[i]) / h
    run.counts.failed_kernel = 0


def begin_implicit(
    f: Function, run: Run, implicit: ImplicitStep, times: Reals, t: Reals, x: Reals, breaks: Reals
) -> int:
    """Begin as `step_machine.begin` does."""
    code = begin(f, run, times, t, x, breaks)
    if code == RUNNING:
        set_out(f, run, implicit)
    return code


def attempt_implicit(
    f: Function, k: Function, d: Function, g: Function, run: Run, implicit: ImplicitStep, h: float
) -> float:
    """Try one step; return its error over the tolerance: infinite, or -1 where Newton's method fails."""
    if solve_step(f, k, d, run, implicit, h) == 0:
        return -1.0
    if finish_step(k, run, implicit, h) == 0:
        return -1.0
    error = 0.0
    if implicit.one_length == 0.0:
        error = local_error(run, implicit, h)
    if error <= 1.0 and exists(run.projection):
        moved = project_new_state(g, run, run.t_new)
        if moved < 0.0 or not is_finite(moved):
            return INFINITY
        if moved > 0.0:
            if renew_turn(k, run, implicit, h) == 0:
                return INFINITY
    return error


def shorten_step(run: Run, factor: float) -> None:
    """Go on with a shorter step, after one in vain."""
    run.counts.rejected = run.counts.rejected + 1
    run.after_rejection = 1.0
    run.step = run.length * factor


def step_factor(run: Run, error: float) -> float:
    """Return by how much the next step may be longer after an error."""
    factor = run.method.growth
    if error > 0.0 and is_finite(error):
        factor = SAFETY / power(error, run.method.exponent)
    if not is_finite(error):
        factor = run.method.shrink
    return min(max(factor, run.method.shrink), run.method.growth)


def choose_step(run: Run, implicit: ImplicitStep, error: float) -> None:
    """Choose the length of the next step after one that was accepted."""
    if implicit.one_length != 0.0:
        run.step = run.goal.direction * run.goal.max_step
        return
    factor = step_factor(run, error)
    if run.after_rejection != 0.0:
        factor = min(factor, 1.0)
    if factor > NEARLY and factor < WORTHWHILE:
        factor = 1.0
    h = run.length
    if factor >= 1.0 and abs(h) < abs(run.step):
        h = run.step  # what lay ahead, not its error, made the step short
        factor = 1.0
    run.step = run.goal.direction * min(abs(h) * factor, run.goal.max_step)
    run.after_rejection = 0.0


def accept_implicit(f: Function, run: Run, implicit: ImplicitStep, error: float) -> None:
    """Go on to the end of a step, behind a jump that lies there."""
    n = run.states
    n_v = implicit.unknowns
    copy(n, run.slopes, implicit.slopes_before)
    copy(n, part(run.slopes, n, n), run.slopes)
    copy(n, run.state_new, run.state_old)
    copy(n_v, implicit.rates_new, implicit.rates)
    implicit.length_before = run.length
    run.counts.accepted = run.counts.accepted + 1
    run.time = run.t_new
    choose_step(run, implicit, error)
    t = behind_jump(run, run.time)
    if t != run.time:
        run.time = t
        evaluate(f, run, t, run.state_old, run.slopes)
        set_out(f, run, implicit)


def try_implicit(
    f: Function, k: Function, d: Function, g: Function, e: Function, run: Run, implicit: ImplicitStep,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step; return why there is no other, or `RUNNING`."""
    plan_trial(run, run.time, run.step)
    h = run.length
    if h == 0.0:
        return failure(run)
    error = attempt_implicit(f, k, d, g, run, implicit, h)
    if error >= 0.0 and error <= 1.0:
        error = keep_step(f, g, e, run, error, times, t, x, breaks, pieces)
    if error >= 0.0 and error <= 1.0:
        accept_implicit(f, run, implicit, error)
        return RUNNING
    if implicit.one_length != 0.0:
        return failure(run)
    factor = QUARTER
    if error >= 0.0:
        factor = min(step_factor(run, error), SAFETY)
    shorten_step(run, factor)
    return RUNNING


def advance_implicit(
    f: Function, k: Function, d: Function, g: Function, e: Function, run: Run, implicit: ImplicitStep,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps; return one of the codes of `block`, as `step_machine.advance` does."""
    for _trial in range(trials):
        code = reached_limit(run)
        if code == RUNNING:
            code = try_implicit(f, k, d, g, e, run, implicit, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING
