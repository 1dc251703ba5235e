"""Equations in a page: rows that the browser breaks to the width there is, with a hanging indent.

Browsers break lines between ``math`` elements, never inside one. So each term is an element of its own, and a
long term has one for each term inside its brackets: a row ends in front of a sign, of the outermost that
fits. How they look is `symbody/display/maths.css`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from types import MappingProxyType
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import (
    letter_count,
    math_element,
    mathml_matrix,
    terms_of,
)
from symbody.expr.printing.names import name_words
from symbody.expr.printing.relation import Relation

_LONG: Final = 20  # letters from which a term may be broken inside its brackets
_BRACKET: Final = 10  # letters below which brackets are never opened
_WIDEST: Final = 46  # letters of the rows of a matrix that is drawn as one
_TALL: Final = frozenset({"mfrac", "mtable"})
_HEIGHT: Final = "2.3em"  # of a bracket around a fraction whose halves may stand in two rows


def equations_html(
    sides: Iterable[tuple[str, str]],
    remarks: Sequence[str] = (),
    relations: Mapping[int, Relation] = MappingProxyType({}),
) -> str:
    """Return equations of MathML below each other, each as a row that may be broken anywhere between terms.

    Parameters
    ----------
    sides : iterable of (left, right)
        MathML of both sides.
    remarks : sequence of str
        What is said behind each equation; none for those beyond the list.
    relations : mapping of int to Relation
        What stands between sides where that is no equality, by their place.
    """
    said = [*remarks]
    rows = []
    for k, (left, right) in enumerate(sides):
        remark = said[k] if k < len(said) else ""
        sign = relations.get(k, Relation.EQUAL).mathml
        words = f' <span class="sb-remark">({escape(remark)})</span>' if remark else ""
        rows.append(f'<div class="sb-equation">{"".join(_terms(left, right, sign))}{words}</div>')
    return f'<div class="sb-equations">{"".join(rows)}</div>'


def matrix_html(symbol: str, rows: Sequence[Sequence[str]], names: Sequence[Sequence[str]]) -> str:
    """Return a matrix of MathML: drawn where it is narrow, else drawn of names, with a row for each entry.

    Of a symmetric matrix the entries on and above the diagonal are listed, of all matrices those that are not
    0.

    Parameters
    ----------
    symbol : str
        MathML of its name.
    rows, names : sequence of sequence of str
        MathML of the entries, and of what they are called.
    """
    if matrix_width(rows) <= _WIDEST:
        content = f"{symbol}<mo>=</mo>{mathml_matrix([[*map(_fit, row)] for row in rows])}"
        return f'<div class="sb-matrix" tabindex="0">{_with_title(math_element(content, block=True))}</div>'
    is_symmetric = len(rows) == len(rows[0]) and all(
        rows[i][j] == rows[j][i] for i in range(len(rows)) for j in range(i)
    )
    listed = [
        (names[i][j], entry)
        for i, row in enumerate(rows)
        for j, entry in enumerate(row)
        if _is_nonzero(entry) and (j >= i or not is_symmetric)
    ]
    drawn = [
        [names[i][j] if _is_nonzero(entry) else entry for j, entry in enumerate(row)]
        for i, row in enumerate(rows)
    ]
    if is_symmetric:
        drawn = [[drawn[min(i, j)][max(i, j)] for j in range(len(rows))] for i in range(len(rows))]
    content = f"{symbol}<mo>=</mo>{mathml_matrix(drawn)}"
    shown = f'<div class="sb-matrix" tabindex="0">{math_element(content, block=True)}</div>'
    return shown + equations_html(listed)


def entry_names(symbol: str, rows: int, columns: int) -> list[list[str]]:
    """Return what the entries of a matrix are called, counted from 1: M11, and F1 of a column."""
    return [
        [entry_name(symbol, i, *([j] if columns > 1 else [])) for j in range(columns)] for i in range(rows)
    ]


def entry_name(symbol: str, *indices: int) -> str:
    """Return the name of an entry of a matrix or a vector, with indices from 0, as MathML."""
    head, *words = name_words(symbol)
    mark = "" if all(k < 9 for k in indices) else ","
    numbers = mark.join(str(k + 1) for k in indices)
    return mathml_name("_".join([head, *words, numbers]))


def matrix_width(rows: Sequence[Sequence[str]]) -> int:
    """Return about how many letters wide a matrix is."""
    widths = [[letter_count(_parse(entry)) for entry in row] for row in rows]
    return sum(max(column) + 2 for column in zip(*widths, strict=True))


def _is_nonzero(entry: str) -> bool:
    return entry != "<mn>0</mn>"


def _terms(left: str, right: str, relation: str) -> Iterator[str]:
    yield from (_term(elements) for elements in terms_of(list(_parse(left))))
    first, *others = terms_of(list(_parse(right)))
    sign = Element("mo", form="infix")
    sign.text = relation
    yield _term([sign, *first])
    yield from map(_term, others)


def _term(elements: Sequence[Element]) -> str:
    """Return a term with its sign, as an element that is broken inside only where it is longer than a row."""
    span = next((e.get("data-span") for e in elements if e.get("data-span")), "")
    plain = [part for e in elements for part in (list(e) if e.get("data-span") else [e])]
    mark = f' data-span="{escape(span)}"' if span else ""
    return _unit(plain, mark)


def _unit(elements: list[Element], mark: str = "") -> str:
    is_sign = len(elements) > 1 and elements[0].tag == "mo" and elements[0].text in ("+", "\u2212")
    if is_sign and elements[0].get("form") is None:
        elements[0].set("form", "infix")  # with the blanks of a sign between two terms
    pieces = _pieces(elements) if sum(map(letter_count, elements)) > _LONG else [elements]
    if len(pieces) == 1:
        return f'<span class="sb-term"{mark}{_title(elements)}>{_math(pieces[0])}</span>'
    inner = "".join(_unit(piece) for piece in pieces)
    return f'<span class="sb-term sb-long"{mark}>{inner}</span>'


def _pieces(elements: Iterable[Element]) -> list[list[Element]]:
    """Return the parts between which a long term may be broken: the terms inside its brackets."""
    pieces: list[list[Element]] = [[]]
    for element in elements:
        if not (_is_bracket(element) and letter_count(element) > _BRACKET):
            pieces[-1].append(element)
            continue
        opening, *content, closing = list(element)
        is_tall = _is_tall(element)
        for bracket in (opening, closing):
            # Its other half may stand in another row, so its height cannot follow what is between them.
            bracket.attrib |= {"minsize": _HEIGHT, "maxsize": _HEIGHT} if is_tall else {}
            bracket.attrib |= {"form": "prefix" if bracket is opening else "postfix"}
        first, *others = terms_of(content)
        pieces[-1] += [opening, *first]
        pieces += others
        pieces[-1].append(closing)
    return pieces


def _is_bracket(element: Element) -> bool:
    return element.tag == "mrow" and len(element) > 2 and element[0].text == "(" and element[-1].text == ")"


def _math(elements: Sequence[Element]) -> str:
    content = "".join(ElementTree.tostring(part, encoding="unicode") for part in elements)
    return math_element(content).replace("<math ", '<math displaystyle="true" ', 1)


def _title(elements: Iterable[Element]) -> str:
    """Return the full values of rounded numbers as a title, which browsers show of HTML but not of MathML."""
    rounded = {
        part.text: part.get("data-full") for e in elements for part in e.iter() if part.get("data-full")
    }
    words = ", ".join(f"{short} = {full}" for short, full in rounded.items())
    return f' title="{escape(words)}"' if words else ""


def _with_title(math: str) -> str:
    return f"<span{_title([_parse(math)])}>{math}</span>"


def _parse(formula: str) -> Element:
    """Return the elements of a formula; brackets grow only around fractions and tables, as in books."""
    root = ElementTree.fromstring(f"<mrow>{formula}</mrow>")
    for element in root.iter():
        if _is_bracket(element) and not _is_tall(element):
            for bracket in (element[0], element[-1]):
                bracket.set("stretchy", "false")
    return root


def _fit(formula: str) -> str:
    return "".join(ElementTree.tostring(part, encoding="unicode") for part in _parse(formula))


def _is_tall(element: Element) -> bool:
    return any(child.tag in _TALL for child in element.iter())
