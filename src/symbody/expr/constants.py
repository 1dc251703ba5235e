"""Arithmetic on the constants of the graph: exact stays exact while it stays small.

Rounded constants are combined only with each other or with an exact one directly beside them;
each function returns None where folding would lose exactness, overflow or leave the reals.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Final

from symbody.expr.graph import Constant
from symbody.expr.opcodes import (
    ABS,
    ACOS,
    ASIN,
    ATAN,
    ATAN2,
    COS,
    COSH,
    EXP,
    FLOOR,
    LOG,
    POW,
    SIGN,
    SIN,
    SINH,
    SQRT,
    TAN,
    TANH,
)  # fmt: skip

# Exact results beyond this many bits stay unfolded, so that no input can make numbers explode.
_BITS: Final = 512

_FLOAT_FUNCTIONS: Final[dict[int, Callable[..., float]]] = {
    SIN: math.sin, COS: math.cos, TAN: math.tan, ASIN: math.asin, ACOS: math.acos, ATAN: math.atan,
    SINH: math.sinh, COSH: math.cosh, TANH: math.tanh, EXP: math.exp, LOG: math.log, SQRT: math.sqrt,
    ATAN2: math.atan2, POW: math.pow,
}  # fmt: skip

# Functions whose value at one exact argument is exact: (argument, value).
_EXACT_POINTS: Final = {
    SIN: (0, 0), COS: (0, 1), TAN: (0, 0), ASIN: (0, 0), ACOS: (1, 0), ATAN: (0, 0), SINH: (0, 0),
    COSH: (0, 1), TANH: (0, 0), EXP: (0, 1), LOG: (1, 0),
}  # fmt: skip


def fold_sum(x: Constant, y: Constant) -> Constant | None:
    """Return ``x + y``, or None."""
    return _float_value(operator.add, x, y) if _any_float(x, y) else _exact_or_none(x + y)


def fold_product(x: Constant, y: Constant) -> Constant | None:
    """Return ``x * y``, or None."""
    return _float_value(operator.mul, x, y) if _any_float(x, y) else _exact_or_none(x * y)


def fold_quotient(x: Constant, y: Constant) -> Constant | None:
    """Return ``x / y``, or None."""
    return (
        _float_value(operator.truediv, x, y)
        if _any_float(x, y)
        else _exact_or_none(Fraction(x) / Fraction(y))
    )


def fold_power(x: Constant, n: int) -> Constant | None:
    """Return ``x ** n`` for ``n > 0``, or None."""
    if isinstance(x, float):
        return _float_value(math.pow, x, n)
    size = max(x.numerator.bit_length(), x.denominator.bit_length())
    return _exact_or_none(x**n) if size * n <= 2 * _BITS else None


def fold_function(op: int, *values: Constant) -> Constant | None:
    """Return a function of constants where the result is exact, or where an argument is rounded."""
    if op in (ABS, SIGN, FLOOR):
        x = values[0]
        if op == ABS:
            return -x if x < 0 else x
        return int(x > 0) - int(x < 0) if op == SIGN else math.floor(x)
    if _any_float(*values):
        function = _FLOAT_FUNCTIONS.get(op)
        return None if function is None else _float_value(function, *values)
    if op == SQRT:
        return _exact_root(Fraction(values[0]))
    point = _EXACT_POINTS.get(op)
    return point[1] if point is not None and values[0] == point[0] else None


def _exact_root(x: Fraction) -> Constant | None:
    if x < 0:
        return None
    top, bottom = math.isqrt(x.numerator), math.isqrt(x.denominator)
    return _exact_or_none(Fraction(top, bottom)) if Fraction(top * top, bottom * bottom) == x else None


def _any_float(*values: Constant) -> bool:
    return any(isinstance(value, float) for value in values)


def _exact_or_none(x: int | Fraction | float) -> Constant | None:
    if isinstance(x, float) or max(x.numerator.bit_length(), x.denominator.bit_length()) > _BITS:
        return None
    return x.numerator if x.denominator == 1 else x


def _float_value(function: Callable[..., float], *values: Constant) -> float | None:
    try:
        result = function(*map(float, values))
    except (ArithmeticError, ValueError):  # overflow, pole, or outside the domain
        return None
    return result if math.isfinite(result) else None
