"""Derivatives where an expression has branches: what belongs to a branch not taken is never multiplied.

In a reverse sweep a select, min or max adds its weight to one operand where its condition holds and to
the other where not. Multiplying by 1 or 0 instead would turn an infinite slope of the branch not taken
into 0 * inf. So weights are kept apart by the conditions under which they hold until the branches meet again.
"""

from __future__ import annotations

from typing import Final

from symbody.expr.canonical import ZERO, add, apply, mul, select
from symbody.expr.graph import Graph
from symbody.expr.opcodes import LT, MAX, MIN, SELECT

Branch = frozenset[tuple[int, bool]]  # conditions, and whether they hold
Weights = dict[Branch, int]

ALWAYS: Final[Branch] = frozenset()

# Branches that never meet again could double at every select; more than this are added up.
_MAX_BRANCHES: Final = 16


def alternatives(graph: Graph, node: int) -> tuple[int, int, int] | None:
    """Return (condition, value if it holds, value if not) of a select, min or max, else None."""
    op = graph.ops[node]
    if op == SELECT:
        condition, then, otherwise = graph.operands(node)
        return condition, then, otherwise
    if op not in (MIN, MAX):
        return None
    a, b = graph.operands(node)
    return (apply(graph, LT, a, b) if op == MIN else apply(graph, LT, b, a)), a, b


def hand_on(graph: Graph, weights: Weights, slope: int, onto: Weights) -> None:
    """Add ``weights * slope`` to the weights `onto`."""
    for branch, weight in weights.items():
        onto[branch] = add(graph, onto.get(branch, ZERO), mul(graph, weight, slope))


def hand_on_within(graph: Graph, weights: Weights, condition: int, holds: bool, onto: Weights) -> None:
    """Add the `weights` to `onto` where `condition` has the value `holds`."""
    for branch, weight in weights.items():
        if (condition, not holds) not in branch:
            inner = branch | {(condition, holds)}
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
            done[branch] = weight
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
