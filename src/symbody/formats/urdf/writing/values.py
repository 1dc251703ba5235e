"""Formulas of a model as numbers, for a file that has no formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.formats.urdf.file.placement import numeral
from symbody.model.declarations.arguments import Value
from symbody.model.model import Model, resolve_parameters
from symbody.model.numbers import as_float, formula_value


@dataclass(frozen=True, slots=True)
class Values:
    """The values of the parameters of a model."""

    known: Mapping[str, Constant]

    @classmethod
    def from_model(cls, model: Model, parameters: Mapping[str, Value]) -> Values:
        """Return the values of all parameters.

        Raises
        ------
        ModelError
            Listing all that have none.
        """
        return cls(resolve_parameters(model, parameters))

    def number(self, formula: Formula) -> float:
        """Return the value of a formula in parameters."""
        value = formula_value(formula, self.known)
        if value is None:
            raise AssertionError(f"{formula} has names that are not parameters")
        return as_float(value)

    def is_known(self, formula: Formula) -> bool:
        """Return whether a formula contains parameters alone."""
        return formula_value(formula, self.known) is not None

    def text(self, formula: Formula) -> str:
        """Return the value of a formula as text."""
        return numeral(self.number(formula))
