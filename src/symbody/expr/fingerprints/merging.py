"""Merging of equal values before use: one fingerprint, one node, the cheaper definition wins.

Each output is merged by itself, so that its value has the same bits whether it is asked for alone
or together with others. A definition that can fail (division, root, logarithm) never replaces one that
cannot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from symbody.expr.canonical import ONE, ZERO, add, div, make, mul, neg, sub
from symbody.expr.deadline import check
from symbody.expr.fingerprints.circle import Pair
from symbody.expr.fingerprints.fingerprint import drop_signs, fingerprints
from symbody.expr.fingerprints.shapes import shape
from symbody.expr.graph import Constant, Graph, copied_datum, copy_nodes
from symbody.expr.opcodes import (
    ACOS,
    ADD,
    ARITY,
    ASIN,
    CALL,
    COS,
    DIV,
    FMA,
    LOG,
    MAP,
    MUL,
    NEG,
    POW,
    SADDLE,
    SIN,
    SQRT,
    SUB,
    TAN,
)  # fmt: skip
from symbody.expr.rewrite import node_cost

# By what a product is chosen: a sine or cosine among its factors, the size of a constant, shape and hash of
# the smaller factor, which limbs share if it belongs to the trunk.
_Look = tuple[int, Constant, int, int]
_NO_PRODUCT: _Look = (0, 0, 0, 0)
_TWO: Final[Mapping[int, Callable[[Graph, int, int], int]]] = {ADD: add, SUB: sub, MUL: mul, DIV: div}
_RISKY = frozenset({ACOS, ASIN, CALL, DIV, LOG, MAP, SADDLE, SQRT, TAN})


def merge_equal(source: Graph, roots: Sequence[int], target: Graph, given: Sequence[int] = ()) -> list[int]:
    """Return the `roots` rebuilt in `target` with equal or opposite values computed once.

    Parameters
    ----------
    given : sequence of int
        Some of the roots: what they take is defined as if they were alone, and used by the others, also where
        it can fail and something equal could not: then the given ones fail anyway.
    """
    nodes = source.reachable([ZERO, ONE, *roots])
    keys, flipped = drop_signs(fingerprints(source, nodes))
    check()
    rank = _ranks(source, nodes)
    check()
    fixed: dict[Pair, int] = {}
    if given:
        below = source.reachable([ZERO, ONE, *given])
        alone = _cheapest(below, keys, rank, {})
        fixed = {keys[node]: node for node in _find_needed(source, given, alone)}
    best = _cheapest(nodes, keys, rank, fixed)
    kept = _find_needed(source, roots, best)
    check()
    # A representative ranks no higher than what it replaces, so this order puts operands first; those that
    # are fixed read only each other.
    early = {node for node in kept if fixed.get(keys[node]) == node} if fixed else set()
    order = [*sorted(early, key=rank.__getitem__), *sorted(kept - early, key=rank.__getitem__)]
    return _rebuild(source, order, target, roots, best, flipped)


def _rebuild(
    source: Graph,
    order: Iterable[int],
    target: Graph,
    roots: Sequence[int],
    best: Mapping[int, int],
    flipped: Mapping[int, bool],
) -> list[int]:
    """Return the `roots` made in `target` of the representatives in `order`, operands first."""
    built: dict[int, int] = {}
    ops, left, right = source.ops, source.left, source.right

    def in_target(node: int) -> int:
        other = best[node]
        return built[other] if flipped[node] == flipped[other] else neg(target, built[other])

    for node in order:
        op = ops[node]
        if ADD <= op <= DIV:  # most are
            built[node] = _TWO[op](target, in_target(left[node]), in_target(right[node]))
        elif op == NEG:
            built[node] = neg(target, in_target(left[node]))
        else:
            built[node] = _rebuilt(source, node, target, [in_target(k) for k in source.operands(node)])
    return [in_target(root) for root in roots]


def contract_products(graph: Graph, roots: Sequence[int], given: Sequence[int] = ()) -> list[int]:
    """Return the `roots` with ``a*b + c`` as one rounding where the product has no other use.

    Those that are `given` are as if they were alone.
    """
    memo: dict[int, int] = {}
    if given:
        _contract(graph, given, memo)
    _contract(graph, roots, memo)
    return [memo[root] for root in roots]


def _contract(graph: Graph, roots: Sequence[int], memo: dict[int, int]) -> None:
    """Add to `memo` what is not in it yet."""
    nodes = graph.reachable(roots)
    operands = [graph.operands(node) for node in nodes]
    uses = dict.fromkeys(nodes, 0)
    for old in operands:
        for operand in old:
            uses[operand] += 1
    for root in roots:
        uses[root] += 1
    looks, ops = _looks(graph, nodes, operands), graph.ops
    for node, old in zip(nodes, operands, strict=True):
        if node in memo:
            continue
        op = ops[node]
        fused = _fuse(graph, node, uses, looks, memo) if op in (ADD, SUB) else None
        if fused is not None:
            memo[node] = fused
        elif ADD <= op <= DIV:  # most are
            a, b = old
            x, y = memo[a], memo[b]
            memo[node] = node if x == a and y == b else graph.node(op, x, y)
        else:
            memo[node] = _remade(graph, node, old, memo)


def _looks(graph: Graph, nodes: Sequence[int], operands: Sequence[tuple[int, ...]]) -> dict[int, _Look]:
    """Return by what products are chosen, so that limbs that differ in one place are alike in all others."""
    shapes: dict[int, int] = {}
    sizes: dict[int, float] = {}
    looks: dict[int, _Look] = {}
    for node, old in zip(nodes, operands, strict=True):
        shapes[node] = shape(graph.ops[node], tuple([shapes[k] for k in old]))
        sizes[node] = 1.0 + sum([sizes[k] for k in old])
        factors = _factors(graph, node)
        if factors is not None:
            numbers: list[Constant] = [
                number if number > 0 else -number for k in factors if (number := graph.number(k)) is not None
            ]
            circle = max([graph.ops[k] for k in factors if graph.ops[k] in (SIN, COS)], default=0)
            _, look, code = min([(sizes[k], shapes[k], graph.hashes[k]) for k in factors])
            looks[node] = circle, max(numbers, default=0), look, code
    return looks


def _fuse(
    graph: Graph, node: int, uses: dict[int, int], looks: dict[int, _Look], memo: dict[int, int]
) -> int | None:
    """Return a sum with one of its products fused, that of the greater look."""
    a, b, ops = graph.left[node], graph.right[node], graph.ops
    if not any(uses[k] == 1 and ops[k] in (MUL, POW) for k in (a, b)):
        return None
    sign = -1 if ops[node] == SUB else 1
    sides = [(a, b, 1, sign), (b, a, sign, 1)]
    if looks.get(b, _NO_PRODUCT) > looks.get(a, _NO_PRODUCT):
        sides.reverse()
    for product, rest, product_sign, rest_sign in sides:
        factors = _factors(graph, product) if uses[product] == 1 else None
        if factors is not None:
            x, y, z = memo[factors[0]], memo[factors[1]], memo[rest]
            x = neg(graph, x) if product_sign < 0 else x
            z = neg(graph, z) if rest_sign < 0 else z
            return graph.many(FMA, (x, y, z))
    return None


def _factors(graph: Graph, node: int) -> tuple[int, int] | None:
    if graph.ops[node] == MUL:
        return graph.left[node], graph.right[node]
    if graph.ops[node] == POW and graph.number(graph.right[node]) == 2:
        return graph.left[node], graph.left[node]
    return None


def _remade(graph: Graph, node: int, old: tuple[int, ...], memo: dict[int, int]) -> int:
    """Return `node` with new operands, without folding: contraction must not move signs or terms."""
    new = tuple([memo[k] for k in old])
    if new == old:
        return node
    op = graph.ops[node]
    if ARITY[op] == 2:
        return graph.node(op, *new)
    return (
        graph.node(op, new[0], graph.right[node])
        if ARITY[op] == 1
        else graph.many(op, new, graph.right[node])
    )


def _ranks(graph: Graph, nodes: Sequence[int]) -> dict[int, tuple[bool, float, int, int]]:
    """Return (can fail, size written out, depth, hash) of each node: a strict order, operands first.

    Nothing in it depends on when a node was made, nor on what else was asked for. Sizes saturate.
    """
    ranks: dict[int, tuple[bool, float, int, int]] = {}
    ops, left, right, hashes = graph.ops, graph.left, graph.right, graph.hashes
    for node in nodes:
        op = ops[node]
        if ADD <= op <= MUL:  # most are, and these need no look further
            fails, size, depth, _ = ranks[left[node]]
            also, more, other, _ = ranks[right[node]]
            top = depth if depth > other else other
            ranks[node] = (fails or also, 1.0 + (size + more), 1 + top, hashes[node])
            continue
        below = [ranks[k] for k in graph.operands(node)]
        risky = op in _RISKY or (op == POW and not isinstance(graph.number(right[node]), int))
        ranks[node] = (
            risky or any([rank[0] for rank in below]),
            float(node_cost(graph, node)) + sum([rank[1] for rank in below]),
            1 + max([rank[2] for rank in below], default=0),
            hashes[node],
        )
    return ranks


def _cheapest(
    nodes: Iterable[int],
    keys: Mapping[int, Pair],
    rank: Mapping[int, tuple[bool, float, int, int]],
    fixed: Mapping[Pair, int],
) -> dict[int, int]:
    """Return for each node the one that stands for all of its value: a fixed one, or that of lowest rank."""
    chosen: dict[Pair, int] = {}
    for node in nodes:
        known = chosen.get(keys[node])
        if known is None or rank[node] < rank[known]:
            chosen[keys[node]] = node
    chosen |= fixed
    return {node: chosen[keys[node]] for node in nodes}


def _find_needed(graph: Graph, roots: Sequence[int], best: dict[int, int]) -> set[int]:
    needed = {best[root] for root in roots}
    found = list(needed)
    for node in found:  # it grows meanwhile
        for operand in graph.operands(node):
            other = best[operand]
            if other not in needed:
                needed.add(other)
                found.append(other)
    return needed


def _rebuilt(source: Graph, node: int, target: Graph, operands: list[int]) -> int:
    op = source.ops[node]
    if not operands:
        return copy_nodes(source, target, [node], {})[0]
    return make(target, op, tuple(operands), copied_datum(source, target, node))
