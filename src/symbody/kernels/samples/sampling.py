"""Values that are held between samples: each is computed anew at its instants, in the order of the model.

Instants are products of a count and a sample time, never sums. What comes first in the model is new already
where what comes later is computed; all else has the values of before.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FunctionNumbers, Run
from symbody.kernels.language import INFINITY, Function, Reals, part
from symbody.kernels.runge_kutta import call, copy
from symbody.kernels.samples.sample_hold import SampleHold

# Times that differ by less, over the larger one, are one instant: 3*0.1 and 0.3.
ONE_INSTANT: Final = 8.0 * 2.220446049250313e-16


def is_instant(held: SampleHold, a: float, b: float) -> int:
    """Return 1 if two times are one instant, else 0."""
    if abs(a - b) <= ONE_INSTANT * max(max(abs(a), abs(b)), abs(held.start)):
        return 1
    return 0


def instant_of(held: SampleHold, group: int) -> float:
    """Return when the next sample of a group is due."""
    return held.start + held.taken[group] * held.steps[group]


def find_next(held: SampleHold) -> None:
    """Set `next` to when the next sample of any group is due."""
    t = INFINITY
    for group in range(held.groups):
        t = min(t, instant_of(held, group))
    held.next = t


def is_due(held: SampleHold, t: float) -> int:
    """Return 1 if a sample has to be taken at a time, else 0."""
    if held.next <= t:
        return 1
    return is_instant(held, held.next, t)


def show_values(held: SampleHold, numbers: FunctionNumbers) -> None:
    """Write the held values among the inputs of a function."""
    for k in range(held.count):
        numbers.inputs[int(held.slots[k])] = held.values[k]


def take_samples(
    h: Function, numbers: FunctionNumbers, held: SampleHold, Y: Reals, t: float, x: Reals
) -> int:
    """Compute the values that are due at a time, and record all; return the status of the function.

    `numbers` are those of the function h of new values; Y has room for one more row. What jumps at the same
    instant has jumped: 3*0.29 is less than 0.87 by rounding alone.
    """
    behind = t + ONE_INSTANT * max(abs(t), abs(held.start))
    count = held.count
    new = held.new
    show_values(held, numbers)
    for k in range(count):
        when = instant_of(held, int(held.group_of[k]))
        if when <= t or is_instant(held, when, t) != 0:
            status = call(h, held.speeds, numbers, behind, x, new)
            if status != 0:
                held.fault = status
                return status
            held.values[k] = new[k]
            numbers.inputs[int(held.slots[k])] = new[k]
    for group in range(held.groups):
        when = instant_of(held, group)
        if when <= t or is_instant(held, when, t) != 0:
            held.taken[group] = held.taken[group] + 1.0
    find_next(held)
    row = part(Y, (count + 1) * held.recorded, count + 1)
    row[0] = t
    copy(count, held.values, part(row, 1, count))
    held.recorded = held.recorded + 1
    return 0


def piece_end(run: Run, held: SampleHold, end: float) -> float:
    """Return where the motion has to stop for the next sample, `end` if that comes first."""
    if held.next >= end or is_instant(held, held.next, end) != 0:
        return end
    return max(held.next, run.time)


def rewind_samples(held: SampleHold, Y: Reals, t: float) -> None:
    """Forget the samples behind a time from which a motion goes on anew, as far as they are recorded."""
    count = held.count
    last = held.recorded
    while last > 0:
        time = Y[(count + 1) * (last - 1)]
        if time <= t or is_instant(held, time, t) != 0:
            break
        last = last - 1
    if last == 0 or last == held.recorded:
        return
    held.recorded = last
    copy(count, part(Y, (count + 1) * (last - 1) + 1, count), held.values)
    for group in range(held.groups):
        while held.taken[group] > 0.0:
            when = held.start + (held.taken[group] - 1.0) * held.steps[group]
            if when <= t or is_instant(held, when, t) != 0:
                break
            held.taken[group] = held.taken[group] - 1.0
    find_next(held)
