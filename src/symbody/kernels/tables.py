"""Inputs given by points: pieces of polynomials, found by bisection from the piece of the last time.

The tables of a function lie behind its numbers: how many there are, then for each the input that it gives
and where it begins, from there. A table holds its sizes, both ends, where each piece begins, and the
polynomial of each in the time since, lowest power first.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals, half, part

# A table: how many pieces, numbers of each polynomial, first and last time, the piece of the last time.
PIECES: Final = 0
POWERS: Final = 1
FIRST_TIME: Final = 2
LAST_TIME: Final = 3
LAST_PIECE: Final = 4
STARTS: Final = 5


def find_piece(T: Reals, t: float) -> int:
    """Return the last piece that begins at a time or before it, the first one if none does."""
    count = int(T[PIECES])
    low = int(T[LAST_PIECE])
    width = 1
    while low > 0 and T[STARTS + low] > t:
        low = max(low - width, 0)
        width = 2 * width
    high = min(low + width, count)
    while high < count and T[STARTS + min(high, count - 1)] <= t:
        low = high
        width = 2 * width
        high = min(low + width, count)
    while high - low > 1:
        middle = half(low + high)
        if T[STARTS + middle] <= t:
            low = middle
        else:
            high = middle
    T[LAST_PIECE] = float(low)
    return low


def read_table(T: Reals, t: float) -> float:
    """Return the value at a time; beyond its ends a table keeps the values there."""
    count = int(T[PIECES])
    powers = int(T[POWERS])
    piece = find_piece(T, t)
    since = min(max(t, T[FIRST_TIME]), T[LAST_TIME]) - T[STARTS + piece]
    first = STARTS + count + powers * piece
    value = 0.0
    for k in range(powers - 1, -1, -1):
        value = value * since + T[first + k]
    return value


def read_tables(numbers: FunctionNumbers, t: float) -> None:
    """Set the inputs of a function that are tables to their values at a time."""
    D = numbers.tables
    for k in range(int(D[0])):
        value = read_table(part(D, int(D[2 + 2 * k]), 1), t)
        numbers.inputs[int(D[1 + 2 * k])] = value
