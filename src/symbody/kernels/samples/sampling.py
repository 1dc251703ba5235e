"""Values that are held between samples: each is computed anew at its instants, in the order of the model.

Instants are products of a count and a sample time, never sums. What comes first in the model is new already
where what comes later is computed; all else has the values of before.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import R_PLACE, TIME
from symbody.kernels.language import INFINITY, Function, Reals, part
from symbody.kernels.runge_kutta import call, copy
from symbody.kernels.samples.sample_block import (
    COUNT,
    FAULT,
    GROUP_OF,
    GROUPS,
    NEW,
    NEXT,
    RECORDED,
    SLOTS,
    SPEEDS,
    START,
    STEPS,
    TAKEN,
    VALUES,
)

# Times that differ by less, over the larger one, are one instant: 3*0.1 and 0.3.
ONE_INSTANT: Final = 8.0 * 2.220446049250313e-16


def is_instant(Z: Reals, a: float, b: float) -> int:
    """Return 1 if two times are one instant, else 0."""
    if abs(a - b) <= ONE_INSTANT * max(max(abs(a), abs(b)), abs(Z[START])):
        return 1
    return 0


def instant_of(Z: Reals, group: int) -> float:
    """Return when the next sample of a group is due."""
    return Z[START] + Z[int(Z[TAKEN]) + group] * Z[int(Z[STEPS]) + group]


def find_next(Z: Reals) -> None:
    """Set `NEXT` to when the next sample of any group is due."""
    t = INFINITY
    for group in range(int(Z[GROUPS])):
        t = min(t, instant_of(Z, group))
    Z[NEXT] = t


def is_due(Z: Reals, t: float) -> int:
    """Return 1 if a sample has to be taken at a time, else 0."""
    if Z[NEXT] <= t:
        return 1
    return is_instant(Z, Z[NEXT], t)


def show_values(Z: Reals, numbers: Reals) -> None:
    """Write the held values among the inputs of a function."""
    for k in range(int(Z[COUNT])):
        numbers[R_PLACE + int(Z[int(Z[SLOTS]) + k])] = Z[int(Z[VALUES]) + k]


def take_samples(h: Function, numbers: Reals, Z: Reals, Y: Reals, t: float, x: Reals) -> int:
    """Compute the values that are due at a time, and record all; return the status of the function.

    `numbers` are those of the function h of new values; Y has room for one more row. What jumps at the same
    instant has jumped: 3*0.29 is less than 0.87 by rounding alone.
    """
    behind = t + ONE_INSTANT * max(abs(t), abs(Z[START]))
    count = int(Z[COUNT])
    new = part(Z, int(Z[NEW]), count)
    show_values(Z, numbers)
    for k in range(count):
        when = instant_of(Z, int(Z[int(Z[GROUP_OF]) + k]))
        if when <= t or is_instant(Z, when, t) != 0:
            status = call(h, int(Z[SPEEDS]), numbers, behind, x, new)
            if status != 0:
                Z[FAULT] = float(status)
                return status
            Z[int(Z[VALUES]) + k] = new[k]
            numbers[R_PLACE + int(Z[int(Z[SLOTS]) + k])] = new[k]
    for group in range(int(Z[GROUPS])):
        when = instant_of(Z, group)
        if when <= t or is_instant(Z, when, t) != 0:
            Z[int(Z[TAKEN]) + group] = Z[int(Z[TAKEN]) + group] + 1.0
    find_next(Z)
    row = part(Y, (count + 1) * int(Z[RECORDED]), count + 1)
    row[0] = t
    copy(count, part(Z, int(Z[VALUES]), count), part(row, 1, count))
    Z[RECORDED] = Z[RECORDED] + 1.0
    return 0


def piece_end(B: Reals, Z: Reals, end: float) -> float:
    """Return where the motion has to stop for the next sample, `end` if that comes first."""
    if Z[NEXT] >= end or is_instant(Z, Z[NEXT], end) != 0:
        return end
    return max(Z[NEXT], B[TIME])
