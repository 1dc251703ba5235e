"""`NumericChecks`: formulas of a model as numbers, for checks that need values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from symbody.errors import ExpressionError, Problem
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.model.numbers import as_float, formula_value

_UNIT: Final = 1e-9


class NumericChecks:
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
            value = formula_value(formula, self.parameters)
        except ExpressionError as error:
            self.problems.extend(Problem(p.code, where, p.what, p.why, p.fix) for p in error.problems)
            return None
        if value is None:
            return None
        if math.isfinite(as_float(value)):
            return as_float(value)
        what = f"{formula} is {as_float(value)} with the given values"
        why = "a function has no real value there, or the result is too large"
        self.refuse("model.not_finite", where, what, why, "change the values")
        return None

    def values(self, formulas: Iterable[Formula], where: str) -> list[float] | None:
        """Return several values, or None if one is missing."""
        found = [self.value(formula, f"{where}[{k}]") for k, formula in enumerate(formulas)]
        numbers = [value for value in found if value is not None]
        return numbers if len(numbers) == len(found) else None

    def refuse(self, code: str, where: str, what: str, why: str, fix: str) -> None:
        """Note an error."""
        self.problems.append(Problem(code, where, what, why, fix))

    def note(self, text: str) -> None:
        """Note something legal but unusual."""
        self.notes.append(text)


def need_value(check: NumericChecks, formula: Formula, where: str) -> None:
    """Refuse a formula whose value is not finite."""
    check.value(formula, where)


def check_axis(check: NumericChecks, axis: Sequence[Formula], where: str) -> None:
    """Refuse a direction of length zero; remark on one that is normalized."""
    values = check.values(axis, where)
    if values is None:
        return
    length = math.hypot(*values)
    if length == 0:
        fix = 'give a direction, for instance "z" or [0, 0, 1]'
        check.refuse("model.zero_axis", where, "the axis has length zero", "all its components are 0", fix)
    elif abs(length - 1) > _UNIT:
        check.note(f"{where}: the axis of length {length:g} is normalized")


def check_angle(check: NumericChecks, angle: Formula, where: str) -> None:
    """Remark on an angle of more than a turn, which may be in degrees."""
    value = check.value(angle, where)
    if value is not None and abs(value) > 2 * math.pi:
        check.note(f'{where}: {value:g} rad is more than a turn; for degrees write "{value:g} deg"')


def positive_length(why: str) -> Callable[[NumericChecks, Formula, str], None]:
    """Return the check of a length that has to be above zero; `why` is the cause of the fault."""

    def check_length(check: NumericChecks, length: Formula, where: str) -> None:
        value = check.value(length, where)
        if value is not None and value <= 0:
            what = f"{length} is {value:g} m"
            check.refuse("model.no_length", where, what, why, "give a length above zero")

    return check_length


def refuse_zero_ratio(check: NumericChecks, ratio: Formula, where: str) -> None:
    """Refuse a ratio of zero."""
    if check.value(ratio, where) == 0:
        check.refuse(
            "model.no_ratio",
            where,
            f"{ratio} is 0",
            "the first coordinate could not move, regardless of the second",
            "give a nonzero number; to lock the first coordinate, use a joint without this degree of freedom",
        )


def note_negative(check: NumericChecks, coefficient: Formula, where: str) -> None:
    """Remark on a negative stiffness or damping; the last word of its place is what it is."""
    value = check.value(coefficient, where)
    if value is not None and value < 0:
        label, _, path = where.partition(", ")
        check.note(f"{label}: the {path.rpartition('.')[2]} {coefficient} is negative ({value:g})")
