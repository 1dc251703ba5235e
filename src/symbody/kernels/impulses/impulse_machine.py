"""The method of Moreau and Jean: steps of one length, impulses at their ends.

The functions are f, slopes of all states without impulses; k, rates of coordinates; e, gaps; d, how points
are moved; g, which closes the constraints. A step is that of the midpoint rule where nothing touches. Points
act whose gaps it would leave negative; with J, M and all forces in the middle, they get the impulses that
fulfil the laws at the end: ``u = u_free + M^-1 J^T P``, ``q = q_old + h N(q_m) (u_m + (u - u_free)/2)``.
Gaps that are still negative then, since they are not linear, are closed by displacements, without speeds.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import NO_MODE_ROOM, OUT_OF_REACH, RUNNING, Run
from symbody.kernels.configurations.projection import project, project_new_state
from symbody.kernels.impulses.impulse_responses import (
    add_impulse,
    answer_to_point,
    forget_responses,
    row_change,
)
from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.impulses.impulse_sweeps import solve_impulses, work_of_impulses
from symbody.kernels.language import Function, Reals, is_finite, part
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import all_finite, call, copy, evaluate
from symbody.kernels.step_bounds import behind_jump, plan_trial
from symbody.kernels.step_machine import begin, begin_again, failure, keep_step, reached_limit

MOST_ROUNDS: Final = 8  # of points that join, and of displacements
COARSE: Final = 1e-2  # residual, as a share, that is enough to see which points join
MOST_PUSHES: Final = 400  # sweeps of one displacement
PUSHED: Final = 0.1  # of what counts as closed
ENTRY: Final = 4  # numbers of a point in the record


def measure_gaps(e: Function, run: Run, step: ImpulseStep, t: float, x: Reals) -> int:
    """Compute all gaps at a state; return 0 if they are no numbers."""
    if call(e, step.speeds, step.gap_numbers, t, x, step.widths) != 0:
        run.counts.failed_kernel = 1
        return 0
    return all_finite(step.gaps, step.widths)


def measure_responses(d: Function, run: Run, step: ImpulseStep, t: float, x: Reals) -> int:
    """Compute how points are moved at a state; return 0 if that fails."""
    if call(d, step.speeds, step.response_numbers, t, x, step.values) != 0:
        run.counts.failed_kernel = 1
        return 0
    forget_responses(step)
    return all_finite(step.values_size, step.values)


def choose_points(step: ImpulseStep, wanted: float) -> int:
    """Let points act whose gaps are below some closed ones, and all without gaps; return how many join."""
    joined = 0
    for k in range(step.points):
        if step.acts[k] == 0.0:
            if k >= step.gaps:
                joined = joined + join_point(step, k)
            elif step.widths[k] <= wanted * step.closed[k]:
                joined = joined + join_point(step, k)
    if joined > 0:
        list_points(step)
    return joined


def begin_points(step: ImpulseStep) -> None:
    """Begin a step in which no point acts yet; without a step before no impulses are known."""
    step.count = 0
    step.residual = 0.0
    for k in range(step.points):
        step.acts[k] = 0.0
    for k in range(step.gaps):
        step.widths_before[k] = step.widths[k]
    for row in range(step.rows):
        step.impulses[row] = 0.0
        if step.begins == 0.0:
            step.kept[row] = 0.0


def join_point(step: ImpulseStep, point: int) -> int:
    """Let a point act, with the impulses of the step before to begin with; return 1."""
    step.acts[point] = 1.0
    first = int(step.point_first[point])
    for row in range(first, first + int(step.point_rows[point])):
        step.impulses[row] = step.kept[row]
    return 1


def list_points(step: ImpulseStep) -> None:
    """Write down which points act, in their order."""
    count = 0
    for k in range(step.points):
        if step.acts[k] != 0.0:
            step.active[count] = float(k)
            count = count + 1
    step.count = count


def choose_resting_points(step: ImpulseStep) -> None:
    """Let points act that have pressed in the step before, if their gaps are no wider than one closes freely.

    Shapes that rest on others fall with these where nothing acts: their gaps do not close then.
    """
    fall = 0.0
    for k in range(step.gaps):
        if step.kept[int(step.point_first[k])] > 0.0:
            fall = max(fall, step.widths_before[k] - step.widths[k])
    for k in range(step.gaps):
        if step.acts[k] == 0.0 and step.kept[int(step.point_first[k])] > 0.0:
            if step.widths_before[k] <= fall and step.widths[k] <= step.widths_before[k] + step.closed[k]:
                join_point(step, k)
    list_points(step)


def move_coordinates(
    k: Function, e: Function, g: Function, run: Run, step: ImpulseStep, t: float, h: float
) -> int:  # fmt: skip
    """Set the new coordinates, with the rates in the middle of the step, and measure the gaps there.

    Returns 0 if they are no numbers.
    """
    n_u = step.speeds
    n = step.states
    stage = run.stage
    for i in range(n_u):
        stage[i] = run.state_old[i] + 0.5 * h * run.slopes[i] + 0.5 * (step.moving[i] - step.free[i])
        stage[i] = stage[i] + step.shifts[i] / h
    if call(k, n_u, step.rate_numbers, t, stage, step.turn) != 0:
        run.counts.failed_kernel = 1
        return 0
    n_q = step.coordinates
    for i in range(n_q):
        run.state_new[n_u + i] = run.state_old[n_u + i] + h * step.turn[i]
    if all_finite(n, run.state_new) == 0:
        return 0
    if exists(run.projection):
        if not is_finite(project(g, run, run.time + h, run.state_new)):
            return 0
    return measure_gaps(e, run, step, run.time + h, run.state_new)


def attempt_impulses(
    f: Function, k: Function, e: Function, d: Function, g: Function, run: Run, step: ImpulseStep, h: float
) -> int:  # fmt: skip
    """Try one step; return 0 if it fails."""
    n = step.states
    n_u = step.speeds
    old = run.state_old
    new = run.state_new
    stage = run.stage
    middle = run.time + 0.5 * h
    end = run.time + h
    run.counts.failed_kernel = 0
    for i in range(n):
        stage[i] = old[i] + 0.5 * h * run.slopes[i]
    evaluate(f, run, middle, stage, step.middle)
    if run.counts.failed_kernel != 0 or all_finite(n, step.middle) == 0:
        copy(n, step.middle, part(run.slopes, n, n))
        return 0
    for i in range(n):
        new[i] = old[i] + h * step.middle[i]
    for i in range(n_u):
        step.free[i] = new[i]
        step.moving[i] = new[i]
        step.shifts[i] = 0.0
    begin_points(step)
    if measure_gaps(e, run, step, end, new) == 0:
        return 0
    if choose_points(step, 0.0) > 0:
        choose_resting_points(step)
        if touch(k, e, d, g, run, step, h) == 0:
            return 0
    for i in range(n_u):
        new[i] = step.moving[i]
    return 1


def touch(
    k: Function, e: Function, d: Function, g: Function, run: Run, step: ImpulseStep, h: float
) -> int:  # fmt: skip
    """Find impulses, and displacements where gaps stay negative; return 0 if there are none."""
    middle = run.time + 0.5 * h
    n = step.states
    if measure_responses(d, run, step, middle, run.stage) == 0:
        return 0
    tolerance = max(step.tolerance, COARSE)
    unsolved = 1
    for turn in range(MOST_ROUNDS):
        if unsolved > 0:
            if turn == MOST_ROUNDS - 1:
                tolerance = step.tolerance
            if solve_impulses(step, h, run.state_old, tolerance) == 0:
                return 0
            if move_coordinates(k, e, g, run, step, middle, h) == 0:
                return 0
            unsolved = 0
            if turn + 1 < MOST_ROUNDS:
                unsolved = choose_points(step, -1.0)
            if unsolved == 0 and tolerance > step.tolerance:
                tolerance = step.tolerance
                if step.residual > tolerance * step.scale:
                    unsolved = 1
    run.state_new[n - 1] = run.state_new[n - 1] + work_of_impulses(step, step.before)
    return push_back(k, e, d, g, run, step, h)


def push_back(
    k: Function, e: Function, d: Function, g: Function, run: Run, step: ImpulseStep, h: float
) -> int:  # fmt: skip
    """Close gaps that are negative by displacements of least kinetic energy; return 0 if that fails.

    From the second one on directions are those behind the one before: shapes may touch elsewhere there.
    """
    for turn in range(MOST_ROUNDS):
        if overlap(step) > 1.0:
            if turn > 0:
                if measure_responses(d, run, step, run.time + h, run.state_new) == 0:
                    return 0
            if displace(step) == 0:
                return 0
            if move_coordinates(k, e, g, run, step, run.time + 0.5 * h, h) == 0:
                return 0
    return 1


def displace(step: ImpulseStep) -> int:
    """Find the displacements that open gaps; return 0 if speeds do not answer to impulses."""
    choose_points(step, -1.0)
    for i in range(step.speeds):
        step.nudge[i] = 0.0
    for i in range(step.count):
        if answer_to_point(step, int(step.active[i])) == 0:
            return 0
        step.pushes[int(step.active[i])] = 0.0
    for _sweep in range(MOST_PUSHES):
        if push_points(step) <= PUSHED:
            break
    for i in range(step.speeds):
        step.shifts[i] = step.shifts[i] + step.nudge[i]
    return 1


def overlap(step: ImpulseStep) -> float:
    """Return the largest overlap over what counts as closed."""
    worst = 0.0
    for i in range(step.gaps):
        worst = max(worst, -step.widths[i] / step.closed[i])
    return worst


def push_points(step: ImpulseStep) -> float:
    """Sweep once over displacements; return the largest change of a gap over what counts as closed.

    Gaps are kept with the displacements so far.
    """
    most = 0.0
    for i in range(step.count):
        point = int(step.active[i])
        if point < step.gaps:
            response = step.own[9 * point]
            if response > 0.0:
                width = step.widths[point] + row_change(step, int(step.point_first[point]), step.nudge)
                push = max(0.0, step.pushes[point] - width / response)
                change = push - step.pushes[point]
                if change != 0.0:
                    step.pushes[point] = push
                    add_impulse(step, point, 0, change, step.nudge)
                    most = max(most, abs(change) * response / step.closed[point])
    return most


def note_step(run: Run, step: ImpulseStep, h: float, S: Reals, Z: Reals) -> None:
    """Write down the efforts of all points in a step, and what is to be told of it."""
    place = step.steps
    entry = step.recorded
    S[2 * place] = run.time
    S[2 * place + 1] = float(entry)
    for k in range(step.points):
        first = int(step.point_first[k])
        rows = int(step.point_rows[k])
        pushes = 0.0
        for r in range(rows):
            value = 0.0
            if step.acts[k] != 0.0:
                value = step.impulses[first + r]
            step.kept[first + r] = value
            pushes = max(pushes, abs(value))
        if pushes > 0.0:
            Z[ENTRY * entry] = float(k)
            for r in range(rows):
                Z[ENTRY * entry + 1 + r] = step.kept[first + r] / h
            entry = entry + 1
    step.begins = 1.0
    step.steps = place + 1
    step.recorded = entry
    step.most = max(step.most, float(step.count))
    if step.residual > step.worst * step.scale:
        step.worst = step.residual / step.scale
        step.worst_time = run.time
    if step.residual > step.tolerance * step.scale:
        if step.missed == 0.0:
            step.missed_time = run.time
        step.missed = step.missed + 1.0
    deep = overlap(step)
    if deep > step.deepest:
        step.deepest = deep
        step.deepest_time = run.t_new


def finish_impulses(f: Function, g: Function, run: Run, step: ImpulseStep) -> int:
    """Close constraints at the end of a step and compute the slopes there; return 0 if that fails.

    For what lies between the ends speeds, and the work, change evenly: they jump nowhere.
    """
    n = step.states
    n_u = step.speeds
    h = run.length
    K = run.slopes
    if exists(run.projection):
        moved = project_new_state(g, run, run.t_new)
        if moved < 0.0 or not is_finite(moved):
            run.counts.failed_kernel = OUT_OF_REACH
            return 0
    evaluate(f, run, run.time + h, run.state_new, step.slopes_end)
    copy(n, step.slopes_end, part(K, n, n))
    if run.counts.failed_kernel != 0 or all_finite(n, step.slopes_end) == 0:
        return 0
    for i in range(n):
        if i < n_u or i == n - 1:
            slope = (run.state_new[i] - run.state_old[i]) / h
            K[i] = slope
            K[n + i] = slope
    return 1


def try_impulses(
    f: Function, k: Function, e: Function, d: Function, g: Function, run: Run, step: ImpulseStep,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, S: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Try one step; return why there is no other, or `RUNNING`."""
    if step.steps + 1 > step.step_room or step.recorded + step.points > step.entry_room:
        return NO_MODE_ROOM
    plan_trial(run, run.time, run.step)
    h = run.length
    if h == 0.0:
        return failure(run)
    if attempt_impulses(f, k, e, d, g, run, step, h) == 0:
        return failure(run)
    if finish_impulses(f, g, run, step) == 0:
        return failure(run)
    if keep_step(f, g, f, run, 0.0, times, t, x, breaks, pieces) > 0.0:
        return failure(run)
    note_step(run, step, h, S, Z)
    n = step.states
    copy(n, step.slopes_end, run.slopes)
    copy(n, run.state_new, run.state_old)
    run.counts.accepted = run.counts.accepted + 1
    run.time = run.t_new
    run.step = run.goal.direction * run.goal.max_step
    behind = behind_jump(run, run.time)
    if behind != run.time:
        run.time = behind
        evaluate(f, run, behind, run.state_old, run.slopes)
    return RUNNING


def advance_impulses(
    f: Function, k: Function, e: Function, d: Function, g: Function, run: Run, step: ImpulseStep,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, S: Reals, Z: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps; return one of the codes of `block`, `NO_MODE_ROOM` for more of S and Z."""
    for _trial in range(trials):
        code = reached_limit(run)
        if code == RUNNING:
            code = try_impulses(f, k, e, d, g, run, step, times, t, x, breaks, pieces, S, Z)
        if code != RUNNING:
            return code
    return RUNNING


def begin_impulses(f: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Begin as `step_machine.begin` does, behind steps that are stored."""
    if run.counts.steps == 0:
        return begin(f, run, times, t, x, breaks)
    return begin_again(f, run, times, t, x, breaks)
