"""`NumericChecks`: formulas of a model as numbers; `Domain`: which of them a formula may be."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

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

    def judge(self, domain: Domain, formula: Formula, where: str) -> float | None:
        """Note a value that is outside of a domain; return it."""
        value = self.value(formula, where)
        if value is not None and not domain.has(value):
            what = domain.what.format(formula=formula, value=f"{value:g}")
            self.refuse(domain.code, where, what, domain.why, domain.fix)
        return value

    def refuse(self, code: str, where: str, what: str, why: str, fix: str) -> None:
        """Note an error."""
        self.problems.append(Problem(code, where, what, why, fix))

    def note(self, text: str) -> None:
        """Note something legal but unusual."""
        self.notes.append(text)


@dataclass(frozen=True, slots=True)
class Domain:
    """The numbers that a formula may be: finite, and as it says.

    Calling it notes a value that is outside; a formula whose names have no values is not judged.

    Attributes
    ----------
    code, what, why, fix : str
        Of the problem; `what` with ``{formula}`` and ``{value}``.
    least, most : float
        None is below or above.
    above : bool
        Whether `least` itself is none.
    nonzero : bool
        Whether 0 is none.
    """

    code: str
    what: str
    why: str
    fix: str
    least: float = -math.inf
    above: bool = False
    nonzero: bool = False
    most: float = math.inf

    def has(self, value: float) -> bool:
        """Return whether a number is one of it."""
        if not math.isfinite(value) or not self.least <= value <= self.most:
            return False
        return not (self.above and value == self.least) and not (self.nonzero and value == 0.0)

    def __call__(self, check: NumericChecks, formula: Formula, where: str) -> float | None:
        """Note a value that is outside; return it."""
        return check.judge(self, formula, where)


class Demand(NamedTuple):
    """A formula, or what follows from several, with its domain."""

    path: str
    formula: Formula
    domain: Domain


class DemandList(NumericChecks):
    """Collects what is demanded of formulas, whatever their values are.

    Attributes
    ----------
    demands : list of Demand
    """

    __slots__ = ("demands",)

    def __init__(self) -> None:
        super().__init__({})
        self.demands: list[Demand] = []

    def value(self, formula: Formula, where: str) -> None:
        """Return None: there are no values."""

    def judge(self, domain: Domain, formula: Formula, where: str) -> None:
        """Collect the domain of a formula."""
        self.demands.append(Demand(where, formula, domain))


# Takes the checks, a formula and its place.
NumberCheck = Callable[[NumericChecks, Formula, str], object]
FINITE: Final = Domain("block.domain", "{formula} is {value}", "it is not a number", "give other values")
SAMPLE_TIME: Final = Domain(
    "signal.sample", "the time between samples, {formula}, is {value} s",
    "samples are taken at the start and after every such time", "give seconds, such as sample = 0.01",
    0.0, above=True,
)  # fmt: skip
TIME: Final = Domain(
    "block.domain", "{formula} is {value} s", "this is the time constant of a state, which divides its rate",
    "give seconds above 0, short compared with the motion", 0.0, above=True,
)  # fmt: skip
NOT_NEGATIVE: Final = Domain("block.domain", "{formula} is {value}", "a sign is wrong", "give 0 or more", 0.0)


def positive_length(why: str) -> Domain:
    """Return the lengths above zero; `why` is the cause of the fault."""
    return Domain(
        "model.no_length", "{formula} is {value} m", why, "give a length above zero", 0.0, above=True
    )


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


def note_negative(check: NumericChecks, coefficient: Formula, where: str) -> None:
    """Remark on a negative stiffness or damping; the last word of its place is what it is."""
    value = check.value(coefficient, where)
    if value is not None and value < 0:
        label, _, path = where.partition(", ")
        check.note(f"{label}: the {path.rpartition('.')[2]} {coefficient} is negative ({value:g})")
