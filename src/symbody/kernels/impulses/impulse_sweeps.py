"""The impulses of all points at once: sweeps of Gauss and Seidel, each point solved exactly.

Newton's law of impacts: where a gap closes, its rate behind is at least minus the restitution times that
before [Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; Jean, The non-smooth
contact dynamics method, 1999].
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.impulses.impulse_acceleration import (
    accelerate,
    forget_sweeps,
    keep_best,
    keep_start,
    take_best,
)
from symbody.kernels.impulses.impulse_responses import add_impulse, answer_to_point, rate_along
from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.impulses.point_impulse import SCRATCH, solve_point, stiffest_across
from symbody.kernels.language import INFINITY, Reals, is_finite, part, sqrt

LEAST_SHARE: Final = 1e-3  # of restitution
ROUNDED: Final = 1e-13  # of the work that impulses do


def solve_impulses(step: ImpulseStep, h: float, old: Reals, tolerance: float) -> int:
    """Find the impulses of the points that act, and the speeds behind them; return 0 if there are none.

    If they would do work the restitution of all is lowered, down to none, which never does. Of a residual
    above the tolerance of the motion nothing of that is seen.
    """
    if prepare_points(step, old) == 0:
        return 0
    step.share = 1.0
    sweep_points(step, h, tolerance)
    if tolerance > step.tolerance and step.residual > step.tolerance * step.scale:
        return 1
    while step.share > 0.0 and work_of_impulses(step, step.without) > ROUNDED * size_of_work(step):
        if step.share == 1.0:
            step.lowered = step.lowered + 1.0
        step.share = 0.5 * step.share
        if step.share < LEAST_SHARE:
            step.share = 0.0
        sweep_points(step, h, tolerance)
    for i in range(step.speeds):
        if not is_finite(step.moving[i]):
            return 0
    return 1


def prepare_points(step: ImpulseStep, old: Reals) -> int:
    """Compute what does not change between sweeps, and speeds with the impulses of the last step."""
    for i in range(step.speeds):
        step.moving[i] = step.free[i]
    step.scale = 0.0
    acting = 0
    for k in range(step.count):
        point = int(step.active[k])
        if answer_to_point(step, point) == 0:
            return 0
        first = int(step.point_first[point])
        for r in range(int(step.point_rows[point])):
            row = first + r
            step.before[row] = rate_along(step, row, old)
            step.without[row] = rate_along(step, row, step.free)
            step.scale = max(step.scale, max(abs(step.before[row]), abs(step.without[row])))
            add_impulse(step, point, r, step.impulses[row], step.moving)
            step.acting_rows[acting] = float(row)
            acting = acting + 1
    step.acting = acting
    return 1


def sweep_points(step: ImpulseStep, h: float, tolerance: float) -> None:
    """Sweep over the points, forth and back, until the residual is within a tolerance."""
    goal = tolerance * step.scale
    forget_sweeps(step)
    step.turn_count = 0
    step.residual = INFINITY
    step.best = INFINITY
    left = step.sweeps
    while left > 0 and step.residual > goal:
        keep_start(step)
        step.residual = 0.0
        for k in range(step.count):
            sweep_point(step, int(step.active[k]), h)
        left = left - 1
        if left > 0 and step.residual > goal:
            step.residual = 0.0
            for k in range(step.count - 1, -1, -1):
                sweep_point(step, int(step.active[k]), h)
            left = left - 1
        if step.residual > goal:
            keep_best(step)
        if left > 0 and step.residual > goal:
            accelerate(step)
    if step.residual > goal and step.best < step.residual:
        take_best(step)
    step.swept = step.swept + float(step.sweeps - left)


def sweep_point(step: ImpulseStep, point: int, h: float) -> None:
    """Solve for the impulse at one point with the speeds so far, and note how far off the last one was."""
    first = int(step.point_first[point])
    rows = int(step.point_rows[point])
    G = part(step.own, 9 * point, 9)
    b = part(step.local, 0, 3)
    P = part(step.local, 3, 3)
    rates = part(step.local, 6, 3)
    A = part(step.local, 9, SCRATCH)
    values = part(step.values, int(step.point_values[point]), 3)
    gap = 0
    if point < step.gaps:
        gap = 1
    for r in range(rows):
        rates[r] = rate_along(step, first + r, step.moving)
    if gap == 1:
        rates[0] = rates[0] + step.share * values[0] * step.before[first]
    impulses = part(step.impulses, first, rows)
    step.residual = max(step.residual, point_residual(rows, gap, values[1], values[2], h, G, rates, impulses))
    for r in range(rows):
        b[r] = rates[r]
        for s in range(rows):
            b[r] = b[r] - G[3 * r + s] * impulses[s]
    begin = step.multipliers[point]
    step.multipliers[point] = solve_point(rows, gap, values[1], values[2], h, G, b, begin, P, A)
    for r in range(rows):
        change = P[r] - impulses[r]
        if change != 0.0:
            add_impulse(step, point, r, change, step.moving)
            impulses[r] = P[r]


def point_residual(
    rows: int, gap: int, strength: float, limit: float, h: float, G: Reals, rates: Reals, impulses: Reals
) -> float:  # fmt: skip
    """Return by how much a point misses its laws, as a rate: the natural map of normal and friction."""
    pressing = h
    residual = 0.0
    if gap == 1:
        pressing = impulses[0]
        if G[0] > 0.0:
            residual = abs(impulses[0] - max(0.0, impulses[0] - rates[0] / G[0])) * G[0]
    if rows == gap:
        return residual
    stiffest = stiffest_across(rows, gap, G)
    if not stiffest > 0.0:
        return residual
    missed = friction_residual(rows, gap, strength * pressing, stiffest, rates, impulses)
    if limit > strength:
        missed = min(missed, friction_residual(rows, gap, limit * pressing, stiffest, rates, impulses))
    return max(residual, missed)


def friction_residual(
    rows: int, gap: int, bound: float, stiffest: float, rates: Reals, impulses: Reals
) -> float:
    """Return how far impulses across the normal are from the projection on the disk of a bound, as a rate."""
    norm = 0.0
    for r in range(gap, rows):
        x = impulses[r] - rates[r] / stiffest
        norm = norm + x * x
    norm = sqrt(norm)
    share = 1.0
    if norm > bound:
        share = bound / norm
    missed = 0.0
    for r in range(gap, rows):
        x = share * (impulses[r] - rates[r] / stiffest) - impulses[r]
        missed = missed + x * x
    return sqrt(missed) * stiffest


def work_of_impulses(step: ImpulseStep, first_rates: Reals) -> float:
    """Return the work of all impulses: each times the mean of some first rates and of those behind."""
    total = 0.0
    for k in range(step.count):
        point = int(step.active[k])
        first = int(step.point_first[point])
        for row in range(first, first + int(step.point_rows[point])):
            rate = rate_along(step, row, step.moving)
            total = total + 0.5 * step.impulses[row] * (rate + first_rates[row])
    return total


def size_of_work(step: ImpulseStep) -> float:
    """Return the sum of the magnitudes of the works of impulses."""
    total = 0.0
    for k in range(step.count):
        point = int(step.active[k])
        first = int(step.point_first[point])
        for row in range(first, first + int(step.point_rows[point])):
            total = total + abs(step.impulses[row]) * step.scale
    return total
