"""The Runge-Kutta loop, compiled by numba once for every model.

The right-hand side comes in as the address of a function with the signature of all generated code, ::

    int f(const double *t, const double *q, const double *u, const double *r,
          const double *p, const double *c, double *out, double *work)

so the loop is compiled at its first call only, and later processes read it from numba's cache. Coefficients
arrive as arguments: numba renews what it keeps only when the text of the file of the outermost function, this
one, changes; `SOURCES` stands for the files compiled into it. States are ordered x = (u, q); sections are
those of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., and from IV on of
Hairer and Wanner, part II.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.simulation.native.interface import (
    Floats,
    Goal,
    Integers,
    Memory,
    Method,
    Projector,
    Record,
    RightHandSide,
    borrow,
    compile_loop,
    inline,
)
from symbody.simulation.native.layout import (
    ACCEPTED,
    AFTER_REJECTION,
    COLLAPSED,
    ERROR,
    ERROR_1,
    ERROR_2,
    FINISHED,
    FIRST_BREAK,
    FULL,
    KERNEL,
    NEXT_BREAK,
    NOT_FINITE,
    OTHER_VOTES,
    REJECTED,
    RUNNING,
    SAMPLES,
    SINGULAR,
    STAGE,
    STATE,
    STATE_NEW,
    STATE_OLD,
    STEP,
    STEPS,
    STIFF,
    STIFF_VOTES,
    TIME,
    TOO_MANY,
)
from symbody.simulation.native.projection import asked_move, project
from symbody.simulation.native.stages import (
    attempt,
    evaluate,
    form_dense_output,
    four_states,
    row_is_finite,
    scale,
)
from symbody.simulation.native.step_bounds import EPSILON as EPSILON
from symbody.simulation.native.step_bounds import behind_jump, next_break, next_trial

# Of the files below that are compiled into these functions; a test says what it has to be.
SOURCES: Final = "da5632157b0b783e"
SAFETY: Final = 0.9


@inline
def interpolate(F: Floats, piece: int, s: float, x: Floats, target: int) -> None:
    """Set x[target] to the dense output at the share s of the step; `dense_output` repeats it."""
    rows, n = F.shape[1], F.shape[2]
    for block in range(0, n, 4):
        i, j, k, m = four_states(block, n)
        a = b = c = d = 0.0
        factor, other = (s, 1.0 - s) if rows % 2 == 0 else (1.0 - s, s)
        for row in range(rows - 1, 0, -1):
            a = (a + F[piece, row, i]) * factor
            b = (b + F[piece, row, j]) * factor
            c = (c + F[piece, row, k]) * factor
            d = (d + F[piece, row, m]) * factor
            factor, other = other, factor
        x[target, i] = F[piece, 0, i] + a
        x[target, j] = F[piece, 0, j] + b
        x[target, k] = F[piece, 0, k] + c
        x[target, m] = F[piece, 0, m] + d


@inline
def _needs_dense_output(goal: Goal, memory: Memory, record: Record, t_new: float) -> bool:
    if record.keep_dense or record.every_step:
        return record.keep_dense
    sample = memory.counts[SAMPLES]
    if sample == record.wanted.size:
        return False
    inside: bool = (record.wanted[sample] - t_new) * goal.direction < 0.0
    return inside


@inline
def _store_sample(memory: Memory, record: Record, t: float, source: int) -> None:
    sample = memory.counts[SAMPLES]
    record.t[sample] = t
    for i in range(record.x.shape[1]):
        record.x[sample, i] = memory.vectors[source, i]
    memory.counts[SAMPLES] = sample + 1


@inline
def _store(projector: Projector, goal: Goal, memory: Memory, record: Record, t: float, t_new: float) -> None:
    """Store the samples of an accepted step, and its end if the dense output is kept."""
    counts = memory.counts
    F, piece = (record.pieces, counts[STEPS]) if record.keep_dense else (memory.F, 0)
    if record.keep_dense:
        record.breaks[counts[STEPS] + 1] = t_new
        counts[STEPS] += 1
    if record.every_step:
        _store_sample(memory, record, t_new, STATE_NEW)
        return
    while counts[SAMPLES] < record.wanted.size:
        time = record.wanted[counts[SAMPLES]]
        if (time - t_new) * goal.direction > 0.0:
            return
        if time == t_new:
            _store_sample(memory, record, time, STATE_NEW)
        else:
            interpolate(F, piece, (time - t) / (t_new - t), record.x, counts[SAMPLES])
            if projector.address != 0:
                project(projector, goal.rtol, goal.atol, time, record.x, counts[SAMPLES])
            record.t[counts[SAMPLES]] = time
            counts[SAMPLES] += 1


@inline
def is_stiff(method: Method, memory: Memory, h: float) -> bool:
    """Count steps at the stability bound as section IV.2 does; return whether there are too many."""
    counts, vectors, K = memory.counts, memory.vectors, memory.K
    if (counts[ACCEPTED] + 1) % 1000 != 0 and counts[STIFF_VOTES] == 0:
        return False
    slope = 0.0
    distance = 0.0
    for i in range(K.shape[1]):
        slope += (K[method.stages, i] - K[method.stages - 1, i]) ** 2
        distance += (vectors[STATE_NEW, i] - vectors[STAGE, i]) ** 2
    if h * h * slope > method.stiff_bound**2 * distance and distance > 0.0:
        counts[OTHER_VOTES] = 0
        counts[STIFF_VOTES] += 1
    else:
        counts[OTHER_VOTES] += 1
        if counts[OTHER_VOTES] == 6:
            counts[STIFF_VOTES] = 0
            counts[OTHER_VOTES] = 0
    is_stiff: bool = counts[STIFF_VOTES] >= 15
    return is_stiff


@inline
def accept(
    method: Method, goal: Goal, real: Floats, counts: Integers, t_new: float, h: float, error: float
) -> None:
    """Go on to the end of a step and choose the next one: sections II.4 and IV.2."""
    factor = SAFETY * error ** (-method.exponent) if error > 0.0 else method.growth
    if method.memory != 0.0 and error > 0.0:
        factor *= real[ERROR] ** method.memory
    factor = min(max(factor, method.shrink), method.growth)
    if counts[AFTER_REJECTION] != 0:
        factor = min(factor, 1.0)
    real[TIME] = t_new
    real[STEP] = goal.direction * min(abs(h) * factor, goal.max_step)
    real[ERROR] = max(error, 1e-4)
    counts[ACCEPTED] += 1
    counts[AFTER_REJECTION] = 0


@inline
def reject(method: Method, real: Floats, counts: Integers, h: float, error: float) -> None:
    """Choose a shorter step."""
    real[STEP] = h * max(method.shrink, SAFETY * error ** (-method.exponent))
    counts[REJECTED] += 1
    counts[AFTER_REJECTION] = 1


@inline
def failure(method: Method, goal: Goal, memory: Memory) -> int:
    """Say why the last trial failed, and write which state is to blame to counts[STATE]."""
    if memory.counts[KERNEL] != 0:
        return SINGULAR
    for row in range(method.stages + 1):
        for i in range(memory.K.shape[1]):
            if not np.isfinite(memory.K[row, i]):
                memory.counts[STATE] = i
                return NOT_FINITE
    worst = 0.0
    for i in range(memory.K.shape[1]):
        error = abs(memory.vectors[ERROR_1, i]) / scale(goal, memory, i)
        if error >= worst:
            worst = error
            memory.counts[STATE] = i
    return COLLAPSED


@inline
def project_new_state(projector: Projector, goal: Goal, memory: Memory, t_new: float) -> float:
    """Project the new state; return how far it moved, negative if that was too far.

    What the state before the step would ask for if rounded otherwise is no fault of the step, and a shorter
    one mends nothing.
    """
    moved: float = project(projector, goal.rtol, goal.atol, t_new, memory.vectors, STATE_NEW)
    if not moved <= projector.limit:
        t = memory.real[TIME]
        asked = asked_move(projector, goal.rtol, goal.atol, t, memory.vectors, STATE_OLD, ERROR_2)
        if not moved <= projector.limit * asked:
            return -1.0
    return moved


@inline
def _close(
    rhs: RightHandSide, projector: Projector, method: Method, goal: Goal, memory: Memory, t_new: float
) -> bool:
    """Project the new state and renew its derivative; return whether it needed no large move."""
    moved = project_new_state(projector, goal, memory, t_new)
    if moved < 0.0:
        return False
    if moved > 0.0:
        evaluate(rhs, memory, t_new, STATE_NEW, method.stages)
    return memory.counts[KERNEL] == 0 and row_is_finite(memory.K, method.stages)


@inline
def pass_jump(rhs: RightHandSide, goal: Goal, memory: Memory) -> None:
    """Go on behind a jump, with the derivative there, if a step has ended at one."""
    t = behind_jump(goal, memory.counts, memory.real[TIME])
    if t != memory.real[TIME]:
        memory.real[TIME] = t
        evaluate(rhs, memory, t, STATE_OLD, 0)


@inline
def _try_step(
    rhs: RightHandSide, projector: Projector, method: Method, goal: Goal, memory: Memory, record: Record
) -> int:
    t, counts = memory.real[TIME], memory.counts
    h, t_new = next_trial(goal, counts, t, memory.real[STEP])
    if h == 0.0:
        return failure(method, goal, memory)
    error = attempt(rhs, method, goal, memory, t, h)
    if error <= 1.0 and projector.address != 0 and not _close(rhs, projector, method, goal, memory, t_new):
        error = np.inf
    if error <= 1.0 and _needs_dense_output(goal, memory, record, t_new):
        F, piece = (record.pieces, counts[STEPS]) if record.keep_dense else (memory.F, 0)
        if not form_dense_output(rhs, method, memory, t, h, F, piece):
            error = np.inf
    if error <= 1.0:
        _store(projector, goal, memory, record, t, t_new)
        stiff = is_stiff(method, memory, h)
        accept(method, goal, memory.real, counts, t_new, h, error)
        for i in range(memory.K.shape[1]):
            memory.vectors[STATE_OLD, i] = memory.vectors[STATE_NEW, i]
            memory.K[0, i] = memory.K[method.stages, i]
        pass_jump(rhs, goal, memory)
        return STIFF if stiff and goal.stop_when_stiff and t_new != goal.t_end else RUNNING
    reject(method, memory.real, counts, h, error)
    return RUNNING


@compile_loop
def advance(
    rhs: RightHandSide,
    projector: Projector,
    method: Method,
    goal: Goal,
    memory: Memory,
    record: Record,
    budget: int,
) -> int:
    """Try up to `budget` steps; return one of the codes at the top of this file.

    FULL asks for more room in `record`, RUNNING for another call.
    """
    rhs, projector, method, goal = (
        borrow(rhs),
        borrow(projector),
        borrow(method),
        borrow(goal),
    )
    memory, record = borrow(memory), borrow(record)
    counts = memory.counts
    for _ in range(budget):
        if memory.real[TIME] == goal.t_end:
            return FINISHED
        if record.every_step and counts[SAMPLES] == record.t.size:
            return FULL
        if record.keep_dense and counts[STEPS] == record.pieces.shape[0]:
            return FULL
        if counts[ACCEPTED] + counts[REJECTED] >= goal.max_trials:
            return TOO_MANY
        code = _try_step(rhs, projector, method, goal, memory, record)
        if code != RUNNING:
            return code
    return RUNNING


@inline
def _norm(goal: Goal, memory: Memory, array: Floats, row: int, minus: int) -> float:
    """Return the scaled root mean square of a row, less another row if `minus` is not negative."""
    n = array.shape[1]
    total = 0.0
    for i in range(n):
        other = array[minus, i] if minus >= 0 else 0.0
        total += ((array[row, i] - other) / scale(goal, memory, i)) ** 2
    norm: float = np.sqrt(total / n) if n > 0 else 0.0
    return norm


@inline
def _first_step(rhs: RightHandSide, method: Method, goal: Goal, memory: Memory) -> float:
    """Guess a step from the size of the first two derivatives: section II.4, Starting Step Size.

    What adds up quantities of different units there does so in units of the longest step allowed, so that the
    guess does not depend on the unit of time.
    """
    t = memory.real[TIME]
    bound: float = min(abs(goal.t_end - t), goal.max_step)
    vectors, K = memory.vectors, memory.K
    size = _norm(goal, memory, vectors, STATE_OLD, -1)
    slope = bound * _norm(goal, memory, K, 0, -1)
    share: float = min(1e-6 if size < 1e-5 or slope < 1e-5 else 0.01 * size / slope, 1.0)
    h = share * bound
    for i in range(K.shape[1]):
        vectors[STAGE, i] = vectors[STATE_OLD, i] + goal.direction * h * K[0, i]
    evaluate(rhs, memory, t + goal.direction * h, STAGE, 1)
    steepest = max(slope, bound * _norm(goal, memory, K, 1, 0) / share)
    if not np.isfinite(steepest):
        return h
    longer: float = (
        max(1e-6, 1e-3 * share) if steepest <= 1e-15 else (0.01 / steepest) ** (1.0 / method.order)
    )
    return min(100.0 * share, longer, 1.0) * bound


@compile_loop
def begin(
    rhs: RightHandSide, method: Method, goal: Goal, memory: Memory, record: Record, first_step: float
) -> int:
    """Evaluate the first derivative, choose the first step unless it is given, store the first sample."""
    vectors = memory.vectors
    for i in range(vectors.shape[1]):
        vectors[STATE_NEW, i] = vectors[STATE_OLD, i]
    t = memory.real[TIME]
    if record.every_step or (record.wanted.size > 0 and record.wanted[0] == t):
        _store_sample(memory, record, t, STATE_OLD)
    if record.keep_dense:
        record.breaks[0] = t
    if t == goal.t_end:
        return FINISHED
    memory.real[ERROR] = 1e-4
    memory.real[TIME] = behind_jump(goal, memory.counts, t)
    evaluate(rhs, memory, memory.real[TIME], STATE_OLD, 0)
    if memory.counts[KERNEL] != 0 or not row_is_finite(memory.K, 0):
        return failure(method, goal, memory)
    step = first_step if first_step > 0.0 else _first_step(rhs, method, goal, memory)
    memory.real[STEP] = goal.direction * min(step, goal.max_step)
    return RUNNING


@compile_loop
def project_row(projector: Projector, rtol: float, atol: Floats, t: float, x: Floats, row: int) -> float:
    """Move x[row] onto the constraints; see `projection.project`."""
    moved: float = project(projector, rtol, atol, t, x, row)
    return moved


@compile_loop
def longest_step(goal: Goal, counts: Integers, t: float) -> tuple[float, float, float]:
    """Return from where to where the longest step at a time leads, and when it is said to end."""
    begin = behind_jump(goal, counts, t)
    length, end = next_trial(goal, counts, begin, goal.direction * np.inf)
    k = next_break(goal, counts, end)
    if end != goal.t_end and k > counts[FIRST_BREAK] and goal.jumps[k - 1] and goal.breaks[k - 1] == end:
        stop = end - goal.direction * goal.margins[k - 1]
    else:
        stop = end
    counts[NEXT_BREAK] = counts[FIRST_BREAK]
    return begin, stop, end
