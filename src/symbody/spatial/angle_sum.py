"""Sums of angles in which opposite terms cancel: ``(a + b) - b`` is ``a``.

The graph adds two nodes without looking inside them, which is not enough for turns forth and back.
"""

from __future__ import annotations

from fractions import Fraction

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, MUL, NEG, RATIONAL, SUB

Form = dict[int, Fraction]


def angle_sum(a: Expr, b: Expr) -> Expr:
    """Return ``a + b``, collected if the two have a term in common."""
    if a.graph is not b.graph:
        return a + b
    graph = a.graph
    first, second = _linear_form(graph, a.index), _linear_form(graph, b.index)
    if first.keys().isdisjoint(second):
        return a + b  # as it is: longer sums go on sharing the shorter ones
    for node, factor in second.items():
        first[node] = first.get(node, Fraction(0)) + factor
    total = Expr(graph, 0)
    for node, factor in first.items():
        total = total + Expr(graph, node) * factor
    return total


def _linear_form(graph: Graph, node: int) -> Form:
    """Return the terms of a sum with their exact factors, in the order they are written."""
    form: Form = {}
    stack = [(node, Fraction(1))]
    while stack:
        term, factor = stack.pop()
        op, left, right = graph.ops[term], graph.left[term], graph.right[term]
        if op in (ADD, SUB):
            stack.append((right, factor if op == ADD else -factor))
            stack.append((left, factor))
        elif op == NEG:
            stack.append((left, -factor))
        elif op == MUL and graph.ops[left] == RATIONAL:
            stack.append((right, factor * Fraction(graph.constants[graph.left[left]])))
        else:
            form[term] = form.get(term, Fraction(0)) + factor
    return form
