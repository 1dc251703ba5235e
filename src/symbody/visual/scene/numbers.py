"""Numbers of a model: every formula that a picture needs, whatever of the model has a value."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from symbody.errors import ExpressionError, nearest
from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.language.formula import Formula, build
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.model import Model
from symbody.model.numbers import as_float, formula_value
from symbody.model.parameters import dependence_order
from symbody.model.simple_rotation import LETTERS, Axis
from symbody.visual.scene.scene import Floats

# Quantities without a value are drawn as if they had this one.
ASSUMED: Final = 1
# Pictures are made of numbers in single precision, and squares of them are formed.
_LARGEST: Final = 1e30


@dataclass(frozen=True, slots=True)
class ModelNumbers:
    """Values of the parameters of a model at the time 0.

    Attributes
    ----------
    values : mapping of name to number
        All parameters; those without a value are `ASSUMED`.
    assumed : tuple of str
        The parameters that have none.
    """

    values: Mapping[str, Constant]
    assumed: tuple[str, ...]
    # Values of formulas in parameters alone: hundreds of places of a large model hold the same few.
    _kept: dict[tuple[str, float], float] = field(default_factory=dict, repr=False, compare=False)

    def number(self, formula: Formula, default: float = 0.0, /, **names: float) -> float:
        """Return the value of a formula, or `default` where it has none that can be drawn.

        Parameters
        ----------
        **names : float
            Values of what the formula may contain beside parameters.
        """
        if names and not names.keys().isdisjoint(formula.names):
            return self._value(formula, default, {**self.values, **names})
        kept = self._kept.get((formula.text, default))
        if kept is None:
            kept = self._kept[formula.text, default] = self._value(formula, default, self.values)
        return kept

    def _value(self, formula: Formula, default: float, values: Mapping[str, Constant]) -> float:
        try:
            value = formula_value(formula, values)
        except ExpressionError:
            return default
        number = default if value is None else as_float(value)
        if not abs(number) < _LARGEST:  # or not a number
            return default
        return number if abs(number) > 1.0 / _LARGEST else 0.0

    def vector(self, formulas: Iterable[Formula], **names: float) -> Floats:
        """Return the values of several formulas, 0 where one has none."""
        return np.array([self.number(formula, 0.0, **names) for formula in formulas])

    def axis(self, axis: Axis) -> Floats:
        """Return a unit vector (3,); along z where the axis has no direction."""
        vector = self.vector(LETTERS[axis] if isinstance(axis, str) else axis)
        return unit(vector)

    def samples(self, formulas: Iterable[Formula], names: tuple[str, ...], points: Floats) -> Floats:
        """Return the values (N, K) of K formulas where some names have the values `points` (N, n)."""
        graph = Graph()
        symbols: dict[str, int] = {}

        def node(name: str, _: object) -> int:
            if name == "pi":
                return graph.pi()
            if name in names:
                return symbols.setdefault(name, graph.symbol(Symbol(name)))
            return graph.constant(self.values.get(name, 0))

        roots = [build(formula, graph, node) for formula in formulas]
        inputs = {symbols[name]: Input(name, "p", k) for k, name in enumerate(names) if name in symbols}
        sequence = build_sequence(graph, [Roots("values", (len(roots),), tuple(roots))], inputs)
        return np.array([evaluate_sequence(sequence, {"p": point})[0] for point in points.tolist()])


def model_numbers(model: Model, parameters: Mapping[str, Value]) -> ModelNumbers:
    """Return the values of the parameters of a model.

    Parameters
    ----------
    parameters : mapping of name to number or formula
        Take the place of the model's values.

    Raises
    ------
    ModelError
        With all names that are not parameters, values that are not formulas, and formulas that depend on
        each other in a circle.
    """
    arguments = Arguments("parameters")
    changed: dict[str, Formula | None] = dict(model.parameters)
    for name, value in parameters.items():
        if name in changed:
            changed[name] = arguments.formula(value, name)
        else:
            arguments.add(
                "parameters.unknown", name, f"the model has no parameter {name!r}", "",
                nearest(name, model.parameters),
            )  # fmt: skip
    arguments.raise_all()
    values: dict[str, Constant] = {"t": 0}
    assumed = []
    for name in dependence_order(changed):
        number = _value(changed[name], values)
        if number is None:
            assumed.append(name)
        values[name] = ASSUMED if number is None else number
    return ModelNumbers(values, tuple(assumed))


def unit(vector: Floats) -> Floats:
    """Return a vector (3,) of length 1; along z if it has none."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 and math.isfinite(length) else np.array([0.0, 0.0, 1.0])


def _value(formula: Formula | None, values: Mapping[str, Constant]) -> Constant | None:
    """Return the finite value of a parameter's formula, or None."""
    try:
        value = None if formula is None else formula_value(formula, values)
    except ExpressionError:
        return None
    return value if value is None or math.isfinite(as_float(value)) else None
