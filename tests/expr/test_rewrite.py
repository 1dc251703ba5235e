"""Substitution keeps values; counts are what a person counts."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest
from hypothesis import assume, given

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, neg, power, sub
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind, copy_nodes
from symbody.expr.rewrite import (
    dependence,
    multiplications,
    node_cost,
    operation_count,
    substitute,
    substitute_into,
    symbols_of,
    tree_size,
)
from symbody.expr.sequences.evaluate import evaluate_sequence
from tests.expr.intervals import Undecided, interval, interval_arithmetic
from tests.expr.strategies import (
    DIGITS,
    SYMBOLS,
    Program,
    Sample,
    both_tiers,
    built,
    compositions,
    exact,
    mpmath_values,
    samples,
    sequence_of,
)
from tests.tiers import cases


class Pen:
    def __init__(self) -> None:
        self.g = Graph()
        self.x, self.y, self.z = (self.g.symbol(symbol) for symbol in SYMBOLS)


@both_tiers
@given(compositions())
def test_substitution_composes_functions(pair: tuple[Sample, Program]) -> None:
    inner, outer = pair
    graph = Graph()
    argument, root = built(inner.program, graph)[-1], built(outer, graph)[-1]
    composed = substitute(graph, [root], {graph.symbol(SYMBOLS[0]): argument})
    with mpmath.workdps(DIGITS):
        point = [exact(x) for x in inner.point]
        expected = mpmath_values(outer, [mpmath_values(inner.program, point)[-1], *point[1:]])[-1]
        unit = Fraction(1, 10**50)
        inputs = {"q": [interval(x, unit) for x in inner.point]}
        try:
            allowed = evaluate_sequence(sequence_of(graph, composed), inputs, interval_arithmetic(unit))[0][0]
        except Undecided:
            assume(False)
        assume(allowed.width < 1e-30)
        assert expected in allowed


@both_tiers
@given(samples())
def test_substituting_nothing_changes_nothing(sample: Sample) -> None:
    graph = Graph()
    nodes = built(sample.program, graph)
    size = len(graph)
    x, absent = graph.symbol(SYMBOLS[0]), graph.symbol(Symbol("absent"))
    assert substitute(graph, nodes, {}) == nodes
    assert substitute(graph, nodes, {x: x}) == nodes
    assert substitute(graph, nodes, {absent: ZERO}) == nodes
    assert len(graph) == size + 1


@both_tiers
@given(compositions())
def test_substitution_into_another_graph_makes_the_same_nodes(pair: tuple[Sample, Program]) -> None:
    inner, outer = pair
    graph, target = Graph(), Graph()
    argument, roots = built(inner.program, graph)[-1], built(outer, graph)
    replaced = {graph.symbol(SYMBOLS[0]): argument, graph.symbol(SYMBOLS[1]): ONE}
    try:
        expected = copy_nodes(graph, target, substitute(graph, roots, replaced), {})
    except ExpressionError:  # a divisor became 0
        with pytest.raises(ExpressionError):
            substitute_into(target, graph, roots, replaced)
        return
    size = len(graph.ops)
    assert substitute_into(target, graph, roots, replaced) == expected
    assert len(graph.ops) == size


def test_replacements_are_made_at_once_and_not_searched_again() -> None:
    pen = Pen()
    g = pen.g
    swapped = substitute(g, [sub(g, pen.x, mul(g, TWO, pen.y))], {pen.x: pen.y, pen.y: pen.x})
    assert swapped == [sub(g, pen.y, mul(g, TWO, pen.x))]
    assert substitute(g, [pen.x], {pen.x: add(g, pen.x, ONE)}) == [add(g, pen.x, ONE)]


def test_any_node_may_be_replaced_and_what_results_is_folded() -> None:
    pen = Pen()
    g = pen.g
    sine = apply(g, op.SIN, pen.x)
    root = add(g, mul(g, sine, pen.y), pen.z)
    assert substitute(g, [root, sine], {sine: ZERO}) == [pen.z, ZERO]
    assert substitute(g, [root], {root: pen.x}) == [pen.x]
    assert substitute(g, [sine], {pen.x: ZERO}) == [ZERO]
    assert substitute(g, [power(g, pen.x, TWO)], {pen.x: neg(g, g.constant(3))}) == [g.constant(9)]


def test_a_divisor_that_becomes_zero_is_refused() -> None:
    pen = Pen()
    with pytest.raises(ExpressionError) as caught:
        substitute(pen.g, [div(pen.g, pen.y, sub(pen.g, pen.x, pen.z))], {pen.x: pen.z})
    assert caught.value.problems[0].code == "expression.division_by_zero"


def test_functions_and_kernels_are_rebuilt_on_new_operands() -> None:
    pen = Pen()
    g = pen.g
    kernel = g.kernel(KernelNode(1, 0))
    pick = g.node(op.PICK, g.many(op.SADDLE, (pen.x, pen.y), kernel), 1)
    choice = g.many(op.SELECT, (apply(g, op.LT, pen.x, pen.y), pick, pen.z))
    changed = substitute(g, [choice], {pen.x: pen.z})[0]
    expected = g.node(op.PICK, g.many(op.SADDLE, (pen.z, pen.y), kernel), 1)
    assert changed == g.many(op.SELECT, (apply(g, op.LT, pen.z, pen.y), expected, pen.z))


def test_symbols_come_in_order_of_creation() -> None:
    pen = Pen()
    roots = [mul(pen.g, pen.z, pen.x), pen.g.pi(), pen.g.constant(3)]
    assert symbols_of(pen.g, roots) == [pen.x, pen.z]


def test_operations_are_counted_as_people_count() -> None:
    pen = Pen()
    g, x, y = pen.g, pen.x, pen.y
    sine = apply(g, op.SIN, x)
    for root, expected in [
        (x, 0), (neg(g, x), 0), (add(g, x, y), 1), (sub(g, x, y), 1), (mul(g, TWO, x), 1), (div(g, x, y), 1),
        (sine, 1), (apply(g, op.ATAN2, x, y), 1), (apply(g, op.FMA, x, y, x), 2),
        (power(g, x, TWO), 1), (power(g, x, g.constant(7)), 4), (power(g, x, g.constant(Fraction(1, 3))), 1),
        (power(g, x, y), 1), (g.pi(), 0), (g.constant(-3), 0), (g.constant(0.5), 0),
        (mul(g, add(g, sine, y), add(g, sine, ONE)), 4),
        (g.node(op.PICK, g.many(op.SADDLE, (x, y), g.kernel(KernelNode(1, 0))), 0), 1),
    ]:  # fmt: skip
        assert operation_count(g, [root]) == expected
    assert operation_count(g, [sine, add(g, sine, y), sine]) == 2
    assert operation_count(g, []) == 0


@pytest.mark.parametrize(
    ("exponent", "expected"), [(1, 0), (2, 1), (3, 2), (4, 2), (15, 6), (16, 4), (2**40 - 1, 78)]
)
def test_whole_powers_cost_their_multiplications(exponent: int, expected: int) -> None:
    assert multiplications(exponent) == expected


def test_written_out_size_is_exact_however_large() -> None:
    """Each square of a sum doubles the size and adds one operation each: 2^k - 1 twice over."""
    pen = Pen()
    g, node = pen.g, pen.x
    for _ in range(500):
        node = mul(g, add(g, node, ONE), add(g, node, TWO))
    assert tree_size(g, node) == 3 * (2**500 - 1)
    assert operation_count(g, [node]) == 3 * 500


@both_tiers
@given(samples())
def test_counts_are_consistent(sample: Sample) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    shared = operation_count(graph, [root])
    assert shared == sum(node_cost(graph, node) for node in graph.reachable([root]))
    assert shared <= tree_size(graph, root)
    kinds = dependence(graph, [root])
    assert kinds[root] == {SymbolKind.COORDINATE for _ in symbols_of(graph, [root])}
    assert kinds.keys() == set(graph.reachable([root]))


def test_dependence_tells_kinds() -> None:
    g = Graph()
    nodes = [g.symbol(Symbol("a", kind)) for kind in SymbolKind if kind != SymbolKind.TIME]
    time = g.symbol(TIME)
    total = time
    for node in nodes:
        total = add(g, total, apply(g, op.SIN, node))
    kinds = dependence(g, [total])
    assert kinds[total] == set(SymbolKind)
    assert kinds[time] == {SymbolKind.TIME}
    assert dependence(g, [g.pi()]) == {g.pi(): frozenset()}


@pytest.mark.parametrize("count", cases([20_000, 100_000, 1_000_000], fast=[20_000]))
def test_depth_has_no_limit(count: int) -> None:
    pen = Pen()
    g, node = pen.g, pen.x
    for _ in range(count // 2):
        node = add(g, apply(g, op.SIN, node), pen.y)
    back = substitute(g, substitute(g, [node], {pen.y: pen.z}), {pen.z: pen.y})
    assert back == [node]
    assert tree_size(g, node) == operation_count(g, [node]) == 2 * (count // 2)
    assert dependence(g, [node])[node] == {SymbolKind.COORDINATE}
