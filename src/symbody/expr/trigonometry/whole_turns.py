"""Which symbols are angles: those that may grow by whole turns while nothing changes."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, COS, DIV, MUL, NEG, RATIONAL, SIN, SUB, TAN


def turning_symbols(graph: Graph, roots: Sequence[int], symbols: Sequence[int]) -> list[int]:
    """Return those symbols that stand in `roots`, and only in sines, cosines and tangents.

    They stand there with whole factors: that of half an angle changes its sign with a whole turn.
    """
    reached = graph.reachable(roots)
    return [symbol for symbol in symbols if _is_turning(graph, reached, roots, symbol)]


def _is_turning(graph: Graph, reached: Sequence[int], roots: Sequence[int], symbol: int) -> bool:
    slopes = {symbol: Fraction(1)}  # nodes of first degree in the symbol
    turned: set[int] = set()  # those that do not change by a whole turn
    for node in reached:
        operands = graph.operands(node)
        if node == symbol or slopes.keys().isdisjoint(operands):
            if not turned.isdisjoint(operands):
                turned.add(node)
            continue
        slope = None if not turned.isdisjoint(operands) else _slope(graph, node, slopes)
        if slope is None:
            return False
        if graph.ops[node] not in (SIN, COS, TAN):
            slopes[node] = slope
        elif slope.denominator == 1:
            turned.add(node)
        else:
            return False
    return bool(turned) and slopes.keys().isdisjoint(roots)


def _slope(graph: Graph, node: int, slopes: dict[int, Fraction]) -> Fraction | None:
    """Return the slope of a node, of the angle if it is a sine; None if it is not of first degree."""
    op, a, b = graph.ops[node], graph.left[node], graph.right[node]
    none = Fraction(0)
    if op in (SIN, COS, TAN):
        return slopes[a]
    if op == NEG:
        return -slopes[a]
    if op in (ADD, SUB):
        return slopes.get(a, none) + slopes.get(b, none) * (1 if op == ADD else -1)
    factor = _number(graph, b if a in slopes else a)
    if factor is None or (op == DIV and b in slopes) or op not in (MUL, DIV):
        return None
    return slopes[a if a in slopes else b] * factor if op == MUL else slopes[a] / factor


def _number(graph: Graph, node: int) -> Fraction | None:
    if graph.ops[node] == NEG:
        inner = _number(graph, graph.left[node])
        return None if inner is None else -inner
    return Fraction(graph.constants[graph.left[node]]) if graph.ops[node] == RATIONAL else None
