"""Roots and powers of positive numbers by + - * / and square roots alone, with the same bits everywhere."""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import exponent, power_of_two, sqrt

LOG_2: Final = 0.6931471805599453
HALF_ROOT: Final = 0.7071067811865476
LARGEST_POWER: Final = 700.0


def logarithm(x: float) -> float:
    """Return ln x of a positive normal number, to some units of the last digit.

    With x = m 2^e and m near 1 it is e ln 2 + 2 artanh((m - 1) / (m + 1)) [Abramowitz and Stegun, 4.1.27].
    """
    e = exponent(x)
    m = x * power_of_two(-e)
    if m < HALF_ROOT:
        m = 2.0 * m
        e = e - 1
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    a = 1.0 / 3.0 + z * (1.0 / 5.0)
    b = 1.0 / 7.0 + z * (1.0 / 9.0)
    c = 1.0 / 11.0 + z * (1.0 / 13.0)
    d = 1.0 / 15.0 + z * (1.0 / 17.0)
    w = z * z
    series = a + w * (b + w * (c + w * d))
    return e * LOG_2 + 2.0 * (s + s * z * series)


def exponential(y: float) -> float:
    """Return e^y to some units of the last digit; y beyond `LARGEST_POWER` in size counts as that.

    With y = k ln 2 + r the series of e^(r / 4) is squared twice.
    """
    bounded = min(max(y, -LARGEST_POWER), LARGEST_POWER)
    k = int(bounded / LOG_2)
    r = 0.25 * (bounded - k * LOG_2)
    w = r * r
    a = 1.0 + r
    b = 1.0 / 2.0 + r * (1.0 / 6.0)
    c = 1.0 / 24.0 + r * (1.0 / 120.0)
    d = 1.0 / 720.0 + r * (1.0 / 5040.0)
    e = 1.0 / 40320.0 + r * (1.0 / 362880.0)
    f = 1.0 / 3628800.0 + r * (1.0 / 39916800.0)
    series = a + w * (b + w * (c + w * (d + w * (e + w * f))))
    squared = series * series
    return squared * squared * power_of_two(k)


def power(x: float, a: float) -> float:
    """Return x^a of a positive number; 1/8, 1/4, 1/2 and 1 by square roots."""
    if a == 1.0:
        return x
    if a == 0.5:
        return sqrt(x)
    if a == 0.25:
        return sqrt(sqrt(x))
    if a == 0.125:
        return sqrt(sqrt(sqrt(x)))
    return exponential(a * logarithm(x))
