"""Many motions of one mechanism, one in each lane: what `native.cases` computes, bit for bit.

Each lane has its own step and error, and goes on with the next case when one has ended. Stages, errors and
dense outputs are computed for all lanes at once, what is left lane by lane, projections among it. Where the
function fails, each lane tries its step in the loop for a single motion, whose arrays are filled from the
lane's.
`SOURCES` stands for the files compiled into `run_cases_in_lanes`, see `native.cases`.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from symbody.simulation.native.cases import Cases, Outcome, conclude, fill, fill_projector, prepare
from symbody.simulation.native.interface import (
    Goal,
    Memory,
    Method,
    Projector,
    Record,
    RightHandSide,
    borrow,
    compile_loop,
    inline,
)
from symbody.simulation.native.lanes.arithmetic import WIDTH
from symbody.simulation.native.lanes.lane_projection import project_new_states
from symbody.simulation.native.lanes.lane_steps import (
    CALLS,
    ERROR_NORM,
    FIRST,
    MASK,
    T_NEW,
    Bundle,
    H,
    T,
    attempt_all,
    form_dense_outputs,
    take_marked,
)
from symbody.simulation.native.layout import (
    ACCEPTED,
    EVALUATIONS,
    FINISHED,
    KERNEL,
    REJECTED,
    RUNNING,
    SAMPLES,
    STATE_NEW,
    STATE_OLD,
    STEP,
    STIFF,
    STIFF_VOTES,
    TIME,
    TOO_MANY,
)
from symbody.simulation.native.loop import (
    accept,
    advance,
    begin,
    failure,
    interpolate,
    is_stiff,
    pass_jump,
    reject,
)
from symbody.simulation.native.projection import project
from symbody.simulation.native.step_bounds import behind_jump, next_trial

# A test says what it has to be.
SOURCES: Final = "1fcb5a9f89bfcefa"


class Single(NamedTuple):
    """The loop for one motion, which is what a lane is for a moment."""

    rhs: RightHandSide
    projector: Projector
    method: Method
    goal: Goal
    memory: Memory
    record: Record


@inline
def _load(single: Single, bundle: Bundle, lane: int) -> None:
    """Fill the arrays for one motion from those of a lane."""
    memory = single.memory
    for i in range(memory.K.shape[1]):
        for row in range(memory.vectors.shape[0]):
            memory.vectors[row, i] = bundle.vectors[row, i * WIDTH + lane]
        for row in range(memory.K.shape[0]):
            memory.K[row, i] = bundle.K[row, i * WIDTH + lane]
    for k in range(memory.real.size):
        memory.real[k] = bundle.real[lane, k]
    for k in range(memory.counts.size):
        memory.counts[k] = bundle.counts[lane, k]


@inline
def _unload(single: Single, bundle: Bundle, lane: int) -> None:
    """Fill the arrays of a lane from those for one motion."""
    memory = single.memory
    for i in range(memory.K.shape[1]):
        for row in range(memory.vectors.shape[0]):
            bundle.vectors[row, i * WIDTH + lane] = memory.vectors[row, i]
        for row in range(memory.K.shape[0]):
            bundle.K[row, i * WIDTH + lane] = memory.K[row, i]
    for k in range(memory.real.size):
        bundle.real[lane, k] = memory.real[k]
    for k in range(memory.counts.size):
        bundle.counts[lane, k] = memory.counts[k]


@inline
def _own_record(single: Single, outcome: Outcome, k: int) -> Record:
    """Return where the samples of case k go; all samples have the same times."""
    record = single.record
    return Record(record.wanted, record.t, outcome.x[k], record.breaks, record.pieces, False, False)


@inline
def _refill(
    single: Single, wide: RightHandSide, bundle: Bundle, cases: Cases, outcome: Outcome, lane: int,
    first: int, start: float, first_step: float,
) -> int:  # fmt: skip
    """Begin the first case from `first` on that has not ended; return where to look for the next."""
    count = cases.states.shape[0]
    k = first
    while k < count and outcome.codes[k] != -1:
        k += 1
    bundle.trial[H, lane] = 0.0
    if k == count:
        bundle.cases[lane] = -1
        return k
    prepare(single.rhs, single.memory, cases, k, start)
    fill(single.goal.atol, cases.atol, k)
    for i in range(single.memory.K.shape[1]):
        bundle.atol[0, i * WIDTH + lane] = cases.atol[k, i]
    own = _own_record(single, outcome, k)
    bundle.codes[lane] = begin(single.rhs, single.method, single.goal, single.memory, own, first_step)
    bundle.cases[lane] = k
    _unload(single, bundle, lane)
    for i in range(cases.parameters.shape[1]):
        wide.parameters[i * WIDTH + lane] = cases.parameters[k, i]
    for i in range(cases.constants.shape[1]):
        wide.constants[i * WIDTH + lane] = cases.constants[k, i]
    return k + 1


@inline
def _plan(single: Single, bundle: Bundle, lane: int) -> int:
    """Set the next trial of a lane; return why there is none, as `loop.advance` does."""
    counts, goal, t = bundle.counts, single.goal, bundle.real[lane, TIME]
    code: int = bundle.codes[lane]
    if code != RUNNING:
        return code
    if t == goal.t_end:
        return FINISHED
    if counts[lane, ACCEPTED] + counts[lane, REJECTED] >= goal.max_trials:
        return TOO_MANY
    h, t_new = next_trial(goal, counts[lane], t, bundle.real[lane, STEP])
    bundle.trial[T, lane], bundle.trial[H, lane], bundle.trial[T_NEW, lane] = t, h, t_new
    if h != 0.0:
        return RUNNING
    _load(single, bundle, lane)
    for i in range(single.memory.K.shape[1]):
        goal.atol[i] = bundle.atol[0, i * WIDTH + lane]
    code = failure(single.method, goal, single.memory)
    _unload(single, bundle, lane)
    return code


@inline
def _put_down(single: Single, bundle: Bundle, outcome: Outcome, lane: int, code: int) -> None:
    """Write down how far the case of a lane came."""
    memory = single.memory
    memory.real[TIME] = bundle.real[lane, TIME]
    for k in range(memory.counts.size):
        memory.counts[k] = bundle.counts[lane, k]
    conclude(memory, outcome, bundle.cases[lane], code)


@inline
def _try_alone(single: Single, bundle: Bundle, cases: Cases, outcome: Outcome, lane: int) -> None:
    """Try the step of a lane in the loop for one motion, from what it started from."""
    k = bundle.cases[lane]
    _load(single, bundle, lane)
    _fill(single, cases, k)
    fill_projector(single.projector, cases, k)
    own = _own_record(single, outcome, k)
    bundle.codes[lane] = advance(
        single.rhs, single.projector, single.method, single.goal, single.memory, own, 1
    )
    _unload(single, bundle, lane)


@inline
def _fill(single: Single, cases: Cases, k: int) -> None:
    """Set the function for one motion to the numbers of case k."""
    fill(single.rhs.parameters, cases.parameters, k)
    fill(single.rhs.constants, cases.constants, k)
    fill(single.goal.atol, cases.atol, k)


@inline
def _pass_jump(single: Single, bundle: Bundle, cases: Cases, lane: int) -> None:
    """Go on behind a jump in a lane, as `loop.pass_jump` does."""
    t = bundle.real[lane, TIME]
    if behind_jump(single.goal, bundle.counts[lane], t) != t:
        _load(single, bundle, lane)
        _fill(single, cases, bundle.cases[lane])
        pass_jump(single.rhs, single.goal, single.memory)
        _unload(single, bundle, lane)


@inline
def _next_sample(goal: Goal, record: Record, sample: int, t_new: float) -> float:
    """Return how far beyond the end of a step the next sample lies, negative if it lies before."""
    return (record.wanted[sample] - t_new) * goal.direction if sample < record.wanted.size else 1.0


@inline
def _mark_samples(single: Single, bundle: Bundle) -> bool:
    """Mark the lanes whose steps have samples inside; return whether there are any."""
    some = False
    for lane in range(WIDTH):
        bundle.trial[MASK, lane] = 0.0
        if bundle.cases[lane] >= 0 and bundle.trial[ERROR_NORM, lane] <= 1.0:
            sample, t_new = bundle.counts[lane, SAMPLES], bundle.trial[T_NEW, lane]
            if _next_sample(single.goal, single.record, sample, t_new) < 0.0:
                bundle.trial[MASK, lane] = 1.0
                some = True
    return some


@inline
def _store_samples(single: Single, bundle: Bundle, cases: Cases, outcome: Outcome, lane: int) -> None:
    """Store the samples of the step of a lane."""
    F, x, goal, record = single.memory.F, outcome.x[bundle.cases[lane]], single.goal, single.record
    projector, n = single.projector, x.shape[1]
    fill_projector(projector, cases, bundle.cases[lane])
    fill(goal.atol, cases.atol, bundle.cases[lane])
    for i in range(n):
        for row in range(F.shape[1]):
            F[0, row, i] = bundle.F[row, i * WIDTH + lane]
    t, t_new = bundle.trial[T, lane], bundle.trial[T_NEW, lane]
    sample = bundle.counts[lane, SAMPLES]
    while sample < record.wanted.size:
        time = record.wanted[sample]
        if (time - t_new) * goal.direction > 0.0:
            break
        if time == t_new:
            for i in range(n):
                x[sample, i] = bundle.vectors[STATE_NEW, i * WIDTH + lane]
        else:
            interpolate(F, 0, (time - t) / (t_new - t), x, sample)
            if projector.address != 0:
                project(projector, goal.rtol, goal.atol, time, x, sample)
        sample += 1
    bundle.counts[lane, SAMPLES] = sample


@inline
def _judge(single: Single, bundle: Bundle, lane: int) -> None:
    """End the case of a lane if it is stiff, as `loop.advance` does."""
    method, goal, memory = single.method, single.goal, single.memory
    counts, trial = bundle.counts, bundle.trial
    if (counts[lane, ACCEPTED] + 1) % 1000 != 0 and counts[lane, STIFF_VOTES] == 0:
        return
    _load(single, bundle, lane)
    stiff = is_stiff(method, memory, trial[H, lane])
    for k in range(memory.counts.size):
        counts[lane, k] = memory.counts[k]
    if stiff and goal.stop_when_stiff and trial[T_NEW, lane] != goal.t_end:
        bundle.codes[lane] = STIFF


@inline
def _conclude_lane(
    single: Single, bundle: Bundle, cases: Cases, outcome: Outcome, lane: int, extra: int
) -> None:
    """Accept or reject the step of a lane, and mark the lane if it is accepted.

    `extra` evaluations were needed for dense output, where a sample lies inside.
    """
    trial, counts, method = bundle.trial, bundle.counts[lane], single.method
    h, t_new, error = trial[H, lane], trial[T_NEW, lane], trial[ERROR_NORM, lane]
    counts[KERNEL] = 0
    counts[EVALUATIONS] += np.intp(trial[CALLS, lane])
    if trial[MASK, lane] != 0.0:
        counts[EVALUATIONS] += extra
        if trial[FIRST, lane] != 0.0:
            error = np.inf
    trial[MASK, lane] = 0.0
    if error > 1.0:
        reject(method, bundle.real[lane], counts, h, error)
        return
    if _next_sample(single.goal, single.record, counts[SAMPLES], t_new) <= 0.0:
        _store_samples(single, bundle, cases, outcome, lane)
    _judge(single, bundle, lane)
    accept(method, single.goal, bundle.real[lane], counts, t_new, h, error)
    trial[MASK, lane] = 1.0


@inline
def _conclude_all(
    single: Single, wide: RightHandSide, bundle: Bundle, cases: Cases, outcome: Outcome, is_tried: bool
) -> None:
    """Accept or reject the steps that `attempt_all` tried, unless it failed."""
    trial, method = bundle.trial, single.method
    extra = bundle.K.shape[0] - method.stages - 1
    is_dense = True
    if is_tried and single.projector.address != 0:
        is_tried = project_new_states(
            wide, single.projector, method, single.goal, single.memory, bundle, cases
        )
    if is_tried and _mark_samples(single, bundle):
        is_dense = form_dense_outputs(wide, method, bundle)
    for lane in range(WIDTH):
        if bundle.cases[lane] < 0:
            trial[MASK, lane] = 0.0
        elif is_tried and (is_dense or trial[MASK, lane] == 0.0):
            _conclude_lane(single, bundle, cases, outcome, lane, extra)
        else:
            trial[MASK, lane] = 0.0
            _try_alone(single, bundle, cases, outcome, lane)
    take_marked(bundle, bundle.vectors, STATE_NEW, bundle.vectors, STATE_OLD)
    take_marked(bundle, bundle.K, method.stages, bundle.K, 0)
    for lane in range(WIDTH):
        if trial[MASK, lane] != 0.0:
            _pass_jump(single, bundle, cases, lane)


@compile_loop
def run_cases_in_lanes(
    single: Single,
    wide: RightHandSide,
    bundle: Bundle,
    start: float,
    first_step: float,
    cases: Cases,
    outcome: Outcome,
) -> None:
    """Compute all cases that have no code yet, as `native.cases.run_cases`, by `wide` in lanes."""
    group = Single(
        borrow(single.rhs),
        borrow(single.projector),
        borrow(single.method),
        borrow(single.goal),
        borrow(single.memory),
        borrow(single.record),
    )
    wide, bundle = borrow(wide), borrow(bundle)
    cases, outcome = borrow(cases), borrow(outcome)
    following = 0
    while outcome.stop[0] == 0:
        running = 0
        for lane in range(WIDTH):
            code = FINISHED
            while code != RUNNING:
                if bundle.cases[lane] >= 0:
                    code = _plan(group, bundle, lane)
                    if code == RUNNING:
                        running += 1
                        break
                    _put_down(group, bundle, outcome, lane, code)
                following = _refill(group, wide, bundle, cases, outcome, lane, following, start, first_step)
                if bundle.cases[lane] < 0:
                    break
        if running == 0:
            return
        is_tried = attempt_all(wide, group.method, group.goal, bundle)
        _conclude_all(group, wide, bundle, cases, outcome, is_tried)
    for lane in range(WIDTH):
        if bundle.cases[lane] >= 0:
            _put_down(group, bundle, outcome, lane, RUNNING)
