"""The arguments of one element while they are read: all faults are collected, and raised together.

A constructor makes `Arguments`, reads every argument with it, and calls `raise_all`, which raises once with
everything that was wrong.
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from decimal import Decimal
from numbers import Real
from typing import Final, SupportsFloat, TypeGuard, TypeVar, cast

from symbody.arguments import is_sympy
from symbody.errors import ExpressionError, ModelError, Problem, SymbodyError
from symbody.expr.language.formula import Formula, FormulaLike
from symbody.expr.language.tokens import normalize
from symbody.model.declarations.formula_site import Triple
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.naming import element_problem, symbol_problem

Value = FormulaLike | SupportsFloat
T = TypeVar("T")

ZERO: Final = Formula.from_value(0)


class Arguments:
    """Collects the faults of one element.

    Parameters
    ----------
    label : str
        The element in words, for instance ``"joint slider"``; the first part of every `where`.
    """

    __slots__ = ("label", "problems")

    def __init__(self, label: str) -> None:
        self.label = label
        self.problems: list[Problem] = []

    def where(self, path: str) -> str:
        """Return the place of an argument in words."""
        return f"{self.label}, {path}" if path else self.label

    def add(self, code: str, path: str, what: str, why: str = "", fix: str = "") -> None:
        """Note a fault."""
        self.problems.append(Problem(code, self.where(path), what, why, fix))

    def element_name(self, name: object, path: str = "name") -> str:
        """Return the name of an element, in composed letters."""
        return self._name(element_problem(name, self.where(path)), name)

    def symbol_name(self, name: object, path: str) -> str:
        """Return the name of a symbol as the expression parser will see it."""
        return self._name(symbol_problem(name, self.where(path)), name)

    def formula(self, value: object, path: str) -> Formula:
        """Return a formula from text, a real number or a formula."""
        try:
            return Formula.from_value(plain_value(value), where=self.where(path))
        except ExpressionError as error:
            self.problems.extend(error.problems)
            return ZERO

    def triple(self, values: object, path: str) -> Triple:
        """Return three formulas."""
        items = list(values) if _is_many(values) else None
        if items is None or len(items) != 3:
            found = f"one: {reprlib.repr(values)}" if items is None else str(len(items))
            what = f"three entries are needed, not {found}"
            self.add("model.not_three", path, what, "", "give the components along x, y and z")
            return (ZERO, ZERO, ZERO)
        if all(map(_is_many, items)):
            fix = "give its diagonal; entries xy, xz, yz of an inertia are products="
            self.add("model.not_three", path, "three entries are needed, but a matrix was given", "", fix)
            return (ZERO, ZERO, ZERO)
        x, y, z = (self.formula(item, f"{path}[{k}]") for k, item in enumerate(items))
        return (x, y, z)

    def items(self, values: object, path: str) -> list[object]:
        """Return the entries of a list; anything that can be iterated but text and mappings counts as one."""
        if _is_many(values):
            return list(values)
        self.add("model.not_a_list", path, f"{reprlib.repr(values)} is not a list", "", "write [.., .., ..]")
        return []

    def table(self, values: object, path: str, read: Callable[[object, str], T]) -> FrozenMapping[T]:
        """Return a table of what `read` makes of each value."""
        if not isinstance(values, Mapping):
            what = f"{values!r} is not a mapping of names"
            self.add("model.not_a_table", path, what, "", "write {name: value}")
            return FrozenMapping()
        entries: dict[str, T] = {}
        for name, value in values.items():
            key = normalize(name) if isinstance(name, str) else str(name)
            if key in entries:
                what = f"the name {key!r} appears twice after Unicode normalization"
                why = "letters that look alike, such as \u00b5 and \u03bc, become one"
                self.add("names.duplicate", f"{path}.{key}" if path else key, what, why, "rename one of them")
            entries[key] = read(value, f"{path}.{key}" if path else key)
        return FrozenMapping(entries)

    def attempt(self, make: Callable[[], T], path: str | None = None) -> T | None:
        """Return what `make` returns; None if it raises, its faults taken over, below `path` if given."""
        try:
            return make()
        except SymbodyError as error:
            for problem in error.problems:
                rest = problem.where.partition(", ")[2]
                where = problem.where if path is None else self.where(f"{path}.{rest}" if rest else path)
                self.problems.append(replace(problem, where=where))
            return None

    def raise_all(self) -> None:
        """Raise a ModelError with what was collected, if there is anything."""
        if self.problems:
            raise ModelError(*self.problems)

    def _name(self, problem: Problem | None, name: object) -> str:
        if problem is not None:
            self.problems.append(problem)
        return normalize(name) if isinstance(name, str) else "?"


def plain_value(value: object) -> FormulaLike:
    """Return a scalar of another library as float; anything else as it is, to be told what is wrong."""
    is_known = isinstance(value, str | Formula | Real | Decimal | complex) or is_sympy(value)
    if type(value).__name__ in ("bool", "bool_"):  # NumPy's does what bool does, and is not a number either
        return cast(FormulaLike, bool(value))
    if not is_known and isinstance(value, SupportsFloat):
        try:
            return float(value)
        except (TypeError, ValueError):  # an array of several entries, a symbol
            pass
    return cast(FormulaLike, value)


def _is_many(values: object) -> TypeGuard[Iterable[object]]:
    """Return whether something counts as a list: it can be iterated, and is neither text nor a mapping."""
    if not isinstance(values, Iterable) or isinstance(values, str | bytes | Mapping):
        return False
    try:
        iter(values)
    except TypeError:  # an array without axes
        return False
    return True
