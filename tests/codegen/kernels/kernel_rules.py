"""A kernel that uses every rule of the language once."""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import (
    INFINITY,
    NAN,
    Reals,
    exponent,
    half,
    is_finite,
    part,
    power_of_two,
    sqrt,
)

TENTH: Final = 1.0 / 10.0


def fill(n: int, x: float, out: Reals) -> None:
    """Set the first entries of an array."""
    for k in range(n):
        out[k] = x


def rules(given: Reals, out: Reals) -> None:
    """Set `out` (15,) to the results of all rules for two numbers."""
    x = given[0]
    y = given[1]
    out[0] = min(x, y)
    out[1] = max(x, y)
    out[2] = abs(x)
    out[3] = sqrt(x)
    out[4] = float(exponent(x))
    out[5] = float(half(exponent(x)))
    out[6] = power_of_two(-half(exponent(y)))
    out[7] = x - (y - 1.0)
    out[8] = x * y + TENTH
    out[9] = 0.0
    if is_finite(x) and not x != y:
        out[9] = 1.0
    elif x < y or x > y:
        out[9] = 2.0
    out[10] = -x
    count = 0
    for k in range(5, 1, -1):
        if k == 3:
            break
        count = count + k
    while count < 20:
        count = count + min(count, 7)
    out[11] = float(count - max(count, 3) - abs(1 - count))
    out[12] = INFINITY - x * NAN
    tail = part(out, 13, 2)
    fill(2, y / (x * x + 1.0), tail)
