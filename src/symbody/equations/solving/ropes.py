"""Ropes: the equations of a mechanism for each way in which its ropes are taut or slack."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.model.constraints import Distance


def ropes(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the names of the ropes, in the order of the model."""
    conditions = [c for c in formed.topology.model.constraints if isinstance(c, Distance) and c.rope]
    known = {row.element for row in (*formed.rows, *formed.slack)} if conditions else set()
    return tuple(c.name for c in conditions if c.name in known)


def rope_row(formed: EquationsOfMotion, name: str) -> ConstraintEquation:
    """Return the row that holds while a rope is taut, whether it is or not."""
    return next(row for row in (*formed.slack, *formed.rows) if row.element == name)


def length_of(formed: EquationsOfMotion, row: ConstraintEquation) -> Expr:
    """Return the length of the rope of a row."""
    rod = formed.topology.contacts[row.element]
    return formed.names.expression(next(iter(rod.formula_sites())).formula, f"constraint {row.element}")


def slacken(formed: EquationsOfMotion, names: Collection[str]) -> EquationsOfMotion:
    """Return the equations without the rows of some ropes; their multipliers are 0."""
    gone = tuple(row for row in formed.rows if row.element in names)
    if not gone:
        return formed
    kept = tuple(row for row in formed.rows if row.element not in names)
    zero = number(formed.graph, 0)
    known = formed.names.with_values({row.name: zero for row in gone})
    return replace(formed.with_rows(kept), slack=(*formed.slack, *gone), names=known)


def rope_words(formed: EquationsOfMotion) -> dict[str, str]:
    """Return a name for what is watched of each rope that formulas can contain, by rope.

    Names of elements may have blanks, and so those of multipliers.
    """
    taken = {*formed.names.symbols, *formed.names.values}
    words: dict[str, str] = {}
    for k, name in enumerate(ropes(formed)):
        word = f"rope_{k}"
        while word in taken:
            word += "_"
        words[name] = word
    return words


def with_words(formed: EquationsOfMotion, words: Mapping[str, str]) -> EquationsOfMotion:
    """Return the equations with these names for the push of taut ropes, and for how slack the others are."""
    values = {words[row.element]: -row.value for row in formed.slack if row.element in words}
    for row in formed.rows:
        if row.element in words:
            values[words[row.element]] = symbol(formed.graph, Symbol(row.name, SymbolKind.MULTIPLIER))
    return formed.with_names(values)


def rope_rows(formed: EquationsOfMotion, names: Collection[str]) -> list[int]:
    """Return the places of the rows of taut ropes, in the order of the names."""
    places = {row.element: k for k, row in enumerate(formed.rows)}
    return [places[name] for name in names]
