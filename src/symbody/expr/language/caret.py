"""Where in a text a fault lies: line, column, and the line itself with a caret under the place."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Final

from symbody.errors import Problem

# Characters of the line shown on either side of the caret.
_REACH: Final = 36


@dataclass(frozen=True, slots=True)
class Source:
    """A text and the place in the model it comes from.

    Attributes
    ----------
    text : str
        The whole text, possibly of several lines.
    where : str
        Object path or file, for instance ``"joint slider, motion"``; may be empty.
    has_outputs : bool
        Whether names in single quotes are outputs, ``'reaction A Fx'``; otherwise quotes are a fault.
    """

    text: str
    where: str = ""
    has_outputs: bool = False

    def problem(self, code: str, column: int, what: str, why: str = "", fix: str = "") -> Problem:
        """Return a problem whose text shows the line and a caret.

        Parameters
        ----------
        column : int
            Position in the whole text, counted from 1; one past the end is allowed.
        """
        start = self.text.rfind("\n", 0, column - 1) + 1
        end = self.text.find("\n", start)
        line = self.text[start : len(self.text) if end < 0 else end]
        place = f"column {column - start}"
        if "\n" in self.text:
            place = f"line {self.text.count(chr(10), 0, start) + 1}, {place}"
        if self.where:
            place = f"{self.where}, {place}"
        return Problem(code, place, f"{what}\n{_display(line, column - 1 - start)}", why, fix)


def printable(text: str) -> str:
    """Return `text` with everything that does not print as an escape, shortened to one line."""
    short = text if len(text) <= 2 * _REACH else text[:_REACH] + "..."
    return "".join(map(_glyph, short))


def _display(line: str, offset: int) -> str:
    """Return the part of `line` around `offset`, and below it the caret."""
    low, high = max(0, offset - _REACH), offset + _REACH
    before = ("..." if low else "") + "".join(map(_glyph, line[low:offset]))
    after = "".join(map(_glyph, line[offset:high])) + ("..." if high < len(line) else "")
    return f"    {before}{after}\n    {' ' * sum(map(_width, before))}^"


def _glyph(character: str) -> str:
    if character in "\t\r\n":
        return " "
    # repr turns what cannot be printed (controls, bidi marks, lone surrogates) into an escape.
    return character if character.isprintable() else repr(character)[1:-1]


def _width(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1
