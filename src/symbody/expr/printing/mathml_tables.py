"""MathML of whole pages: ``math`` elements, matrices, and the terms of sums."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final
from xml.etree.ElementTree import Element

_NAMESPACE: Final = "http://www.w3.org/1998/Math/MathML"
_SIGNS: Final = frozenset("+\u2212")
_INVISIBLE: Final = frozenset("\u2061\u2062")


def math_element(content: str, block: bool = False) -> str:
    """Return a ``math`` element around MathML, in the line or as a block of its own."""
    display = ' display="block"' if block else ""
    return f'<math xmlns="{_NAMESPACE}"{display}><mrow>{content}</mrow></math>'


def mathml_matrix(rows: Sequence[Sequence[str]]) -> str:
    """Return a matrix of formulas in square brackets."""
    lines = (f"<mtr>{''.join(f'<mtd>{entry}</mtd>' for entry in row)}</mtr>" for row in rows)
    return f"<mrow><mo>[</mo><mtable>{''.join(lines)}</mtable><mo>]</mo></mrow>"


def terms_of(elements: Sequence[Element]) -> list[list[Element]]:
    """Return the elements of each term, its sign first."""
    terms: list[list[Element]] = [[]]
    for element in elements:
        if element.tag == "mo" and element.text in _SIGNS and terms[-1]:
            terms.append([])
        terms[-1].append(element)
    return terms


def letter_count(element: Element) -> int:
    """Return about how many letters wide an element of MathML is."""
    if element.tag == "mfrac":
        return max(map(letter_count, element), default=0)
    text = element.text or ""
    return (0 if text in _INVISIBLE else len(text)) + sum(map(letter_count, element))
