"""SymPy at the border: objects made by users come in, closed forms go out. Text is never interpreted.

Coordinates, speeds, inputs and multipliers are ``dynamicsymbols`` and their time derivatives, so results
paste into scripts of sympy.physics.mechanics; parameters are plain symbols without assumptions. Names are
only names: a parameter called ``I`` is ``Symbol("I")``, never the imaginary unit. Functions of the user
are undefined functions of their name; those with a formula, curves, keep its numbers and slopes and come in
written out. An entry k of ``solve_saddle`` is ``solve_saddle_n_m(k, M, J, F, gamma)``, all matrices row by
row.

SymPy flattens, sorts and evaluates as it builds, so going out and coming in again gives the same function,
not always the same node; doing both once more gives the same node. Coming in and going out gives the
same SymPy object, but for what the graph writes otherwise: comparisons turned round, choices with ``Ne`` or
``Not`` turned round too, signs of sums before the product they are in, ``sec, csc, cot, sech, csch, coth,
ceiling, frac, Mod, Heaviside, ITE`` by other functions, whole rounded exponents as integers, rounded numbers
in double precision.

SymPy's rules look deep into their operands, recursively and for hyperbolic functions in exponential time.
They are left on for operands of small height; higher ones are put together as they are, and the two
statements above then hold for values only.

SymPy takes a third of a second to import, which most work does not need: it is imported by the first call:
`sympy_reader` and `sympy_writer` are loaded when they are first read off their package.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, TypeGuard

import symbody.expr.sympy as border
from symbody.expr.graph import Graph, Symbol
from symbody.expr.printing.definitions import EXPAND_LIMIT


class _KnownByName(type):
    """The type of classes that stand for those of SymPy before these are imported."""

    def __instancecheck__(cls, thing: object) -> bool:
        return any(
            kind.__name__ == cls.__name__ and kind.__module__.startswith("sympy.")
            for kind in type(thing).__mro__
        )


if TYPE_CHECKING:
    from symbody.expr.sympy.sympy_reader import Lookup
    from symbody.expr.sympy.sympy_types import SympyEquation as SympyEquation
    from symbody.expr.sympy.sympy_types import SympyExpr as SympyExpr
    from symbody.expr.sympy.sympy_types import SympyMatrix as SympyMatrix
else:
    SympyExpr = _KnownByName("Expr", (), {})
    SympyEquation = _KnownByName("Equality", (), {})
    SympyMatrix = _KnownByName("MutableDenseMatrix", (), {})


def to_sympy(graph: Graph, nodes: Iterable[int]) -> list[SympyExpr]:
    """Return nodes as SymPy expressions written out; shared nodes become shared objects.

    Raises
    ------
    ExpressionError
        If two symbols in them would be the same symbol to SymPy.
    """
    return border.sympy_writer.to_sympy(graph, nodes)


def to_sympy_with_definitions(
    graph: Graph, nodes: Sequence[int], limit: int = EXPAND_LIMIT
) -> tuple[list[SympyExpr], list[tuple[SympyExpr, SympyExpr]]]:
    """Return nodes with shared parts as symbols z1, z2, ... if one exceeds `limit` operations.

    Returns
    -------
    (expressions, definitions)
        Definitions are pairs of symbol and expression, each using earlier symbols only; all together are
        as long as the graph, however often its parts are shared.
    """
    return border.sympy_writer.to_sympy_with_definitions(graph, nodes, limit)


def from_sympy(expression: object, graph: Graph, lookup: Lookup | None = None) -> int:
    """Return the node of a SymPy expression, or of a number; see `sympy_reader.from_sympy`."""
    return border.sympy_reader.from_sympy(expression, graph, lookup)


def nodes_from_sympy(expressions: Iterable[object], graph: Graph, lookup: Lookup | None = None) -> list[int]:
    """Return the nodes of several expressions, which must agree on what their names are."""
    return border.sympy_reader.nodes_from_sympy(expressions, graph, lookup)


def nodes_from_equations(
    equations: Iterable[object], graph: Graph, lookup: Lookup | None = None
) -> list[int]:
    """Return ``left - right`` of equations as nodes; an expression stands for an equation with 0."""
    return border.sympy_writer.nodes_from_equations(equations, graph, lookup)


def time_derivatives(functions: Iterable[SympyExpr]) -> list[SympyExpr]:
    """Return the derivatives of SymPy expressions by time."""
    return border.sympy_writer.time_derivatives(functions)


def sympy_matrix(graph: Graph, rows: int, columns: int, nodes: Sequence[int]) -> SympyMatrix:
    """Return nodes in row-major order as a matrix."""
    matrix: SympyMatrix = border.sympy_writer.sympy_matrix(graph, rows, columns, nodes)
    return matrix


def sympy_equations(graph: Graph, left: Sequence[int], right: Sequence[int]) -> list[SympyEquation]:
    """Return ``left = right``, entry by entry, unevaluated."""
    return border.sympy_writer.sympy_equations(graph, left, right)


def sympy_derivative(thing: object, variables: Sequence[SympyExpr]) -> object:
    """Return the derivative of a SymPy expression, matrix or equation; of anything else None."""
    return border.sympy_writer.sympy_derivative(thing, variables)


def symbol_to_sympy(symbol: Symbol) -> SympyExpr:
    """Return a symbol as SymPy writes it: a function of time, its derivative, or a plain symbol."""
    written: SympyExpr = border.sympy_writer.symbol_to_sympy(symbol)
    return written


def is_expression(thing: object) -> bool:
    """Return whether something is a scalar SymPy expression: nothing is before SymPy is imported."""
    if "sympy" not in sys.modules:
        return False
    return border.sympy_writer.is_expression(thing)


def is_matrix(thing: object) -> TypeGuard[SympyMatrix]:
    """Return whether something is a SymPy matrix, mutable or not."""
    if "sympy" not in sys.modules:
        return False
    return border.sympy_writer.is_matrix(thing)
