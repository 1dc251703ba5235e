"""Programs for several items: the same as writing every item out, wherever they pass."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence as Items

import pytest

from symbody.expr import opcodes as op
from symbody.expr.calculus import forward, gradient
from symbody.expr.canonical import ONE
from symbody.expr.expression import Expr, cos, number, symbol
from symbody.expr.graph import Graph, Symbol
from symbody.expr.rewrite import substitute, substitute_into
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.program import map_program, unroll, written_out
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence

COUNT = 5


def inputs(graph: Graph, count: int = COUNT) -> tuple[list[Expr], dict[int, Input]]:
    found = [symbol(graph, Symbol(f"x{k}")) for k in range(count)]
    return found, {x.index: Input(f"x{k}", "q", k) for k, x in enumerate(found)}


def area(shared: list[Expr], own: list[Expr]) -> list[Expr]:
    return [shared[0] * own[0] + shared[1] * own[1], own[0] ** 3 - own[1] / shared[1]]


def two_programs(graph: Graph) -> tuple[list[Expr], dict[int, Input]]:
    """Results of a program that reads another's, beside plain operations on both sides."""
    x, places = inputs(graph)
    first = map_program(
        graph, [x[0], x[1]], [[x[2] * k + 1 for k in range(11)], [cos(x[3]) + k for k in range(11)]], area
    )
    row = [x[4] * k for k in range(7)]
    second = map_program(graph, [first[0][3], x[1]], [first[1][2:9], row], area)
    return [*first[0], *second[0], second[1][2] * first[1][1]], places


def sequence(graph: Graph, values: Items[int], places: dict[int, Input], *, merge: bool = True) -> Sequence:
    return build_sequence(graph, [Roots("all", (len(values),), tuple(values))], places, merge=merge)


def points(seed: int, count: int = 20) -> list[list[float]]:
    source = random.Random(seed)
    return [[source.uniform(0.5, 2.0) for _ in range(COUNT)] for _ in range(count)]


def values(program: Sequence, point: list[float]) -> list[float]:
    return evaluate_sequence(program, {"q": point})[0]


def test_written_out_has_the_same_bits() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    short = sequence(graph, [x.index for x in results], places)
    long = written_out(short)
    assert [o.op for o in short.operations].count(op.MAP) == 2
    assert op.MAP not in {o.op for o in long.operations} and not long.programs
    assert long.operation_count == short.operation_count
    for point in points(1):
        assert values(short, point) == values(long, point)


def test_results_are_what_the_formulas_say() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    found = sequence(graph, [x.index for x in results], places)
    for point in points(2):
        a, b, c, d, e = point
        first = [(c * k + 1, math.cos(d) + k) for k in range(11)]
        tops, cubes = zip(*((a * x + b * y, x**3 - y / b) for x, y in first), strict=True)
        second = [
            (tops[3] * x + b * y, x**3 - y / b)
            for x, y in zip(cubes[2:9], [e * k for k in range(7)], strict=True)
        ]
        expected = [*tops, *(x for x, _ in second), second[2][1] * cubes[1]]
        assert values(found, point) == pytest.approx(expected, rel=1e-12)


def test_merging_and_copies_keep_the_values() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    nodes = [x.index for x in results]
    plain, merged = (sequence(graph, nodes, places, merge=merge) for merge in (False, True))
    other = Graph()
    moved = substitute_into(other, graph, nodes, {next(iter(places)): graph.constant(2)})
    known = {other.symbol(Symbol(f"x{k}")): Input(f"x{k}", "q", k) for k in range(COUNT)}
    replaced = sequence(other, moved, known)
    for point in points(3):
        assert values(plain, point) == pytest.approx(values(merged, point), rel=1e-12)
        assert values(replaced, point) == pytest.approx(values(plain, [2.0, *point[1:]]), rel=1e-12)


def test_derivatives_go_through_programs() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    last = results[-1].index
    by = list(places)
    assert gradient(graph, last, by) == gradient(graph, unroll(graph, [last])[0], by)
    (slope,) = forward(graph, [last], {by[3]: ONE, **dict.fromkeys(by[:3], 0)})
    found, function = sequence(graph, [slope], places), sequence(graph, [last], places)
    for point in points(4):
        ends = [values(function, [*point[:3], point[3] + h, *point[4:]])[0] for h in (1e-6, -1e-6)]
        assert values(found, point)[0] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-6)


def test_unrolled_is_equal_by_fingerprint_of_values() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    nodes = [x.index for x in results]
    flat = unroll(graph, nodes)
    assert all(graph.ops[node] != op.MAP for node in graph.reachable(flat))
    one, two = sequence(graph, nodes, places), sequence(graph, flat, places)
    for point in points(5):
        assert values(one, point) == pytest.approx(values(two, point), rel=1e-12)


def test_rows_of_one_constant_are_part_of_the_program() -> None:
    graph = Graph()
    (x, y, *_), places = inputs(graph)
    zero = number(graph, 0)
    results = map_program(graph, [x], [[y, y + 1], [zero, zero]], lambda s, o: [s[0] * o[0] + s[0] * o[1]])
    found = sequence(graph, [value.index for value in results[0]], places)
    (program,) = found.programs
    assert program.group_size("q") == 1
    assert program.operation_count == 1  # x times 0 is gone
    assert values(found, [3.0, 5.0]) == [15.0, 18.0]


def test_what_no_item_changes_is_no_program() -> None:
    graph = Graph()
    (x, y, *_), places = inputs(graph)
    results = map_program(graph, [x, y], [[x, y]], lambda s, _: [s[0] * s[1]])
    assert [value.index for value in results[0]] == [(x * y).index] * 2
    assert values(sequence(graph, [results[0][1].index], places), [3.0, 5.0]) == [15.0]


def test_programs_are_shared_and_hashed_alike_in_every_graph() -> None:
    graphs = [Graph(), Graph()]
    hashes = []
    for graph in graphs:
        results, _ = two_programs(graph)
        hashes.append([graph.hashes[x.index] for x in results])
        assert len(graph.programs) == 2 - (graph.programs[0] == graph.programs[-1])
    assert hashes[0] == hashes[1]


def test_given_values_are_the_ones_they_are_alone() -> None:
    """What two outputs share is defined as the first alone defines it, with fused products and all."""
    graph = Graph()
    (x, y, z, *_), places = inputs(graph)
    product = x * y
    inner = product + z
    outer = inner * inner + product
    alone = Roots("inner", (), (inner.index,))
    first = build_sequence(graph, [alone], places)
    both = build_sequence(graph, [alone, Roots("outer", (), (outer.index,), (inner.index,))], places)
    apart = build_sequence(graph, [alone, Roots("outer", (), (outer.index,))], places)
    fused = [o.op for o in both.operations].count(op.FMA)
    assert [o.op for o in first.operations].count(op.FMA) == 1
    assert fused >= 1
    inner_values = {value for output in both.outputs if output.name == "inner" for value in output.values}
    assert both.operations[inner_values.pop()].op == op.FMA
    assert len(both.operations) <= len(apart.operations)
    for point in points(6):
        (one,), (two,), (three,) = (evaluate_sequence(s, {"q": point})[0] for s in (first, both, apart))
        assert one == two == three


def test_substitution_reaches_what_programs_read() -> None:
    graph = Graph()
    results, places = two_programs(graph)
    by = list(places)
    nodes = substitute(graph, [results[0].index], {by[0]: by[1]})
    found, before = sequence(graph, nodes, places), sequence(graph, [results[0].index], places)
    for point in points(7):
        assert values(found, point) == values(before, [point[1], *point[1:]])
