"""Several points at once: the bits of one after the other, for any batch, stride, kernel and failure."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.machine import lanes
from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.signature import Signature
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Output, Sequence
from tests.codegen.native import call
from tests.codegen.sequences import EXACT, LIBRARY, TRIGONOMETRIC, random_sequence, same_bits, single
from tests.codegen.test_llvm import NUMBERS, kernels
from tests.tiers import cases

ALL = (*EXACT, *LIBRARY, *TRIGONOMETRIC)
WIDTH = lanes()


def functions(sequence: Sequence) -> tuple[CompiledFunction, CompiledFunction]:
    """A function without lanes and one that always uses them."""
    groups = {g: tuple(f"{g}{k}" for k in range(sequence.group_size(g))) for g in "qurp"}
    signature = Signature(**groups)
    return CompiledFunction(sequence, signature, lanes=False), CompiledFunction(
        sequence, signature, lanes=True
    )


def in_lanes(sequence: Sequence, points: list[dict[str, list[float]]], piece_size: int) -> list[list[float]]:
    """Outputs of `WIDTH` points by the function in lanes, every array laid out by hand."""
    function = compile_sequence(sequence, in_lanes=True, piece_size=piece_size)
    groups = {g: [x for entry in zip(*(p[g] for p in points), strict=True) for x in entry] for g in points[0]}
    wide = _widened(sequence)
    status, values = call(function, wide, groups)
    assert status == 0
    return [values[lane::WIDTH] for lane in range(WIDTH)]


def _widened(sequence: Sequence) -> Sequence:
    """A sequence with as many outputs as all lanes together have."""
    values = tuple(k for output in sequence.outputs for k in output.values)
    return replace(sequence, outputs=(Output("all", (len(values) * WIDTH,), values * WIDTH),))


@pytest.mark.parametrize("seed", cases(range(6), fast=[1]))
@pytest.mark.parametrize("piece_size", [17, 2000])
def test_random_sequences_have_the_bits_of_scalars(seed: int, piece_size: int) -> None:
    sequence, inputs = random_sequence(seed, 200, ALL)
    source = random.Random(seed)
    points = [
        {g: [x + source.uniform(-0.1, 0.1) for x in values] for g, values in inputs.items()}
        for _ in range(WIDTH)
    ]
    scalar = compile_sequence(sequence)
    for point, found in zip(points, in_lanes(sequence, points, piece_size), strict=True):
        assert same_bits(found, call(scalar, sequence, point)[1])


CODES = sorted(op.UNARY_FUNCTIONS | {op.NEG, op.ADD, op.SUB, op.MUL, op.DIV, op.ATAN2, op.MIN, op.MAX})


@pytest.mark.parametrize("code", CODES, ids=[op.NAMES[code] for code in CODES])
def test_special_numbers_stay_in_their_lanes(code: int) -> None:
    arity = op.ARITY[code]
    without, with_lanes = functions(single(code, arity))
    numbers = [*NUMBERS, 1e5, 1.1e5, -3e9]  # sines beyond 1e5 come from the library, lane by lane
    q = np.array([[x, y][:arity] for x in numbers for y in numbers])
    empty = np.zeros(0)
    assert same_bits(without(0.0, q, empty).ravel().tolist(), with_lanes(0.0, q, empty).ravel().tolist())


def test_failing_points_are_told_as_one_by_one_and_spoil_no_other() -> None:
    sequence = kernels(2)
    function = compile_sequence(sequence, in_lanes=True)
    masses = [[1.0, 2.0], *[[3.0, 4.0]] * (WIDTH - 2), [2.0, -1.0]]
    wide = _widened(sequence)
    q = [x for entry in zip(*masses, strict=True) for x in entry]
    status, values = call(function, wide, {"q": q, "u": [8.0] * (2 * WIDTH)})
    assert status != 0
    assert values[0] == 8.0 and values[WIDTH] == 4.0
    assert values[WIDTH - 1] == 4.0 and math.isnan(values[2 * WIDTH - 1])
    _, with_lanes = functions(sequence)
    with pytest.raises(sb.SimulationError):
        with_lanes(0.0, np.tile(np.array(masses), (3, 1)), [8.0, 8.0])


@pytest.fixture(scope="module")
def arm() -> sb.EquationSet:
    """Three hinged links."""
    elements: list[object] = []
    before = "ground"
    for k, axis in enumerate("zyx"):
        ends = {"P": sb.Frame(at=(0, 0, "-l/2")), "Q": sb.Frame(at=(0, 0, "l/2"))}
        elements += [
            sb.Body(f"B{k}", mass=1 + k, inertia=(0.1, 0.2, 0.15), frames=ends),
            sb.Revolute(f"J{k}", before, f"B{k}.P", axis=axis, coordinate=f"q{k}"),
        ]
        before = f"B{k}.Q"
    return sb.form_equations(
        sb.Model("arm", elements, gravity=(0, 0, "-g"), parameters={"g": 9.81, "l": 0.5})
    )


@pytest.mark.parametrize("count", [0, 1, WIDTH - 1, WIDTH, WIDTH + 1, 5 * WIDTH + 3])
@pytest.mark.parametrize("threads", [1, 3])
def test_any_batch_by_any_threads_has_the_same_bits(
    arm: sb.EquationSet, count: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symbody.codegen.native_call._WORTH_A_THREAD", 1)
    outputs = ["udot", "mass_matrix"]
    without = sb.compile(arm, outputs, free=["l"], lanes=False)
    with_lanes = sb.compile(arm, outputs, free=["l"], lanes=True)
    source = np.random.default_rng(count)
    wide = source.normal(size=(count, 12))
    given = (source.normal(size=count), wide[:, 1:7:2], wide[:, 9:6:-1], ())  # strided, and backwards
    for p in ([0.4], source.uniform(0.3, 0.6, size=(count, 1))):
        expected, found = without(*given, p), with_lanes(*given, p, threads=threads)
        assert all(a.tobytes() == b.tobytes() for a, b in zip(expected, found, strict=True))
        single_points = [without(given[0][k], given[1][k], given[2][k], (), np.broadcast_to(p, (count, 1))[k])
                         for k in range(count)]  # fmt: skip
        assert all((found[0][k] == one[0]).all() for k, one in enumerate(single_points))


def test_quick_code_has_the_same_bits(arm: sb.EquationSet) -> None:
    q, u = np.random.default_rng(1).normal(size=(2, 20, 3))
    thorough, quick = sb.compile(arm, "udot"), sb.compile(arm, "udot", quick=True)
    assert thorough(0.0, q, u).tobytes() == quick(0.0, q, u).tobytes()


@pytest.mark.parametrize("threads", [0, -1, 1.5, True])
def test_threads_are_counted(arm: sb.EquationSet, threads: object) -> None:
    with pytest.raises(sb.CompileError, match="number of threads"):
        sb.compile(arm, "udot", quick=True)(0.0, np.zeros((4, 3)), np.zeros(3), threads=threads)


def test_circles_known_at_the_head_share_a_call() -> None:
    sequence, _ = random_sequence(1, 100, (*EXACT, *TRIGONOMETRIC))
    function = compile_sequence(sequence, keep_ir=True)
    assert "@symbody_sincos_" in function.ir
