"""Names of a robot that a model can have: each unique, none changed without a note."""

from __future__ import annotations

from symbody.expr.language.tokens import MAX_NAME, normalize
from symbody.model.naming import CENTRE, GROUND, RESERVED_SYMBOLS, make_symbol

_MARKS = str.maketrans({".": "_", '"': "_", "'": "_"})
_DERIVED = ("", "_dot", "_ddot")
_LONGEST = MAX_NAME - 16  # leaves room for what is put before and behind


class Naming:
    """Hands out names of one model."""

    __slots__ = ("_elements", "_symbols", "notes")

    def __init__(self) -> None:
        self._elements = {GROUND, CENTRE}
        self._symbols = set(RESERVED_SYMBOLS)
        self.notes: list[str] = []

    def element(self, name: str, suffix: str, what: str) -> str:
        """Return the name of a body, joint or frame; `suffix` distinguishes it from a namesake."""
        plain = " ".join(normalize(name).translate(_MARKS).split())[:_LONGEST]
        if plain.isdigit() or plain.lower() == GROUND or plain == CENTRE:
            plain = f"{plain}{suffix}" if not plain.isdigit() else f"_{plain}"
        found, number = plain, 1
        while found in self._elements:
            found = f"{plain}{suffix}" + (f"_{number}" if number > 1 else "")
            number += 1
        self._elements.add(found)
        if found != normalize(name):
            self.notes.append(f"{what} {name} is called {found!r} in the model")
        return found

    def symbol(self, name: str, what: str) -> str:
        """Return the name of a coordinate, so that it, its rate and its acceleration are free."""
        plain = make_symbol(name[:_LONGEST])
        found, number = plain, 1
        while not self._symbols.isdisjoint(f"{found}{end}" for end in _DERIVED):
            number += 1
            found = f"{plain}_{number}"
        self._symbols.update(f"{found}{end}" for end in _DERIVED)
        if found != normalize(name):
            self.notes.append(f"{what} {name} has the symbol {found}")
        return found

    def take(self, *symbols: str) -> None:
        """Reserve symbols that must be called so."""
        self._symbols.update(symbols)
