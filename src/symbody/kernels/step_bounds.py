"""How long a step may be: to the end of a motion, and by what depends on time alone."""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import Run
from symbody.kernels.language import INFINITY, Reals

EPSILON: Final = 2.220446049250313e-16
RASTER: Final = 1e-9  # of a step: what lies so close to its end lies there
SMALLEST_STEP: Final = 1e-290  # absolute, for motions that fail at t = 0


def next_break(run: Run, t: float) -> int:
    """Return where the next breakpoint after a time lies in the block, one that is at hand left behind."""
    breaks = run.breaks
    direction = run.goal.direction
    place = breaks.next
    while place > 0:
        before = place - 1
        if not (breaks.points[before].time - t) * direction > 2.0 * breaks.points[before].margin:
            break
        place = before  # an event led back
    while (breaks.points[place].time - t) * direction <= 2.0 * breaks.points[place].margin:
        place = place + 1
    breaks.next = place
    return place


def find_jump_at_end(run: Run, t: float, length: float) -> int:
    """Return the breakpoint of a jump that lies at the end of a step of a given length, or -1."""
    breaks = run.breaks
    place = next_break(run, t)
    while abs(breaks.points[place].time - t) < length * (1.0 - RASTER):
        place = place + 1
    if breaks.points[place].jumps != 0.0 and abs(breaks.points[place].time - t) <= length * (1.0 + RASTER):
        return place
    return -1


def begin_of_step(run: Run, t: float) -> float:
    """Return when a step begins: at the jump that it begins just behind, else at its time."""
    breaks = run.breaks
    place = breaks.next
    if place > 0:
        before = place - 1
        time = breaks.points[before].time
        if breaks.points[before].jumps != 0.0 and abs(time - t) <= 2.0 * breaks.points[before].margin:
            return time
    return t


def bound_step(run: Run, t: float, h: float) -> int:
    """Set `length` to how long a step of length h may be; return the breakpoint where it has to end, or -1.

    A step is no longer than every piece that it enters allows; it ends where it would enter one that allows
    less than the way there. Steps of one length end at jumps only that lie on their raster.
    """
    breaks = run.breaks
    place = next_break(run, t)
    if run.method.growth == 1.0:
        run.length = abs(h)
        return find_jump_at_end(run, t, abs(h))
    length = min(abs(h), breaks.points[place].longest)
    while abs(breaks.points[place].time - t) < length:
        way = abs(breaks.points[place].time - t)
        if breaks.points[place].jumps != 0.0 or breaks.points[place + 1].longest < way:
            run.length = way
            return place
        place = place + 1
        length = min(length, breaks.points[place].longest)
    run.length = length
    return -1


def end_motion(run: Run, t: float, bound: int) -> None:
    """Let the next trial lead to the end of the motion, or to just before a jump there."""
    breaks = run.breaks
    ahead = run.t_end - t
    place = bound
    if bound < 0 or run.method.growth == 1.0:  # the last step may be shorter, or longer by the stretch
        place = find_jump_at_end(run, t, abs(ahead))
    run.length = ahead
    run.t_new = run.t_end
    if place >= 0 and breaks.points[place].jumps != 0.0:
        jump = breaks.points[place]
        if abs(jump.time - run.t_end) <= jump.margin:
            before = jump.time - run.goal.direction * jump.margin
            if (before - t) * run.goal.direction > 0.0 and (run.t_end - before) * run.goal.direction > 0.0:
                run.length = before - t


def plan_trial(run: Run, t: float, h: float) -> None:
    """Set `length` and `t_new` of the next trial; the length is 0 where steps are too short to go on.

    Before a jump the step is shorter than its end tells, by the margin of the jump.
    """
    breaks = run.breaks
    t_end = run.t_end
    direction = run.goal.direction
    ahead = t_end - t
    place = bound_step(run, t, h)
    length = run.length
    # stretched by one percent rather than leave a tiny last step, but never beyond the step that was allowed,
    # and a step that ends beside the end by the rounding of times alone ends there
    allowed = length + 4.0 * EPSILON * abs(t_end)
    if length == abs(h) and abs(ahead) <= abs(breaks.points[breaks.next].time - t):
        allowed = max(allowed, 1.01 * length)
    if run.after_rejection == 0.0 and abs(ahead) <= 10.0 * EPSILON * abs(t_end):
        allowed = abs(ahead)  # an event that acts may lie so close to the end
    if abs(ahead) <= allowed and abs(ahead) <= run.goal.max_step * (1.0 + 1e-9):
        end_motion(run, t, place)
        return
    if place >= 0:
        end = breaks.points[place].time
        run.length = end - t
        if breaks.points[place].jumps != 0.0:
            run.length = end - t - direction * breaks.points[place].margin
        run.t_new = end
        return
    if length <= max(10.0 * EPSILON * abs(t), SMALLEST_STEP):
        run.length = 0.0
        run.t_new = t
        return
    run.length = direction * length
    run.t_new = t + direction * length
    if run.method.growth == 1.0:
        begin = begin_of_step(run, t)
        if begin != t:
            run.t_new = begin + direction * length
            run.length = run.t_new - t


def behind_jump(run: Run, t: float) -> float:
    """Return a time just behind a jump that lies at this time; the time itself without one before the end."""
    breaks = run.breaks
    place = next_break(run, t)
    if place <= 0 or t == run.t_end:
        return t
    direction = run.goal.direction
    before = place - 1
    margin = breaks.points[before].margin
    if breaks.points[before].jumps != 0.0 and (breaks.points[before].time - t) * direction >= -margin:
        behind = breaks.points[before].time + direction * margin
        if (run.t_end - behind) * direction > 0.0:  # motions may end just before a jump
            return behind
    return t


def longest_step(run: Run, t: float, ends: Reals) -> None:
    """Set `ends` (3,) to where the longest step at a time begins and ends, and when it is said to end."""
    breaks = run.breaks
    start = behind_jump(run, t)
    plan_trial(run, start, run.goal.direction * INFINITY)
    end = run.t_new
    place = next_break(run, end)
    ends[0] = start
    ends[1] = end
    ends[2] = end
    if end != run.t_end and place > 0:
        before = place - 1
        if breaks.points[before].jumps != 0.0 and breaks.points[before].time == end:
            ends[1] = end - run.goal.direction * breaks.points[before].margin
    breaks.next = 0
