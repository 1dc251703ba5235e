"""Functions that stand by name in formulas for people, and are written out where numbers are needed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol, runtime_checkable

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, UserFunction
from symbody.expr.opcodes import CALL
from symbody.expr.rewrite import substitute


@runtime_checkable
class WrittenFunction(UserFunction, Protocol):
    """A function of one argument that has a formula."""

    def formula(self, x: Expr) -> Expr:
        """Return the value at `x`, written out in the graph of `x`."""


def write_out(graph: Graph, nodes: Sequence[int]) -> list[int]:
    """Return nodes with the formulas of such functions instead of their names."""
    return substitute(graph, nodes, dict(_formulas(graph, graph.reachable(nodes))))


def _formulas(graph: Graph, nodes: Iterable[int]) -> Iterator[tuple[int, int]]:
    for node in nodes:
        function = graph.functions[graph.right[node]] if graph.ops[node] == CALL else None
        if isinstance(function, WrittenFunction):
            yield node, function.formula(Expr(graph, graph.operands(node)[0])).index
