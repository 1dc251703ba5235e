"""Motions side by side in steps of the caller's own length: what `stepping` computes, bit for bit.

The block is that of `lane_motions`, with the block of a motion of its own in each lane. `S` holds the numbers
of the caller, as `stepping` describes, a row of `size` for each lane. Between steps the blocks of the lanes
hold the state and its derivative; the case of a lane that is under way is 0, else -1.
"""

from __future__ import annotations

from symbody.kernels.block import (
    CASE,
    FINISHED,
    FUNCTION,
    LANE_CODE,
    R_PLACE,
    RUNNING,
    STATE_NEW,
    STATE_OLD,
    STEP,
    T_END,
    TIME,
    VECTOR_ROWS,
    VECTORS,
    N,
)
from symbody.kernels.lanes.lane_block import H_ROW, LANE_BLOCKS, LANE_R, LANE_SIZE, T_ROW, TRIAL
from symbody.kernels.lanes.lane_motions import conclude_all, gather, plan_lane, scatter, state_size
from symbody.kernels.lanes.lane_steps import attempt_lanes
from symbody.kernels.language import LANES, Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.stepping import INPUTS, NOW, PLANNED, STATE_AT, UNDER_WAY, conclude_step, set_off


def begin_lane(f: Function, L: Reals, lane: int, S: Reals) -> None:
    """Begin the step of a lane, or go on with one that is under way."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    n = int(B[N])
    B[CASE] = 0.0
    if S[UNDER_WAY] != 0.0:
        return
    B[LANE_CODE] = float(set_off(f, B, S))
    scatter(L, lane, STATE_OLD * n, n)
    scatter(L, lane, VECTOR_ROWS * n, n)
    for k in range(int(S[INPUTS])):
        L[int(L[FUNCTION]) + LANE_R + k * LANES + lane] = B[int(B[FUNCTION]) + R_PLACE + k]


def show_state(L: Reals, lane: int, S: Reals) -> None:
    """Give the caller the time and state that a lane has reached."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    S[NOW] = B[TIME]
    copy(int(B[N]), part(B, VECTORS + STATE_OLD * int(B[N]), int(B[N])), part(S, STATE_AT, int(B[N])))


def plan_step(L: Reals, lane: int, S: Reals) -> int:
    """Plan the next trial of a lane; return 1, or 0 if its step has ended."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    if B[CASE] < 0.0:
        return 0
    if B[TIME] != B[T_END]:
        S[PLANNED] = B[STEP]
    code = plan_lane(L, lane)
    if code == RUNNING:
        return 1
    n = int(B[N])
    gather(L, lane, STATE_OLD * n, n)
    gather(L, lane, STATE_NEW * n, n)
    gather(L, lane, VECTOR_ROWS * n, n)
    conclude_step(B, S, code)
    B[LANE_CODE] = float(code)
    B[CASE] = -1.0
    L[TRIAL + T_ROW * LANES + lane] = B[TIME]
    L[TRIAL + H_ROW * LANES + lane] = 0.0
    show_state(L, lane, S)
    return 0


def step_lanes(
    f: Function, wide: Function, g: Function, L: Reals, S: Reals, size: int, count: int, turns: int
) -> int:
    """Go on with the steps of the first `count` lanes; return `FINISHED` where all have ended."""
    nothing = part(S, 0, 1)
    for _turn in range(turns):
        running = 0
        for lane in range(count):
            running = running + plan_step(L, lane, part(S, lane * size, size))
        if running == 0:
            return FINISHED
        attempted = attempt_lanes(wide, L)
        conclude_all(f, wide, g, L, attempted, nothing, nothing, nothing)
    for lane in range(count):
        if L[int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]) + CASE] >= 0.0:
            gather(L, lane, 0, state_size(L))
            show_state(L, lane, part(S, lane * size, size))
    return RUNNING


def step_all(
    f: Function, wide: Function, g: Function, L: Reals, stride: int, S: Reals, size: int, count: int,
    begins: int, turns: int,
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
        own = part(L, place, stride)
        rows = part(S, first * size, size * LANES)
        some = min(LANES, count - first)
        if begins != 0:
            for lane in range(some):
                begin_lane(f, own, lane, part(rows, lane * size, size))
        if step_lanes(f, wide, g, own, rows, size, some, turns) == RUNNING:
            running = 1
        for lane in range(some):
            ended = int(own[int(own[LANE_BLOCKS]) + lane * int(own[LANE_SIZE]) + LANE_CODE])
            if ended != FINISHED:
                code = ended
        first = first + LANES
        place = place + stride
    if running != 0:
        return RUNNING
    return code
