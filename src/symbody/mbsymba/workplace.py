"""Where expressions by hand live: a graph of their own for each thread, made when needed, gone with them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from threading import local
from typing import Final
from weakref import ReferenceType, ref

from symbody.errors import Problem, UsageError
from symbody.expr.expression import Expr, common_graph
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.opcodes import SYMBOL
from symbody.expr.sympy.closed_form import readable
from symbody.expr.sympy.sympy_reader import nodes_from_sympy
from symbody.expr.sympy.sympy_writer import SympyExpr, to_sympy
from symbody.spatial.matrix import Triple
from symbody.spatial.placed import PlacedVector


class Workplace(local):
    """The graph and the gravity of one thread; the graph is kept by what is made in it."""

    def __init__(self) -> None:
        self.gravity: PlacedVector | None = None
        self.serial: Iterator[int] = count(1)
        self._graph: ReferenceType[Graph] | None = None

    @property
    def graph(self) -> Graph:
        """The graph in which new expressions are made."""
        graph = None if self._graph is None else self._graph()
        if graph is None:
            graph = Graph()
            self._graph = ref(graph)
        return graph


WORKPLACE: Final = Workplace()


def to_expressions(values: Iterable[object]) -> list[Expr]:
    """Return SymPy expressions, or numbers, as expressions of this thread's graph."""
    graph = WORKPLACE.graph
    return [Expr(graph, node) for node in nodes_from_sympy(values, graph)]


def triple(x: object, y: object, z: object) -> Triple:
    """Return three components."""
    a, b, c = to_expressions((x, y, z))
    return (a, b, c)


def to_sympy_expressions(values: Sequence[Expr]) -> list[SympyExpr]:
    """Return expressions in the short form in which books print them, as SymPy's."""
    if not values:
        return []
    graph, nodes = common_graph(values)
    return to_sympy(graph, readable(graph, nodes))


def function_names(given: object, where: str) -> list[str]:
    """Return the names of functions of time.

    Raises
    ------
    UsageError
        If something is not a function of time.
    """
    items = list(given) if isinstance(given, Iterable) else [given]
    symbols = [_coordinate_symbol(value) for value in to_expressions(items)]
    wrong = [str(item) for item, symbol in zip(items, symbols, strict=True) if symbol is None]
    if wrong:
        raise UsageError(
            Problem("mbsymba.not_a_function", where, f"{', '.join(wrong)} is not a function of time",
                    "coordinates and multipliers change with time",
                    "create it with dynamicsymbols('x'), and give the function itself, not its derivative")
        )  # fmt: skip
    return [symbol.name for symbol in symbols if symbol is not None]


def _coordinate_symbol(value: Expr) -> Symbol | None:
    graph = value.graph
    symbol = graph.symbols[graph.left[value.index]] if graph.ops[value.index] == SYMBOL else None
    return symbol if symbol and symbol.kind is SymbolKind.COORDINATE and not symbol.order else None
