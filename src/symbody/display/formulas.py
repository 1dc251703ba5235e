"""Formulas of a model file as MathML."""

from __future__ import annotations

from collections.abc import Collection

from symbody.display.html import Markup
from symbody.errors import ExpressionError
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.expr.printing.mathml import to_mathml
from symbody.expr.printing.mathml_tables import math_element


def show_formula(formula: Formula | None, states: Collection[str] = ()) -> str:
    """Return a formula as MathML, a plain number as it is typed, or a dash where there is none.

    Parameters
    ----------
    states : collection of str
        Coordinates and speeds, which stand behind parameters in a product.
    """
    if formula is None:
        return "\u2013"
    if formula.is_number:
        return formula.text
    try:
        return Markup(math_element(to_mathml(*graph_of_formula(formula, states))))
    except ExpressionError:  # a division by zero, or longer than anybody reads
        return formula.text


def graph_of_formula(formula: Formula, states: Collection[str] = ()) -> tuple[Graph, int]:
    """Return a formula as a node of a graph of its own.

    Parameters
    ----------
    states : collection of str
        Coordinates and speeds, which stand behind parameters in a product.

    Raises
    ------
    ExpressionError
        If it divides by zero, or is longer than anybody reads.
    """
    graph = Graph()

    def look_up(name: str, column: int) -> int:
        if name == "pi":
            return graph.pi()
        for ending, order in (("_ddot", 2), ("_dot", 1)):
            if name.endswith(ending):
                return graph.symbol(Symbol(name.removesuffix(ending), SymbolKind.COORDINATE, order))
        return graph.symbol(Symbol(name, SymbolKind.COORDINATE if name in states else SymbolKind.PARAMETER))

    return graph, build(formula, graph, look_up)
