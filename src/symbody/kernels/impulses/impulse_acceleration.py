"""Where sweeps lead: the extrapolation of Anderson, cut where an impulse along a normal comes to zero.

Points that bear a load together let impulses wander along what they can share, by the same small amount in
each sweep, until one of them opens. The extrapolation takes all of that way at once [Anderson, Iterative
procedures for nonlinear integral equations, J. ACM 12, 1965].
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.impulses.impulse_responses import add_impulse
from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.language import Reals, half, part, sqrt
from symbody.kernels.linear.cholesky import factor_positive, solve_lower

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
    """Extrapolate the impulses from what sweeps have changed, every other turn."""
    if step.residual > WORSE * step.residual_before and step.residual_before > 0.0:
        forget_sweeps(step)
    step.residual_before = step.residual
    if note_changes(step) == 0:
        return
    step.turn_count = step.turn_count + 1
    if step.turn_count == 2 * PERIOD:
        step.turn_count = 0
        forget_sweeps(step)
    elif step.turn_count <= PERIOD and 2 * half(step.turn_count) == step.turn_count:
        extrapolate(step)


def note_changes(step: ImpulseStep) -> int:
    """Note what sweeps have changed; return 0 if there is nothing to compare it with, else 1."""
    n = step.acting
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
        return 0
    step.known = min(step.known + 1, MEMORY)
    step.slot = step.slot + 1
    if step.slot == MEMORY:
        step.slot = 0
    return 1


def extrapolate(step: ImpulseStep) -> None:
    """Go to where the last change, combined with the differences that are known, would be least."""
    n = step.acting
    count = step.known
    fill_equations(step, count)
    if factor_positive(count, step.normal_matrix) == 0:
        forget_sweeps(step)
        return
    solve_lower(count, count, step.normal_matrix, step.weights)
    for i in range(n):
        total = 0.0
        for j in range(count):
            total = total - step.weights[j] * step.history[2 * n * j + n + i]
        step.way[int(step.acting_rows[i])] = total
    share = share_of_way(step)
    take_way(step, share)
    if share < 1.0:
        forget_sweeps(step)


def fill_equations(step: ImpulseStep, count: int) -> None:
    """Write the normal equations of the combination of differences that lies nearest to the last change."""
    n = step.acting
    trace = 0.0
    for i in range(count):
        first = part(step.history, 2 * n * i, n)
        for j in range(i + 1):
            step.normal_matrix[count * i + j] = inner(n, first, part(step.history, 2 * n * j, n))
        step.weights[i] = inner(n, first, step.last_change)
        trace = trace + step.normal_matrix[count * i + i]
    for i in range(count):
        step.normal_matrix[count * i + i] = step.normal_matrix[count * i + i] + SLIGHT * trace


def inner(n: int, x: Reals, y: Reals) -> float:
    """Return an inner product."""
    total = 0.0
    for i in range(n):
        total = total + x[i] * y[i]
    return total


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


def share_of_way(step: ImpulseStep) -> float:
    """Return how far one can go until an impulse along a normal comes to zero; points without stay there."""
    share = 1.0
    for k in range(step.count):
        point = int(step.active[k])
        row = int(step.point_first[point])
        if point < step.gaps:
            if not step.impulses[row] > 0.0:
                for r in range(int(step.point_rows[point])):
                    step.way[row + r] = 0.0
            elif step.impulses[row] + step.way[row] < 0.0:
                share = min(share, -step.impulses[row] / step.way[row])
    return share


def take_way(step: ImpulseStep, share: float) -> None:
    """Change the impulses by a share of the way, within cones of friction, and the speeds with them."""
    largest = 0.0
    for i in range(step.acting):
        row = int(step.acting_rows[i])
        largest = max(largest, abs(step.impulses[row]))
        step.impulses[row] = step.impulses[row] + share * step.way[row]
    for k in range(step.count):
        point = int(step.active[k])
        row = int(step.point_first[point])
        if point < step.gaps:
            if step.impulses[row] <= NOTHING * largest:
                for r in range(int(step.point_rows[point])):
                    step.impulses[row + r] = 0.0
            return_to_cone(step, point)
    move_by_impulses(step)
