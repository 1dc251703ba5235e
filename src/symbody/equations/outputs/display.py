"""Equations of motion as a person writes them: what moves on the left, what drives it on the right."""

from __future__ import annotations

from symbody.equations.outputs.textbook import Textbook
from symbody.expr.canonical import ZERO, add, sub
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.opcodes import ADD, NEG, SUB
from symbody.expr.rewrite import dependence

_MOVING = frozenset({SymbolKind.COORDINATE, SymbolKind.SPEED, SymbolKind.MULTIPLIER})


def equation_sides(textbook: Textbook) -> list[tuple[int, int]]:
    """Return the nodes of the left and the right side of each equation."""
    graph = textbook.formed.graph
    pairs = zip(textbook.inertial_side.nodes, textbook.shown_forcing_side.nodes, strict=True)
    return [_sides(graph, sub(graph, inertial, driving)) for inertial, driving in pairs]


def _sides(graph: Graph, total: int) -> tuple[int, int]:
    """Split ``total = 0`` into terms that move and terms that do not."""
    kinds = dependence(graph, [total])
    left, right = ZERO, ZERO
    for sign, term in signed_terms(graph, total):
        if kinds[term] & _MOVING:
            left = add(graph, left, term) if sign > 0 else sub(graph, left, term)
        else:
            right = sub(graph, right, term) if sign > 0 else add(graph, right, term)
    return left, right


def signed_terms(graph: Graph, node: int) -> list[tuple[int, int]]:
    """Return the signed terms of a sum, nested sums included."""
    terms = []
    stack = [(1, node)]
    while stack:
        sign, node = stack.pop()
        op = graph.ops[node]
        if op in (ADD, SUB):
            stack += [(sign if op == ADD else -sign, graph.right[node]), (sign, graph.left[node])]
        elif op == NEG:
            stack.append((-sign, graph.left[node]))
        else:
            terms.append((sign, node))
    return terms
