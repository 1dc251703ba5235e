"""Where sweeps lead: the extrapolation of Anderson, cut where an impulse along a normal comes to zero.

Points that bear a load together let impulses wander along what they can share, by the same small amount in
each sweep, until one of them opens. The extrapolation takes all of that way at once [Anderson, Iterative
procedures for nonlinear integral equations, J. ACM 12, 1965].
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.impulses.impulse_responses import add_impulse
from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.language import half, part, sqrt

MEMORY: Final = 5
SLIGHT: Final = 1e-12  # added to the diagonal of the normal equations, as a share of their trace
NOTHING: Final = 1e-13  # share of the largest impulse that is rounding
PERIOD: Final = 64  # turns: what is hard for extrapolations may be easy without, and the other way round
WORSE: Final = 4.0  # times as large residuals let what is known be forgotten


def move_by_impulses(step: ImpulseStep) -> None:
    """Set the speeds to those with all impulses."""
    for i in range(step.speeds):
        step.moving[i] = step.free[i]
    for k in range(step.count):
        point = int(step.active[k])
        row = int(step.point_first[point])
        for r in range(int(step.point_rows[point])):
            add_impulse(step, point, r, step.impulses[row + r], step.moving)


def keep_best(step: ImpulseStep) -> None:
    """Note the impulses before sweeps if they miss their laws by less than all so far."""
    if step.residual < step.best:
        step.best = step.residual
        for i in range(step.acting):
            step.best_impulses[i] = step.impulses[int(step.acting_rows[i])]


def take_best(step: ImpulseStep) -> None:
    """Go back to the impulses that missed their laws by least."""
    step.residual = step.best
    for i in range(step.acting):
        step.impulses[int(step.acting_rows[i])] = step.best_impulses[i]
    move_by_impulses(step)


def forget_sweeps(step: ImpulseStep) -> None:
    """Begin to look where sweeps lead."""
    step.known = 0
    step.slot = 0
    step.has_last = 0.0
    step.residual_before = 0.0


def keep_start(step: ImpulseStep) -> None:
    """Note the impulses before sweeps."""
    for i in range(step.acting):
        step.start[i] = step.impulses[int(step.acting_rows[i])]


def accelerate(step: ImpulseStep) -> None:
    """Extrapolate the impulses from what sweeps have changed."""
    n = step.acting
    if step.residual > WORSE * step.residual_before and step.residual_before > 0.0:
        forget_sweeps(step)
    step.residual_before = step.residual
    differences = part(step.history, 2 * n * step.slot, 2 * n)
    for i in range(n):
        change = step.impulses[int(step.acting_rows[i])] - step.start[i]
        if step.has_last != 0.0:
            differences[i] = change - step.last_change[i]
            differences[n + i] = step.start[i] - step.last_start[i] + differences[i]
        step.last_change[i] = change
        step.last_start[i] = step.start[i]
    if step.has_last == 0.0:
        step.has_last = 1.0
        return
    step.slot = step.slot + 1
    if step.slot == MEMORY:
        step.slot = 0
    step.known = min(step.known + 1, MEMORY)
    count = step.known
    step.turn_count = step.turn_count + 1
    half_period = half(step.turn_count)
    if 2 * half_period != step.turn_count or step.turn_count > PERIOD:
        if step.turn_count == 2 * PERIOD:
            step.turn_count = 0
            forget_sweeps(step)
        return
    if solve_weights(step, count) == 0:
        forget_sweeps(step)
        return
    for i in range(n):
        total = 0.0
        for j in range(count):
            total = total - step.weights[j] * step.history[2 * n * j + n + i]
        step.way[int(step.acting_rows[i])] = total
    if take_way(step) == 1:
        forget_sweeps(step)


def solve_weights(step: ImpulseStep, count: int) -> int:
    """Find the combination of differences that lies nearest to the last change; return 0 if there is none."""
    n = step.acting
    A = step.normal_matrix
    y = step.weights
    trace = 0.0
    for i in range(count):
        first = part(step.history, 2 * n * i, n)
        for j in range(i + 1):
            second = part(step.history, 2 * n * j, n)
            total = 0.0
            for k in range(n):
                total = total + first[k] * second[k]
            A[MEMORY * i + j] = total
        total = 0.0
        for k in range(n):
            total = total + first[k] * step.last_change[k]
        y[i] = total
        trace = trace + A[MEMORY * i + i]
    for i in range(count):
        A[MEMORY * i + i] = A[MEMORY * i + i] + SLIGHT * trace
    for i in range(count):
        for j in range(i + 1):
            total = A[MEMORY * i + j]
            for k in range(j):
                total = total - A[MEMORY * i + k] * A[MEMORY * j + k]
            if i == j:
                if not total > 0.0:
                    return 0
                A[MEMORY * i + i] = sqrt(total)
            else:
                A[MEMORY * i + j] = total / A[MEMORY * j + j]
    for i in range(count):
        total = y[i]
        for k in range(i):
            total = total - A[MEMORY * i + k] * y[k]
        y[i] = total / A[MEMORY * i + i]
    for i in range(count - 1, -1, -1):
        total = y[i]
        for k in range(i + 1, count):
            total = total - A[MEMORY * k + i] * y[k]
        y[i] = total / A[MEMORY * i + i]
    return 1


def return_to_cone(step: ImpulseStep, point: int) -> None:
    """Shorten an impulse across the normal that is beyond what friction can do."""
    row = int(step.point_first[point])
    bound = step.values[int(step.point_values[point]) + 2] * step.impulses[row]
    total = 0.0
    for r in range(1, int(step.point_rows[point])):
        total = total + step.impulses[row + r] * step.impulses[row + r]
    if total > bound * bound:
        share = bound / sqrt(total)
        for r in range(1, int(step.point_rows[point])):
            step.impulses[row + r] = step.impulses[row + r] * share


def take_way(step: ImpulseStep) -> int:
    """Go as far as no impulse along a normal becomes negative; return 1 if one comes to zero, else 0."""
    share = 1.0
    largest = 0.0
    for k in range(step.count):
        point = int(step.active[k])
        row = int(step.point_first[point])
        if point < step.gaps:
            largest = max(largest, step.impulses[row])
            if not step.impulses[row] > 0.0:
                for r in range(int(step.point_rows[point])):
                    step.way[row + r] = 0.0
            elif step.impulses[row] + step.way[row] < 0.0:
                share = min(share, -step.impulses[row] / step.way[row])
    for k in range(step.count):
        point = int(step.active[k])
        row = int(step.point_first[point])
        rows = int(step.point_rows[point])
        for r in range(rows):
            step.impulses[row + r] = step.impulses[row + r] + share * step.way[row + r]
        if point < step.gaps:
            if step.impulses[row] <= NOTHING * largest:
                for r in range(rows):
                    step.impulses[row + r] = 0.0
            return_to_cone(step, point)
    move_by_impulses(step)
    if share < 1.0:
        return 1
    return 0
