"""How long a step may be: to the end of a motion, and by what depends on time alone.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from typing import Final

from symbody.simulation.native.interface import Goal, Integers, inline
from symbody.simulation.native.layout import FIRST_BREAK, NEXT_BREAK

EPSILON: Final = 2.220446049250313e-16
SMALLEST_STEP: Final = 1e-290  # absolute, for motions that fail at t = 0


@inline
def next_break(goal: Goal, counts: Integers, t: float) -> int:
    """Return the number of the next breakpoint after a time, one that is at hand left behind."""
    k = counts[NEXT_BREAK]
    while k > counts[FIRST_BREAK] and (goal.breaks[k - 1] - t) * goal.direction > 2.0 * goal.margins[k - 1]:
        k -= 1  # an event led back
    while (goal.breaks[k] - t) * goal.direction <= 2.0 * goal.margins[k]:
        k += 1
    counts[NEXT_BREAK] = k
    return int(k)


@inline
def _bound_step(goal: Goal, counts: Integers, t: float, h: float) -> tuple[float, int]:
    """Return how long a step of length h may be, and the breakpoint at which it has to end, -1 for none.

    A step is no longer than every piece that it enters allows; it ends where it would enter one that allows
    less than the way there.
    """
    k = next_break(goal, counts, t)
    length = min(abs(h), goal.longest[k])
    while abs(goal.breaks[k] - t) < length:
        way = abs(goal.breaks[k] - t)
        if goal.jumps[k] or goal.longest[k + 1] < way:
            return way, k
        k += 1
        length = min(length, goal.longest[k])
    return length, -1


@inline
def next_trial(goal: Goal, counts: Integers, t: float, h: float) -> tuple[float, float]:
    """Return length and end of the next trial, of length 0 where steps are too short to go on.

    Before a jump the step is shorter than its end tells, by `Goal.margins`.
    """
    rest = goal.t_end - t
    length, k = _bound_step(goal, counts, t, h)
    # stretched by one percent rather than leave a tiny last step, but never beyond the step that was allowed
    is_free = length == abs(h) and abs(rest) <= abs(goal.breaks[counts[NEXT_BREAK]] - t)
    # and a step that ends beside the end by the rounding of times alone ends there
    allowed = 1.01 * length if is_free else length + 4.0 * EPSILON * abs(goal.t_end)
    if abs(rest) <= allowed and abs(rest) <= goal.max_step * (1.0 + 1e-9):
        return rest, goal.t_end
    if k >= 0:
        end = goal.breaks[k]
        return (end - t - goal.direction * goal.margins[k] if goal.jumps[k] else end - t), end
    if length <= max(10.0 * EPSILON * abs(t), SMALLEST_STEP):
        return 0.0, t
    return goal.direction * length, t + goal.direction * length


@inline
def behind_jump(goal: Goal, counts: Integers, t: float) -> float:
    """Return a time just behind a jump that lies at this time; the time itself without one before the end."""
    k = next_break(goal, counts, t)
    if k > counts[FIRST_BREAK] and goal.jumps[k - 1] and t != goal.t_end:
        if (goal.breaks[k - 1] - t) * goal.direction >= -goal.margins[k - 1]:
            behind: float = goal.breaks[k - 1] + goal.direction * goal.margins[k - 1]
            if (goal.t_end - behind) * goal.direction > 0.0:  # motions may end just before a jump
                return behind
    return t
