"""Equations as MathML in a narrow column: rows end inside brackets too, where a term alone is too long."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from symbody.expr.printing.mathml_tables import letter_count

_SIGNS: Final = frozenset("+\u2212=")
_TIMES: Final = "\u2062"
_SHORT: Final = 4  # letters: a row "= 0" is better not alone
_FILLED: Final = 0.4  # of a row, before a sign in fewer brackets is not preferred to a fuller row
_WHOLE: Final = 0.5  # of a row: shorter brackets are never broken


def mathml_column(sides: Iterable[tuple[str, str]], width: int) -> str:
    """Return equations below each other, each in rows of about `width` letters, further rows indented.

    A row ends in front of the sign that stands in the fewest brackets, of equals the last one; where there is
    none, between two factors.
    """
    rows = []
    for left, right in sides:
        root = ElementTree.fromstring(f"<mrow>{left}<mo>=</mo>{right}</mrow>")
        parts = _break_parts(list(_parts(root, width)), width)
        rows += [_row(part, k) for k, part in enumerate(parts)]
    return f'<mtable displaystyle="false">{"".join(rows)}</mtable>'


def _row(parts: Sequence[Element], place: int) -> str:
    text = "".join(ElementTree.tostring(part, encoding="unicode") for part in parts)
    space = '<mspace width="1em"/>' if place else ""
    above = "" if place else ";padding-top:0.6em"
    return f'<mtr><mtd style="text-align:left{above}">{space}{text}</mtd></mtr>'


def _parts(element: Element, width: int) -> Iterator[Element]:
    """Yield what stands in a row beside each other; long brackets are opened."""
    for child in element:
        if child.tag == "mrow" and letter_count(child) > _WHOLE * width:
            brackets = [part for part in (child[0], child[-1]) if part.text in ("(", ")")]
            for bracket in brackets:
                bracket.set("stretchy", "false")  # its other half may stand in another row
            yield from _parts(child, width)
        else:
            yield child


def _break_parts(parts: list[Element], width: int) -> Iterator[list[Element]]:
    while sum(map(letter_count, parts)) > width:
        place = _break_place(parts, width)
        if place is None:
            break
        yield parts[:place]
        parts = parts[place:]
        if parts[0].text == _TIMES:
            parts = parts[1:]
        else:
            parts[0].set("form", "infix")  # with the blanks of a sign between two terms
    yield parts


def _break_place(parts: Sequence[Element], width: int) -> int | None:
    """Return the part that begins the next row, or None where there is no place."""
    filled = list(accumulate(map(letter_count, parts), initial=0))
    depths = list(accumulate(((p.text == "(") - (p.text == ")") for p in parts), initial=0))
    signs = [k for k in range(1, len(parts)) if parts[k].tag == "mo" and parts[k].text in _SIGNS]
    times = [k for k in range(1, len(parts)) if parts[k].text == _TIMES]
    for places in (signs, times):
        near = [k for k in places if filled[k] <= width]
        full = [k for k in near if filled[k] >= _FILLED * width]
        if full or (near and places is times):
            return min(full or near, key=lambda k: (depths[k], filled[-1] - filled[k] < _SHORT, -k))
    return min((*signs, *times), default=None)
