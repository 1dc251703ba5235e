"""Turns that make up a given rotation matrix."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.formula_site import Triple
from symbody.model.numbers import formula_value
from symbody.model.simple_rotation import LETTERS, SimpleRotation

# A matrix typed with 10 digits of cos 30 deg means 30 deg.
_SNAP: Final = 2e-11


def euler_turns(matrix: tuple[Triple, Triple, Triple]) -> tuple[SimpleRotation, ...]:
    """Return body-fixed turns about z, y, x that lead to the axes whose rotation matrix is given.

    Numbers give the angles as numbers, multiples of pi/12 exactly; formulas give them by atan2, which
    presumes that the y turn is no right angle.
    """
    values = [[formula_value(entry) for entry in row] for row in matrix]
    numbers = [[float(value) for value in row if value is not None] for row in values]
    if sum(map(len, numbers)) < 9:
        angles: tuple[Formula, ...] = _formulas(matrix)
    else:
        angles = tuple(_angle(angle) for angle in _numbers(numbers))
    pairs = zip("zyx", angles, strict=True)
    return tuple(SimpleRotation(LETTERS[letter], angle) for letter, angle in pairs if angle.text != "0")


def _numbers(r: list[list[float]]) -> tuple[float, float, float]:
    """Return the three angles of R = Rz Ry Rx."""
    horizontal = math.hypot(r[0][0], r[1][0])
    second = math.atan2(-r[2][0], horizontal)
    if horizontal < 1e-9:  # z and x turn about one line: let x do it
        return 0.0, second, math.atan2(-r[1][2], r[1][1])
    return math.atan2(r[1][0], r[0][0]), second, math.atan2(r[2][1], r[2][2])


def _angle(angle: float) -> Formula:
    steps = round(angle * 12 / math.pi)
    if abs(angle - steps * math.pi / 12) > _SNAP:
        return Formula.from_value(angle)
    part = Fraction(steps, 12)
    return Formula.from_value(f"{part.numerator}*pi/{part.denominator}" if steps else 0)


def _formulas(matrix: tuple[Triple, Triple, Triple]) -> tuple[Formula, Formula, Formula]:
    r = [[entry.text for entry in row] for row in matrix]
    return (
        Formula.from_value(f"atan2({r[1][0]}, {r[0][0]})"),
        Formula.from_value(f"atan2(-({r[2][0]}), sqrt(({r[0][0]})**2 + ({r[1][0]})**2))"),
        Formula.from_value(f"atan2({r[2][1]}, {r[2][2]})"),
    )
