"""Formulas whose terms bear a mark, so that the page can say which term was clicked."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from symbody.expr.graph import Graph
from symbody.expr.printing.mathml import to_mathml
from symbody.expr.printing.mathml_tables import terms_of


def with_spans(graph: Graph, spans: Mapping[int, str], formula: str) -> str:
    """Return a formula whose terms bear the spans they are known under.

    Parameters
    ----------
    spans : mapping of node to str
        Terms that may stand in it.
    formula : str
        MathML of a sum.
    """
    marks = {_strip_sign(to_mathml(graph, node)): span for node, span in spans.items()}
    parts = []
    for elements in terms_of(list(ElementTree.fromstring(f"<mrow>{formula}</mrow>"))):
        signs, unsigned = _split_sign(elements)
        span = marks.get("".join(map(_text, unsigned)))
        inner = "".join(map(_text, unsigned))
        parts.append("".join(map(_text, signs)))
        parts.append(inner if span is None else f'<mrow data-span="{span}">{inner}</mrow>')
    return "".join(parts)


def _strip_sign(formula: str) -> str:
    _, unsigned = _split_sign(list(ElementTree.fromstring(f"<mrow>{formula}</mrow>")))
    return "".join(map(_text, unsigned))


def _split_sign(elements: list[Element]) -> tuple[list[Element], list[Element]]:
    is_sign = bool(elements) and elements[0].tag == "mo" and elements[0].text in ("+", "\u2212")
    return (elements[:1], elements[1:]) if is_sign else ([], elements)


def _text(element: Element) -> str:
    return ElementTree.tostring(element, encoding="unicode")
