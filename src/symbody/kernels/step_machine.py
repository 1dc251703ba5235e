"""The integrator: steps of one motion, their samples, and why there are no more.

All state lies in the block, so a run stops after any step and goes on, in this process or another. The arrays
of a record are `times`, the samples to store in the order of the motion; `t` and `x`, the samples; `breaks`
and `pieces`, ends and dense output of each step, if they are kept.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    ACCEPTED,
    COLLAPSED,
    DENSE_ROWS,
    DIRECTION,
    ERROR,
    ERROR_1,
    EVERY_STEP,
    FINISHED,
    FIRST_STEP,
    FULL,
    KEEP_DENSE,
    KERNEL,
    LENGTH,
    MAX_STEP,
    MAX_TRIALS,
    METHOD,
    NOT_FINITE,
    ORDER,
    PROJECTOR,
    REJECTED,
    RUNNING,
    SAMPLE_ROOM,
    SAMPLES,
    SINGULAR,
    STAGE,
    STAGE_ROWS,
    STAGES,
    STATE,
    STATE_NEW,
    STATE_OLD,
    STEP,
    STEP_ROOM,
    STEPS,
    STIFF,
    STOP_WHEN_STIFF,
    T_END,
    T_NEW,
    TIME,
    TIMES,
    TOO_MANY,
    VECTOR_ROWS,
    VECTORS,
    N,
)
from symbody.kernels.configurations.projection import project, project_new_state
from symbody.kernels.dense_output import form_dense_output, interpolate
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.power import power
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


def store_sample(B: Reals, time: float, source: int, t: Reals, x: Reals) -> None:
    """Store vector number `source` as a sample."""
    n = int(B[N])
    sample = int(B[SAMPLES])
    t[sample] = time
    copy(n, part(B, VECTORS + source * n, n), part(x, sample * n, n))
    B[SAMPLES] = B[SAMPLES] + 1.0


def is_sampled(B: Reals, times: Reals) -> int:
    """Return 1 if the next sample lies inside the step, 2 if at its end, 0 if beyond."""
    sample = int(B[SAMPLES])
    if sample == int(B[TIMES]):
        return 0
    beyond = (times[sample] - B[T_NEW]) * B[DIRECTION]
    if beyond < 0.0:
        return 1
    if beyond == 0.0:
        return 2
    return 0


def store_samples(g: Function, B: Reals, F: Reals, times: Reals, t: Reals, x: Reals) -> None:
    """Store the samples of an accepted step with the dense output F."""
    n = int(B[N])
    start = B[TIME]
    t_new = B[T_NEW]
    where = is_sampled(B, times)
    while where != 0:
        sample = int(B[SAMPLES])
        time = times[sample]
        if where == 2:
            store_sample(B, time, STATE_NEW, t, x)
        else:
            target = part(x, sample * n, n)
            interpolate(n, int(B[METHOD + DENSE_ROWS]), F, (time - start) / (t_new - start), target)
            if B[PROJECTOR] != 0.0:
                project(g, B, time, target)
            t[sample] = time
            B[SAMPLES] = B[SAMPLES] + 1.0
        where = is_sampled(B, times)


def failure(B: Reals) -> int:
    """Return why the last trial failed, and set `STATE` to the state that is to blame."""
    if B[KERNEL] != 0.0:
        return SINGULAR
    n = int(B[N])
    K = part(B, VECTORS + VECTOR_ROWS * n, (int(B[METHOD + STAGES]) + 1) * n)
    for row in range(int(B[METHOD + STAGES]) + 1):
        for i in range(n):
            if not is_finite(K[row * n + i]):
                B[STATE] = float(i)
                return NOT_FINITE
    worst = 0.0
    for i in range(n):
        error = abs(B[VECTORS + ERROR_1 * n + i]) / error_scale(B, n, i)
        if error >= worst:
            worst = error
            B[STATE] = float(i)
    return COLLAPSED


def close(f: Function, g: Function, B: Reals) -> int:
    """Project the new state and renew its derivative; return 1 if it needed no large move, else 0."""
    t_new = B[T_NEW]
    end = int(B[METHOD + STAGES])
    n = int(B[N])
    moved = project_new_state(g, B, t_new)
    if moved < 0.0:
        return 0
    if moved > 0.0:  # a step that ends at a jump keeps the derivative before it
        evaluate(f, B, B[TIME] + B[LENGTH], STATE_NEW, end)
    if B[KERNEL] != 0.0:
        return 0
    return all_finite(n, part(B, VECTORS + (VECTOR_ROWS + end) * n, n))


def pass_jump(f: Function, B: Reals) -> None:
    """Go on behind a jump, with the derivative there, if a step has ended at one."""
    t = behind_jump(B, B[TIME])
    if t != B[TIME]:
        B[TIME] = t
        evaluate(f, B, t, STATE_OLD, 0)


def try_step(
    f: Function, g: Function, B: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals
) -> int:
    """Try one step; return why there is no other, or `RUNNING`."""
    plan_trial(B, B[TIME], B[STEP])
    h = B[LENGTH]
    if h == 0.0:
        return failure(B)
    error = attempt(f, B, B[TIME], h)
    if error <= 1.0 and B[PROJECTOR] != 0.0:
        if close(f, g, B) == 0:
            error = INFINITY
    if error <= 1.0:
        error = keep_step(f, g, B, error, times, t, x, breaks, pieces)
    if not error <= 1.0:
        reject(B, h, error)
        return RUNNING
    n = int(B[N])
    t_new = B[T_NEW]
    stiff = count_stiff_votes(B, h)
    accept(B, t_new, h, error)
    end = VECTORS + (VECTOR_ROWS + int(B[METHOD + STAGES])) * n
    copy(n, part(B, VECTORS + STATE_NEW * n, n), part(B, VECTORS + STATE_OLD * n, n))
    copy(n, part(B, end, n), part(B, VECTORS + VECTOR_ROWS * n, n))
    pass_jump(f, B)
    if stiff != 0 and B[STOP_WHEN_STIFF] != 0.0 and t_new != B[T_END]:
        return STIFF
    return RUNNING


def keep_step(
    f: Function, g: Function, B: Reals, error: float, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals,
) -> float:  # fmt: skip
    """Store what is kept of an accepted step; return its error, infinite if not all of it is finite."""
    n = int(B[N])
    rows = int(B[METHOD + DENSE_ROWS])
    if B[KEEP_DENSE] != 0.0:
        steps = int(B[STEPS])
        piece = part(pieces, steps * rows * n, rows * n)
        if form_dense_output(f, B, B[TIME], B[LENGTH], piece) == 0:
            return INFINITY
        breaks[steps + 1] = B[T_NEW]
        B[STEPS] = B[STEPS] + 1.0
        if B[EVERY_STEP] == 0.0:
            store_samples(g, B, piece, times, t, x)
    elif B[EVERY_STEP] == 0.0 and is_sampled(B, times) != 0:
        F = part(B, VECTORS + (VECTOR_ROWS + int(B[METHOD + STAGE_ROWS])) * n, rows * n)
        if is_sampled(B, times) == 1:
            if form_dense_output(f, B, B[TIME], B[LENGTH], F) == 0:
                return INFINITY
        store_samples(g, B, F, times, t, x)
    if B[EVERY_STEP] != 0.0:
        store_sample(B, B[T_NEW], STATE_NEW, t, x)
    return error


def reached_limit(B: Reals) -> int:
    """Return why no further step may be tried, or `RUNNING`."""
    if B[TIME] == B[T_END]:
        return FINISHED
    if B[EVERY_STEP] != 0.0 and B[SAMPLES] == B[SAMPLE_ROOM]:
        return FULL
    if B[KEEP_DENSE] != 0.0 and B[STEPS] == B[STEP_ROOM]:
        return FULL
    if B[ACCEPTED] + B[REJECTED] >= B[MAX_TRIALS]:
        return TOO_MANY
    return RUNNING


def advance(
    f: Function, g: Function, B: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
    trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps; return one of the codes of `block`.

    `FULL` wants more room for the record, `RUNNING` another call.
    """
    for _trial in range(trials):
        code = reached_limit(B)
        if code == RUNNING:
            code = try_step(f, g, B, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING


def scaled_norm(B: Reals, x: Reals) -> float:
    """Return the root mean square of a vector over the tolerated errors."""
    n = int(B[N])
    total = 0.0
    for i in range(n):
        share = x[i] / error_scale(B, n, i)
        total = total + share * share
    return sqrt(total / max(n, 1))


def first_step(f: Function, B: Reals) -> float:
    """Guess a step from the size of the first two derivatives: section II.4, Starting Step Size.

    What adds up quantities of different units there does so in units of the longest step allowed, so that the
    guess does not depend on the unit of time. It is not shorter than times can tell.
    """
    n = int(B[N])
    t = B[TIME]
    direction = B[DIRECTION]
    bound = min(abs(B[T_END] - t), B[MAX_STEP])
    V = part(B, VECTORS, VECTOR_ROWS * n)
    K = part(B, VECTORS + VECTOR_ROWS * n, 2 * n)
    size = scaled_norm(B, part(V, STATE_OLD * n, n))
    slope = bound * scaled_norm(B, K)
    share = 1e-6
    if size >= 1e-5 and slope >= 1e-5:
        share = 0.01 * size / slope
    share = min(share, 1.0)
    h = share * bound
    for i in range(n):
        V[STAGE * n + i] = V[STATE_OLD * n + i] + direction * h * K[i]
    evaluate(f, B, t + direction * h, STAGE, 1)
    for i in range(n):
        V[STAGE * n + i] = K[n + i] - K[i]
    steepest = max(slope, bound * scaled_norm(B, part(V, STAGE * n, n)) / share)
    if not is_finite(steepest):
        return h
    longer = max(1e-6, 1e-3 * share)
    if steepest > 1e-15:
        longer = power(0.01 / steepest, 1.0 / B[METHOD + ORDER])
    least = min(bound, SHORTEST * EPSILON * abs(t))
    return max(min(min(100.0 * share, longer), 1.0) * bound, least)


def begin(f: Function, B: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Evaluate the first derivative, choose the first step unless it is given, store the first sample."""
    n = int(B[N])
    copy(n, part(B, VECTORS + STATE_OLD * n, n), part(B, VECTORS + STATE_NEW * n, n))
    start = B[TIME]
    if B[EVERY_STEP] != 0.0:
        store_sample(B, start, STATE_OLD, t, x)
    elif B[TIMES] > 0.0:
        if times[0] == start:
            store_sample(B, start, STATE_OLD, t, x)
    if B[KEEP_DENSE] != 0.0:
        breaks[0] = start
    if start == B[T_END]:
        return FINISHED
    B[ERROR] = 1e-4
    B[TIME] = behind_jump(B, start)
    evaluate(f, B, B[TIME], STATE_OLD, 0)
    if B[KERNEL] != 0.0:
        return failure(B)
    if all_finite(n, part(B, VECTORS + VECTOR_ROWS * n, n)) == 0:
        return failure(B)
    step = B[FIRST_STEP]
    if not step > 0.0:
        step = first_step(f, B)
    B[STEP] = B[DIRECTION] * min(step, B[MAX_STEP])
    return RUNNING
