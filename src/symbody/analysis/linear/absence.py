"""Whether a coordinate is absent from equations: all their derivatives by it vanish identically."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from symbody.expr.calculus import forward
from symbody.expr.canonical import ONE, ZERO
from symbody.expr.fingerprint import vanishing
from symbody.expr.graph import Graph
from symbody.expr.opcodes import EQ, FLOOR, LE, LT, PICK, SADDLE, SIGN
from symbody.expr.program import unrolled
from symbody.expr.rewrite import symbols_of

# What a coordinate can decide although derivatives by it are 0.
_STEPS: Final = frozenset({LT, LE, EQ, SIGN, FLOOR})


def is_absent(graph: Graph, roots: Sequence[int], symbol: int) -> bool:
    """Return whether nothing in `roots` changes with a symbol.

    True is certain. Systems of equations are compared by their coefficients, so that False may also mean
    that these change and their solution does not.
    """
    if symbol not in symbols_of(graph, roots):
        return True
    roots = unrolled(graph, roots)
    derivatives = {symbol: ONE}
    for operands, results in _stages(graph, roots):
        if not all(vanishing(graph, forward(graph, operands, derivatives))):
            return False
        derivatives.update(dict.fromkeys(results, ZERO))
    return all(vanishing(graph, forward(graph, roots, derivatives)))


def _stages(graph: Graph, roots: Sequence[int]) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Return what systems of equations and steps are made of, in order, and the nodes that follow from it."""
    for node in graph.reachable(roots):
        op = graph.ops[node]
        if op == SADDLE:
            kernel = graph.kernels[graph.right[node]]
            yield graph.operands(node), [graph.node(PICK, node, k) for k in range(kernel.n + kernel.m)]
        elif op in _STEPS:
            yield graph.operands(node), [node]
