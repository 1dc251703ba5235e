"""Derivatives where an expression has branches: what belongs to a branch not taken is never multiplied.

In a reverse sweep a select, min or max adds its weight to one operand where its condition holds and to
the other where not. Multiplying by 1 or 0 instead would turn an infinite slope of the branch not taken
into 0 * inf. So weights are kept apart by the conditions under which they hold until the branches meet again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from symbody.expr.canonical import ZERO, add, apply, mul, select
from symbody.expr.graph import Graph
from symbody.expr.opcodes import LE, LT, MAX, MIN, SELECT

Branch = frozenset[tuple[int, bool]]  # conditions, and whether they hold
Literals = tuple[tuple[int, bool], ...]
Weights = dict[Branch, int]

ALWAYS: Final[Branch] = frozenset()

# Branches that never meet again could double at every select; more than this are added up.
_MAX_BRANCHES: Final = 16


def alternatives(graph: Graph, node: int) -> tuple[tuple[Literals, int | None], ...]:
    """Return what a select, min or max is: conditions with their values, and the operand that they choose.

    No operand stands where numbers cannot be compared: one of them is nan, so is the node, and its slope is
    to be, in whatever order the operands are. Nothing is returned of other nodes.
    """
    op = graph.ops[node]
    if op == SELECT:
        condition, then, otherwise = graph.operands(node)
        return (((condition, True),), then), (((condition, False),), otherwise)
    if op not in (MIN, MAX):
        return ()
    a, b = graph.operands(node)
    left, right = (a, b) if op == MIN else (b, a)
    first, second = apply(graph, LT, left, right), apply(graph, LE, right, left)
    others: Literals = ((first, False), (second, False))
    return (((first, True),), a), (((first, False), (second, True)), b), (others, None)


def chosen_tangent(graph: Graph, node: int, known: Mapping[int, int]) -> int | None:
    """Return the tangent of a select, min or max from those of its operands, None for other nodes."""
    result: int | None = None
    for conditions, operand in reversed(alternatives(graph, node)):
        value = node if operand is None else known.get(operand, ZERO)
        result = value if result is None else select(graph, conditions[-1][0], value, result)
    return result


def hand_on(graph: Graph, weights: Weights, slope: int, onto: Weights) -> None:
    """Add ``weights * slope`` to the weights `onto`."""
    for branch, weight in weights.items():
        onto[branch] = add(graph, onto.get(branch, ZERO), mul(graph, weight, slope))


def hand_on_within(graph: Graph, weights: Weights, conditions: Literals, onto: Weights) -> None:
    """Add the `weights` to `onto` where `conditions` hold."""
    opposite = {(condition, not holds) for condition, holds in conditions}
    for branch, weight in weights.items():
        if opposite.isdisjoint(branch):
            inner = branch.union(conditions)
            onto[inner] = add(graph, onto.get(inner, ZERO), weight)


def join_branches(graph: Graph, weights: Weights) -> Weights:
    """Return the weights with branches put together that cover both values of a condition."""
    left = dict(weights)
    done: Weights = {}
    while left:
        branch, weight = left.popitem()
        for condition, holds in _in_order(graph, branch):
            outer = branch - {(condition, holds)}
            partner = outer | {(condition, not holds)}
            if partner in left:
                pair = (weight, left.pop(partner)) if holds else (left.pop(partner), weight)
                left[outer] = add(graph, left.get(outer, ZERO), select(graph, condition, *pair))
                break
        else:
            # Perhaps not the first: a pair may have been put together after its outer branch was done.
            done[branch] = add(graph, done.get(branch, ZERO), weight)
    return done if len(done) <= _MAX_BRANCHES else {ALWAYS: total(graph, done)}


def total(graph: Graph, weights: Weights) -> int:
    """Return the sum of all weights, each zero outside its branch."""
    result = ZERO
    for branch, weight in weights.items():
        for condition, holds in _in_order(graph, branch):
            pair = (weight, ZERO) if holds else (ZERO, weight)
            weight = select(graph, condition, *pair)
        result = add(graph, result, weight)
    return result


def _in_order(graph: Graph, branch: Branch) -> list[tuple[int, bool]]:
    return sorted(branch, key=lambda literal: (graph.hashes[literal[0]], literal[1]))
