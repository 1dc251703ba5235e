"""Every text, run by its own tool, gives what plain evaluation gives."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence
from symbody.formats.native import from_data
from tests.codegen.sequences import EXACT, LIBRARY, TRIGONOMETRIC, random_sequence, same_bits
from tests.codegen.texts.running import ALL, CASADI_, FORTRAN, JAVASCRIPT, JULIA_, MATLAB, RUST, Point, run
from tests.codegen.texts.test_c import HOSTILE, SPECIAL, named
from tests.codegen.texts.test_python import expected
from tests.problems.mechanisms import EPS, condition, equations_of, random_values, state_of
from tests.problems.test_parallelogram import parallelogram
from tests.tiers import cases

# Names that mean something to Fortran, MATLAB, Julia, JAX and CasADi, or break their texts.
NAMES = (
    "lambda", "I", "E", "S", "N", "do", "Do", "DO", "end", "End", "function", "type", "e", "i", "j", "pi", "Pi", "t",
    "fn", "Self", "f64", "Outputs", "await", "Math", "__proto__", "constructor", "*/", "</script>",
    "T", "q", "Q", "work", "WORK", "sin", "SIN", "merge", "Merge", "dp", "kind", "symbody_piece_0", "Z3", "z3",
    "number", "module", "using", "struct", "jnp", "jax", "ca", "sum", "null", "jac", "'''", '"""', "#=", "=#", "$(1)",
    "! a", "% a", "%{", "a...", "a &", "&", "ans", "eps", "Inf", "self", "x" * 200, "ä", "µ",
)  # fmt: skip

CURVES = {
    "name": "curves",
    "parameters": {"k": 40.0, "c": 0.3, "g": 9.81},
    "inputs": ["F"],
    "body": [{"name": "Mass", "mass": 2.0}],
    "joint": [{
        "name": "slider", "type": "prismatic", "between": ["ground", "Mass"], "axis": "x", "coordinate": "x",
        "force": {"applied": "F - k*if(x > 0.1, x**3, min(x, 0.05*sign(x))) - c*max(abs(x_dot), 1)*atan2(x_dot, x)"
                             " + floor(3*x) + exp(-x**2)*log(2 + x**2)**1.5 + tanh(x_dot)/sqrt(1 + x**2)"},
    }],
}  # fmt: skip


def close(ours: list[float], theirs: list[float], tolerance: float) -> bool:
    found, reference = np.array(ours), np.array(theirs)
    return bool(np.abs(found - reference).max() <= tolerance * max(1.0, np.abs(reference).max()))


@pytest.mark.parametrize("language", ALL)
@pytest.mark.parametrize("name", cases(["slider_crank", "spinning_top", "rr_robot"], fast=["slider_crank"]))
def test_examples(language: str, name: str, tmp_path: Path) -> None:
    eqs = equations_of(name)
    outputs = ["udot", "qdot", "mass_matrix", "kinetic_energy", *(["lambda"] if eqs.multiplier_names else [])]
    sequence, _ = form_sequence(eqs, outputs)
    rng = np.random.default_rng(4)
    states = [state_of(eqs, random_values(eqs, rng)) for _ in range(4)]
    points: list[Point] = [{"t": [0.5], "q": [*s.q], "u": [*s.u], "r": [*s.r]} for s in states]
    for state, point, ours in zip(states, points, run(language, sequence, points, tmp_path), strict=True):
        # Up to 2 ulp an operation, and what the linear system makes of them.
        tolerance = 2 * EPS * sequence.operation_count * condition(eqs, state)
        assert close(ours, expected(sequence, point), tolerance)


@pytest.mark.parametrize("language", ALL)
def test_a_parallelogram_at_its_dead_centre(language: str, tmp_path: Path) -> None:
    """Stretched out, a row of the constraints depends on the others, and its multiplier is 0."""
    eqs = parallelogram()
    sequence, _ = form_sequence(eqs, ["udot", "lambda"])
    points: list[Point] = [
        {"t": [0.0], "q": [0.0, 0.0, 0.0], "u": [0.5, -0.5, 0.5]},
        {"t": [0.0], "q": [0.3, -0.3, 0.3], "u": [0.5, -0.5, 0.5]},
    ]
    results = run(language, sequence, points, tmp_path)
    for point, ours in zip(points, results, strict=True):
        reference = expected(sequence, point)
        assert all(math.isfinite(x) for x in ours)
        # Condition numbers are below 100; sines of pi and the like do not enter.
        assert close(ours, reference, 200 * EPS * sequence.operation_count)
    assert results[0][-2:].count(0.0) == expected(sequence, points[0])[-2:].count(0.0)


@pytest.mark.parametrize("language", ALL)
def test_curves_and_choices(language: str, tmp_path: Path) -> None:
    eqs = sb.form_equations(from_data(CURVES))
    sequence, _ = form_sequence(eqs, ["udot", "effort slider"])
    codes = {operation.op for operation in sequence.operations}
    assert codes >= {op.SELECT, op.MIN, op.MAX, op.ABS, op.SIGN, op.ATAN2, op.FLOOR, op.POW, op.TANH}
    points: list[Point] = [
        {"t": [0.0], "q": [x], "u": [v], "r": [1.5]}
        for x in (-1.3, -0.02, 0.0, 0.02, 0.09, 0.4, 2.5) for v in (-2.0, 0.0, 0.7)
    ]  # fmt: skip
    for point, ours in zip(points, run(language, sequence, points, tmp_path), strict=True):
        # The power of a logarithm triples its error; no cancellation beyond the size of the terms, 1000.
        assert close(ours, expected(sequence, point), 4 * EPS * sequence.operation_count)


@pytest.mark.parametrize("language", ALL)
def test_functions_differ_by_roundings_only(language: str, tmp_path: Path) -> None:
    operations = [Operation(op.SYMBOL, (), 0), Operation(op.SYMBOL, (), 1), Operation(op.RATIONAL, (), 0)]
    codes = (*LIBRARY, *TRIGONOMETRIC, op.POW)
    operations += [Operation(code, (0, 1) if op.ARITY[code] == 2 else (0,)) for code in codes]
    operations.append(Operation(op.POW, (0, 2)))
    values = tuple(range(3, len(operations)))
    inputs = (Input("x", "q", 0), Input("y", "q", 1))
    sequence = Sequence(inputs, (11,), (), (), tuple(operations), (Output("y", (len(values),), values),))
    points: list[Point] = [{"q": [x, y]} for x in (0.1, 0.7, 0.999, 3.0, 1e4) for y in (0.3, -1.7)]
    for point, found in zip(points, run(language, sequence, points, tmp_path), strict=True):
        reference = expected(sequence, point)
        for ours, theirs in zip(found, reference, strict=True):
            # Libraries promise 1 to 4 ulp; a power by repeated products has half an ulp for each.
            assert same_bits([ours], [theirs]) or abs(ours - theirs) <= 4 * math.ulp(theirs), point


@pytest.mark.parametrize("language", [FORTRAN, MATLAB, JULIA_, RUST, JAVASCRIPT])
def test_special_numbers_are_treated_as_in_compiled_code(language: str, tmp_path: Path) -> None:
    codes = (op.ADD, op.SUB, op.MUL, op.DIV, op.ATAN2, op.MIN, op.MAX, op.POW)
    singles = (op.NEG, op.SQRT, op.ABS, op.SIGN, op.LOG, op.EXP, op.TANH, op.ASIN, op.SIN)
    operations = [Operation(op.SYMBOL, (), 0), Operation(op.SYMBOL, (), 1)]
    operations += [Operation(code, (0, 1)) for code in codes] + [Operation(code, (0,)) for code in singles]
    for code in (op.LT, op.LE, op.EQ):
        operations.append(Operation(code, (0, 1)))
        operations.append(Operation(op.NOT, (len(operations) - 1,)))
        operations.append(Operation(op.SELECT, (len(operations) - 1, 0, 1)))
    values = tuple(k for k, operation in enumerate(operations) if operation.op not in op.CONDITIONS)
    inputs = (Input("x", "q", 0), Input("y", "q", 1))
    sequence = Sequence(inputs, (), (), (), tuple(operations), (Output("y", (len(values),), values),))
    points: list[Point] = [{"q": [x, y]} for x in SPECIAL for y in SPECIAL]
    for point, found in zip(points, run(language, sequence, points, tmp_path), strict=True):
        for k, (ours, theirs) in enumerate(zip(found, expected(sequence, point), strict=True)):
            same = ours == theirs or (ours != ours and theirs != theirs)  # signs of zero may differ
            assert same or abs(ours - theirs) <= 4 * math.ulp(theirs), (point, k)


@pytest.mark.parametrize("language", [FORTRAN, RUST, JAVASCRIPT])
@pytest.mark.parametrize(
    ("seed", "piece_size"),
    [(1, 40), *(pytest.param(*more, marks=pytest.mark.exhaustive) for more in [(0, 2000), (2, 150)])],
)
def test_random_sequences_agree_to_the_last_bit(
    language: str, seed: int, piece_size: int, tmp_path: Path
) -> None:
    """Kernels too; without floor, which loses a sign in Fortran. In Rust fma is fused, in Python not."""
    codes = tuple(code for code in EXACT if code != (op.FMA if language == "rust" else op.FLOOR))
    sequence, inputs = random_sequence(seed, 400, codes)
    assert sequence.kernels
    found = run(language, sequence, [inputs], tmp_path, piece_size=piece_size)
    assert same_bits(found[0], expected(sequence, inputs))


@pytest.mark.parametrize("language", [MATLAB, CASADI_, JULIA_])
def test_random_arithmetic_agrees_to_the_last_bit(language: str, tmp_path: Path) -> None:
    codes = tuple(code for code in EXACT if code not in (op.FLOOR, op.SADDLE, op.POW, op.FMA))
    sequence, inputs = random_sequence(7, 400, codes)
    (found,) = run(language, sequence, [inputs], tmp_path)
    assert [*map(abs, found)] == [*map(abs, expected(sequence, inputs))] or same_bits(
        found, expected(sequence, inputs)
    )


@pytest.mark.parametrize("language", ALL)
@pytest.mark.parametrize("names", [HOSTILE, NAMES], ids=["of C", "of others"])
def test_no_name_breaks_the_text(language: str, names: tuple[str, ...], tmp_path: Path) -> None:
    sequence = named(names)
    points: list[Point] = [{"p": [0.1 * k for k in range(len(names))]}]
    (found,) = run(language, sequence, points, tmp_path, name="sin_table")
    assert found == pytest.approx([*(math.sin(x) for x in points[0]["p"]), 0.0], rel=4 * EPS)


@pytest.mark.parametrize("language", ALL)
def test_a_system_without_solution_is_nan(language: str, tmp_path: Path) -> None:
    operations = (*(Operation(op.SYMBOL, (), k) for k in range(2)), Operation(op.SADDLE, (0, 1), 0),
                  Operation(op.PICK, (2,), 0), Operation(op.PICK, (2,), 1))  # fmt: skip
    inputs = (Input("m", "q", 0), Input("f", "q", 1))
    sequence = Sequence(inputs, (), (KernelNode(1, 0),), (), operations, (Output("x", (2,), (3, 4)),))
    points: list[Point] = [{"q": [2.0, 3.0]}, {"q": [0.0, 3.0]}, {"q": [-1.0, 3.0]}]
    solved, *others = run(language, sequence, points, tmp_path)
    assert solved == [1.5, 0.0]
    assert all(math.isnan(first) and rank == 0.0 for first, rank in others)
