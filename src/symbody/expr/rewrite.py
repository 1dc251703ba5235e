"""Substitution: rebuild what depends on replaced nodes, keep everything else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from symbody.errors import ExpressionError
from symbody.expr.canonical import make
from symbody.expr.graph import Graph, SymbolKind, copied_datum, copy_node, copy_nodes
from symbody.expr.opcodes import COST, POW, SELECT, SYMBOL

Make = Callable[[Graph, int, tuple[int, ...], int], int]  # as `make`


class Substitution:
    """Nodes replaced by others, all at once; replacements are not searched again.

    What has been visited is kept: many roots that share nodes cost as much as one that has all of them.

    Parameters
    ----------
    replacements : mapping of node to node
    made : callable, optional
        Makes each node that changes.
    """

    def __init__(self, graph: Graph, replacements: Mapping[int, int], made: Make = make) -> None:
        self.graph, self._made = graph, made
        self._memo = dict(replacements)

    def roots(self, roots: Sequence[int]) -> list[int]:
        """Return what becomes of the `roots`.

        What has no value, as a division by what has become 0, is left out where a choice does not take it.

        Raises
        ------
        ExpressionError
            If a root has none.
        """
        graph, memo, made = self.graph, self._memo, self._made
        ops, operands = graph.ops, graph.operands
        undefined: dict[int, ExpressionError] = {}
        for node in graph.reachable(roots, memo):
            old = operands(node)
            if undefined and not undefined.keys().isdisjoint(old):
                chosen = _decide_branch(graph, ops[node], old, [memo.get(k, k) for k in old], undefined)
                if chosen is None:
                    undefined[node] = next(undefined[k] for k in old if k in undefined)
                else:
                    memo[node] = chosen
                continue
            new = tuple([memo[k] for k in old])
            try:
                memo[node] = node if new == old else made(graph, ops[node], new, graph.datum(node))
            except ExpressionError as error:
                undefined[node] = error
        return _check_defined(roots, memo, undefined)


def substitute(
    graph: Graph, roots: Sequence[int], replacements: Mapping[int, int], made: Make = make
) -> list[int]:
    """Return the `roots` with nodes replaced; see `Substitution`."""
    return Substitution(graph, replacements, made).roots(roots)


def substitute_into(
    target: Graph, source: Graph, roots: Sequence[int], replacements: Mapping[int, int]
) -> list[int]:
    """Substitute into another graph; the source does not grow."""
    values = copy_nodes(source, target, replacements.values(), {})
    memo = dict(zip(replacements, values, strict=True))
    changed = set(memo)
    undefined: dict[int, ExpressionError] = {}
    for node in source.reachable(roots):
        if node in changed:
            continue
        old = source.operands(node)
        if undefined and not undefined.keys().isdisjoint(old):
            new = tuple([memo.get(k, -1) for k in old])
            chosen = _decide_branch(target, source.ops[node], old, new, undefined)
            if chosen is None:
                undefined[node] = next(undefined[k] for k in old if k in undefined)
                continue
            memo[node] = chosen
            changed.add(node)
            continue
        if changed.isdisjoint(old):
            memo[node] = copy_node(source, target, node, memo)
            continue
        datum = copied_datum(source, target, node)
        try:
            memo[node] = make(target, source.ops[node], tuple([memo[k] for k in old]), datum)
        except ExpressionError as error:
            undefined[node] = error
        changed.add(node)
    return _check_defined(roots, memo, undefined)


def _decide_branch(
    graph: Graph, code: int, old: Sequence[int], new: Sequence[int], undefined: Mapping[int, ExpressionError]
) -> int | None:
    """Return the operand that a decided condition selects, if it has a value, else None."""
    if code != SELECT or old[0] in undefined:
        return None
    decided = graph.number(new[0])
    if decided is None:
        return None
    place = 1 if decided else 2
    return None if old[place] in undefined else new[place]


def _check_defined(
    roots: Sequence[int], memo: Mapping[int, int], undefined: Mapping[int, ExpressionError]
) -> list[int]:
    for root in roots:
        if root in undefined:
            raise undefined[root]
    return [memo.get(root, root) for root in roots]


def symbols_of(graph: Graph, roots: Iterable[int]) -> list[int]:
    """Return the symbol nodes the `roots` depend on, in order of creation."""
    return [node for node in graph.reachable(roots) if graph.ops[node] == SYMBOL]


def operation_count(graph: Graph, roots: Iterable[int]) -> int:
    """Return the operations of a shared evaluation: + - * / and functions 1 each, negation 0, fma 2.

    A whole power counts its multiplications by squaring.
    """
    total = 0
    for node in graph.reachable(roots):
        total += node_cost(graph, node)
    return total


def node_cost(graph: Graph, node: int) -> int:
    """Return the operations of one node, its operands given."""
    op = graph.ops[node]
    if op == POW:
        exponent = graph.number(graph.right[node])
        if isinstance(exponent, int):
            return multiplications(exponent)
    return COST[op]


def multiplications(exponent: int) -> int:
    """Return the multiplications of square-and-multiply for a whole exponent >= 1."""
    return exponent.bit_length() - 1 + exponent.bit_count() - 1


def tree_size(graph: Graph, root: int) -> int:
    """Return the operations of `root` written out as one formula; exact, however large."""
    return tree_sizes(graph, [root])[0]


def tree_sizes(graph: Graph, roots: Sequence[int]) -> list[int]:
    """Return the operations of each root written out as one formula, in one pass over what they share."""
    size: dict[int, int] = {}
    for node in graph.reachable(roots):
        size[node] = node_cost(graph, node) + sum(size[k] for k in graph.operands(node))
    return [size[root] for root in roots]


def dependence(graph: Graph, roots: Iterable[int]) -> dict[int, frozenset[SymbolKind]]:
    """Return for every reachable node the kinds of symbols it depends on."""
    found: dict[int, frozenset[SymbolKind]] = {}
    nothing: frozenset[SymbolKind] = frozenset()
    for node in graph.reachable(roots):
        if graph.ops[node] == SYMBOL:
            found[node] = frozenset({graph.symbols[graph.left[node]].kind})
        else:
            found[node] = nothing.union(*[found[k] for k in graph.operands(node)])
    return found
