"""Many motions of one mechanism, one in each lane: what `many_motions` computes, bit for bit.

Each lane has its own step and error, and goes on with the next case when one has ended. Stages, errors and
dense outputs are computed for all lanes at once, what is left in the block of each lane by the functions for
one motion, which also try its step where the function fails.
"""

from __future__ import annotations

from symbody.kernels.block import (
    CASE,
    CASES_ENDED,
    CODE,
    DENSE_ROWS,
    EVALUATIONS,
    FINISHED,
    FUNCTION,
    KERNEL,
    LANE_CODE,
    LENGTH,
    METHOD,
    NOT_ENDED,
    P_PLACE,
    PROJECTOR,
    RUNNING,
    STAGE_ROWS,
    STAGES,
    STATE_NEW,
    STATE_OLD,
    STEP,
    STIFF,
    STIFF_VOTES,
    STOP_WHEN_STIFF,
    T_END,
    T_NEW,
    TIME,
    TIMES,
    UNJUDGED,
    VECTOR_ROWS,
    VECTORS,
    VERDICT_SIZE,
    WORK_PLACE,
    N,
)
from symbody.kernels.configurations.projection import project_new_state
from symbody.kernels.lanes.lane_block import (
    CALLS_ROW,
    ERROR_ROW,
    FIRST_ROW,
    H_ROW,
    LANE_BLOCKS,
    LANE_SIZE,
    LANE_VECTORS,
    MASK_ROW,
    SCRATCH,
    T_ROW,
    TRIAL,
)
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
from symbody.kernels.runge_kutta import accept, count_stiff_votes, reject
from symbody.kernels.step_bounds import behind_jump, plan_trial
from symbody.kernels.step_machine import (
    begin,
    failure,
    is_sampled,
    pass_jump,
    reached_limit,
    store_samples,
    try_step,
)


def gather(L: Reals, lane: int, first: int, size: int) -> None:
    """Fill entries of the block of a lane, from place `first` of the vectors on, from the registers."""
    B = int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]) + VECTORS
    for i in range(first, first + size):
        L[B + i] = L[LANE_VECTORS + i * LANES + lane]


def scatter(L: Reals, lane: int, first: int, size: int) -> None:
    """Fill the registers of a lane from its block, from place `first` of the vectors on."""
    B = int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]) + VECTORS
    for i in range(first, first + size):
        L[LANE_VECTORS + i * LANES + lane] = L[B + i]


def state_size(L: Reals) -> int:
    """Return how many numbers vectors and derivatives are."""
    return (VECTOR_ROWS + int(L[METHOD + STAGE_ROWS])) * int(L[N])


def refill(
    f: Function, L: Reals, lane: int, count: int, size: int, cases: Reals, times: Reals, t: Reals, x: Reals,
    verdicts: Reals,
) -> None:  # fmt: skip
    """Begin the next case that has no verdict in a lane."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    k = int(L[CASE])
    while k < count:
        if verdicts[k * VERDICT_SIZE + CODE] == NOT_ENDED:
            break
        k = k + 1
    L[TRIAL + H_ROW * LANES + lane] = 0.0
    L[CASE] = float(min(k + 1, count))
    if k == count:
        B[CASE] = -1.0
        return
    n = int(B[N])
    samples = int(B[TIMES]) * n
    prepare(B, part(cases, k * size, size))
    B[CASE] = float(k)
    B[LANE_CODE] = float(begin(f, B, times, t, part(x, k * samples, samples), t))
    scatter(L, lane, 0, state_size(L))
    narrow = part(B, int(B[FUNCTION]), WORK_PLACE + 1)
    wide = part(L, int(L[FUNCTION]), WORK_PLACE + 1)
    first = int(narrow[P_PLACE])
    for i in range(int(narrow[WORK_PLACE]) - first):
        L[int(L[FUNCTION]) + int(wide[P_PLACE]) + i * LANES + lane] = B[int(B[FUNCTION]) + first + i]


def plan_lane(L: Reals, lane: int) -> int:
    """Set the next trial of a lane; return why there is none, as `step_machine.advance` does."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    code = int(B[LANE_CODE])
    if code == RUNNING:
        code = reached_limit(B)
    if code != RUNNING:
        return code
    plan_trial(B, B[TIME], B[STEP])
    L[TRIAL + T_ROW * LANES + lane] = B[TIME]
    L[TRIAL + H_ROW * LANES + lane] = B[LENGTH]
    if B[LENGTH] != 0.0:
        return RUNNING
    gather(L, lane, 0, state_size(L))
    return failure(B)


def fill_lane(
    f: Function, L: Reals, lane: int, count: int, size: int, cases: Reals, times: Reals, t: Reals, x: Reals,
    verdicts: Reals,
) -> int:  # fmt: skip
    """Plan the next trial of a lane, of another case where one has ended; return 1, or 0 if none is left."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    while B[CASE] >= 0.0 or L[CASE] < count:
        if B[CASE] >= 0.0:
            code = plan_lane(L, lane)
            if code == RUNNING:
                return 1
            conclude(B, code, part(verdicts, int(B[CASE]) * VERDICT_SIZE, VERDICT_SIZE))
            L[CASES_ENDED] = L[CASES_ENDED] + 1.0
        refill(f, L, lane, count, size, cases, times, t, x, verdicts)
    L[TRIAL + H_ROW * LANES + lane] = 0.0
    return 0


def project_lanes(wide: Function, g: Function, L: Reals) -> int:
    """Do what `step_machine.close` does in every lane whose error is tolerated.

    Returns the status of the function if it failed. The errors of lanes that had to move too far become
    infinite.
    """
    n = int(L[N])
    some = 0
    for lane in range(LANES):
        B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
        L[TRIAL + MASK_ROW * LANES + lane] = 0.0
        if B[CASE] >= 0.0 and L[TRIAL + ERROR_ROW * LANES + lane] <= 1.0:
            gather(L, lane, STATE_OLD * n, n)
            gather(L, lane, STATE_NEW * n, n)
            moved = project_new_state(g, B, B[T_NEW])
            scatter(L, lane, STATE_NEW * n, n)
            if moved < 0.0:
                L[TRIAL + ERROR_ROW * LANES + lane] = INFINITY
            elif moved > 0.0:
                L[TRIAL + MASK_ROW * LANES + lane] = 1.0
                L[TRIAL + CALLS_ROW * LANES + lane] = L[TRIAL + CALLS_ROW * LANES + lane] + 1.0
                some = 1
    if some == 0:
        return 0
    return renew_derivatives(wide, L)


def renew_derivatives(wide: Function, L: Reals) -> int:
    """Renew the derivatives at the ends of the steps that are marked; return the status of the function.

    Other lanes compute the beginnings of theirs, where the function is known not to fail.
    """
    n = int(L[N])
    size = n * LANES
    V = part(L, LANE_VECTORS, VECTOR_ROWS * size)
    x = part(L, int(L[SCRATCH]), size)
    slopes = part(L, int(L[SCRATCH]) + size, size)
    end = part(L, LANE_VECTORS + (VECTOR_ROWS + int(L[METHOD + STAGES])) * size, size)
    copy_lanes(n, part(V, STATE_OLD * size, size), x)
    take_marked(L, n, part(V, STATE_NEW * size, size), x)
    marks = take(L, TRIAL + MASK_ROW * LANES)
    start = take(L, TRIAL + T_ROW * LANES)
    # a step that ends at a jump keeps the derivative before it
    t = where(marks > 0.0, start + take(L, TRIAL + H_ROW * LANES), start)
    status = call_lanes(wide, L, t, x, slopes)
    if status != 0:
        return status
    take_marked(L, n, slopes, end)
    mark_infinities(L, n, end)
    for lane in range(LANES):
        if L[TRIAL + MASK_ROW * LANES + lane] != 0.0 and L[TRIAL + FIRST_ROW * LANES + lane] != 0.0:
            L[TRIAL + ERROR_ROW * LANES + lane] = INFINITY
    return 0


def mark_samples(L: Reals, times: Reals) -> int:
    """Mark the lanes whose steps have samples inside; return 1 if there are any, else 0."""
    some = 0
    for lane in range(LANES):
        B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
        L[TRIAL + MASK_ROW * LANES + lane] = 0.0
        if B[CASE] >= 0.0 and L[TRIAL + ERROR_ROW * LANES + lane] <= 1.0:
            if is_sampled(B, times) == 1:
                L[TRIAL + MASK_ROW * LANES + lane] = 1.0
                some = 1
    return some


def judge(L: Reals, lane: int) -> int:
    """Return 1 if the case of a lane is stiff and ends for that, as in `step_machine.try_step`, else 0."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    if B[STIFF_VOTES] != 0.0 or B[UNJUDGED] == 999.0:
        gather(L, lane, 0, state_size(L))
    stiff = count_stiff_votes(B, B[LENGTH])
    if stiff != 0 and B[STOP_WHEN_STIFF] != 0.0 and B[T_NEW] != B[T_END]:
        return 1
    return 0


def conclude_lane(g: Function, L: Reals, lane: int, times: Reals, t: Reals, x: Reals) -> None:
    """Accept or reject the step of a lane, and mark the lane if it is accepted."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    error = L[TRIAL + ERROR_ROW * LANES + lane]
    n = int(B[N])
    B[KERNEL] = 0.0
    B[EVALUATIONS] = B[EVALUATIONS] + L[TRIAL + CALLS_ROW * LANES + lane]
    if L[TRIAL + MASK_ROW * LANES + lane] != 0.0:
        B[EVALUATIONS] = B[EVALUATIONS] + (B[METHOD + STAGE_ROWS] - B[METHOD + STAGES] - 1.0)
        if L[TRIAL + FIRST_ROW * LANES + lane] != 0.0:
            error = INFINITY
    L[TRIAL + MASK_ROW * LANES + lane] = 0.0
    if not error <= 1.0:
        reject(B, B[LENGTH], error)
        return
    if is_sampled(B, times) != 0:
        rows = int(B[METHOD + DENSE_ROWS]) * n
        gather(L, lane, state_size(L), rows)
        gather(L, lane, STATE_NEW * n, n)
        samples = int(B[TIMES]) * n
        store_samples(
            g, B, part(B, VECTORS + state_size(L), rows), times, t, part(x, int(B[CASE]) * samples, samples)
        )
    if judge(L, lane) != 0:
        B[LANE_CODE] = float(STIFF)
    accept(B, B[T_NEW], B[LENGTH], error)
    L[TRIAL + MASK_ROW * LANES + lane] = 1.0


def try_alone(f: Function, g: Function, L: Reals, lane: int, times: Reals, t: Reals, x: Reals) -> None:
    """Try the step of a lane as that of one motion, from what it started from."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    samples = int(B[TIMES]) * int(B[N])
    gather(L, lane, 0, state_size(L))
    own = part(x, int(B[CASE]) * samples, samples)
    B[LANE_CODE] = float(try_step(f, g, B, times, t, own, t, t))
    scatter(L, lane, 0, state_size(L))


def conclude_all(
    f: Function, wide: Function, g: Function, L: Reals, attempted: int, times: Reals, t: Reals, x: Reals
) -> None:
    """Accept or reject the steps that `attempt_lanes` tried; with a status other than 0 it failed."""
    status = attempted
    if status == 0 and L[PROJECTOR] != 0.0:
        status = project_lanes(wide, g, L)
    dense_status = 0
    if status == 0:
        if mark_samples(L, times) != 0:
            dense_status = form_dense_outputs(wide, L)
    n = int(L[N])
    for lane in range(LANES):
        B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
        if B[CASE] < 0.0:
            L[TRIAL + MASK_ROW * LANES + lane] = 0.0
        elif status == 0 and (dense_status == 0 or L[TRIAL + MASK_ROW * LANES + lane] == 0.0):
            conclude_lane(g, L, lane, times, t, x)
        else:
            L[TRIAL + MASK_ROW * LANES + lane] = 0.0
            try_alone(f, g, L, lane, times, t, x)
    size = n * LANES
    V = part(L, LANE_VECTORS, VECTOR_ROWS * size)
    K = part(L, LANE_VECTORS + VECTOR_ROWS * size, int(L[METHOD + STAGE_ROWS]) * size)
    take_marked(L, n, part(V, STATE_NEW * size, size), part(V, STATE_OLD * size, size))
    take_marked(L, n, part(K, int(L[METHOD + STAGES]) * size, size), part(K, 0, size))
    for lane in range(LANES):
        if L[TRIAL + MASK_ROW * LANES + lane] != 0.0:
            pass_jump_in_lane(f, L, lane)


def pass_jump_in_lane(f: Function, L: Reals, lane: int) -> None:
    """Go on behind a jump in a lane, as `step_machine.pass_jump` does."""
    B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
    if behind_jump(B, B[TIME]) != B[TIME]:
        n = int(B[N])
        gather(L, lane, STATE_OLD * n, n)
        pass_jump(f, B)
        scatter(L, lane, VECTOR_ROWS * n, n)


def run_lanes(
    f: Function, wide: Function, g: Function, L: Reals, count: int, size: int, cases: Reals, times: Reals,
    t: Reals, x: Reals, verdicts: Reals, turns: int,
) -> int:  # fmt: skip
    """Try so many steps in all lanes, as `many_motions.run_cases`; return `RUNNING` or `FINISHED`."""
    for _turn in range(turns):
        running = 0
        for lane in range(LANES):
            running = running + fill_lane(f, L, lane, count, size, cases, times, t, x, verdicts)
        if running == 0:
            return FINISHED
        attempted = attempt_lanes(wide, L)
        conclude_all(f, wide, g, L, attempted, times, t, x)
    for lane in range(LANES):
        B = part(L, int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]), int(L[LANE_SIZE]))
        if B[CASE] >= 0.0:
            conclude(B, RUNNING, part(verdicts, int(B[CASE]) * VERDICT_SIZE, VERDICT_SIZE))
    return RUNNING
