"""How long a step may be: to the end of a motion, and by what depends on time alone."""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    AFTER_REJECTION,
    BREAK_JUMPS,
    BREAK_LONGEST,
    BREAK_MARGIN,
    BREAK_SIZE,
    BREAK_TIME,
    DIRECTION,
    FIRST_BREAK,
    GROWTH,
    LENGTH,
    MAX_STEP,
    METHOD,
    NEXT_BREAK,
    T_END,
    T_NEW,
)
from symbody.kernels.language import INFINITY, Reals

EPSILON: Final = 2.220446049250313e-16
RASTER: Final = 1e-9  # of a step: what lies so close to its end lies there
SMALLEST_STEP: Final = 1e-290  # absolute, for motions that fail at t = 0


def next_break(B: Reals, t: float) -> int:
    """Return where the next breakpoint after a time lies in the block, one that is at hand left behind."""
    direction = B[DIRECTION]
    place = int(B[NEXT_BREAK])
    first = int(B[FIRST_BREAK])
    while place > first:
        before = place - BREAK_SIZE
        if not (B[before + BREAK_TIME] - t) * direction > 2.0 * B[before + BREAK_MARGIN]:
            break
        place = before  # an event led back
    while (B[place + BREAK_TIME] - t) * direction <= 2.0 * B[place + BREAK_MARGIN]:
        place = place + BREAK_SIZE
    B[NEXT_BREAK] = float(place)
    return place


def find_jump_at_end(B: Reals, t: float, length: float) -> int:
    """Return the breakpoint of a jump that lies at the end of a step of a given length, or -1."""
    place = next_break(B, t)
    while abs(B[place + BREAK_TIME] - t) < length * (1.0 - RASTER):
        place = place + BREAK_SIZE
    if B[place + BREAK_JUMPS] != 0.0 and abs(B[place + BREAK_TIME] - t) <= length * (1.0 + RASTER):
        return place
    return -1


def begin_of_step(B: Reals, t: float) -> float:
    """Return when a step begins: at the jump that it begins just behind, else at its time."""
    place = int(B[NEXT_BREAK])
    if place > int(B[FIRST_BREAK]):
        before = place - BREAK_SIZE
        time = B[before + BREAK_TIME]
        if B[before + BREAK_JUMPS] != 0.0 and abs(time - t) <= 2.0 * B[before + BREAK_MARGIN]:
            return time
    return t


def bound_step(B: Reals, t: float, h: float) -> int:
    """Set `LENGTH` to how long a step of length h may be; return the breakpoint where it has to end, or -1.

    A step is no longer than every piece that it enters allows; it ends where it would enter one that allows
    less than the way there. Steps of one length end at jumps only that lie on their raster.
    """
    place = next_break(B, t)
    if B[METHOD + GROWTH] == 1.0:
        B[LENGTH] = abs(h)
        return find_jump_at_end(B, t, abs(h))
    length = min(abs(h), B[place + BREAK_LONGEST])
    while abs(B[place + BREAK_TIME] - t) < length:
        way = abs(B[place + BREAK_TIME] - t)
        if B[place + BREAK_JUMPS] != 0.0 or B[place + BREAK_SIZE + BREAK_LONGEST] < way:
            B[LENGTH] = way
            return place
        place = place + BREAK_SIZE
        length = min(length, B[place + BREAK_LONGEST])
    B[LENGTH] = length
    return -1


def end_motion(B: Reals, t: float, bound: int) -> None:
    """Let the next trial lead to the end of the motion, or to just before a jump there."""
    ahead = B[T_END] - t
    place = bound
    if bound < 0 or B[METHOD + GROWTH] == 1.0:  # the last step may be shorter, or longer by the stretch
        place = find_jump_at_end(B, t, abs(ahead))
    B[LENGTH] = ahead
    B[T_NEW] = B[T_END]
    if place >= 0 and B[place + BREAK_JUMPS] != 0.0:
        if abs(B[place + BREAK_TIME] - B[T_END]) <= B[place + BREAK_MARGIN]:
            before = B[place + BREAK_TIME] - B[DIRECTION] * B[place + BREAK_MARGIN]
            if (before - t) * B[DIRECTION] > 0.0 and (B[T_END] - before) * B[DIRECTION] > 0.0:
                B[LENGTH] = before - t


def plan_trial(B: Reals, t: float, h: float) -> None:
    """Set `LENGTH` and `T_NEW` of the next trial; the length is 0 where steps are too short to go on.

    Before a jump the step is shorter than its end tells, by the margin of the jump.
    """
    t_end = B[T_END]
    direction = B[DIRECTION]
    ahead = t_end - t
    place = bound_step(B, t, h)
    length = B[LENGTH]
    # stretched by one percent rather than leave a tiny last step, but never beyond the step that was allowed,
    # and a step that ends beside the end by the rounding of times alone ends there
    allowed = length + 4.0 * EPSILON * abs(t_end)
    if length == abs(h) and abs(ahead) <= abs(B[int(B[NEXT_BREAK]) + BREAK_TIME] - t):
        allowed = max(allowed, 1.01 * length)
    if B[AFTER_REJECTION] == 0.0 and abs(ahead) <= 10.0 * EPSILON * abs(t_end):
        allowed = abs(ahead)  # an event that acts may lie so close to the end
    if abs(ahead) <= allowed and abs(ahead) <= B[MAX_STEP] * (1.0 + 1e-9):
        end_motion(B, t, place)
        return
    if place >= 0:
        end = B[place + BREAK_TIME]
        B[LENGTH] = end - t
        if B[place + BREAK_JUMPS] != 0.0:
            B[LENGTH] = end - t - direction * B[place + BREAK_MARGIN]
        B[T_NEW] = end
        return
    if length <= max(10.0 * EPSILON * abs(t), SMALLEST_STEP):
        B[LENGTH] = 0.0
        B[T_NEW] = t
        return
    B[LENGTH] = direction * length
    B[T_NEW] = t + direction * length
    if B[METHOD + GROWTH] == 1.0:
        begin = begin_of_step(B, t)
        if begin != t:
            B[T_NEW] = begin + direction * length
            B[LENGTH] = B[T_NEW] - t


def behind_jump(B: Reals, t: float) -> float:
    """Return a time just behind a jump that lies at this time; the time itself without one before the end."""
    place = next_break(B, t)
    if place <= int(B[FIRST_BREAK]) or t == B[T_END]:
        return t
    direction = B[DIRECTION]
    before = place - BREAK_SIZE
    margin = B[before + BREAK_MARGIN]
    if B[before + BREAK_JUMPS] != 0.0 and (B[before + BREAK_TIME] - t) * direction >= -margin:
        behind = B[before + BREAK_TIME] + direction * margin
        if (B[T_END] - behind) * direction > 0.0:  # motions may end just before a jump
            return behind
    return t


def longest_step(B: Reals, t: float, ends: Reals) -> None:
    """Set `ends` (3,) to where the longest step at a time begins and ends, and when it is said to end."""
    start = behind_jump(B, t)
    plan_trial(B, start, B[DIRECTION] * INFINITY)
    end = B[T_NEW]
    place = next_break(B, end)
    ends[0] = start
    ends[1] = end
    ends[2] = end
    if end != B[T_END] and place > int(B[FIRST_BREAK]):
        before = place - BREAK_SIZE
        if B[before + BREAK_JUMPS] != 0.0 and B[before + BREAK_TIME] == end:
            ends[1] = end - B[DIRECTION] * B[before + BREAK_MARGIN]
    B[NEXT_BREAK] = B[FIRST_BREAK]
