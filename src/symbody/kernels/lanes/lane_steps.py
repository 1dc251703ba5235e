"""One Runge-Kutta step in every lane: what `runge_kutta` does for one motion, operation by operation."""

from __future__ import annotations

from symbody.kernels.block import Method, Run
from symbody.kernels.lanes.lane_block import LaneGroup, LaneNumbers
from symbody.kernels.language import INFINITY, LANES, Function, Lanes, Reals, part, put, spread, take, where
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import error_size
from symbody.kernels.tables import read_table


def combine_lanes(
    n: int, row: int, method: Method, K: Reals, factor: Lanes, base: Reals, target: Reals
) -> None:
    """Set `target` to `base` plus `factor` times a row of the method times K, four states at a time."""
    rows = method.rows
    weights = method.weights
    first = int(rows[row])
    stop = int(rows[row + 1])
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
            at = int(weights[2 * entry])
            weight = spread(weights[2 * entry + 1])
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


def take_marked(group: LaneGroup, n: int, source: Reals, target: Reals) -> None:
    """Copy n registers in the lanes that are marked."""
    mask = take(group.mask, 0)
    for i in range(n):
        at = i * LANES
        put(target, at, where(mask > 0.0, take(source, at), take(target, at)))


def read_tables_in_lanes(numbers: LaneNumbers) -> None:
    """Set the inputs that are tables to their values at the time of each lane."""
    D = numbers.tables
    for k in range(int(D[0])):
        for lane in range(LANES):
            value = read_table(part(D, int(D[2 + 2 * k]), 1), numbers.times[lane])
            numbers.inputs[int(D[1 + 2 * k]) * LANES + lane] = value


def call_lanes(wide: Function, group: LaneGroup, t: Lanes, x: Reals, out: Reals) -> int:
    """Write the derivatives at times and states x; return the status of the function."""
    numbers = group.numbers
    put(numbers.times, 0, t)
    if exists(numbers.tables):
        read_tables_in_lanes(numbers)
    q = part(x, group.speeds * LANES, (group.states - group.speeds) * LANES)
    r = numbers.inputs
    return wide(numbers.times, q, x, r, numbers.parameters, numbers.constants, out, numbers.work)


def call_at(wide: Function, group: LaneGroup, c: float, x: Reals, out: Reals) -> int:
    """Write the derivatives at the share c of each step; return the status of the function."""
    t = take(group.start, 0) + spread(c) * take(group.length, 0)
    return call_lanes(wide, group, t, x, out)


def write_errors(group: LaneGroup) -> None:
    """Write the errors of all lanes to the trial, as `runge_kutta.error_norm` computes them."""
    n = group.states
    method = group.method
    row = method.stage_rows
    K = group.slopes
    state_old = group.state_old
    state_new = group.state_new
    error_1 = group.error_1
    error_2 = group.error_2
    tolerances = group.tolerances
    ones = take(group.ones, 0)
    combine_lanes(n, row, method, K, ones, group.zero_state, error_1)
    combine_lanes(n, row + 1, method, K, ones, group.zero_state, error_2)
    rtol = spread(group.rtol)
    first = spread(0.0)
    second = spread(0.0)
    for i in range(n):
        at = i * LANES
        old = abs(take(state_old, at))
        new = abs(take(state_new, at))
        larger = where(new > old, new, old)
        share = 1.0 / (take(tolerances, at) + rtol * larger)
        a = take(error_1, at) * share
        b = take(error_2, at) * share
        first = first + a * a
        second = second + b * b
    put(group.first, 0, first)
    put(group.second, 0, second)
    for lane in range(LANES):
        h = group.length[lane]
        error = error_size(group.first[lane], group.second[lane], h, n)
        group.error[lane] = error


def mark_infinities(group: LaneGroup, n: int, x: Reals) -> None:
    """Set `first` to 0 where n registers are finite, to NaN in the other lanes."""
    zero = spread(0.0)
    for i in range(n):
        zero = zero + 0.0 * take(x, i * LANES)
    put(group.first, 0, zero)


def write_faults(group: LaneGroup) -> None:
    """Make the errors of lanes infinite where they, or tolerated ends, are not finite; count evaluations."""
    n = group.states
    method = group.method
    end = method.stages
    mark_infinities(group, n, part(group.slopes, end * n * LANES, n * LANES))
    for lane in range(LANES):
        error = group.error[lane]
        group.calls[lane] = float(end - 1)
        if method.error_reads_end != 0.0 or error <= 1.0:
            group.calls[lane] = float(end)
        if error != error or (error <= 1.0 and group.first[lane] != 0.0):
            group.error[lane] = INFINITY


def mark_small_errors(group: LaneGroup) -> int:
    """Mark the lanes whose error is tolerated; return 1 if one of them computes a case, else 0."""
    some = 0
    for lane in range(LANES):
        group.mask[lane] = 0.0
        if group.error[lane] <= 1.0:
            group.mask[lane] = 1.0
            if Run.view(group.runs, lane * group.run_size).cases.current >= 0:
                some = 1
    return some


def attempt_lanes(wide: Function, group: LaneGroup) -> int:
    """Do what `runge_kutta.attempt` does in every lane; return the status of the function if it failed.

    What an attempt for one motion starts from is then as it was.
    """
    n = group.states
    size = n * LANES
    n_u = group.speeds
    method = group.method
    end = method.stages
    K = group.slopes
    old = group.state_old
    stage = group.stage
    new = group.state_new
    nodes = method.nodes
    h = take(group.length, 0)
    for k in range(1, end):
        combine_lanes(n, k, method, K, h, old, stage)
        if method.split != 0.0:
            moved = (n - n_u) * LANES
            copy_lanes(n - n_u, part(old, n_u * LANES, moved), part(stage, n_u * LANES, moved))
        status = call_at(wide, group, nodes[k], stage, part(K, k * size, size))
        if status != 0:
            return status
    combine_lanes(n, end, method, K, h, old, new)
    if method.split != 0.0:
        copy_lanes(n_u, stage, new)
    if method.error_reads_end != 0.0:
        status = call_at(wide, group, 1.0, new, part(K, end * size, size))
        if status != 0:
            return status
    write_errors(group)
    if mark_small_errors(group) != 0 and method.error_reads_end == 0.0:
        scratch = group.scratch
        status = call_at(wide, group, 1.0, new, scratch)
        if status != 0:
            return status
        take_marked(group, n, scratch, part(K, end * size, size))
    write_faults(group)
    return 0


def form_dense_outputs(wide: Function, group: LaneGroup) -> int:
    """Do what `dense_output.form_dense_output` does in the lanes that are marked; the others lose theirs.

    `first` is 0 where all is finite. It returns the status of the function if it
    failed.
    """
    n = group.states
    size = n * LANES
    method = group.method
    end = method.stages
    stage_rows = method.stage_rows
    K = group.slopes
    rows = method.dense_rows
    F = group.dense
    scratch = group.scratch
    h = take(group.length, 0)
    for k in range(end + 1, stage_rows):
        combine_lanes(n, k, method, K, h, group.state_old, scratch)
        take_marked(group, n, scratch, group.error_1)
        status = call_at(wide, group, method.nodes[k], scratch, part(K, k * size, size))
        if status != 0:
            return status
    state_old = group.state_old
    state_new = group.state_new
    for i in range(n):
        at = i * LANES
        old = take(state_old, at)
        move = take(state_new, at) - old
        first = take(K, at)
        put(F, at, old)
        put(F, size + at, move)
        put(F, 2 * size + at, h * first - move)
        put(F, 3 * size + at, 2.0 * move - h * (first + take(K, end * size + at)))
    zeros = group.zero_state
    for row in range(4, rows):
        combine_lanes(n, stage_rows + row - 2, method, K, h, zeros, part(F, row * size, size))
    mark_infinities(group, (rows - 4) * n, part(F, 4 * size, (rows - 4) * size))
    return 0
