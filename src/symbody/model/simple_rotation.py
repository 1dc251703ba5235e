"""Directions and simple rotations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from symbody.expr.graph import Graph, Symbol
from symbody.expr.language.formula import Formula, build
from symbody.expr.trigonometry.normal_form import trigonometric_form
from symbody.model.declarations.arguments import ZERO, Arguments
from symbody.model.declarations.formula_site import Triple
from symbody.model.numbers import formula_value, square_root

# "x", "y", "z", or components along x, y and z, of any length.
Axis = str | Triple

ONE: Final = Formula.from_value(1)
LETTERS: Final[dict[str, Triple]] = {
    "x": (ONE, ZERO, ZERO),
    "y": (ZERO, ONE, ZERO),
    "z": (ZERO, ZERO, ONE),
}

# Axes typed with 9 digits pass.
_PERPENDICULAR: Final = 1e-8


@dataclass(frozen=True, slots=True)
class SimpleRotation:
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


def read_axis(arguments: Arguments, value: object, path: str) -> Axis:
    """Return an axis from a letter or three components."""
    if isinstance(value, str):
        if value in LETTERS:
            return value
        arguments.add("model.axis_letter", path, f"{value!r} is not an axis", "", _axis_cure(value))
        return "x"
    return arguments.triple(value, path)


def _axis_cure(text: str) -> str:
    """Return what to write; for an axis with a minus its components."""
    letter = text.replace(" ", "").lower().removeprefix("-")
    if letter in LETTERS and "-" in text:
        components = ", ".join('"-1"' if each == letter else '"0"' for each in "xyz")
        return f"write three components, [{components}]"
    return 'write "x", "y", "z", or three components such as ["0", "0", "-1"]'


def unit_axis(axis: Axis) -> Triple:
    """Return the unit vector of an axis.

    Letters and vectors whose length is a rational number give exact components; other numbers are
    divided by the root of the exact square sum, formulas by the formula of their length unless it is 1.
    """
    if isinstance(axis, str):
        return LETTERS[axis]
    values = [formula_value(component) for component in axis]
    numbers = [value for value in values if value is not None]
    if len(numbers) < 3:
        return _divide(axis, [c for c, value in zip(axis, values, strict=True) if value != 0])
    square = sum(value * value for value in numbers)
    length = square_root(square)
    if not square or length == 1:
        return axis
    if length is not None:
        x, y, z = (Formula.from_value(value / length) for value in numbers)
        return (x, y, z)
    return _divide(axis, [Formula.from_value(square)], squared=True)


def _divide(axis: Triple, terms: list[Formula], *, squared: bool = False) -> Triple:
    """Return the axis divided by the root of the sum of `terms`, or of their squares."""
    exponent = "" if squared else "**2"
    length = " + ".join(f"({term.text}){exponent}" for term in terms)
    if not squared and _is_one(Formula.from_value(length)):
        return axis
    x, y, z = (_quotient(component, length) for component in axis)
    return (x, y, z)


def _is_one(formula: Formula) -> bool:
    """Return whether a formula is 1 whatever its names stand for, as ``sin(a)**2 + cos(a)**2``."""
    graph = Graph()
    node = build(formula, graph, lambda name, _: graph.pi() if name == "pi" else graph.symbol(Symbol(name)))
    (shown,) = trigonometric_form(graph, [node])
    return graph.number(shown) == 1


def _quotient(component: Formula, length: str) -> Formula:
    return ZERO if component.constant() == 0 else Formula.from_value(f"({component.text})/sqrt({length})")


def shift_along(axis: Axis, displacement: str) -> Triple:
    """Return a unit vector times a displacement, short where a component is 0 or 1."""
    x, y, z = (_product(component, displacement) for component in unit_axis(axis))
    return (x, y, z)


def in_plane(normal: str, first: Formula, second: Formula) -> Triple:
    """Return components along the two axes that follow the normal in cyclic order."""
    return {"x": (ZERO, first, second), "y": (second, ZERO, first), "z": (first, second, ZERO)}[normal]


def not_perpendicular(first: Sequence[float], second: Sequence[float]) -> tuple[str, str, str] | None:
    """Return what, why and fix for two axes that are not perpendicular; None if they are, or one is zero."""
    lengths = math.hypot(*first) * math.hypot(*second)
    if lengths == 0:
        return None
    cosine = sum(a * b for a, b in zip(first, second, strict=True)) / lengths
    if not math.isfinite(cosine) or abs(cosine) <= _PERPENDICULAR:
        return None
    angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    return (
        f"the angle between the axes is {angle:.6g} deg",
        "this joint needs perpendicular axes",
        'make it 90 deg, for instance with ["x", "y"]; typed decimals must be accurate to nine digits',
    )


def _product(component: Formula, displacement: str) -> Formula:
    if component.text in ("0", "1"):
        return Formula.from_value(displacement) if component.text == "1" else ZERO
    return Formula.from_value(f"({component.text})*{displacement}")
