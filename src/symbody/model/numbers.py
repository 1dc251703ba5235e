"""Values of formulas: exact where the graph folds them, in floats otherwise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

from symbody.expr.graph import Constant, Graph
from symbody.expr.language.formula import Formula, build
from symbody.expr.sequences.evaluate import value_of


class _Unknown(Exception):
    """A name without value."""


def formula_value(formula: Formula, values: Mapping[str, Constant] | None = None) -> Constant | None:
    """Return the value of a formula, or None if it contains a name that has none.

    Raises ExpressionError if the formula divides by zero.

    Parameters
    ----------
    values : mapping of name to number
        Values of the parameters; ``pi`` needs none.
    """
    named = values or {}
    if formula.text in named:  # most formulas are the name of a parameter
        return named[formula.text]
    plain = formula.constant()
    if plain is not None:
        return plain
    graph = Graph()

    def node(name: str, _: object) -> int:
        if name == "pi":
            return graph.pi()
        if name not in named:
            raise _Unknown
        return graph.constant(named[name])

    try:
        root = build(formula, graph, node)
    except _Unknown:
        return None
    exact = graph.number(root)
    return value_of(graph, root) if exact is None else exact


def square_root(square: Constant) -> Constant | None:
    """Return the root of a number if it is exact, or rounded as the number itself is; else None."""
    if isinstance(square, float):
        return math.sqrt(square)
    exact = Fraction(square)
    top, bottom = math.isqrt(exact.numerator), math.isqrt(exact.denominator)
    return Fraction(top, bottom) if Fraction(top * top, bottom * bottom) == exact else None


def as_float(value: Constant) -> float:
    """Return a number as float, infinite where it is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.copysign(math.inf, value)
