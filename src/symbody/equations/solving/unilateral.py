"""Gaps of ropes, stops and rigid contacts: rows that hold while one is closed and never pull it shut."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.model.constraints import Distance
from symbody.model.contacts.contact import Contact


def unilateral_elements(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return names of all gaps, in the order of the model.

    They are those of their elements; a contact in several points has one for each, with its number behind.
    """
    rows = {row.name: row for row in (*formed.slack, *formed.rows) if row.sense}
    if not rows:
        return ()
    order = {part.name: k for k, part in enumerate(formed.topology.model.constraints)}
    return tuple(
        row.gap for row in sorted(rows.values(), key=lambda row: (order[row.element], row_number(row.name)))
    )


def row_number(multiplier: str) -> int:
    """Return which of the rows of its element a multiplier belongs to."""
    return int(multiplier.rpartition("_")[2])


def unilateral_row(formed: EquationsOfMotion, name: str) -> ConstraintEquation:
    """Return the row that holds while a gap is closed, whether it is or not."""
    return next(row for row in (*formed.slack, *formed.rows) if row.gap == name)


def element_words(formed: EquationsOfMotion, name: str) -> tuple[str, str]:
    """Return what a gap, or something that sticks and slips, is in sentences: its kind and its name.

    Kinds are "rope", "stop", "contact" and "joint". A contact in several points has gaps and friction in
    each: they are named by the contact and the number of the point.
    """
    rows = [row for row in (*formed.slack, *formed.rows) if row.sense]
    row = next((row for row in rows if row.gap == name), None)
    if row is None:
        touch = next((law.touch for law in formed.friction if law.element == name), None)
        if touch is None:
            return "joint", name
        row = next(row for row in rows if row.name == touch.row)
    if row.sense < 0:
        return "rope", row.element
    point = "" if row.gap == row.element else f", point {row_number(row.name)}"
    is_contact = isinstance(formed.topology.contacts.get(row.element), Contact)
    return "contact" if is_contact else "stop", f"{row.element}{point}"


def gap_place(formed: EquationsOfMotion, name: str) -> str:
    """Return where a problem with a gap is: ropes and stops are constraints of a model."""
    kind, shown = element_words(formed, name)
    return f"{kind if kind == 'contact' else 'constraint'} {shown}"


def gap_of(row: ConstraintEquation) -> Expr:
    """Return the gap of a row: how much shorter the ends of a rope are apart than it is long."""
    return row.value if row.sense > 0 else -row.value


def effort_of(row: ConstraintEquation) -> Expr:
    """Return the effort that opens the gap of a row, as an unknown: the tension of a rope."""
    effort = symbol(row.value.graph, Symbol(row.name, SymbolKind.MULTIPLIER))
    return effort if row.sense > 0 else -effort


def gap_scale(formed: EquationsOfMotion, row: ConstraintEquation) -> Expr:
    """Return what a gap is small against: the length of a rope; 0 for the scale of the row."""
    rod = formed.topology.contacts.get(row.element)
    if not isinstance(rod, Distance):
        return number(formed.graph, 0)
    return formed.names.expression(rod.value, f"constraint {row.element}")


def open_gaps(formed: EquationsOfMotion, names: Collection[str]) -> EquationsOfMotion:
    """Return the equations without the rows of some gaps; their multipliers are 0."""
    gone = tuple(row for row in formed.rows if row.sense and row.gap in names)
    if not gone:
        return formed
    kept = tuple(row for row in formed.rows if not (row.sense and row.gap in names))
    zero = number(formed.graph, 0)
    known = formed.names.with_values({row.name: zero for row in gone})
    return replace(formed.with_rows(kept), slack=(*formed.slack, *gone), names=known)


def row_places(formed: EquationsOfMotion, names: Collection[str]) -> list[int]:
    """Return the places of the rows of closed gaps, in the order of the names."""
    places = {row.gap: k for k, row in enumerate(formed.rows) if row.sense}
    return [places[name] for name in names]
