"""Directions and simple rotations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.door import ZERO, Door
from symbody.model.numbers import square_root, value_of
from symbody.model.uses import Triple

# "x", "y", "z", or components along x, y and z, of any length.
Axis = str | Triple

ONE: Final = Formula.of(1)
LETTERS: Final[dict[str, Triple]] = {
    "x": (ONE, ZERO, ZERO),
    "y": (ZERO, ONE, ZERO),
    "z": (ZERO, ZERO, ONE),
}


@dataclass(frozen=True, slots=True)
class Turn:
    """One simple rotation from a frame to the next.

    Attributes
    ----------
    axis : (3,) Formula
        Unit vector; it has the same components in both frames.
    angle : Formula
        Angle [rad], right-handed about `axis`.
    """

    axis: Triple
    angle: Formula


def axis_from(door: Door, value: object, path: str) -> Axis:
    """Return an axis from a letter or three components."""
    if isinstance(value, str):
        if value in LETTERS:
            return value
        door.refuse(
            "model.axis_letter",
            path,
            f"{value!r} is not an axis",
            "",
            'write "x", "y", "z", or three components such as ["0", "0", "-1"]',
        )
        return "x"
    return door.triple(value, path)


def unit_axis(axis: Axis) -> Triple:
    """Return the unit vector of an axis.

    Letters and vectors whose length is a rational number give exact components; other numbers are
    divided by the root of the exact square sum, formulas by the formula of their length.
    """
    if isinstance(axis, str):
        return LETTERS[axis]
    values = [value_of(component) for component in axis]
    numbers = [value for value in values if value is not None]
    if len(numbers) < 3:
        return _divided(axis, [c for c, value in zip(axis, values, strict=True) if value != 0])
    square = sum(value * value for value in numbers)
    length = square_root(square)
    if not square or length == 1:
        return axis
    if length is not None:
        x, y, z = (Formula.of(value / length) for value in numbers)
        return (x, y, z)
    return _divided(axis, [Formula.of(square)], squared=True)


def _divided(axis: Triple, terms: list[Formula], *, squared: bool = False) -> Triple:
    """Return the axis divided by the root of the sum of `terms`, or of their squares."""
    exponent = "" if squared else "**2"
    length = " + ".join(f"({term.text}){exponent}" for term in terms)
    x, y, z = (_quotient(component, length) for component in axis)
    return (x, y, z)


def _quotient(component: Formula, length: str) -> Formula:
    return ZERO if component.constant() == 0 else Formula.of(f"({component.text})/sqrt({length})")
