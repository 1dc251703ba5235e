"""One Runge-Kutta step in every lane: what `runge_kutta` does for one motion, operation by operation."""

from __future__ import annotations

from symbody.kernels.block import (
    C_PLACE,
    CASE,
    DENSE_ROWS,
    ENTRIES,
    ERROR_1,
    ERROR_2,
    ERROR_READS_END,
    FUNCTION,
    METHOD,
    METHOD_SIZE,
    N_U,
    NODES,
    NOTHING,
    P_PLACE,
    ROWS,
    RTOL,
    SPLIT,
    STAGE,
    STAGE_ROWS,
    STAGES,
    STATE_NEW,
    STATE_OLD,
    TABLES_PLACE,
    TOLERANCES,
    VECTOR_ROWS,
    WORK_PLACE,
    N,
)
from symbody.kernels.lanes.lane_block import (
    CALLS_ROW,
    ERROR_ROW,
    FIRST_ROW,
    H_ROW,
    LANE_BLOCKS,
    LANE_CLOCK,
    LANE_R,
    LANE_SIZE,
    LANE_VECTORS,
    MASK_ROW,
    ONE_ROW,
    SCRATCH,
    SECOND_ROW,
    T_ROW,
    TRIAL,
)
from symbody.kernels.language import INFINITY, LANES, Function, Lanes, Reals, part, put, spread, take, where
from symbody.kernels.runge_kutta import error_size
from symbody.kernels.tables import read_table


def combine_lanes(n: int, row: int, M: Reals, K: Reals, factor: Lanes, base: Reals, target: Reals) -> None:
    """Set `target` to `base` plus `factor` times a row of the method times K, four states at a time."""
    first = int(M[ROWS + row])
    stop = int(M[ROWS + row + 1])
    place = 0
    while place < n:
        i = max(min(place, n - 4), 0)
        j = min(i + 1, n - 1) * LANES
        k = min(i + 2, n - 1) * LANES
        m = min(i + 3, n - 1) * LANES
        i = i * LANES
        a = spread(0.0)
        b = spread(0.0)
        c = spread(0.0)
        d = spread(0.0)
        for entry in range(first, stop):
            at = int(M[ENTRIES + 2 * entry])
            weight = spread(M[ENTRIES + 2 * entry + 1])
            a = a + weight * take(K, at + i)
            b = b + weight * take(K, at + j)
            c = c + weight * take(K, at + k)
            d = d + weight * take(K, at + m)
        put(target, i, take(base, i) + factor * a)
        put(target, j, take(base, j) + factor * b)
        put(target, k, take(base, k) + factor * c)
        put(target, m, take(base, m) + factor * d)
        place = place + 4


def copy_lanes(n: int, source: Reals, target: Reals) -> None:
    """Copy n registers."""
    for i in range(n):
        put(target, i * LANES, take(source, i * LANES))


def take_marked(L: Reals, n: int, source: Reals, target: Reals) -> None:
    """Copy n registers in the lanes that are marked."""
    mask = take(L, TRIAL + MASK_ROW * LANES)
    for i in range(n):
        at = i * LANES
        put(target, at, where(mask > 0.0, take(source, at), take(target, at)))


def read_tables_in_lanes(numbers: Reals) -> None:
    """Set the inputs that are tables to their values at the time of each lane."""
    D = part(numbers, int(numbers[TABLES_PLACE]), 1)
    for k in range(int(D[0])):
        for lane in range(LANES):
            value = read_table(part(D, int(D[2 + 2 * k]), 1), numbers[LANE_CLOCK + lane])
            numbers[LANE_R + int(D[1 + 2 * k]) * LANES + lane] = value


def call_lanes(wide: Function, L: Reals, t: Lanes, x: Reals, out: Reals) -> int:
    """Write the derivatives at times and states x; return the status of the function."""
    numbers = part(L, int(L[FUNCTION]), LANE_R)
    clock = part(numbers, LANE_CLOCK, LANES)
    put(clock, 0, t)
    if numbers[TABLES_PLACE] != 0.0:
        read_tables_in_lanes(numbers)
    r = part(numbers, LANE_R, 0)
    p = part(numbers, int(numbers[P_PLACE]), int(numbers[C_PLACE]) - int(numbers[P_PLACE]))
    c = part(numbers, int(numbers[C_PLACE]), int(numbers[WORK_PLACE]) - int(numbers[C_PLACE]))
    work = part(numbers, int(numbers[WORK_PLACE]), 1)
    q = part(x, int(L[N_U]) * LANES, (int(L[N]) - int(L[N_U])) * LANES)
    return wide(clock, q, x, r, p, c, out, work)


def call_at(wide: Function, L: Reals, c: float, x: Reals, out: Reals) -> int:
    """Write the derivatives at the share c of each step; return the status of the function."""
    t = take(L, TRIAL + T_ROW * LANES) + spread(c) * take(L, TRIAL + H_ROW * LANES)
    return call_lanes(wide, L, t, x, out)


def write_errors(L: Reals) -> None:
    """Write the errors of all lanes to the trial, as `runge_kutta.error_norm` computes them."""
    n = int(L[N])
    size = n * LANES
    M = part(L, METHOD, METHOD_SIZE)
    row = int(M[STAGE_ROWS])
    V = part(L, LANE_VECTORS, VECTOR_ROWS * size)
    K = part(L, LANE_VECTORS + VECTOR_ROWS * size, row * size)
    ones = take(L, TRIAL + ONE_ROW * LANES)
    combine_lanes(n, row, M, K, ones, part(V, NOTHING * size, size), part(V, ERROR_1 * size, size))
    combine_lanes(n, row + 1, M, K, ones, part(V, NOTHING * size, size), part(V, ERROR_2 * size, size))
    rtol = spread(L[RTOL])
    first = spread(0.0)
    second = spread(0.0)
    for i in range(n):
        at = i * LANES
        old = abs(take(V, STATE_OLD * size + at))
        new = abs(take(V, STATE_NEW * size + at))
        larger = where(new > old, new, old)
        share = 1.0 / (take(V, TOLERANCES * size + at) + rtol * larger)
        a = take(V, ERROR_1 * size + at) * share
        b = take(V, ERROR_2 * size + at) * share
        first = first + a * a
        second = second + b * b
    T = part(L, TRIAL, LANE_VECTORS - TRIAL)
    put(T, FIRST_ROW * LANES, first)
    put(T, SECOND_ROW * LANES, second)
    for lane in range(LANES):
        h = T[H_ROW * LANES + lane]
        error = error_size(T[FIRST_ROW * LANES + lane], T[SECOND_ROW * LANES + lane], h, n)
        T[ERROR_ROW * LANES + lane] = error


def mark_infinities(L: Reals, n: int, x: Reals) -> None:
    """Set the row `FIRST_ROW` of the trial to 0 where n registers are finite, to NaN in the other lanes."""
    zero = spread(0.0)
    for i in range(n):
        zero = zero + 0.0 * take(x, i * LANES)
    put(L, TRIAL + FIRST_ROW * LANES, zero)


def write_faults(L: Reals) -> None:
    """Make the errors of lanes infinite where they, or tolerated ends, are not finite; count evaluations."""
    n = int(L[N])
    M = part(L, METHOD, METHOD_SIZE)
    end = int(M[STAGES])
    mark_infinities(L, n, part(L, LANE_VECTORS + (VECTOR_ROWS + end) * n * LANES, n * LANES))
    T = part(L, TRIAL, LANE_VECTORS - TRIAL)
    for lane in range(LANES):
        error = T[ERROR_ROW * LANES + lane]
        T[CALLS_ROW * LANES + lane] = float(end - 1)
        if M[ERROR_READS_END] != 0.0 or error <= 1.0:
            T[CALLS_ROW * LANES + lane] = float(end)
        if error != error or (error <= 1.0 and T[FIRST_ROW * LANES + lane] != 0.0):
            T[ERROR_ROW * LANES + lane] = INFINITY


def mark_small_errors(L: Reals) -> int:
    """Mark the lanes whose error is tolerated; return 1 if one of them computes a case, else 0."""
    T = part(L, TRIAL, LANE_VECTORS - TRIAL)
    some = 0
    for lane in range(LANES):
        T[MASK_ROW * LANES + lane] = 0.0
        if T[ERROR_ROW * LANES + lane] <= 1.0:
            T[MASK_ROW * LANES + lane] = 1.0
            if L[int(L[LANE_BLOCKS]) + lane * int(L[LANE_SIZE]) + CASE] >= 0.0:
                some = 1
    return some


def attempt_lanes(wide: Function, L: Reals) -> int:
    """Do what `runge_kutta.attempt` does in every lane; return the status of the function if it failed.

    What an attempt for one motion starts from is then as it was.
    """
    n = int(L[N])
    size = n * LANES
    n_u = int(L[N_U])
    M = part(L, METHOD, METHOD_SIZE)
    end = int(M[STAGES])
    V = part(L, LANE_VECTORS, VECTOR_ROWS * size)
    K = part(L, LANE_VECTORS + VECTOR_ROWS * size, (end + 1) * size)
    old = part(V, STATE_OLD * size, size)
    stage = part(V, STAGE * size, size)
    new = part(V, STATE_NEW * size, size)
    h = take(L, TRIAL + H_ROW * LANES)
    for k in range(1, end):
        combine_lanes(n, k, M, K, h, old, stage)
        if M[SPLIT] != 0.0:
            moved = (n - n_u) * LANES
            copy_lanes(n - n_u, part(old, n_u * LANES, moved), part(stage, n_u * LANES, moved))
        status = call_at(wide, L, M[NODES + k], stage, part(K, k * size, size))
        if status != 0:
            return status
    combine_lanes(n, end, M, K, h, old, new)
    if M[SPLIT] != 0.0:
        copy_lanes(n_u, stage, new)
    if M[ERROR_READS_END] != 0.0:
        status = call_at(wide, L, 1.0, new, part(K, end * size, size))
        if status != 0:
            return status
    write_errors(L)
    if mark_small_errors(L) != 0 and M[ERROR_READS_END] == 0.0:
        scratch = part(L, int(L[SCRATCH]), size)
        status = call_at(wide, L, 1.0, new, scratch)
        if status != 0:
            return status
        take_marked(L, n, scratch, part(K, end * size, size))
    write_faults(L)
    return 0


def form_dense_outputs(wide: Function, L: Reals) -> int:
    """Do what `dense_output.form_dense_output` does in the lanes that are marked; the others lose theirs.

    The row `FIRST_ROW` of the trial is 0 where all is finite. It returns the status of the function if it
    failed.
    """
    n = int(L[N])
    size = n * LANES
    M = part(L, METHOD, METHOD_SIZE)
    end = int(M[STAGES])
    stage_rows = int(M[STAGE_ROWS])
    V = part(L, LANE_VECTORS, VECTOR_ROWS * size)
    K = part(L, LANE_VECTORS + VECTOR_ROWS * size, stage_rows * size)
    rows = int(M[DENSE_ROWS])
    F = part(L, LANE_VECTORS + (VECTOR_ROWS + stage_rows) * size, rows * size)
    scratch = part(L, int(L[SCRATCH]), size)
    h = take(L, TRIAL + H_ROW * LANES)
    for k in range(end + 1, stage_rows):
        combine_lanes(n, k, M, K, h, part(V, STATE_OLD * size, size), scratch)
        take_marked(L, n, scratch, part(V, ERROR_1 * size, size))
        status = call_at(wide, L, M[NODES + k], scratch, part(K, k * size, size))
        if status != 0:
            return status
    for i in range(n):
        at = i * LANES
        old = take(V, STATE_OLD * size + at)
        move = take(V, STATE_NEW * size + at) - old
        first = take(K, at)
        put(F, at, old)
        put(F, size + at, move)
        put(F, 2 * size + at, h * first - move)
        put(F, 3 * size + at, 2.0 * move - h * (first + take(K, end * size + at)))
    zeros = part(V, NOTHING * size, size)
    for row in range(4, rows):
        combine_lanes(n, stage_rows + row - 2, M, K, h, zeros, part(F, row * size, size))
    mark_infinities(L, (rows - 4) * n, part(F, 4 * size, (rows - 4) * size))
    return 0
