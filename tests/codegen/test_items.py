"""Programs in machine code: the bits of plain evaluation, for any number of items and any registers."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm import native
from symbody.codegen.llvm.items import plan_items
from symbody.codegen.llvm.machine import lanes
from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.pieces import plan_pieces
from symbody.codegen.signature import Signature, source_text
from symbody.codegen.stored_sequence import read_sequence, store_sequence
from symbody.expr import opcodes as op
from symbody.expr.expression import Expr, maximum, sqrt, symbol
from symbody.expr.graph import Graph, Symbol
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.program import map_program, written_out
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence
from symbody.storage import VARIABLE
from tests.codegen.native import SIGNATURE as CALL
from tests.codegen.native import call, doubles

INPUTS = 6
SIGNATURE = Signature(tuple(f"x{k}" for k in range(INPUTS)), (), (), ())
WIDTHS = [width for width in (2, 4, 8) if width <= lanes()]


def body(source: random.Random, results: int) -> Callable[[list[Expr], list[Expr]], list[Expr]]:
    """A program of sums, products, quotients, roots, powers and choices."""
    seed = source.random()

    def compute(shared: list[Expr], own: list[Expr]) -> list[Expr]:
        inside = random.Random(seed)
        values = [*shared, *own]
        for _ in range(25):
            a, b = inside.choice(values[-8:]), inside.choice(values)
            kind = inside.randrange(6)
            made = (a + b, a * b / 4, a - b, a / (b**2 + 1), sqrt(b**2 + 1), maximum(a, b) * 0.5)[kind]
            values.append(made)
        return [*values[-results + 1 :], own[0] * shared[0]]

    return compute


def random_programs(seed: int) -> Sequence:
    """Some programs of 1 to 20 items that read inputs, each other, constants and plain operations."""
    source = random.Random(seed)
    graph = Graph()
    x = [symbol(graph, Symbol(f"x{k}")) for k in range(INPUTS)]
    places = {value.index: Input(f"x{k}", "q", k) for k, value in enumerate(x)}
    pool, rows = [*x, x[0] * x[1]], []
    outputs: list[Roots] = []
    for k in range(4):
        count = source.choice([1, 2, 3, 4, 5, 7, 8, 9, 13, 16, 20])
        own = [[source.choice(pool) + source.randrange(3) for _ in range(count)] for _ in range(3)]
        own += [row[:count] for row in rows if len(row) >= count][-2:]  # as another program left it
        results = map_program(graph, source.sample(pool, 3), own, body(source, 4))
        rows += results
        pool += [source.choice(row) for row in results]
        outputs.append(Roots(f"o{k}", (4, count), tuple(value.index for row in results for value in row)))
        outputs.append(Roots(f"p{k}", (), ((results[0][0] * results[1][-1]).index,)))
    return build_sequence(graph, outputs, places)


def points(seed: int, count: int) -> list[list[float]]:
    source = random.Random(seed)
    return [[source.uniform(-1.5, 1.5) for _ in range(INPUTS)] for _ in range(count)]


def flat(values: list[list[float]]) -> list[float]:
    return [x for output in values for x in output]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("seed", range(4))
def test_machine_code_has_the_bits_of_evaluation(
    seed: int, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "lanes", lambda: width)
    sequence = random_programs(seed)
    assert sum(o.op == op.MAP for o in sequence.operations) >= 3
    for piece_size in (300, 8000):
        function = compile_sequence(sequence, piece_size=piece_size, keep_ir=True)
        for point in points(seed, 5):
            status, found = call(function, sequence, {"q": point})
            assert status == 0
            assert found == flat(evaluate_sequence(sequence, {"q": point}))


@pytest.mark.parametrize("seed", range(4))
def test_lanes_have_the_bits_of_one_point(seed: int) -> None:
    sequence = random_programs(10 + seed)
    scalar, wide = (CompiledFunction(sequence, SIGNATURE, lanes=chosen) for chosen in (False, True))
    q = np.array(points(seed, 21))
    for one, two in zip(scalar(0.0, q, np.zeros((21, 0))), wide(0.0, q, np.zeros((21, 0))), strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_is_written_beyond_the_output(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Registers reach over the end of rows: the last row of the last output is the end of the caller's array."""
    monkeypatch.setattr(native, "lanes", lambda: width)
    for count in (1, 3, 7, 9, 13):
        graph = Graph()
        x = symbol(graph, Symbol("x0"))
        rows = map_program(
            graph, [x], [[x + k for k in range(count)]], lambda s, o: [s[0] * o[0], s[0] - o[0]]
        )
        nodes = tuple(value.index for row in rows for value in row)
        sequence = build_sequence(graph, [Roots("o", (2, count), nodes)], {x.index: Input("x0", "q", 0)})
        function = compile_sequence(sequence)
        given, out, work = (
            doubles([2.0]),
            doubles([7.0] * (2 * count + 16)),
            doubles([0.0] * function.work_size),
        )
        assert CALL(function.address)(None, given, None, None, None, None, out, work) == 0
        products, differences = [2 * (2.0 + k) for k in range(count)], [-float(k) for k in range(count)]
        assert list(out) == [*products, *differences, *[7.0] * 16]


def test_results_of_one_program_are_read_where_they_lie() -> None:
    graph = Graph()
    x = [symbol(graph, Symbol(f"x{k}")) for k in range(3)]
    places = {value.index: Input(f"x{k}", "q", k) for k, value in enumerate(x)}
    first = map_program(graph, [x[0]], [[x[1] * k + x[2] for k in range(7)]], lambda s, o: [s[0] * o[0]])
    second = map_program(graph, [x[2]], [first[0]], lambda s, o: [s[0] + o[0]])
    nodes = tuple(value.index for value in second[0])
    sequence = build_sequence(graph, [Roots("o", (7,), nodes)], places)
    plan = plan_pieces(sequence)
    items = plan_items(sequence, plan.needed, plan.outputs, plan.work_size, 4)
    one, two = items.maps.values()
    assert two.own == [one.results]
    assert [place for place, _ in two.stores] == list(two.shared)  # nothing else is moved
    assert two.outputs == {0: 0} and len(items.put) == 7  # and go out as they are
    # The eighth number of the first row is set to zero; what follows from it is left with the seven results.
    assert one.zeros == [(one.own[0] + 7, 1)] and two.zeros == []


def test_stored_sequences_keep_their_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    monkeypatch.setattr("symbody.codegen.stored_sequence.SMALLEST", 1)
    sequence = random_programs(30)
    assert store_sequence(b"key", sequence, SIGNATURE)
    read = read_sequence(b"key")
    assert read is not None and read[0] == sequence


@pytest.mark.parametrize("language", ["c", "python", "fortran", "matlab", "julia", "rust", "javascript"])
def test_texts_write_every_item_out(language: str) -> None:
    sequence = random_programs(31)
    text = source_text(sequence, language, SIGNATURE)
    assert text == source_text(written_out(sequence), language, SIGNATURE)
    assert "map" not in text.split("Results")[-1]
