"""The sections of equations as HTML with MathML: for notebooks and live pages."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Final

from symbody.equations.outputs.equation_sections import (
    SHOWN_DIGITS,
    EquationSection,
    equation_sections,
    has_rounded,
    numerals_of,
)
from symbody.equations.outputs.printed_equations import LONG
from symbody.equations.outputs.textbook import Textbook
from symbody.expr.printing.equation_layout import equations_html
from symbody.expr.printing.mathml import mathml_name, to_mathml_with_definitions
from symbody.expr.rewrite import tree_sizes

DIGITS_NOTE: Final = "Computed numbers are shown with {} significant digits."


def equations_page(textbook: Textbook, limit: int = LONG, digits: int | None = SHOWN_DIGITS) -> str:
    """Return all equations under their headings; shared parts of long ones are named at the end.

    Parameters
    ----------
    limit : int
        Operations of an equation above which shared parts get names.
    digits : int, optional
        Significant digits of computed numbers, which is said above the equations; None for all.
    """
    sections = equation_sections(textbook, limit)
    nodes = [node for section in sections for node in section.nodes]
    numerals = numerals_of(textbook.formed.topology.model, digits)
    leading = {root: own for section in sections for root, own in section.leading.items()}
    texts, definitions = to_mathml_with_definitions(textbook.formed.graph, nodes, limit, numerals, leading)
    pairs = iter(zip(texts[::2], texts[1::2], strict=True))
    parts = []
    if has_rounded(textbook, nodes, numerals):
        parts.append(f'<p class="sb-digits">{DIGITS_NOTE.format(digits)}</p>')
    for section in sections:
        if len(sections) > 1:
            parts.append(_heading(section.title.heading))
        parts.append(_section(section, pairs))
    if definitions:
        parts.append(_heading("where"))
        parts.append(equations_html((mathml_name(name), text) for name, text in definitions))
    return "".join(parts)


def equation_operations(textbook: Textbook) -> int:
    """Return the operations of all equations written out."""
    nodes = [node for section in equation_sections(textbook, LONG) for node in section.nodes]
    return sum(tree_sizes(textbook.formed.graph, nodes))


def _heading(text: str) -> str:
    return f'<p class="sb-maths-heading">{escape(text)}</p>'


def _section(section: EquationSection, pairs: Iterator[tuple[str, str]]) -> str:
    if section.note:
        return f"<p>{escape(section.note)}</p>"
    sides = [next(pairs) for _ in section.sides]
    remarks = [section.remarks.get(k, "") for k in range(len(sides))]
    words = ((mathml_name(name), f"<mtext>{escape(text)}</mtext>") for name, text in section.words)
    return equations_html([*sides, *words], remarks, section.relations)
