"""Nested sums and products seen as one: terms with their factors, factors with their exponents.

For what leaves the graph only (SymPy, formulas for people): inside it, grouping is kept. The time taken
is that of a pass over the nodes of the sum or product, however often they are shared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping
from fractions import Fraction
from typing import TypeAlias

from symbody.expr.graph import Exact, Graph
from symbody.expr.opcodes import ADD, DIV, MUL, NEG, POW, RATIONAL, SQRT, SUB

SUMS = frozenset({ADD, SUB, NEG})

Parts: TypeAlias = list[tuple[int, Exact]]


def linear_terms(
    graph: Graph, node: int, keep: Collection[int] = (), *, distribute: bool = False
) -> dict[int, Exact]:
    """Return the terms of a sum, each with its exact factor, which is never 0.

    Parameters
    ----------
    keep : collection of nodes
        Taken as terms even if they are sums.
    distribute : bool
        Whether ``2*(x + y)`` counts as ``2*x + 2*y``, as it does in SymPy.
    """

    def parts(item: int) -> Parts:
        op, a, b = graph.ops[item], graph.left[item], graph.right[item]
        if item in keep and item != node:
            return []
        if op == NEG:
            return [(a, -1)]
        if op in SUMS:
            return [(a, 1), (b, 1 if op == ADD else -1)]
        is_scaled = op == MUL and graph.ops[a] == RATIONAL and (distribute or graph.ops[b] not in SUMS)
        return [(b, _exact(graph, a))] if is_scaled else []

    return _sum_items(node, parts)


def power_factors(
    graph: Graph, node: int, keep: Collection[int] = ()
) -> tuple[dict[int, int], dict[int, int]]:
    """Return the factors of a product, and those of its divisor, each with its exponent >= 1.

    Parameters
    ----------
    keep : collection of nodes
        Taken as factors even if they are products.
    """

    def parts(item: int) -> Parts:
        # An item is twice a node, plus one below the line.
        factor, below = divmod(item, 2)
        op, a, b = graph.ops[factor], 2 * graph.left[factor] + below, 2 * graph.right[factor] + below
        if factor in keep and factor != node:
            return []
        if op == POW and isinstance(exponent := graph.number(graph.right[factor]), int) and exponent > 0:
            return [(a, exponent)]
        return [(a, 1), (b if op == MUL else b ^ 1, 1)] if op in (MUL, DIV) else []

    found = {item: int(exponent) for item, exponent in _sum_items(2 * node, parts).items()}
    return _half(found, 0), _half(found, 1)


def without_square_roots(
    graph: Graph, above: dict[int, int], below: dict[int, int], keep: Collection[int] = ()
) -> tuple[dict[int, int], dict[int, int]]:
    """Return the factors of a product and of its divisor with ``x`` for ``sqrt(x)^2`` below, cancelled."""
    roots = [node for node in below if graph.ops[node] == SQRT and below[node] > 1 and node not in keep]
    if not roots:
        return above, below
    top, bottom = Counter(above), Counter(below)
    for root in roots:
        squares, rest = divmod(bottom.pop(root), 2)
        bottom += Counter({root: rest})
        inside, under = power_factors(graph, graph.left[root], keep)
        for factor, exponent in inside.items():
            common = min(squares * exponent, top[factor])
            top -= Counter({factor: common})
            bottom += Counter({factor: squares * exponent - common})
        top += Counter({factor: squares * exponent for factor, exponent in under.items()})
    return dict(top), dict(bottom)


def nested_operands(graph: Graph, node: int, keep: Collection[int] = ()) -> list[int]:
    """Return the operands of nested minima, maxima or connectives of one kind, each once, by structure."""
    code = graph.ops[node]
    seen: set[int] = set()
    found: set[int] = set()
    stack = [node]
    while stack:
        item = stack.pop()
        if graph.ops[item] != code or (item in keep and item != node):
            found.add(item)
        elif item not in seen:
            seen.add(item)
            stack.extend(graph.operands(item))
    return sorted(found, key=graph.hashes.__getitem__)


def _half(found: Mapping[int, int], below: int) -> dict[int, int]:
    return {item // 2: exponent for item, exponent in found.items() if item % 2 == below}


def _exact(graph: Graph, node: int) -> Exact:
    value = graph.number(node)
    return value if isinstance(value, int) else Fraction(value or 0)


def _sum_items(root: int, parts: Callable[[int], Parts]) -> dict[int, Exact]:
    """Return the items without parts below `root`, with the sum over all ways to them."""
    inner: dict[int, Parts] = {}
    stack = [root]
    while stack:
        item = stack.pop()
        if item not in inner:
            inner[item] = parts(item)
            stack.extend(part for part, _ in inner[item])
    weights: dict[int, Exact] = {root: 1}
    # Operands are older than what they are operands of, so descending order meets every use first.
    for item in sorted(inner, reverse=True):
        if inner[item]:
            weight = weights.pop(item)
            for part, factor in inner[item]:
                weights[part] = weights.get(part, 0) + weight * factor
    return {item: weight for item, weight in weights.items() if weight}
