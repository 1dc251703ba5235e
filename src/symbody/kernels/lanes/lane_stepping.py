"""Motions side by side in steps of the caller's own length: what `stepping` computes, bit for bit.

The block is that of `lane_motions`, with the block of a motion of its own in each lane. `S` holds the numbers
of the caller, as `stepping` describes, a row of `size` for each lane. Between steps the blocks of the lanes
hold the state and its derivative; the case of a lane that is under way is 0, else -1.
"""

from __future__ import annotations

from symbody.kernels.block import FINISHED, RUNNING, Run
from symbody.kernels.lanes.lane_block import LaneGroup
from symbody.kernels.lanes.lane_motions import conclude_all, gather, gather_all, plan_lane, scatter
from symbody.kernels.lanes.lane_steps import attempt_lanes
from symbody.kernels.language import LANES, Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.stepping import INPUTS, NOW, PLANNED, STATE_AT, UNDER_WAY, conclude_step, set_off


def begin_lane(f: Function, group: LaneGroup, lane: int, S: Reals) -> None:
    """Begin the step of a lane, or go on with one that is under way."""
    run = Run.view(group.runs, lane * group.run_size)
    n = run.states
    run.cases.current = 0
    if S[UNDER_WAY] != 0.0:
        return
    run.cases.lane_code = set_off(f, run, S)
    scatter(lane, n, run.state_old, group.state_old)
    scatter(lane, n, run.slopes, group.slopes)
    scatter(lane, int(S[INPUTS]), run.numbers.inputs, group.numbers.inputs)


def show_state(group: LaneGroup, lane: int, S: Reals) -> None:
    """Give the caller the time and state that a lane has reached."""
    run = Run.view(group.runs, lane * group.run_size)
    S[NOW] = run.time
    copy(run.states, run.state_old, part(S, STATE_AT, run.states))


def plan_step(group: LaneGroup, lane: int, S: Reals) -> int:
    """Plan the next trial of a lane; return 1, or 0 if its step has ended."""
    run = Run.view(group.runs, lane * group.run_size)
    if run.cases.current < 0:
        return 0
    if run.time != run.t_end:
        S[PLANNED] = run.step
    code = plan_lane(group, lane)
    if code == RUNNING:
        return 1
    n = run.states
    gather(lane, n, group.state_old, run.state_old)
    gather(lane, n, group.state_new, run.state_new)
    gather(lane, n, group.slopes, run.slopes)
    conclude_step(run, S, code)
    run.cases.lane_code = code
    run.cases.current = -1
    group.start[lane] = run.time
    group.length[lane] = 0.0
    show_state(group, lane, S)
    return 0


def step_lanes(
    f: Function, wide: Function, g: Function, e: Function, group: LaneGroup, S: Reals, size: int, count: int,
    turns: int,
) -> int:  # fmt: skip
    """Go on with the steps of the first `count` lanes; return `FINISHED` where all have ended."""
    nothing = part(S, 0, 1)
    for _turn in range(turns):
        running = 0
        for lane in range(count):
            running = running + plan_step(group, lane, part(S, lane * size, size))
        if running == 0:
            return FINISHED
        attempted = attempt_lanes(wide, group)
        conclude_all(f, wide, g, e, group, attempted, nothing, nothing, nothing)
    for lane in range(count):
        if Run.view(group.runs, lane * group.run_size).cases.current >= 0:
            gather_all(group, lane)
            show_state(group, lane, part(S, lane * size, size))
    return RUNNING


def step_all(
    f: Function, wide: Function, g: Function, e: Function, groups: Reals, stride: int, S: Reals, size: int,
    count: int, begins: int, turns: int,
) -> int:  # fmt: skip
    """Take a step in `count` lanes, whose common blocks lie one behind the other, `stride` numbers apart.

    Where a call `begins`, all lanes begin their steps; later ones go on. They return `RUNNING` until all have
    ended, each with the code of its lane; then `FINISHED` if all came to their ends, else a code that is not.
    """
    code = FINISHED
    running = 0
    first = 0
    place = 0
    while first < count:
        own = LaneGroup.view(groups, place)
        rows = part(S, first * size, size * LANES)
        some = min(LANES, count - first)
        if begins != 0:
            for lane in range(some):
                begin_lane(f, own, lane, part(rows, lane * size, size))
        if step_lanes(f, wide, g, e, own, rows, size, some, turns) == RUNNING:
            running = 1
        for lane in range(some):
            ended = Run.view(own.runs, lane * own.run_size).cases.lane_code
            if ended != FINISHED:
                code = ended
        first = first + LANES
        place = place + stride
    if running != 0:
        return RUNNING
    return code
