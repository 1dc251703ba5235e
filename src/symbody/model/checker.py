"""`Checker`: formulas of a model as numbers, for checks that need values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from symbody.errors import ExpressionError, Problem
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.model.numbers import as_float, value_of


class Checker:
    """Values of formulas under given parameters; collects what is wrong and what is merely unusual.

    Parameters
    ----------
    parameters : mapping of name to number
        Those that have a value; a formula that needs another is not judged.
    """

    __slots__ = ("notes", "parameters", "problems")

    def __init__(self, parameters: Mapping[str, Constant]) -> None:
        self.parameters = parameters
        self.problems: list[Problem] = []
        self.notes: list[str] = []

    def value(self, formula: Formula, where: str) -> float | None:
        """Return the value of a formula, or None if it has none or one that is not finite."""
        try:
            value = value_of(formula, self.parameters)
        except ExpressionError as error:
            self.problems.extend(Problem(p.code, where, p.what, p.why, p.fix) for p in error.problems)
            return None
        if value is None:
            return None
        if math.isfinite(as_float(value)):
            return as_float(value)
        self.refuse(
            "model.not_finite",
            where,
            f"{formula} is {as_float(value)} with the values given",
            "a function has no real value there, or the result is too large",
            "change the values",
        )
        return None

    def values(self, formulas: Iterable[Formula], where: str) -> list[float] | None:
        """Return several values, or None if one is missing."""
        found = [self.value(formula, f"{where}[{k}]") for k, formula in enumerate(formulas)]
        numbers = [value for value in found if value is not None]
        return numbers if len(numbers) == len(found) else None

    def refuse(self, code: str, where: str, what: str, why: str, fix: str) -> None:
        """Note an error."""
        self.problems.append(Problem(code, where, what, why, fix))

    def remark(self, text: str) -> None:
        """Note something legal but unusual."""
        self.notes.append(text)
