"""Sine and cosine without fused operations: the same bits in every language.

x is reduced by pi/2 in four parts; then a polynomial, a swap and a sign. Errors stay below 1 ulp, next to
multiples of pi/2 below 4.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import NAN, Reals

RANGE: Final = 2.0**32  # beyond, nothing is known of an angle that was rounded
TWO_OVER_PI: Final = 0.6366197723675814
# Adding 1.5 * 2**52 rounds to the nearest integer.
ROUNDER: Final = 1.5 * 2.0**52

# pi/2 is their sum to 2**-113. The first three have up to 21 bits, so their products with whole numbers below
# 2**33 are exact.
PART_1: Final = 1647099.0 * 2.0**-20
PART_2: Final = 345154.0 * 2.0**-40
PART_3: Final = 858182.0 * 2.0**-60
PART_4: Final = 5.170182981794105e-19


def sine_cosine(x: float, result: Reals) -> None:
    """Set `result` (2,) to sine and cosine; to NaN beyond `RANGE`."""
    if not abs(x) <= RANGE:
        result[0] = NAN
        result[1] = NAN
        return
    k = (x * TWO_OVER_PI + ROUNDER) - ROUNDER
    # Both differences are exact; what the third and the fourth lose goes into the tail.
    first = (x - k * PART_1) - k * PART_2
    third = k * PART_3
    second = first - third
    lost = second - first
    remainder = ((first - (second - lost)) - (third + lost)) - k * PART_4
    r = second + remainder
    tail = remainder - (r - second)
    z = r * r
    sine = sine_polynomial(r, z, tail)
    cosine = cosine_polynomial(r, z, tail)
    turns = k * 0.25
    quadrant = turns - ((turns + ROUNDER) - ROUNDER)
    if quadrant == 0.0:
        result[0] = sine
        result[1] = cosine
    elif quadrant == 0.25:
        result[0] = cosine
        result[1] = -sine
    elif quadrant == -0.25:
        result[0] = -cosine
        result[1] = sine
    else:
        result[0] = -sine
        result[1] = -cosine
    if x == 0.0:
        result[0] = x


def sine_polynomial(r: float, z: float, tail: float) -> float:
    """Return sin(r + tail) for |r| <= pi/4, z = r^2."""
    p = 1.5895433271319016e-10
    p = p * z - 2.5050734389075768e-08
    p = p * z + 2.75573135385138e-06
    p = p * z - 0.00019841269829358528
    p = p * z + 0.00833333333332184
    p = p * z - 0.1666666666666663
    return r + (z * r * p + (tail - 0.5 * z * tail))


def cosine_polynomial(r: float, z: float, tail: float) -> float:
    """Return cos(r + tail) for |r| <= pi/4, z = r^2."""
    p = -1.1358749274379452e-11
    p = p * z + 2.0875705396511965e-09
    p = p * z - 2.7557314217041095e-07
    p = p * z + 2.4801587289002083e-05
    p = p * z - 0.0013888888888873342
    p = p * z + 0.041666666666666595
    half = 0.5 * z
    start = 1.0 - half
    return start + ((1.0 - start) - half + (z * z * p - r * tail))


def round_down(x: float) -> float:
    """Return the largest whole number that is not above x."""
    if not abs(x) < 2251799813685248.0:
        return x
    whole = (x + ROUNDER) - ROUNDER
    if whole > x:
        return whole - 1.0
    return whole
