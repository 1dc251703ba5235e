"""Numbers as they are written, and the arithmetic on them by which the parser looks ahead."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from fractions import Fraction
from types import MappingProxyType
from typing import Final

from symbody.expr.constants import fold_power, fold_product, fold_quotient, fold_sum
from symbody.expr.graph import Constant

EXACT_DIGITS: Final = 15
MAX_DIGITS: Final = 400
MAX_EXPONENT: Final = 64


def read_number(text: str) -> Constant:
    """Return the value of an unsigned decimal numeral.

    Integers, and decimals of up to 15 significant digits, are exact; decimals written with more
    are the nearest double. Fifteen digits are what every double gives back unchanged.

    Raises
    ------
    OverflowError
        If the numeral is too long, or its value as a double is infinite or zero.
    """
    mantissa, _, exponent = text.lower().partition("e")
    whole, _, decimals = mantissa.partition(".")
    digits = (whole + decimals).lstrip("0")
    longest = max(len(whole) + len(decimals), len(exponent))
    if longest > MAX_DIGITS:
        raise OverflowError(f"the number is written with {longest} digits; the limit is {MAX_DIGITS}")
    if not digits:
        return 0
    rounded = float(text)
    if math.isinf(rounded):
        raise OverflowError("the number exceeds 1.797e308, the largest number that can be represented")
    if rounded == 0.0:
        raise OverflowError("the number is below 4.9e-324, the smallest number that can be represented")
    if text.isdigit():
        return int(text)
    if len(digits) > EXACT_DIGITS:
        return rounded
    scale = int(exponent or "0") - len(decimals)
    exact = Fraction(int(digits) * 10 ** max(scale, 0), 10 ** max(-scale, 0))
    return exact.numerator if exact.denominator == 1 else exact


def fold(name: str, *values: Constant) -> Constant | None:
    """Return the value of an operation on numbers, exact while it is short; None if not followed.

    Raises
    ------
    ZeroDivisionError
        At a division by zero.
    OverflowError
        If the result is not a finite double.
    ValueError
        Where the operation has no real value.
    """
    operation = _OPERATIONS.get(name)
    if operation is None:
        return None
    result = operation(*values)
    if math.isinf(float(result)):
        raise OverflowError(name)
    return result


def _sum(x: Constant, y: Constant) -> Constant:
    exact = fold_sum(x, y)
    return float(x) + float(y) if exact is None else exact


def _difference(x: Constant, y: Constant) -> Constant:
    return _sum(x, -y)


def _product(x: Constant, y: Constant) -> Constant:
    exact = fold_product(x, y)
    return float(x) * float(y) if exact is None else exact


def _quotient(x: Constant, y: Constant) -> Constant:
    exact = fold_quotient(x, y) if y else None
    return float(x) / float(y) if exact is None else exact


def _remainder(x: Constant, y: Constant) -> Constant:
    return _difference(x, _product(y, math.floor(_quotient(x, y))))


def _power(x: Constant, y: Constant) -> Constant:
    if x == 0 and y < 0:
        raise ZeroDivisionError
    if isinstance(y, int) and 0 < abs(y) <= MAX_EXPONENT:
        exact = fold_power(x, abs(y))
        if exact is not None:
            return exact if y > 0 else _quotient(1, exact)
    return math.pow(x, y)


def _sign(x: Constant) -> int:
    return (x > 0) - (x < 0)


_OPERATIONS: Final = MappingProxyType[str, Callable[..., Constant]](
    {
        "add": _sum, "sub": _difference, "mul": _product, "div": _quotient, "power": _power,
        "neg": operator.neg, "pos": operator.pos, "abs": abs, "sign": _sign, "floor": math.floor,
        "mod": _remainder, "min": min, "max": max, "sin": math.sin, "cos": math.cos, "tan": math.tan,
        "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2, "sinh": math.sinh,
        "cosh": math.cosh, "tanh": math.tanh, "exp": math.exp, "log": math.log, "sqrt": math.sqrt,
        "lt": operator.lt, "le": operator.le, "gt": operator.gt, "ge": operator.ge, "eq": operator.eq,
        "ne": operator.ne, "not": operator.not_, "and": operator.and_, "or": operator.or_,
    }
)  # fmt: skip
