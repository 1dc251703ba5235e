"""The integrator: steps of one motion, their samples, and why there are no more.

All state lies in the block, so a run stops after any step and goes on, in this process or another. The arrays
of a record are `times`, the samples to store in the order of the motion; `t` and `x`, the samples; `breaks`
and `pieces`, ends and dense output of each step, if they are kept.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    CHART_ENDS,
    CHART_IS_WORN,
    COLLAPSED,
    FINISHED,
    FULL,
    NOT_FINITE,
    OUT_OF_REACH,
    RUNNING,
    SINGULAR,
    STIFF,
    TOO_MANY,
    Run,
)
from symbody.kernels.configurations.projection import project, project_new_state
from symbody.kernels.dense_output import form_dense_output, interpolate
from symbody.kernels.events.passed_gaps import passes_gap
from symbody.kernels.features import GAPS
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.power import power
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import (
    accept,
    all_finite,
    attempt,
    copy,
    count_stiff_votes,
    error_scale,
    evaluate,
    reject,
)
from symbody.kernels.step_bounds import EPSILON, behind_jump, plan_trial

SHORTEST: Final = 16.0  # roundings of a time are the shortest first step: beyond the 10 of `plan_trial`


def store_sample(run: Run, time: float, state: Reals, t: Reals, x: Reals) -> None:
    """Store a state as a sample."""
    n = run.states
    sample = run.counts.samples
    t[sample] = time
    copy(n, state, part(x, sample * n, n))
    run.counts.samples = run.counts.samples + 1


def is_sampled(run: Run, times: Reals) -> int:
    """Return 1 if the next sample lies inside the step, 2 if at its end, 0 if beyond."""
    sample = run.counts.samples
    if sample == run.room.times:
        return 0
    beyond = (times[sample] - run.t_new) * run.goal.direction
    if beyond < 0.0:
        return 1
    if beyond == 0.0:
        return 2
    return 0


def store_samples(g: Function, run: Run, F: Reals, times: Reals, t: Reals, x: Reals) -> None:
    """Store the samples of an accepted step with the dense output F."""
    n = run.states
    start = run.time
    t_new = run.t_new
    where = is_sampled(run, times)
    while where != 0:
        sample = run.counts.samples
        time = times[sample]
        if where == 2:
            store_sample(run, time, run.state_new, t, x)
        else:
            target = part(x, sample * n, n)
            interpolate(n, run.method.dense_rows, F, (time - start) / (t_new - start), target)
            if exists(run.projection):
                project(g, run, time, target)
            t[sample] = time
            run.counts.samples = run.counts.samples + 1
        where = is_sampled(run, times)


def failure(run: Run) -> int:
    """Return why the last trial failed, and set `blamed_state` to the state that is to blame."""
    if run.counts.failed_kernel > 0:
        return SINGULAR
    if run.counts.failed_kernel == OUT_OF_REACH:
        return COLLAPSED
    n = run.states
    K = run.slopes
    for row in range(run.method.stages + 1):
        for i in range(n):
            if not is_finite(K[row * n + i]):
                run.counts.blamed_state = i
                return NOT_FINITE
    worst = 0.0
    for i in range(n):
        error = abs(run.error_1[i]) / error_scale(run, n, i)
        if error >= worst:
            worst = error
            run.counts.blamed_state = i
    return COLLAPSED


def close(f: Function, g: Function, run: Run) -> int:
    """Project the new state and renew its derivative; return 1 if it needed no large move, else 0."""
    t_new = run.t_new
    end = run.method.stages
    n = run.states
    moved = project_new_state(g, run, t_new)
    if moved < 0.0:
        return 0
    if moved > 0.0:  # a step that ends at a jump keeps the derivative before it
        evaluate(f, run, run.time + run.length, run.state_new, part(run.slopes, end * n, n))
    if run.counts.failed_kernel != 0:
        return 0
    return all_finite(n, part(run.slopes, end * n, n))


def pass_jump(f: Function, run: Run) -> None:
    """Go on behind a jump, with the derivative there, if a step has ended at one."""
    t = behind_jump(run, run.time)
    if t != run.time:
        run.time = t
        evaluate(f, run, t, run.state_old, run.slopes)


def try_step(
    f: Function, g: Function, e: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals,
) -> int:  # fmt: skip
    """Try one step; return why there is no other, or `RUNNING`."""
    plan_trial(run, run.time, run.step)
    h = run.length
    if h == 0.0:
        return failure(run)
    error = attempt(f, run, run.time, h)
    if error <= 1.0 and exists(run.projection):
        if close(f, g, run) == 0:
            error = INFINITY
    if run.counts.failed_kernel == CHART_IS_WORN:
        return CHART_ENDS
    if error <= 1.0:
        error = keep_step(f, g, e, run, error, times, t, x, breaks, pieces)
    if not error <= 1.0:
        reject(run, h, error)
        return RUNNING
    n = run.states
    t_new = run.t_new
    stiff = count_stiff_votes(run, h)
    accept(run, t_new, h, error)
    copy(n, run.state_new, run.state_old)
    copy(n, part(run.slopes, run.method.stages * n, n), run.slopes)
    pass_jump(f, run)
    if stiff != 0 and run.goal.stop_when_stiff != 0.0 and t_new != run.t_end:
        return STIFF
    return RUNNING


def form_piece(f: Function, e: Function, run: Run, piece: Reals) -> int:
    """Form the dense output of a step; return 1 if all of it is finite and it passes over no gap, else 0."""
    if form_dense_output(f, run, run.time, run.length, piece) == 0:
        return 0
    if GAPS != 0:
        if exists(run.gaps):
            return 1 - passes_gap(e, run, piece)
    return 1


def needs_dense_output(run: Run, times: Reals) -> int:
    """Return 1 if the dense output of a step is needed that is not kept, else 0."""
    if GAPS != 0:
        if exists(run.gaps):
            return 1
    if run.room.every_step == 0.0 and is_sampled(run, times) == 1:
        return 1
    return 0


def keep_step(
    f: Function, g: Function, e: Function, run: Run, error: float, times: Reals, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals,
) -> float:  # fmt: skip
    """Store what is kept of an accepted step; return its error, infinite if `form_piece` refuses it."""
    n = run.states
    rows = run.method.dense_rows
    if run.room.keep_dense != 0.0:
        steps = run.counts.steps
        piece = part(pieces, steps * rows * n, rows * n)
        if form_piece(f, e, run, piece) == 0:
            return INFINITY
        breaks[steps + 1] = run.t_new
        run.counts.steps = run.counts.steps + 1
        if run.room.every_step == 0.0:
            store_samples(g, run, piece, times, t, x)
    else:
        if needs_dense_output(run, times) != 0:
            if form_piece(f, e, run, run.dense) == 0:
                return INFINITY
        if run.room.every_step == 0.0:
            store_samples(g, run, run.dense, times, t, x)
    if run.room.every_step != 0.0:
        store_sample(run, run.t_new, run.state_new, t, x)
    return error


def reached_limit(run: Run) -> int:
    """Return why no further step may be tried, or `RUNNING`."""
    if run.time == run.t_end:
        return FINISHED
    if run.room.every_step != 0.0 and run.counts.samples == run.room.samples:
        return FULL
    if run.room.keep_dense != 0.0 and run.counts.steps == run.room.steps:
        return FULL
    if run.counts.accepted + run.counts.rejected >= run.goal.max_trials:
        return TOO_MANY
    return RUNNING


def advance(
    f: Function, g: Function, e: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps; return one of the codes of `block`.

    `FULL` wants more room for the record, `RUNNING` another call. `e` gives the gaps over which no step may
    pass, if the run has any.
    """
    for _trial in range(trials):
        code = reached_limit(run)
        if code == RUNNING:
            code = try_step(f, g, e, run, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING


def scaled_norm(run: Run, x: Reals) -> float:
    """Return the root mean square of a vector over the tolerated errors."""
    n = run.states
    total = 0.0
    for i in range(n):
        share = x[i] / error_scale(run, n, i)
        total = total + share * share
    return sqrt(total / max(n, 1))


def first_step(f: Function, run: Run) -> float:
    """Guess a step from the size of the first two derivatives: section II.4, Starting Step Size.

    What adds up quantities of different units there does so in units of the longest step allowed, so that the
    guess does not depend on the unit of time. It is not shorter than times can tell.
    """
    n = run.states
    t = run.time
    direction = run.goal.direction
    bound = min(abs(run.t_end - t), run.goal.max_step)
    K = run.slopes
    size = scaled_norm(run, run.state_old)
    slope = bound * scaled_norm(run, K)
    share = 1e-6
    if size >= 1e-5 and slope >= 1e-5:
        share = 0.01 * size / slope
    share = min(share, 1.0)
    h = share * bound
    for i in range(n):
        run.stage[i] = run.state_old[i] + direction * h * K[i]
    evaluate(f, run, t + direction * h, run.stage, part(K, n, n))
    for i in range(n):
        run.stage[i] = K[n + i] - K[i]
    steepest = max(slope, bound * scaled_norm(run, run.stage) / share)
    if not is_finite(steepest):
        return h
    longer = max(1e-6, 1e-3 * share)
    if steepest > 1e-15:
        longer = power(0.01 / steepest, 1.0 / run.method.order)
    least = min(bound, SHORTEST * EPSILON * abs(t))
    return max(min(min(100.0 * share, longer), 1.0) * bound, least)


def begin_record(run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Store the first sample; return `FINISHED` where the motion ends at its beginning, else `RUNNING`."""
    n = run.states
    copy(n, run.state_old, run.state_new)
    start = run.time
    if run.room.every_step != 0.0:
        store_sample(run, start, run.state_old, t, x)
    elif run.room.times > 0:
        if times[0] == start:
            store_sample(run, start, run.state_old, t, x)
    if run.room.keep_dense != 0.0:
        breaks[0] = start
    if start == run.t_end:
        return FINISHED
    return RUNNING


def begin(f: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Evaluate the first derivative, choose the first step unless it is given, store the first sample."""
    n = run.states
    start = run.time
    if begin_record(run, times, t, x, breaks) == FINISHED:
        return FINISHED
    run.error = 1e-4
    run.time = behind_jump(run, start)
    evaluate(f, run, run.time, run.state_old, run.slopes)
    if run.counts.failed_kernel > 0:
        return failure(run)
    if all_finite(n, run.slopes) == 0:
        return failure(run)
    step = run.first_step
    if not step > 0.0:
        step = first_step(f, run)
    run.step = run.goal.direction * min(step, run.goal.max_step)
    return RUNNING


def begin_again(f: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Begin anew from the time and state at present, behind the steps that are stored."""
    run.counts.failed_kernel = 0
    run.after_rejection = 0.0
    run.stiff_votes = 0
    run.other_votes = 0
    run.first_step = 0.0  # steps begin with a short one, as at the start, but those of one length
    if run.method.growth == 1.0:
        run.first_step = run.goal.max_step
    first = breaks[0]
    code = begin(f, run, times, t, x, breaks)
    if run.counts.steps != 0:
        breaks[0] = first  # it belongs to the first stretch
    return code
