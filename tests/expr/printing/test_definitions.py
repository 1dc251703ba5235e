"""Names for shared parts."""

from __future__ import annotations

from symbody.expr.canonical import add, apply, mul, neg, select
from symbody.expr.graph import Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.opcodes import LT, PICK, SADDLE, SIN
from symbody.expr.printing.definitions import definitions
from symbody.expr.rewrite import operation_count, substitute, symbols_of, tree_size


def doubling(graph: Graph, depth: int) -> int:
    """Return a formula of `depth` levels in which every level uses the one below twice."""
    node = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    for k in range(depth):
        node = add(graph, mul(graph, apply(graph, SIN, node), node), graph.symbol(Symbol(f"a{k}")))
    return node


def test_nothing_is_named_up_to_the_limit() -> None:
    graph = Graph()
    node = doubling(graph, 4)
    size = tree_size(graph, node)
    assert definitions(graph, [node], size) == {}
    assert definitions(graph, [node], size - 1)


def test_formulas_with_names_are_as_short_as_the_graph() -> None:
    graph = Graph()
    roots = [doubling(graph, 200), doubling(graph, 150)]
    named = definitions(graph, roots)
    symbols = {node: graph.symbol(Symbol(name)) for node, name in named.items()}
    written = [
        substitute(graph, [node], {k: s for k, s in symbols.items() if k != node})[0] for node in named
    ] + substitute(graph, roots, symbols)
    # At most one operation is written at each use of a value, besides those that compute it.
    assert sum(tree_size(graph, node) for node in written) <= 3 * operation_count(graph, roots)


def test_each_definition_uses_earlier_names_only() -> None:
    graph = Graph()
    named = definitions(graph, [doubling(graph, 30)], 0)
    known: set[int] = set()
    for node in named:
        assert known.issuperset(set(graph.reachable([node])) & set(named) - {node})
        known.add(node)
    assert list(named.values()) == [f"z{k}" for k in range(1, len(named) + 1)]


def test_names_of_symbols_are_left_to_them() -> None:
    graph = Graph()
    speed = graph.symbol(Symbol("z3", SymbolKind.COORDINATE, 1))
    taken = add(graph, graph.symbol(Symbol("z1")), speed)
    named = definitions(graph, [mul(graph, doubling(graph, 6), taken)], 0)
    labels = {graph.symbols[graph.left[k]].label for k in symbols_of(graph, [taken])}
    assert labels == {"z1", "z3_dot"}
    assert list(named.values())[:3] == ["z2", "z4", "z5"]


def test_small_values_signs_and_conditions_have_no_names() -> None:
    graph = Graph()
    x, y, c = (graph.symbol(Symbol(name)) for name in "xyc")
    short = add(graph, x, y)
    condition = apply(graph, LT, apply(graph, SIN, short), c)
    root = add(graph, select(graph, condition, x, neg(graph, short)), select(graph, condition, c, short))
    named = definitions(graph, [root], 0)
    assert list(named) == [apply(graph, SIN, short)]


def test_operands_of_a_kernel_are_named_since_each_entry_shows_them() -> None:
    graph = Graph()
    force = doubling(graph, 1)
    mass = graph.symbol(Symbol("m"))
    solved = graph.many(SADDLE, (mass, force), graph.kernel(KernelNode(1, 0)))
    entries = [graph.node(PICK, solved, k) for k in (0, 1)]
    assert list(definitions(graph, entries, 0)) == [force]
    assert definitions(graph, entries[:1], 0) == {}
