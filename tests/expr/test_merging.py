"""Merging and contraction: fewer operations, the same numbers, never a new way to fail."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction

import mpmath
import pytest
from hypothesis import assume, given

from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, neg, power, sub
from symbody.expr.expression import Expr, cos, number, sin, symbol
from symbody.expr.fingerprints.merging import contract_products, merge_equal
from symbody.expr.graph import Graph, KernelNode, Symbol, copy_nodes
from symbody.expr.rewrite import operation_count
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, build_sequence
from tests.expr.intervals import FLOAT_UNIT, Undecided, interval, interval_arithmetic
from tests.expr.strategies import (
    DIGITS,
    SYMBOLS,
    Sample,
    both_tiers,
    built,
    built_shuffled,
    exact,
    mpmath_values,
    samples,
    sequence_of,
)


class Pen:
    def __init__(self) -> None:
        self.g = Graph()
        self.x, self.y, self.z = (self.g.symbol(symbol) for symbol in SYMBOLS)

    def merged(self, *roots: int) -> tuple[Graph, list[int]]:
        target = Graph()
        return target, merge_equal(self.g, roots, target)


@both_tiers
@given(samples())
def test_merging_keeps_values(sample: Sample) -> None:
    graph, target = Graph(), Graph()
    nodes = built(sample.program, graph)
    merged = merge_equal(graph, nodes, target)
    unit = Fraction(1, 10**50)
    with mpmath.workdps(DIGITS):
        expected = mpmath_values(sample.program, [exact(x) for x in sample.point])
        inputs = {"q": [interval(x, unit) for x in sample.point]}
        sequence = sequence_of(target, merged, merge=False, contract=False)
        try:
            allowed = evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0]
        except Undecided:
            assume(False)
        assume(all(entry.width < 1e-30 for entry in allowed))
        assert all(value in entry for value, entry in zip(expected, allowed, strict=True))


@both_tiers
@given(samples())
def test_merging_never_adds_operations(sample: Sample) -> None:
    graph, target = Graph(), Graph()
    root = built(sample.program, graph)[-1]
    assert operation_count(target, merge_equal(graph, [root], target)) <= operation_count(graph, [root])


@both_tiers
@given(samples())
def test_merging_twice_changes_nothing_more(sample: Sample) -> None:
    graph, once, twice = Graph(), Graph(), Graph()
    first = merge_equal(graph, built(sample.program, graph)[-1:], once)
    second = merge_equal(once, first, twice)
    assert operation_count(twice, second) <= operation_count(once, first)
    assert copy_nodes(twice, once, second, {}) == first


@both_tiers
@given(samples())
def test_merged_form_does_not_depend_on_the_order_of_building(sample: Sample) -> None:
    results = []
    for seed in range(2):
        graph, target = Graph(), Graph()
        root = built_shuffled(sample.program, graph, random.Random(seed))
        results.append([target.hashes[k] for k in merge_equal(graph, [root], target)])
    assert results[0] == results[1]


@both_tiers
@given(samples(), samples())
def test_outputs_have_the_same_bits_alone_or_together(one: Sample, two: Sample) -> None:
    graph = Graph()
    first, second = (built(sample.program, graph)[-1] for sample in (one, two))
    point = {"q": [float(x) for x in one.point]}
    inputs = {graph.symbol(symbol): entry for symbol, entry in zip(SYMBOLS, _inputs(), strict=True)}
    outputs = [Roots("a", (), (first,)), Roots("b", (), (second,))]
    alone = [evaluate_sequence(build_sequence(graph, [output], inputs), point)[0][0] for output in outputs]
    for together in (outputs, outputs[::-1]):
        sequence = build_sequence(graph, together, inputs)
        found = dict(zip([o.name for o in sequence.outputs], evaluate_sequence(sequence, point), strict=True))
        assert [found["a"][0].hex(), found["b"][0].hex()] == [value.hex() for value in alone]


def _inputs() -> list[object]:
    graph = Graph()
    root = add(
        graph, graph.symbol(SYMBOLS[0]), add(graph, graph.symbol(SYMBOLS[1]), graph.symbol(SYMBOLS[2]))
    )
    return sorted(sequence_of(graph, [root]).inputs, key=lambda entry: entry.position)


def turned_tensor(graph: Graph) -> list[Expr]:
    """R D R^T for a body with two equal moments, turned about z, x and z again."""
    angles = [symbol(graph, name) for name in SYMBOLS]
    zero, one, two, three = (number(graph, k) for k in range(4))

    def times(P: list[list[Expr]], Q: list[list[Expr]]) -> list[list[Expr]]:
        return [
            [P[i][0] * Q[0][j] + P[i][1] * Q[1][j] + P[i][2] * Q[2][j] for j in range(3)] for i in range(3)
        ]

    R = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
    for k, angle in enumerate(angles):
        c, s = cos(angle), sin(angle)
        about_x = [[one, zero, zero], [zero, c, -s], [zero, s, c]]
        about_z = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
        R = times(R, about_x if k == 1 else about_z)
    D = [[two, zero, zero], [zero, two, zero], [zero, zero, three]]
    turned = times(times(R, D), [list(row) for row in zip(*R, strict=True)])
    return [entry for row in turned for entry in row]


@pytest.mark.parametrize("contract", [True, False])
def test_the_same_numbers_at_a_hundred_states_with_and_without_merging(contract: bool) -> None:
    """Both lie in intervals that rounding alone explains, and so does the exact value."""
    graph = Graph()
    roots = [entry.index for entry in turned_tensor(graph)]
    with_merging, without = (
        sequence_of(graph, roots, merge=merge, contract=contract) for merge in (True, False)
    )
    assert with_merging.operation_count < without.operation_count
    values = with_merging.outputs[0].values
    assert [values[k] for k in (1, 2, 5)] == [values[k] for k in (3, 6, 7)]  # symmetric halves
    rng = random.Random(3)
    with mpmath.workdps(30):
        for _ in range(100):
            point = [Fraction(rng.randrange(-(2**20), 2**20), 2**18) for _ in SYMBOLS]
            inputs = {"q": [interval(x) for x in point]}
            left, right = (
                evaluate_sequence(sequence, inputs, interval_arithmetic(FLOAT_UNIT))[0]
                for sequence in (with_merging, without)
            )
            assert all(a.low <= b.high and b.low <= a.high for a, b in zip(left, right, strict=True))
            for sequence, allowed in ((with_merging, left), (without, right)):
                found = evaluate_sequence(sequence, {"q": [float(x) for x in point]})[0]
                assert all(value in entry for value, entry in zip(found, allowed, strict=True))
                # fewer than 80 operations on values below 6, a few roundoffs each
                assert all(entry.width < 80 * 6 * 10 * float(FLOAT_UNIT) for entry in allowed)


def test_identities_shrink_to_their_value() -> None:
    pen = Pen()
    g = pen.g
    one = add(g, power(g, apply(g, op.SIN, pen.x), TWO), power(g, apply(g, op.COS, pen.x), TWO))
    root = add(g, mul(g, one, pen.y), sub(g, one, ONE))
    target, (merged,) = pen.merged(root)
    assert target.hashes[merged] == g.hashes[pen.y]


def test_opposite_values_are_computed_once() -> None:
    pen = Pen()
    g = pen.g
    left = mul(g, pen.x, sub(g, pen.y, pen.z))
    right = sub(g, mul(g, pen.x, pen.z), mul(g, pen.x, pen.y))
    target, merged = pen.merged(left, right)
    assert merged[1] == neg(target, merged[0])
    assert operation_count(target, merged) == 2


def test_the_cheaper_definition_wins() -> None:
    pen = Pen()
    g = pen.g
    spread = add(g, mul(g, pen.x, pen.y), mul(g, pen.x, pen.z))
    tight = mul(g, pen.x, add(g, pen.y, pen.z))
    for roots in ((spread, tight), (tight, spread)):
        target, merged = pen.merged(*roots)
        assert merged[0] == merged[1]
        assert target.hashes[merged[0]] == g.hashes[tight]


RISKY_AND_SAFE: dict[str, Callable[[Pen], tuple[int, int]]] = {
    "(x^2-y^2)/(x-y) and 2x+y-x": lambda p: (
        div(p.g, sub(p.g, power(p.g, p.x, TWO), power(p.g, p.y, TWO)), sub(p.g, p.x, p.y)),
        sub(p.g, add(p.g, mul(p.g, TWO, p.x), p.y), p.x),
    ),
    "tan(x) cos(x) and sin(x)+y-y": lambda p: (
        mul(p.g, apply(p.g, op.TAN, p.x), apply(p.g, op.COS, p.x)),
        sub(p.g, add(p.g, apply(p.g, op.SIN, p.x), p.y), p.y),
    ),
    "1+xy/y and 2+x+y-1-y": lambda p: (
        add(p.g, div(p.g, mul(p.g, p.x, p.y), p.y), ONE),
        sub(p.g, sub(p.g, add(p.g, add(p.g, p.x, p.y), TWO), ONE), p.y),
    ),
}


@pytest.mark.parametrize("name", RISKY_AND_SAFE)
@pytest.mark.parametrize("turned", [False, True])
def test_a_definition_that_can_fail_never_replaces_one_that_cannot(name: str, turned: bool) -> None:
    pen = Pen()
    pair = RISKY_AND_SAFE[name](pen)
    target, merged = pen.merged(*(pair[::-1] if turned else pair))
    assert merged[0] == merged[1]
    assert {target.ops[k] for k in target.reachable(merged)}.isdisjoint({op.DIV, op.TAN})


def test_a_definition_that_can_fail_stays_where_there_is_no_other() -> None:
    pen = Pen()
    ratio = div(pen.g, mul(pen.g, pen.x, pen.y), pen.z)
    target, (merged,) = pen.merged(ratio)
    assert target.hashes[merged] == pen.g.hashes[ratio]


def test_a_cheap_risky_definition_does_not_replace_a_dear_safe_one() -> None:
    pen = Pen()
    g, x = pen.g, pen.x
    dear = ZERO
    for k in range(5):  # x^4 + x^3 + ... + 1
        dear = add(g, mul(g, dear, x), ONE) if k else ONE
    cheap = div(g, sub(g, power(g, x, g.constant(5)), ONE), sub(g, x, ONE))
    target, merged = pen.merged(cheap, dear)
    assert merged[0] == merged[1]
    assert op.DIV not in {target.ops[k] for k in target.reachable(merged)}
    sequence = sequence_of(g, [cheap, dear])
    assert evaluate_sequence(sequence, {"q": [1.0]}) == [[5.0, 5.0]]


def test_functions_and_kernels_survive() -> None:
    pen = Pen()
    g = pen.g
    saddle = g.many(op.SADDLE, (pen.x, pen.y), g.kernel(KernelNode(1, 0)))
    again = g.many(op.SADDLE, (pen.x, sub(g, add(g, pen.y, pen.z), pen.z)), g.kernel(KernelNode(1, 0)))
    roots = [g.node(op.PICK, node, k) for node in (saddle, again) for k in (0, 1)]
    target, merged = pen.merged(*roots)
    assert merged[:2] == merged[2:]
    assert merged[0] != merged[1]
    assert target.kernels == [KernelNode(1, 0)]


# Contraction


@pytest.mark.parametrize(
    ("sign", "other", "expected"),
    [(1, 1, (1, 1)), (1, -1, (1, -1)), (-1, 1, (-1, 1))],
)
def test_products_are_fused_with_sums(sign: int, other: int, expected: tuple[int, int]) -> None:
    """x y + z, x y - z and z - x y become one fma each, with signs inside."""
    pen = Pen()
    g = pen.g
    product = mul(g, pen.x, pen.y)
    left = product if sign > 0 else neg(g, product)
    root = add(g, left, pen.z if other > 0 else neg(g, pen.z))
    (fused,) = contract_products(g, [root])
    values = evaluate_sequence(sequence_of(g, [fused], merge=False, contract=False), {"q": [3.0, 5.0, 7.0]})[
        0
    ]
    assert values == [expected[0] * 15.0 + expected[1] * 7.0]
    assert op.FMA in {g.ops[k] for k in g.reachable([fused])}
    assert op.MUL not in {g.ops[k] for k in g.reachable([fused])}


def test_squares_are_fused_and_shared_products_are_not() -> None:
    pen = Pen()
    g = pen.g
    square, product = power(g, pen.x, TWO), mul(g, pen.x, pen.y)
    (fused,) = contract_products(g, [add(g, square, pen.z)])
    assert g.ops[fused] == op.FMA
    shared = add(g, product, pen.z)
    assert contract_products(g, [shared, product]) == [shared, product]
    twice = mul(g, shared, apply(g, op.SIN, product))
    assert op.FMA not in {g.ops[k] for k in g.reachable(contract_products(g, [twice]))}


@both_tiers
@given(samples())
def test_contraction_neither_adds_operations_nor_changes_values(sample: Sample) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    (fused,) = contract_products(graph, [root])
    assert operation_count(graph, [fused]) <= operation_count(graph, [root])
    unit = Fraction(1, 10**50)
    with mpmath.workdps(DIGITS):
        inputs = {"q": [interval(x, unit) for x in sample.point]}
        sequence = sequence_of(graph, [fused], merge=False, contract=False)
        try:
            allowed = evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0][0]
        except Undecided:
            assume(False)
        assume(allowed.width < 1e-30)
        assert mpmath_values(sample.program, [exact(x) for x in sample.point])[-1] in allowed


def test_sizes_that_overflow_are_no_harm() -> None:
    """Written out, the last of these has 2^2000 operations, beyond the largest float."""
    pen = Pen()
    g, node = pen.g, pen.x
    for _ in range(2000):
        node = apply(g, op.SIN, mul(g, node, add(g, node, pen.y)))
    target, merged = pen.merged(node)
    assert target.hashes[merged[0]] == g.hashes[node]
    assert Symbol("x") not in target.symbols
