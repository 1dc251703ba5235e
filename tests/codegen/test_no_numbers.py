"""min, max and smoothstep of what is no number are no number, and so are their slopes, whatever names stand there.

The order of operands in the graph follows from the hashes of their names: each pair is tried both ways.
"""

from __future__ import annotations

import math
from itertools import permutations
from pathlib import Path

import pytest

from symbody.expr import opcodes as op
from symbody.expr.calculus import forward, gradient
from symbody.expr.canonical import ONE, ZERO, apply
from symbody.expr.graph import Graph, Symbol
from symbody.expr.language.lowering import smooth_step
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence
from tests.codegen.test_lanes import WIDTH, functions, in_lanes
from tests.codegen.texts.running import ALL, Point, run

PAIRS = [pair for pair in permutations(("x", "y", "m_1", "theta", "k"), 2)]
NAN = math.nan
WITHOUT = [(NAN, 1.0), (1.0, NAN), (NAN, NAN), (NAN, -2.0), (-2.0, NAN), (NAN, math.inf)]


def extrema(names: tuple[str, str]) -> tuple[Sequence, bool]:
    """min, max, smoothstep of two quantities and their slopes both ways; whether the first stands first."""
    graph = Graph()
    a, b = (graph.symbol(Symbol(name)) for name in names)
    roots = []
    for code in (op.MIN, op.MAX):
        chosen = apply(graph, code, a, b)
        roots += [chosen, *gradient(graph, chosen, [a, b]), *forward(graph, [chosen], {a: ONE, b: ONE})]
        roots += [forward(graph, [chosen], {a: ONE})[0], forward(graph, [chosen], {b: ONE})[0]]
    step = smooth_step(graph, a, ZERO, b)
    roots += [step, *gradient(graph, step, [a, b])]
    inputs = {a: Input(names[0], "q", 0), b: Input(names[1], "q", 1)}
    made = build_sequence(graph, [Roots("f", (len(roots),), tuple(roots))], inputs)
    return made, graph.operands(apply(graph, op.MIN, a, b))[0] == a


def test_the_names_give_both_orders() -> None:
    assert {extrema(pair)[1] for pair in PAIRS} == {True, False}


@pytest.mark.parametrize("names", PAIRS)
def test_evaluation_and_machine_code(names: tuple[str, str]) -> None:
    sequence, _ = extrema(names)
    scalar, wide = functions(sequence)
    for values in WITHOUT:
        assert all(map(math.isnan, evaluate_sequence(sequence, {"q": list(values)})[0])), values
        for function in (scalar, wide):
            assert all(map(math.isnan, function(0.0, list(values), []))), values
    lanes = in_lanes(sequence, [{"q": list(WITHOUT[k % len(WITHOUT)])} for k in range(WIDTH)], 2000)
    assert all(math.isnan(value) for row in lanes for value in row)


@pytest.mark.parametrize("names", PAIRS[:2])
def test_numbers_are_as_before(names: tuple[str, str]) -> None:
    sequence, _ = extrema(names)
    for a, b in ((1.0, 2.0), (2.0, 1.0), (-3.0, 0.5)):
        s = min(max(a / b, 0.0), 1.0)
        slope = 6.0 * s * (1.0 - s)
        low, high = float(a < b), float(b < a)
        expected = [min(a, b), low, high, 1.0, low, high, max(a, b), high, low, 1.0, high, low]
        expected += [s * s * (3.0 - 2.0 * s), slope / b, -slope * a / b**2]
        for found in (evaluate_sequence(sequence, {"q": [a, b]})[0], functions(sequence)[0](0.0, [a, b], [])):
            assert [float(value) for value in found] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("language", ALL)
def test_texts(language: str, tmp_path: Path) -> None:
    seen: set[bool] = set()
    for names in PAIRS:
        sequence, first = extrema(names)
        if first in seen:
            continue
        seen.add(first)
        folder = tmp_path / str(first)
        folder.mkdir()
        points: list[Point] = [{"q": list(values)} for values in WITHOUT]
        for values, row in zip(WITHOUT, run(language, sequence, points, folder), strict=True):
            assert all(map(math.isnan, row)), (values, row)
