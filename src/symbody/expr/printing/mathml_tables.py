"""MathML of whole pages: ``math`` elements, matrices, and equations whose long sides are broken into rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

_NAMESPACE: Final = "http://www.w3.org/1998/Math/MathML"
WIDTH: Final = 70  # letters of a row, about what a column of text holds
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


def mathml_equations(sides: Iterable[tuple[str, str]], width: int = WIDTH) -> str:
    """Return equations below each other, aligned at their signs; sides longer than `width` take several rows.

    Sides are broken in front of the signs of their terms, and further rows are indented; a product is never
    broken.
    """
    rows = [row for left, right in sides for row in _rows(break_rows(left, width), break_rows(right, width))]
    return f'<mtable displaystyle="true">{"".join(rows)}</mtable>'


def _rows(left: Sequence[str], right: Sequence[str]) -> list[str]:
    rows = [(part, "", "") for part in left[:-1]]
    rows.append((left[-1], "<mo>=</mo>", right[0]))
    rows += [("", "", part) for part in right[1:]]
    first = "left" if len(left) > 1 else "right"
    return [
        f'<mtr><mtd style="text-align:{first}">{a}</mtd><mtd>{sign}</mtd>'
        f'<mtd style="text-align:left">{b}</mtd></mtr>'
        for a, sign, b in rows
    ]


def break_rows(formula: str, width: int = WIDTH) -> list[str]:
    """Return the rows of a formula, each of at most `width` letters where its terms allow it."""
    rows: list[list[Element]] = [[]]
    filled = 0
    for term in terms_of(list(ElementTree.fromstring(f"<mrow>{formula}</mrow>"))):
        length = sum(map(letter_count, term))
        if rows[-1] and filled + length > width:
            rows.append([])
            filled = 0
        rows[-1] += term
        filled += length
    for row in rows[1:]:
        row[0].set("form", "infix")  # with the blanks of a sign between two terms
        row.insert(0, Element("mspace", width="1em"))
    return ["".join(ElementTree.tostring(part, encoding="unicode") for part in row) for row in rows]


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
