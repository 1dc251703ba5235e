"""Many motions of one mechanism, one in each lane: what `many_motions` computes, bit for bit.

Each lane has its own step and error, and goes on with the next case when one has ended. Stages, errors and
dense outputs are computed for all lanes at once, what is left in the block of each lane by the functions for
one motion, which also try its step where the function fails.
"""

from __future__ import annotations

from symbody.kernels.block import FINISHED, NOT_ENDED, RUNNING, STIFF, Run, Verdict
from symbody.kernels.configurations.projection import project_new_state
from symbody.kernels.events.passed_gaps import passes_gap
from symbody.kernels.features import GAPS
from symbody.kernels.lanes.lane_block import LaneGroup
from symbody.kernels.lanes.lane_steps import (
    attempt_lanes,
    call_lanes,
    copy_lanes,
    form_dense_outputs,
    mark_infinities,
    take_marked,
)
from symbody.kernels.language import INFINITY, LANES, Function, Reals, part, take, where
from symbody.kernels.many_motions import conclude, prepare
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import accept, count_stiff_votes, reject
from symbody.kernels.step_bounds import behind_jump, plan_trial
from symbody.kernels.step_machine import (
    begin,
    failure,
    is_sampled,
    needs_dense_output,
    pass_jump,
    reached_limit,
    store_samples,
    try_step,
)


def gather(lane: int, n: int, registers: Reals, own: Reals) -> None:
    """Fill an array of the run of a lane from its registers."""
    for i in range(n):
        own[i] = registers[i * LANES + lane]


def scatter(lane: int, n: int, own: Reals, registers: Reals) -> None:
    """Fill the registers of a lane from an array of its run."""
    for i in range(n):
        registers[i * LANES + lane] = own[i]


def gather_all(group: LaneGroup, lane: int) -> None:
    """Fill all vectors and derivatives of the run of a lane."""
    run = Run.view(group.runs, lane * group.run_size)
    n = run.states
    gather(lane, n, group.state_old, run.state_old)
    gather(lane, n, group.stage, run.stage)
    gather(lane, n, group.state_new, run.state_new)
    gather(lane, n, group.error_1, run.error_1)
    gather(lane, n, group.error_2, run.error_2)
    gather(lane, group.method.stage_rows * n, group.slopes, run.slopes)


def scatter_all(group: LaneGroup, lane: int) -> None:
    """Fill all registers of a lane."""
    run = Run.view(group.runs, lane * group.run_size)
    n = run.states
    scatter(lane, n, run.state_old, group.state_old)
    scatter(lane, n, run.stage, group.stage)
    scatter(lane, n, run.state_new, group.state_new)
    scatter(lane, n, run.error_1, group.error_1)
    scatter(lane, n, run.error_2, group.error_2)
    scatter(lane, n, run.tolerances, group.tolerances)
    scatter(lane, group.method.stage_rows * n, run.slopes, group.slopes)


def refill(
    f: Function, group: LaneGroup, lane: int, count: int, size: int, cases: Reals, times: Reals, t: Reals,
    x: Reals, verdicts: Reals,
) -> None:  # fmt: skip
    """Begin the next case that has no verdict in a lane."""
    run = Run.view(group.runs, lane * group.run_size)
    k = group.next_case
    while k < count:
        if Verdict.view(verdicts, k * Verdict.size).code == NOT_ENDED:
            break
        k = k + 1
    group.length[lane] = 0.0
    group.next_case = min(k + 1, count)
    if k == count:
        run.cases.current = -1
        return
    n = run.states
    samples = run.room.times * n
    prepare(run, part(cases, k * size, size))
    run.cases.current = k
    run.cases.lane_code = begin(f, run, times, t, part(x, k * samples, samples), t)
    scatter_all(group, lane)
    narrow = run.numbers
    wide = group.numbers
    scatter(lane, narrow.parameter_count, narrow.parameters, wide.parameters)
    scatter(lane, narrow.constant_count, narrow.constants, wide.constants)


def plan_lane(group: LaneGroup, lane: int) -> int:
    """Set the next trial of a lane; return why there is none, as `step_machine.advance` does."""
    run = Run.view(group.runs, lane * group.run_size)
    code = run.cases.lane_code
    if code == RUNNING:
        code = reached_limit(run)
    if code != RUNNING:
        return code
    plan_trial(run, run.time, run.step)
    group.start[lane] = run.time
    group.length[lane] = run.length
    if run.length != 0.0:
        return RUNNING
    gather_all(group, lane)
    return failure(run)


def fill_lane(
    f: Function, group: LaneGroup, lane: int, count: int, size: int, cases: Reals, times: Reals, t: Reals,
    x: Reals, verdicts: Reals,
) -> int:  # fmt: skip
    """Plan the next trial of a lane, of another case where one has ended; return 1, or 0 if none is left."""
    run = Run.view(group.runs, lane * group.run_size)
    while run.cases.current >= 0 or group.next_case < count:
        if run.cases.current >= 0:
            code = plan_lane(group, lane)
            if code == RUNNING:
                return 1
            conclude(run, code, Verdict.view(verdicts, run.cases.current * Verdict.size))
            group.cases_ended = group.cases_ended + 1
        refill(f, group, lane, count, size, cases, times, t, x, verdicts)
    group.length[lane] = 0.0
    return 0


def project_lanes(wide: Function, g: Function, group: LaneGroup) -> int:
    """Do what `step_machine.close` does in every lane whose error is tolerated.

    Returns the status of the function if it failed. The errors of lanes that had to move too far become
    infinite.
    """
    n = group.states
    some = 0
    for lane in range(LANES):
        run = Run.view(group.runs, lane * group.run_size)
        group.mask[lane] = 0.0
        if run.cases.current >= 0 and group.error[lane] <= 1.0:
            gather(lane, n, group.state_old, run.state_old)
            gather(lane, n, group.state_new, run.state_new)
            moved = project_new_state(g, run, run.t_new)
            scatter(lane, n, run.state_new, group.state_new)
            if moved < 0.0:
                group.error[lane] = INFINITY
            elif moved > 0.0:
                group.mask[lane] = 1.0
                group.calls[lane] = group.calls[lane] + 1.0
                some = 1
    if some == 0:
        return 0
    return renew_derivatives(wide, group)


def renew_derivatives(wide: Function, group: LaneGroup) -> int:
    """Renew the derivatives at the ends of the steps that are marked; return the status of the function.

    Other lanes compute the beginnings of theirs, where the function is known not to fail.
    """
    n = group.states
    size = n * LANES
    x = group.scratch
    slopes = group.scratch_slope
    end = part(group.slopes, group.method.stages * size, size)
    copy_lanes(n, group.state_old, x)
    take_marked(group, n, group.state_new, x)
    marks = take(group.mask, 0)
    start = take(group.start, 0)
    # a step that ends at a jump keeps the derivative before it
    t = where(marks > 0.0, start + take(group.length, 0), start)
    status = call_lanes(wide, group, t, x, slopes)
    if status != 0:
        return status
    take_marked(group, n, slopes, end)
    mark_infinities(group, n, end)
    for lane in range(LANES):
        if group.mask[lane] != 0.0 and group.first[lane] != 0.0:
            group.error[lane] = INFINITY
    return 0


def mark_dense(group: LaneGroup, times: Reals) -> int:
    """Mark the lanes whose steps need their dense outputs; return 1 if there are any, else 0."""
    some = 0
    for lane in range(LANES):
        run = Run.view(group.runs, lane * group.run_size)
        group.mask[lane] = 0.0
        if run.cases.current >= 0 and group.error[lane] <= 1.0:
            if needs_dense_output(run, times) != 0:
                group.mask[lane] = 1.0
                some = 1
    return some


def judge(group: LaneGroup, lane: int) -> int:
    """Return 1 if the case of a lane is stiff and ends for that, as in `step_machine.try_step`, else 0."""
    run = Run.view(group.runs, lane * group.run_size)
    if run.stiff_votes != 0 or run.unjudged == 999:
        gather_all(group, lane)
    stiff = count_stiff_votes(run, run.length)
    if stiff != 0 and run.goal.stop_when_stiff != 0.0 and run.t_new != run.t_end:
        return 1
    return 0


def passes_gap_in_lane(e: Function, group: LaneGroup, lane: int) -> int:
    """Return 1 if the step of a lane passes over a gap, see `passed_gaps`, else 0."""
    if GAPS != 0:
        run = Run.view(group.runs, lane * group.run_size)
        if exists(run.gaps):
            gather(lane, run.method.dense_rows * run.states, group.dense, run.dense)
            return passes_gap(e, run, run.dense)
    return 0


def conclude_lane(
    g: Function, e: Function, group: LaneGroup, lane: int, times: Reals, t: Reals, x: Reals
) -> None:
    """Accept or reject the step of a lane, and mark the lane if it is accepted."""
    run = Run.view(group.runs, lane * group.run_size)
    error = group.error[lane]
    n = run.states
    run.counts.failed_kernel = 0
    run.counts.evaluations = run.counts.evaluations + group.calls[lane]
    if group.mask[lane] != 0.0:
        run.counts.evaluations = run.counts.evaluations + (run.method.stage_rows - run.method.stages - 1)
        if group.first[lane] != 0.0:
            error = INFINITY
    group.mask[lane] = 0.0
    if error <= 1.0:
        if passes_gap_in_lane(e, group, lane) != 0:
            error = INFINITY
    if not error <= 1.0:
        reject(run, run.length, error)
        return
    if is_sampled(run, times) != 0:
        rows = run.method.dense_rows * n
        gather(lane, rows, group.dense, run.dense)
        gather(lane, n, group.state_new, run.state_new)
        samples = run.room.times * n
        store_samples(g, run, run.dense, times, t, part(x, run.cases.current * samples, samples))
    if judge(group, lane) != 0:
        run.cases.lane_code = STIFF
    accept(run, run.t_new, run.length, error)
    group.mask[lane] = 1.0


def try_alone(
    f: Function, g: Function, e: Function, group: LaneGroup, lane: int, times: Reals, t: Reals, x: Reals
) -> None:
    """Try the step of a lane as that of one motion, from what it started from."""
    run = Run.view(group.runs, lane * group.run_size)
    samples = run.room.times * run.states
    gather_all(group, lane)
    own = part(x, run.cases.current * samples, samples)
    run.cases.lane_code = try_step(f, g, e, run, times, t, own, t, t)
    scatter_all(group, lane)


def conclude_all(
    f: Function, wide: Function, g: Function, e: Function, group: LaneGroup, attempted: int, times: Reals,
    t: Reals, x: Reals,
) -> None:  # fmt: skip
    """Accept or reject the steps that `attempt_lanes` tried; with a status other than 0 it failed."""
    status = attempted
    if status == 0 and group.projects != 0.0:
        status = project_lanes(wide, g, group)
    dense_status = 0
    if status == 0:
        if mark_dense(group, times) != 0:
            dense_status = form_dense_outputs(wide, group)
    n = group.states
    for lane in range(LANES):
        run = Run.view(group.runs, lane * group.run_size)
        if run.cases.current < 0:
            group.mask[lane] = 0.0
        elif status == 0 and (dense_status == 0 or group.mask[lane] == 0.0):
            conclude_lane(g, e, group, lane, times, t, x)
        else:
            group.mask[lane] = 0.0
            try_alone(f, g, e, group, lane, times, t, x)
    size = n * LANES
    K = group.slopes
    take_marked(group, n, group.state_new, group.state_old)
    take_marked(group, n, part(K, group.method.stages * size, size), part(K, 0, size))
    for lane in range(LANES):
        if group.mask[lane] != 0.0:
            pass_jump_in_lane(f, group, lane)


def pass_jump_in_lane(f: Function, group: LaneGroup, lane: int) -> None:
    """Go on behind a jump in a lane, as `step_machine.pass_jump` does."""
    run = Run.view(group.runs, lane * group.run_size)
    if behind_jump(run, run.time) != run.time:
        n = run.states
        gather(lane, n, group.state_old, run.state_old)
        pass_jump(f, run)
        scatter(lane, n, run.slopes, group.slopes)


def run_lanes(
    f: Function, wide: Function, g: Function, group: LaneGroup, count: int, size: int, cases: Reals,
    times: Reals, t: Reals, x: Reals, verdicts: Reals, turns: int,
) -> int:  # fmt: skip
    """Try so many steps in all lanes, as `many_motions.run_cases`; return `RUNNING` or `FINISHED`."""
    for _turn in range(turns):
        running = 0
        for lane in range(LANES):
            running = running + fill_lane(f, group, lane, count, size, cases, times, t, x, verdicts)
        if running == 0:
            return FINISHED
        attempted = attempt_lanes(wide, group)
        conclude_all(f, wide, g, f, group, attempted, times, t, x)
    for lane in range(LANES):
        run = Run.view(group.runs, lane * group.run_size)
        if run.cases.current >= 0:
            conclude(run, RUNNING, Verdict.view(verdicts, run.cases.current * Verdict.size))
    return RUNNING
