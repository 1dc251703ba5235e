"""The arena: one node for equal structure, safe in threads, flat in depth, without leaks."""

from __future__ import annotations

import gc
import random
import sys
import threading
import tracemalloc
from collections.abc import Callable

import pytest
from hypothesis import given

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.calculus import jacobian
from symbody.expr.canonical import add, apply, mul, sub
from symbody.expr.expression import (
    atan2,
    common_graph,
    cos,
    maximum,
    minimum,
    number,
    saddle_entry,
    sin,
    sqrt,
    symbol,
)
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind, copy_nodes
from tests.expr.strategies import Sample, both_tiers, built, samples, sequence_of


class Square:
    """A user function."""

    name = "square"

    def __call__(self, *arguments: float) -> float:
        return arguments[0] ** 2

    def derivative(self, position: int) -> Square:
        return self


def test_equal_structure_is_one_node() -> None:
    graph = Graph()
    x, y = graph.symbol(Symbol("x")), graph.symbol(Symbol("y"))
    made = [add(graph, x, y), mul(graph, x, y), apply(graph, op.SIN, x), apply(graph, op.ATAN2, x, y)]
    size = len(graph)
    assert [add(graph, y, x), mul(graph, y, x), apply(graph, op.SIN, x), apply(graph, op.ATAN2, x, y)] == made
    assert len(graph) == size
    assert repr(graph) == f"Graph({size} nodes)"


def test_symbols_differ_by_name_kind_and_order() -> None:
    graph = Graph()
    x = Symbol("x", SymbolKind.COORDINATE)
    names = [x, x.derivative, x.derivative.derivative, Symbol("x"), Symbol("X", SymbolKind.COORDINATE), TIME]
    assert len({graph.symbol(name) for name in names}) == len(names)
    assert len({graph.hashes[graph.symbol(name)] for name in names}) == len(names)
    assert [name.label for name in names[:3]] == ["x", "x_dot", "x_ddot"]


@pytest.mark.parametrize("name", ["I", "lambda", "", "x y", "\u03b2", "\ud800", "x/0", "a" * 1000])
def test_a_name_is_only_a_name(name: str) -> None:
    graph = Graph()
    node = graph.symbol(Symbol(name))
    assert graph.symbols[graph.left[node]].name == name


def test_what_defines_a_node_beside_its_operands() -> None:
    graph = Graph()
    x = graph.symbol(Symbol("x"))
    function = Square()
    call = graph.many(op.CALL, (x,), graph.function(function))
    small, large = graph.kernel(KernelNode(1, 0)), graph.kernel(KernelNode(1, 1))
    saddle = graph.many(op.SADDLE, (x, x), small)
    picks = [graph.node(op.PICK, saddle, k) for k in range(2)]
    assert graph.function(function) == graph.datum(call) == 0
    assert (graph.kernel(KernelNode(1, 0)), large, graph.datum(saddle)) == (small, 1, small)
    assert [graph.datum(pick) for pick in picks] == [0, 1]
    assert graph.operands(picks[1]) == (saddle,)
    assert graph.operands(saddle) == (x, x)
    assert graph.operands(x) == ()
    assert len({graph.hashes[k] for k in (call, saddle, *picks)}) == 4


@both_tiers
@given(samples())
def test_operands_are_older_and_reachable_is_closed(sample: Sample) -> None:
    graph = Graph()
    nodes = built(sample.program, graph)
    for node in range(len(graph)):
        assert all(k < node for k in graph.operands(node))
    found = graph.reachable([nodes[-1]])
    assert found == sorted(set(found))
    assert {k for node in found for k in graph.operands(node)} | {nodes[-1]} >= set(found)
    assert {k for node in found for k in graph.operands(node)} <= set(found)


@both_tiers
@given(samples())
def test_copies_are_the_same_structure(sample: Sample) -> None:
    source, target = Graph(), Graph()
    target.symbol(Symbol("something else"))
    nodes = built(sample.program, source)
    memo: dict[int, int] = {}
    copies = copy_nodes(source, target, nodes, memo)
    assert [target.hashes[k] for k in copies] == [source.hashes[k] for k in nodes]
    assert copy_nodes(target, source, copies, {}) == nodes
    size = len(target)
    assert copy_nodes(source, target, nodes, memo) == copies
    assert len(target) == size


def test_copies_keep_functions_and_kernels() -> None:
    source, target = Graph(), Graph()
    target.function(Square())
    target.kernel(KernelNode(3, 0))
    x = source.symbol(Symbol("x"))
    call = source.many(op.CALL, (x,), source.function(Square()))
    pick = source.node(op.PICK, source.many(op.SADDLE, (x, x), source.kernel(KernelNode(1, 0))), 1)
    choice = source.many(op.SELECT, (apply(source, op.LT, x, call), pick, source.pi()))
    copy = copy_nodes(source, target, [choice], {})[0]
    assert target.hashes[copy] == source.hashes[choice]
    names = [
        target.functions[target.datum(k)].name for k in target.reachable([copy]) if target.ops[k] == op.CALL
    ]
    assert names == ["square"]
    assert KernelNode(1, 0) in target.kernels


# Expressions: nodes with arithmetic


def test_mixing_graphs_copies_the_smaller_side() -> None:
    large, small = Graph(), Graph()
    big = sum((symbol(large, Symbol(f"x{k}")) for k in range(20)), start=number(large, 0))
    little = sin(symbol(small, Symbol("x3"))) + 1
    size = len(small)
    for mixed in (big + little, little + big):
        assert mixed.graph is large
    assert big + little == little + big
    assert len(small) == size
    assert little == sin(symbol(small, Symbol("x3"))) + 1
    assert little != sin(symbol(large, Symbol("x3"))) + 1


def test_mixing_graphs_again_copies_nothing_again() -> None:
    large, small = Graph(), Graph()
    big = sum((symbol(large, Symbol(f"x{k}")) for k in range(20)), start=number(large, 0))
    little = sin(symbol(small, Symbol("y"))) * 2
    mixed = big * little
    size = len(large)
    assert big * little == mixed
    assert len(large) == size
    assert len(large.copies_of(small)) == 4  # 2, y, sin(y) and the product
    assert common_graph([big, little, 3])[0] is large


def test_a_forgotten_graph_frees_its_copies() -> None:
    keeper = Graph()
    keeper_x = symbol(keeper, Symbol("x")) + symbol(keeper, Symbol("y"))
    for _ in range(3):
        passing = Graph()
        assert (keeper_x + symbol(passing, Symbol("x"))).graph is keeper
        del passing
    gc.collect()
    assert len(keeper._copies) == 0


def test_arithmetic_of_expressions() -> None:
    graph = Graph()
    x, y = symbol(graph, Symbol("x")), symbol(graph, Symbol("y"))
    assert 1 + x == x + 1
    assert 1 - x == -(x - 1)
    assert 2 * x == x + x
    assert (1 / x) == x**-1
    assert (2**x).graph.ops[(2**x).index] == op.POW
    assert (x - x).is_zero
    assert (x / x).number is None
    assert number(graph, 3).number == 3
    assert sqrt(x) ** 2 == x
    assert minimum(x, y) == minimum(y, x) != maximum(x, y)
    assert cos(-x) == cos(x)
    assert atan2(y, x) != atan2(x, y)
    assert len({x, y, x + y - y, symbol(graph, Symbol("x"))}) == 3
    assert x != x.index
    entry = saddle_entry(graph, graph.kernel(KernelNode(1, 0)), (x.index, y.index), 0)
    assert graph.ops[entry.index] == op.PICK


def test_an_expression_has_no_truth_value() -> None:
    with pytest.raises(ExpressionError) as caught:
        bool(symbol(Graph(), Symbol("x")))
    assert caught.value.problems[0].code == "expression.truth_value"
    assert "select" in caught.value.problems[0].fix


# Threads


def grow(graph: Graph, seed: int, count: int) -> list[int]:
    """Make the same nodes for the same seed, whatever else the graph holds; return the hashes."""
    rng = random.Random(seed)
    nodes = [graph.symbol(Symbol(f"x{k}")) for k in range(8)]
    rules: list[Callable[[Graph, int, int], int]] = [
        add, sub, mul, lambda g, a, b: apply(g, op.SIN, a), lambda g, a, b: apply(g, op.FMA, a, b, a),
        lambda g, a, b: g.constant(rng.randrange(1000)), lambda g, a, b: g.symbol(Symbol(f"y{rng.randrange(99)}")),
    ]  # fmt: skip
    for _ in range(count):
        nodes.append(rng.choice(rules)(graph, rng.choice(nodes), rng.choice(nodes)))
    return [graph.hashes[node] for node in nodes]


def in_threads(*tasks: Callable[[], object]) -> None:
    """Run tasks at once; all start together."""
    gate = threading.Barrier(len(tasks))
    failures: list[BaseException] = []

    def run(task: Callable[[], object]) -> None:
        gate.wait()
        try:
            task()
        except BaseException as failure:
            failures.append(failure)

    threads = [threading.Thread(target=run, args=(task,)) for task in tasks]
    patience = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # so that threads meet in the middle of everything
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(patience)
    assert not failures


@pytest.mark.parametrize("count", [20_000, pytest.param(300_000, marks=pytest.mark.exhaustive)])
def test_threads_building_in_one_graph_give_the_serial_result(count: int) -> None:
    serial = Graph()
    expected = {seed: grow(serial, seed, count) for seed in (1, 2)}
    shared = Graph()
    found: dict[int, list[int]] = {}
    in_threads(*[lambda seed=seed: found.update({seed: grow(shared, seed, count)}) for seed in (1, 2, 1, 2)])
    assert found == expected
    assert sorted(shared.hashes) == sorted(serial.hashes)
    for node in range(len(shared)):
        assert all(k < node for k in shared.operands(node))
    symbols = [shared.symbols[shared.left[k]] for k in range(len(shared)) if shared.ops[k] == op.SYMBOL]
    assert len(set(symbols)) == len(symbols)


def test_threads_building_in_two_graphs_give_the_serial_result() -> None:
    alone = [Graph(), Graph()]
    expected = [grow(graph, seed, 3_000) for seed, graph in enumerate(alone)]
    graphs = [Graph(), Graph()]
    found: dict[int, list[int]] = {}
    in_threads(*[lambda k=k: found.update({k: grow(graphs[k], k, 3_000)}) for k in range(2)])
    assert [found[k] for k in range(2)] == expected
    assert [graph.ops for graph in graphs] == [graph.ops for graph in alone]
    assert [graph.left for graph in graphs] == [graph.left for graph in alone]


# Size


def chain(graph: Graph, count: int) -> tuple[int, int, int]:
    """Return x, y and sin(... sin(sin(x) + y) + y ...) of `count` nodes."""
    x, y = graph.symbol(Symbol("x", SymbolKind.COORDINATE)), graph.symbol(Symbol("y", SymbolKind.COORDINATE))
    node = x
    for _ in range(count // 2):
        node = add(graph, apply(graph, op.SIN, node), y)
    return x, y, node


@pytest.mark.parametrize("count", [100_000, pytest.param(1_000_000, marks=pytest.mark.exhaustive)])
def test_depth_has_no_limit(count: int) -> None:
    graph = Graph()
    _, _, root = chain(graph, count)
    found = graph.reachable([root])
    assert len(found) == 2 * (count // 2) + 2
    target = Graph()
    copy = copy_nodes(graph, target, [root], {})[0]
    assert target.hashes[copy] == graph.hashes[root]


def derive() -> None:
    """What a derivation does: grow a graph, mix it with another, differentiate, make a sequence."""
    graph, scratch = Graph(), Graph()
    angles = [symbol(graph, Symbol(name, SymbolKind.COORDINATE)) for name in "xyz"]
    other = symbol(scratch, Symbol("x", SymbolKind.COORDINATE))
    roots = [(sin(a) * cos(b) + other).index for a in angles for b in angles]
    rows = jacobian(graph, roots, [angle.index for angle in angles])
    sequence_of(graph, [node for row in rows for node in row])


@pytest.mark.parametrize("count", [50, pytest.param(1000, marks=pytest.mark.exhaustive)])
def test_derivations_in_a_loop_leave_memory_constant(count: int) -> None:
    """Graphs die with their last reference: they are in no cycle, and nothing outside holds them."""
    for _ in range(5):
        derive()
    gc.collect()
    gc.disable()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        derive()
        one = tracemalloc.get_traced_memory()[1] - before
        for _ in range(count):
            derive()
        assert gc.collect() == 0  # besides, it empties Python's own stores of small tuples
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
        gc.enable()
    # Nothing may stay of a derivation; what tracemalloc and the loop hold is not a share of it for each.
    assert after - before < one / 2


def test_a_node_takes_little_memory() -> None:
    """At most 250 bytes beside the numbers themselves, as contracted."""
    graph = Graph()
    chain(graph, 1000)
    gc.collect()
    tracemalloc.start()
    try:
        before, size = tracemalloc.get_traced_memory()[0], len(graph)
        node = graph.symbol(Symbol("z"))
        for _ in range(50_000):
            node = apply(graph, op.SIN, node)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown / (len(graph) - size) < 250
