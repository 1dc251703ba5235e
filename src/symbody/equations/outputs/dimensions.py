"""Units of expressions, from the units of the names in them; none where a doubt is left.

A number is taken for a plain factor if it is as small as those of textbooks, such as 2 or 1/2: others may be
masses, or change the unit. An angle counts as a unit of its own, so that torques and energies differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from fractions import Fraction
from typing import Final

from symbody.errors import ExpressionError
from symbody.expr.language.formula import Formula
from symbody.expr.language.instructions import COMPARISONS, CONNECTIVES
from symbody.expr.language.literals import fold


@dataclass(frozen=True, slots=True)
class Dimension:
    """Exponents of the base units."""

    kg: Fraction = Fraction(0)
    m: Fraction = Fraction(0)
    s: Fraction = Fraction(0)
    rad: Fraction = Fraction(0)

    def __mul__(self, other: Dimension) -> Dimension:
        """Return the dimension of a product."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return Dimension(*(a + b for a, b in pairs))

    def __pow__(self, exponent: Fraction) -> Dimension:
        """Return the dimension of a power."""
        return Dimension(*(a * exponent for a in astuple(self)))

    @property
    def without_angle(self) -> Dimension:
        """The dimension if angles are plain numbers."""
        return replace(self, rad=Fraction(0))


def _dimension(kg: int = 0, m: int = 0, s: int = 0, rad: int = 0) -> Dimension:
    return Dimension(*map(Fraction, (kg, m, s, rad)))


PURE: Final = Dimension()
_UNITS: Final[Mapping[str, Dimension]] = {
    "kg": _dimension(1), "m": _dimension(0, 1), "s": _dimension(0, 0, 1), "rad": _dimension(0, 0, 0, 1),
    "N": _dimension(1, 1, -2), "J": _dimension(1, 2, -2), "W": _dimension(1, 2, -3),
}  # fmt: skip
# Shown by a name of its own; all others by base units.
_NAMES: Final[Mapping[Dimension, str]] = {
    _dimension(1, 1, -2): "N", _dimension(1, 2, -2): "J", _dimension(1, 2, -3): "W",
    _dimension(1, 0, -2): "N/m", _dimension(1, 0, -1): "N s/m",
}  # fmt: skip
_ENERGY: Final = _dimension(1, 2, -2)
# Factors that change the unit and cannot be taken for anything else.
_CONVERTED: Final = (("rad", 180 / math.pi, "deg"), ("rad/s", 180 / math.pi, "deg/s"),
                     ("rad/s", 30 / math.pi, "1/min"))  # fmt: skip
_ALIKE: Final = frozenset({"add", "sub", "min", "max", "mod"})  # operands and result of one unit
_INVERSE: Final = frozenset({"asin", "acos", "atan", "atan2"})  # give angles
_OF_NUMBERS: Final = frozenset("sin cos tan sinh cosh tanh exp log asin acos atan".split())
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True)
class _Quantity:
    """A dimension and the factor in front; literals are numbers as they were written, of any dimension."""

    dimension: Dimension
    factor: float = 1.0
    is_literal: bool = False
    unit: str = ""  # as it was given, where nothing has changed it

    @property
    def is_plain(self) -> bool:
        """Whether the factor is one of those that formulas have."""
        share = Fraction(self.factor).limit_denominator(12) if math.isfinite(self.factor) else Fraction(0)
        is_small = abs(share.numerator) <= 4 and share.denominator <= 4
        is_near = abs(float(share) - self.factor) <= _ROUNDING
        return self.factor != 0.0 and is_near and (is_small or abs(share) == Fraction(1, 12))


def expression_unit(text: str, unit_of: Callable[[str], str | None]) -> str | None:
    """Return the unit of an expression, ``""`` for a pure number; None if it does not follow.

    Parameters
    ----------
    unit_of : callable
        Takes the name of a symbol or output, returns its unit or None.
    """
    try:
        value = _evaluate(Formula.from_value(text, has_outputs=True), unit_of)
    except (ExpressionError, ArithmeticError, ValueError):
        return None
    if value is None or value.is_literal:
        return None
    unit = unit_text(value)
    if value.is_plain:
        return unit
    near = (new for old, factor, new in _CONVERTED if old == unit and math.isclose(value.factor, factor))
    return next(near, None)


def _evaluate(formula: Formula, unit_of: Callable[[str], str | None]) -> _Quantity | None:
    stack: list[_Quantity | None] = []
    for step in formula.program:
        if not isinstance(step.payload, str):
            stack.append(_Quantity(PURE, float(step.payload), is_literal=True))
        elif step.kind == "apply":
            operands = stack[-step.arity :]
            del stack[-step.arity :]
            stack.append(_apply(step.payload, operands))
        else:
            stack.append(_named_quantity(step.payload, unit_of))
    return stack[0]


def _named_quantity(name: str, unit_of: Callable[[str], str | None]) -> _Quantity | None:
    if name == "pi":
        return _Quantity(PURE, math.pi, is_literal=True)
    unit = unit_of(name)
    dimension = None if unit is None else read_unit(unit)
    return None if dimension is None else _Quantity(dimension, unit=unit or "")


def _apply(name: str, given: Sequence[_Quantity | None]) -> _Quantity | None:
    if name == "if":
        return _alike(given[1:])
    if name in COMPARISONS or name in CONNECTIVES:
        return None  # the condition of an if, which has no unit
    values = [value for value in given if value is not None]
    if len(values) < len(given):
        return None
    if all(value.is_literal for value in values):
        number = fold(name, *(value.factor for value in values))
        return None if number is None else _Quantity(PURE, float(number), is_literal=True)
    return _function_quantity(name, values)


def _function_quantity(name: str, values: Sequence[_Quantity]) -> _Quantity | None:
    first = values[0]
    if name in ("neg", "abs"):
        return first
    if name in _ALIKE:
        return _alike(values)
    if name in ("mul", "div"):
        return _product(first, values[1], -1 if name == "div" else 1)
    if name == "sqrt":
        return _power(first, Fraction(1, 2))
    if name == "power":
        exponent = values[1]
        is_exact = exponent.is_literal and float(exponent.factor * 12).is_integer()
        return _power(first, Fraction(exponent.factor)) if is_exact else None
    return _function(name, values)


def _function(name: str, values: Sequence[_Quantity]) -> _Quantity | None:
    is_number = all(value.dimension.without_angle == PURE for value in values)
    if name == "sign":
        return _Quantity(PURE)
    if name in ("atan2", "smoothstep"):
        if _alike(values) is None:
            return None
    elif name not in _OF_NUMBERS or not is_number:
        return None
    return _Quantity(_UNITS["rad"], unit="rad") if name in _INVERSE else _Quantity(PURE)


def _alike(given: Sequence[_Quantity | None]) -> _Quantity | None:
    """Return what has the unit of all operands; literals have any."""
    values = [value for value in given if value is not None]
    if len(values) < len(given):
        return None
    real = [value for value in values if not value.is_literal]
    if not real:
        return values[0]
    first = max(real, key=lambda value: value.dimension.rad % 2 != 0)  # a torque among products
    if any(value.dimension.without_angle != first.dimension.without_angle for value in real):
        return None
    is_angular = replace(first.dimension.without_angle, s=Fraction(0)) == PURE
    if is_angular and any(value.dimension.rad != first.dimension.rad for value in real):
        return None
    unit = first.unit if all(value.unit == first.unit for value in real) else ""
    if all(value.is_plain for value in real):
        return replace(first, factor=1.0, unit=unit)
    same = all(math.isclose(value.factor, first.factor) for value in real)
    return replace(first, unit=unit) if same else None


def _product(a: _Quantity, b: _Quantity, sign: int) -> _Quantity:
    dimension = a.dimension * b.dimension ** Fraction(sign)
    factor = a.factor * b.factor**sign
    unit = b.unit if a.is_literal and sign > 0 else a.unit if b.is_literal else ""
    lever = sign > 0 and {a.unit, b.unit} == {"N", "m"}  # as good as work, but never wrong
    return _Quantity(dimension, factor, unit="N m" if lever else unit)


def _power(value: _Quantity, exponent: Fraction) -> _Quantity | None:
    if value.is_literal or value.factor < 0 and exponent.denominator != 1:
        return None
    return _Quantity(value.dimension**exponent, value.factor ** float(exponent))


def read_unit(unit: str) -> Dimension | None:
    """Return the dimension of a unit such as ``"N m/rad"``; None if a word in it is unknown."""
    total = PURE
    above, *below = unit.split("/")
    words = [(word, 1) for word in above.split()] + [(word, -1) for part in below for word in part.split()]
    for word, sign in words:
        base, _, exponent = word.partition("^")
        if base not in _UNITS or not (exponent or "1").isdigit():
            if word == "1":
                continue
            return None
        total = total * _UNITS[base] ** Fraction(sign * int(exponent or 1))
    is_torque = {"N", "m"} <= set(above.split())  # an energy would be in joules
    return total * _UNITS["rad"] ** Fraction(-1) if is_torque else total


def unit_text(value: _Quantity) -> str:
    """Return the unit of a quantity, ``""`` of a pure number."""
    if value.unit:
        return value.unit
    dimension = value.dimension
    if dimension.without_angle == _ENERGY and dimension.rad % 2:
        return "N m"
    if dimension.kg or dimension.m:
        dimension = dimension.without_angle
    if dimension in _NAMES:
        return _NAMES[dimension]
    words = [(name, exponent) for name, exponent in asdict(dimension).items() if exponent]
    above = [_word(name, exponent) for name, exponent in words if exponent > 0]
    below = [_word(name, -exponent) for name, exponent in words if exponent < 0]
    if not below:
        return " ".join(above)
    text = " ".join(below)
    return f"{' '.join(above) or '1'}/{text if len(below) == 1 else f'({text})'}"


def _word(name: str, exponent: Fraction) -> str:
    if exponent == 1:
        return name
    return f"{name}^{exponent}" if exponent.denominator == 1 else f"{name}^({exponent})"
