"""Bodies, joints and all else that declares its arguments, as a table of those that are not defaults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape

from symbody.display.formulas import show_formula
from symbody.display.html import Markup, page, show_unit, symbol, table
from symbody.expr.language.formula import Formula
from symbody.model.declaration import Declared
from symbody.model.element import Element
from symbody.model.joint import Joint


def show_declared(element: Declared) -> str:
    """Return the arguments with their values and units."""
    name = f" {element.name}" if isinstance(element, Element) else ""
    rows = list(_rows(element))
    if isinstance(element, Joint):
        rows.insert(0, ("from \u2192 to", f"{element.start} \u2192 {element.end}", ""))
        rows.insert(1, ("coordinates", Markup(", ".join(map(symbol, element.coordinates))), ""))
    return page(f"{type(element).__name__}{name}", table(("", "value", "unit"), rows))


def _rows(element: Declared, before: str = "") -> Iterator[tuple[str, str, str]]:
    """Return a row for each argument, those of parts and of mappings below their names."""
    for word, value in element.given_arguments().items():
        if word in ("name", "start", "end", "coordinate", "coordinates"):
            continue
        unit = _unit(element.fields[word].unit, before)
        for place, entry in _entries(value, f"{before}{word}"):
            if isinstance(entry, Declared):
                yield from _rows(entry, f"{place} ")
            else:
                yield place, _value(entry), unit


def _unit(units: str, before: str) -> str:
    """Return a unit; of "N, N m", of displacements and angles, that of the force or torque it belongs to."""
    both = units.split(", ")
    return show_unit(
        both[-1] if before.startswith("torque") else both[0] if before.startswith("force") else units
    )


def _entries(value: object, place: str) -> Iterator[tuple[str, object]]:
    if isinstance(value, Mapping):
        yield from ((f"{place} {name}", entry) for name, entry in value.items())
    elif isinstance(value, tuple) and any(isinstance(entry, Declared) for entry in value):
        yield from ((f"{place} {k + 1}", entry) for k, entry in enumerate(value))
    else:
        yield place, value


def _value(value: object) -> Markup:
    if isinstance(value, Formula):
        shown = show_formula(value)
        return shown if isinstance(shown, Markup) else Markup(escape(shown))
    if isinstance(value, tuple):
        return Markup(f"({', '.join(map(_value, value))})")
    return Markup(escape(str(value)))
