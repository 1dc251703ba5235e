"""SymPy expressions as text of symbody's own language, so that they stand wherever text stands."""

from __future__ import annotations

from symbody.errors import ExpressionError, Problem
from symbody.expr.graph import Graph
from symbody.expr.printing.text import to_text
from symbody.expr.sympy.sympy_reader import from_sympy


def sympy_text(expression: object, where: str = "") -> str:
    """Return a SymPy expression as text; functions of time by their names, derivatives with ``_dot``.

    Raises
    ------
    ExpressionError
        For objects that are not real scalar expressions, and names that text cannot have.
    """
    graph = Graph()
    try:
        return to_text(graph, from_sympy(expression, graph))
    except ExpressionError as error:
        raise ExpressionError(
            *(Problem(p.code, p.where or where, p.what, p.why, p.fix) for p in error.problems)
        ) from error
