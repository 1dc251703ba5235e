"""Interval arithmetic: bounds of what a sequence gives for all values of its inputs between limits.

Moore, Kearfott & Cloud, Introduction to Interval Analysis (2009), chapters 2 and 5. Every result is widened
by some roundings of itself, so that the bounds hold for exact numbers. Functions without a rule here may give
anything.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from fractions import Fraction
from typing import Final

from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import Arithmetic
from symbody.expr.sequences.sequence import Sequence

_ROUNDINGS: Final = 4 * sys.float_info.epsilon  # functions of the C library are within two
# Operations with operands or results of their own, which have no rule.
_OPAQUE: Final = frozenset({op.CALL, op.SADDLE, op.PICK, op.MAP})


class Interval:
    """All numbers from `low` to `high`."""

    __slots__ = ("high", "low")

    def __init__(self, low: float, high: float) -> None:
        self.low = -math.inf if low != low else low
        self.high = math.inf if high != high else high

    def __add__(self, other: Interval) -> Interval:
        return _widen(self.low + other.low, self.high + other.high)

    def __mul__(self, other: Interval) -> Interval:
        if other is self:  # a square
            square = [self.low * self.low, self.high * self.high]
            return _widen(0.0 if self.low <= 0.0 <= self.high else min(square), max(square))
        corners = [
            0.0 if a == 0.0 or b == 0.0 else a * b
            for a in (self.low, self.high)
            for b in (other.low, other.high)
        ]
        return _widen(min(corners), max(corners))

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)


WHOLE: Final = Interval(-math.inf, math.inf)


def interval(value: float | Fraction) -> Interval:
    """Return the interval of one number."""
    return _widen(float(value), float(value))


def can_bound(sequence: Sequence) -> bool:
    """Return whether a sequence has operations on numbers alone."""
    return not any(operation.op in _OPAQUE for operation in sequence.operations)


def _widen(low: float, high: float) -> Interval:
    return Interval(low - _ROUNDINGS * abs(low), high + _ROUNDINGS * abs(high))


def _divide(a: Interval, b: Interval) -> Interval:
    if b.low <= 0.0 <= b.high:
        return WHOLE
    return a * _widen(1.0 / b.high, 1.0 / b.low)


def _sin(a: Interval) -> Interval:
    return _wave(a, math.pi / 2.0, math.sin)


def _cos(a: Interval) -> Interval:
    return _wave(a, 0.0, math.cos)


def _wave(a: Interval, peak: float, function: Callable[[float], float]) -> Interval:
    """Return the bounds of a wave with a maximum at `peak` and a minimum half a turn on."""
    if not a.high - a.low < 2.0 * math.pi:
        return Interval(-1.0, 1.0)
    ends = function(a.low), function(a.high)
    # The argument is known to a rounding of itself.
    slack = _ROUNDINGS * (1.0 + max(abs(a.low), abs(a.high)))

    def holds(place: float) -> bool:
        turns = math.ceil((a.low - slack - place) / (2.0 * math.pi))
        return place + 2.0 * math.pi * turns <= a.high + slack

    low = -1.0 if holds(peak + math.pi) else min(ends) - slack
    high = 1.0 if holds(peak) else max(ends) + slack
    return Interval(max(low, -1.0), min(high, 1.0))


def _sqrt(a: Interval) -> Interval:
    """Return the roots of the numbers that have one."""
    return _widen(math.sqrt(max(a.low, 0.0)), math.sqrt(max(a.high, 0.0)))


def _abs(a: Interval) -> Interval:
    least = 0.0 if a.low <= 0.0 <= a.high else min(abs(a.low), abs(a.high))
    return Interval(least, max(abs(a.low), abs(a.high)))


def _any(*operands: Interval) -> Interval:
    return WHOLE


INTERVALS: Final = Arithmetic(
    constant=interval,
    pi=lambda: _widen(math.pi, math.pi),
    functions=dict.fromkeys(range(len(op.NAMES)), _any)
    | {
        op.NEG: lambda a: -a,
        op.ADD: lambda a, b: a + b,
        op.SUB: lambda a, b: a + -b,
        op.MUL: lambda a, b: a * b,
        op.DIV: _divide,
        op.FMA: lambda a, b, c: a * b + c,
        op.SIN: _sin,
        op.COS: _cos,
        op.SQRT: _sqrt,
        op.ABS: _abs,
    },
    sqrt=_sqrt,
)
