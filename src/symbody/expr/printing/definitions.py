"""Names z1, z2, ... for shared parts, so that formulas stay as short as the graph they are written from."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Final

from symbody.expr.graph import Graph
from symbody.expr.opcodes import CONDITIONS, NEG, SADDLE
from symbody.expr.rewrite import node_cost, symbols_of

EXPAND_LIMIT: Final = 20_000  # operations of a formula written out
_UNNAMED: Final = CONDITIONS | {NEG, SADDLE}  # no numbers by themselves, or nothing to name
_MANY: Final = 1 << 62  # sizes and uses beyond this count as equal


def definitions(graph: Graph, roots: Sequence[int], limit: int = EXPAND_LIMIT) -> dict[int, str]:
    """Return the nodes to be named, operands first, with their names.

    Nothing is named while every root has at most `limit` operations written out. Above it, every value
    of two operations or more that would be written more than once is named; names of symbols are avoided.
    """
    nodes = graph.reachable(roots)
    sizes = _sizes(graph, nodes)
    if max((sizes[root] for root in roots), default=0) <= limit:
        return {}
    taken = set[str]()
    for node in symbols_of(graph, roots):
        symbol = graph.symbols[graph.left[node]]
        taken |= {symbol.name, symbol.label}
    names = (name for number in count(1) if (name := f"z{number}") not in taken)
    return {node: next(names) for node in _find_shared(graph, nodes, roots, sizes)}


def _sizes(graph: Graph, nodes: Sequence[int]) -> dict[int, int]:
    """Return the operations of each node written out."""
    sizes: dict[int, int] = {}
    for node in nodes:
        total = node_cost(graph, node) + sum([sizes[k] for k in graph.operands(node)])
        sizes[node] = min(total, _MANY)
    return sizes


def _find_shared(
    graph: Graph, nodes: Sequence[int], roots: Sequence[int], sizes: dict[int, int]
) -> list[int]:
    """Return, ascending, the nodes that would be written more than once if they had no name."""
    uses = dict.fromkeys(nodes, 0)
    for root in roots:
        uses[root] += 1
    shared: list[int] = []
    for node in reversed(nodes):
        op = graph.ops[node]
        is_named = uses[node] > 1 and sizes[node] > 1 and op not in _UNNAMED
        if is_named:
            shared.append(node)
        weight = 1 if is_named else min(uses[node], _MANY)
        for operand in graph.operands(node):
            uses[operand] += weight
    return shared[::-1]
