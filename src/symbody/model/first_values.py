"""`Initial`: a first value, and whether it holds where loops are closed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value, plain_value
from symbody.model.frozen_mapping import FrozenMapping


@checked_fields
@dataclass(frozen=True, slots=True)
class Initial:
    """An initial value of a coordinate, rate or speed, and its priority.

    Parameters
    ----------
    value : number or formula
        In SI units; of an angle also ``"60 deg"``.
    priority : "hold" or "guess"
        A value that holds is met exactly, or the motion does not start; a guess is where the search for
        closed loops begins.

    Raises
    ------
    UsageError
        If the priority is neither.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> model = sb.Model("cart", [rail], initial={"x": sb.Initial(0.3, "hold"), "x_dot": 1})
    >>> sb.assemble(sb.form_equations(model))["x"]
    0.3
    """

    value: Value
    priority: Literal["hold", "guess"] = "guess"

    def __post_init__(self) -> None:
        if self.priority not in ("hold", "guess"):
            what = f"priority = {self.priority!r} is not a valid choice"
            raise UsageError(Problem("model.priority", "initial", what, fix="write 'hold' or 'guess'"))


# What callers give, with or without a priority of its own.
PlainValue = int | float | str | Formula
FirstValue = PlainValue | Initial


class FirstValues(FrozenMapping[Formula]):
    """First values by name, and which of them hold: a model that is made of another's keeps priorities."""

    __slots__ = ("held",)

    def __init__(self, items: Mapping[str, Formula] | None = None, held: Iterable[str] = ()) -> None:
        super().__init__(items)
        self.held = tuple(name for name in held if name in self)


def read_initial(arguments: Arguments, values: Mapping[str, Value | Initial]) -> FirstValues:
    """Return the formulas of first values, with the names of those that hold."""
    held: list[str] = [*values.held] if isinstance(values, FirstValues) else []

    def read(value: object, path: str) -> Formula:
        if isinstance(value, Mapping) and "value" in value and {*value} <= {"value", "priority"}:
            table: Mapping[str, Any] = value
            value = arguments.attempt(lambda: Initial(**table)) or Initial(ZERO)
        if isinstance(value, Initial):
            if value.priority == "hold":
                held.append(path.removeprefix("initial."))
            value = value.value
        return arguments.formula(value, path)

    return FirstValues(arguments.table(values, "initial", read), held)


def by_priority(
    fixed: Mapping[str, FirstValue], guess: Mapping[str, FirstValue]
) -> tuple[dict[str, PlainValue], dict[str, PlainValue]]:
    """Return what is held and what is guessed, in that order: an `Initial` says so itself."""
    held: dict[str, PlainValue] = {}
    near: dict[str, PlainValue] = {}
    for values, usual in ((guess, near), (fixed, held)):
        for name, value in values.items():
            if isinstance(value, Initial):
                formula = Formula.from_value(plain_value(value.value), where=name)
                (held if value.priority == "hold" else near)[name] = formula
            else:
                usual[name] = value
    return held, near
