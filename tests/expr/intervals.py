"""What rounding can do to a sequence: intervals that hold the exact and every rounded result.

Each operation is taken over all values its operands can have, then widened by its own rounding. So an
interval holds the exact value of the sequence as well as what an arithmetic of unit roundoff `unit` returns,
and its width bounds the difference of the two. Nothing is assumed but the accuracy of single operations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import mpmath

from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import Arithmetic

FLOAT_UNIT = Fraction(1, 2**53)
TINY = Fraction(1, 2**1074)  # what underflow can add
# C libraries stay below 2 units in the last place for these functions (the manual of glibc, "Errors
# in Math Functions"), one such unit being at most 2 roundoffs; mpmath stays below 1.
FUNCTION_ROUNDOFFS = 4


class Undecided(Exception):
    """Rounding alone can turn a comparison round."""


class Interval:
    """All numbers from `low` to `high`, and the unit roundoff of the arithmetic that is watched."""

    __slots__ = ("high", "low", "unit")

    def __init__(self, low: Any, high: Any, unit: Fraction) -> None:
        self.low, self.high, self.unit = low, high, unit

    def __contains__(self, value: Any) -> bool:
        return bool(self.low <= value <= self.high)

    def meets(self, other: Interval) -> bool:
        return bool(self.low <= other.high and other.low <= self.high)

    @property
    def width(self) -> Any:
        return self.high - self.low

    def widened(self, roundoffs: int = 1) -> Interval:
        size = max(abs(self.low), abs(self.high))
        slack = size * roundoffs * self.unit.numerator / self.unit.denominator
        slack += mpmath.mpf(TINY.numerator) / TINY.denominator
        return Interval(self.low - slack, self.high + slack, self.unit)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low, self.unit)

    def __add__(self, other: Interval) -> Interval:
        return Interval(self.low + other.low, self.high + other.high, self.unit).widened()

    def __sub__(self, other: Interval) -> Interval:
        return self + -other

    def __mul__(self, other: Interval) -> Interval:
        return _corners(lambda a, b: a * b, self, other).widened()

    def __abs__(self) -> Interval:
        if self.low >= 0:
            return self
        return -self if self.high <= 0 else Interval(mpmath.mpf(0), max(-self.low, self.high), self.unit)


def interval_arithmetic(unit: Fraction) -> Arithmetic:
    """Return the arithmetic on intervals that watches one of unit roundoff `unit`."""

    def constant(value: int | Fraction | float) -> Interval:
        if isinstance(value, float):  # floats are numbers of the arithmetic
            return Interval(mpmath.mpf(value), mpmath.mpf(value), unit)
        exact = mpmath.mpf(value.numerator) / value.denominator
        return Interval(exact, exact, unit).widened()

    pi = Interval(+mpmath.pi, +mpmath.pi, unit).widened()
    return Arithmetic(constant, lambda: pi, _FUNCTIONS, mpmath.sqrt)


def interval(value: Fraction, unit: Fraction = FLOAT_UNIT) -> Interval:
    """Return the interval of one number that the arithmetic can hold."""
    exact = mpmath.mpf(value.numerator) / value.denominator
    return Interval(exact, exact, unit)


def _corners(function: Callable[..., Any], *operands: Interval) -> Interval:
    """Return the range of a function that is monotone in each operand."""
    points: list[tuple[Any, ...]] = [()]
    for operand in operands:
        points = [(*point, end) for point in points for end in (operand.low, operand.high)]
    values = [function(*point) for point in points]
    return Interval(min(values), max(values), operands[0].unit)


def _monotone(function: Callable[..., Any]) -> Callable[..., Interval]:
    return lambda *operands: _corners(function, *operands).widened(FUNCTION_ROUNDOFFS)


def _circular(function: Callable[[Any], Any]) -> Callable[[Interval], Interval]:
    """Sine and cosine change by no more than their argument."""

    def over(a: Interval) -> Interval:
        middle, radius = function((a.low + a.high) / 2), a.width / 2
        return Interval(middle - radius, middle + radius, a.unit).widened(FUNCTION_ROUNDOFFS)

    return over


def _tan(a: Interval) -> Interval:
    if mpmath.cos(a.low) * mpmath.cos(a.high) <= 0 or a.width > 1:
        raise Undecided  # a pole may lie between
    return _monotone(mpmath.tan)(a)


def _divide(a: Interval, b: Interval) -> Interval:
    if 0 in b:
        raise Undecided
    return _corners(lambda x, y: x / y, a, b).widened()


def _inside(low: float, high: float, rule: Callable[[Interval], Interval]) -> Callable[[Interval], Interval]:
    """Return `rule` for operands within its domain."""

    def over(a: Interval) -> Interval:
        if not (low <= a.low and a.high <= high):
            raise Undecided
        return rule(a)

    return over


def _power(a: Interval, b: Interval) -> Interval:
    if a.low <= 0:
        raise Undecided
    return _monotone(mpmath.power)(a, b)


def _atan2(y: Interval, x: Interval) -> Interval:
    """Monotone in each operand where the other keeps its sign, and away from the negative x axis."""
    if (0 in y and x.low <= 0) or (0 in x and 0 in y):
        raise Undecided
    if 0 in y or 0 in x:
        # d(angle) <= (dx + dy)/r; the middle of the box keeps r above half its value there.
        middle = mpmath.atan2((y.low + y.high) / 2, (x.low + x.high) / 2)
        reach = min(abs(x.low), abs(x.high)) if 0 in y else min(abs(y.low), abs(y.high))
        slack = (x.width + y.width) / reach
        return Interval(middle - slack, middle + slack, y.unit).widened(FUNCTION_ROUNDOFFS)
    return _monotone(mpmath.atan2)(y, x)


def _less(a: Interval, b: Interval) -> bool:
    if a.high < b.low or a.low > b.high:
        return bool(a.high < b.low)
    raise Undecided


def _step(function: Callable[[Any], Any]) -> Callable[[Interval], Interval]:
    def over(a: Interval) -> Interval:
        if function(a.low) != function(a.high):
            raise Undecided
        return Interval(function(a.low), function(a.low), a.unit)

    return over


def _fma(a: Interval, b: Interval, c: Interval) -> Interval:
    exact = _corners(lambda x, y: x * y, a, b)
    return Interval(exact.low + c.low, exact.high + c.high, a.unit).widened()


_FUNCTIONS: Mapping[int, Callable[..., Any]] = {
    op.NEG: lambda a: -a,
    op.ADD: lambda a, b: a + b,
    op.SUB: lambda a, b: a - b,
    op.MUL: lambda a, b: a * b,
    op.DIV: _divide,
    op.POW: _power,
    op.FMA: _fma,
    op.SIN: _circular(mpmath.sin),
    op.COS: _circular(mpmath.cos),
    op.TAN: _tan,
    op.ASIN: _inside(-1, 1, _monotone(mpmath.asin)),
    op.ACOS: _inside(-1, 1, _monotone(mpmath.acos)),
    op.ATAN: _monotone(mpmath.atan),
    op.SINH: _monotone(mpmath.sinh),
    op.COSH: lambda a: _monotone(mpmath.cosh)(abs(a)),
    op.TANH: _monotone(mpmath.tanh),
    op.EXP: _monotone(mpmath.exp),
    op.LOG: _inside(1e-300, mpmath.inf, _monotone(mpmath.log)),
    op.SQRT: _inside(0, mpmath.inf, _monotone(mpmath.sqrt)),
    op.ATAN2: _atan2,
    op.ABS: abs,
    op.MIN: lambda a, b: Interval(min(a.low, b.low), min(a.high, b.high), a.unit),
    op.MAX: lambda a, b: Interval(max(a.low, b.low), max(a.high, b.high), a.unit),
    op.SIGN: _step(mpmath.sign),
    op.FLOOR: _step(mpmath.floor),
    op.LT: _less,
    op.LE: lambda a, b: not _less(b, a),
    op.SELECT: lambda c, a, b: a if c else b,
}
