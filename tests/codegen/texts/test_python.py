"""Python text run by another interpreter against plain evaluation, and names that try to break it."""

from __future__ import annotations

import ast
import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.texts.python import generate
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import FLOATS, evaluate_sequence
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence
from tests.codegen.sequences import (
    EXACT,
    LIBRARY,
    TRIGONOMETRIC,
    Inputs,
    random_sequence,
    same_bits,
    single,
)
from tests.codegen.texts.test_c import HOSTILE, SPECIAL, named
from tests.problems.mechanisms import EPS, condition, equations_of, random_values, state_of

# NumPy has no fma: the text rounds the product first.
TWICE_ROUNDED = replace(FLOATS, functions={**FLOATS.functions, op.FMA: lambda a, b, c: a * b + c})

Point = dict[str, Any]  # arguments by name, lists of any depth

# Without warnings, so that none can be printed; results as nested lists of float.hex().
CALLER = """
import json, sys, warnings
import numpy as np
warnings.simplefilter("error")
from made import {name}
def written(x):
    if isinstance(x, tuple):
        return {{"fields": list(getattr(x, "_fields", ())), "values": [written(each) for each in x]}}
    return {{"shape": list(x.shape), "numbers": [float(each).hex() for each in x.ravel()]}}
for line in sys.stdin:
    given = json.loads(line, parse_constant=float)
    print(json.dumps(written({name}(**given))))
"""


def run_text(text: str, folder: Path, points: list[Point], name: str = "f") -> list[dict[str, Any]]:
    """What the text returns at each point, computed in a process that cannot import symbody."""
    (folder / "made.py").write_text(text, encoding="ascii")
    (folder / "caller.py").write_text(CALLER.format(name=name), encoding="ascii")
    lines = "\n".join(json.dumps(point) for point in points)
    command = [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(folder)!r}); import caller"]
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [json.loads(line) for line in done.stdout.splitlines()]


def flat(result: dict[str, Any]) -> list[float]:
    parts = result["values"] if "values" in result else [result]
    return [float.fromhex(number) for part in parts for number in part["numbers"]]


def arguments(inputs: Point) -> Point:
    given: Point = {"t": [0.0], "q": [0.0], "u": [0.0], **inputs}
    return {**given, "t": given["t"][0]}


def expected(sequence: Sequence, inputs: Inputs) -> list[float]:
    return [value for output in evaluate_sequence(sequence, inputs, TWICE_ROUNDED) for value in output]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_random_sequences_agree_to_the_last_bit(seed: int, tmp_path: Path) -> None:
    """Kernels and all that IEEE 754 rounds in one way; floor loses the sign of -0 in plain evaluation."""
    codes = tuple(code for code in EXACT if code not in (op.FLOOR, op.POW))
    sequence, inputs = random_sequence(seed, 400, codes)
    assert sequence.kernels
    (found,) = run_text(generate(sequence), tmp_path, [arguments(inputs)])
    assert same_bits(flat(found), expected(sequence, inputs))


def test_functions_differ_by_roundings_only(tmp_path: Path) -> None:
    """NumPy's own functions promise 4 ulp, and whole powers are the same products."""
    operations = [Operation(op.SYMBOL, (), 0), Operation(op.SYMBOL, (), 1), Operation(op.RATIONAL, (), 0)]
    codes = (*LIBRARY, *TRIGONOMETRIC, op.POW)
    operations += [Operation(code, (0, 1) if op.ARITY[code] == 2 else (0,)) for code in codes]
    operations.append(Operation(op.POW, (0, 2)))
    values = tuple(range(3, len(operations)))
    inputs = (Input("x", "q", 0), Input("y", "q", 1))
    sequence = Sequence(inputs, (11,), (), (), tuple(operations), (Output("y", (len(values),), values),))
    points: list[Point] = [{"q": [x, y]} for x in (0.1, 0.7, 0.999, 3.0, 1e4) for y in (0.3, -1.7)]
    for point, result in zip(
        points, run_text(generate(sequence), tmp_path, [arguments(point) for point in points]), strict=True
    ):
        found, reference = flat(result), expected(sequence, point)
        assert found[-1] == reference[-1]
        for ours, theirs in zip(found, reference, strict=True):
            assert same_bits([ours], [theirs]) or abs(ours - theirs) <= 4 * math.ulp(theirs)


def test_special_numbers_are_treated_as_in_compiled_code(tmp_path: Path) -> None:
    codes = (op.ADD, op.SUB, op.MUL, op.DIV, op.ATAN2, op.MIN, op.MAX, op.POW)
    singles = (op.NEG, op.SQRT, op.ABS, op.SIGN, op.LOG, op.EXP, op.TANH, op.ASIN)
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
    results = run_text(generate(sequence), tmp_path, [arguments(point) for point in points])
    for point, result in zip(points, results, strict=True):
        for ours, theirs in zip(flat(result), expected(sequence, point), strict=True):
            # Functions within 4 ulp, all else exact; log(2.5) and the like are the only finite ones.
            assert same_bits([ours], [theirs]) or abs(ours - theirs) <= 4 * math.ulp(theirs), point


def test_constants_divide_by_zero_without_an_error(tmp_path: Path) -> None:
    operations = (Operation(op.RATIONAL, (), 0), Operation(op.RATIONAL, (), 1), Operation(op.DIV, (0, 1)),
                  Operation(op.PI, ()), Operation(op.SUB, (3, 3)), Operation(op.DIV, (0, 4)))  # fmt: skip
    outputs = (Output("y", (3,), (2, 5, 3)),)
    sequence = Sequence((), (-1, 0), (), (), operations, outputs)
    (found,) = run_text(generate(sequence), tmp_path, [arguments({})])
    assert flat(found) == [-math.inf, -math.inf, math.pi]


def test_a_singular_system_gives_nan(tmp_path: Path) -> None:
    operations = (Operation(op.SYMBOL, (), 0), Operation(op.RATIONAL, (), 0), Operation(op.SADDLE, (0, 1), 0),
                  Operation(op.PICK, (2,), 0))  # fmt: skip
    sequence = Sequence(
        (Input("m", "q", 0),), (3,), (KernelNode(1, 0),), (), operations, (Output("y", (), (3,)),)
    )
    solved, singular, batch = run_text(
        generate(sequence),
        tmp_path,
        [arguments({"q": [2.0]}), arguments({"q": [0.0]}), arguments({"q": [[2.0], [0.0]]})],
    )
    assert flat(solved) == [1.5] and math.isnan(flat(singular)[0])
    assert batch["shape"] == [2] and same_bits(flat(batch), [1.5, math.nan])


def test_batches_have_the_shapes_of_compiled_functions(tmp_path: Path) -> None:
    eqs = equations_of("slider_crank")
    names = ["udot", "mass_matrix", "kinetic_energy", "lambda"]
    native = sb.compile(eqs, names)
    rng = np.random.default_rng(3)
    states = [state_of(eqs, random_values(eqs, rng)) for _ in range(3)]
    q, u = (np.array([getattr(state, letter) for state in states]) for letter in "qu")
    r = np.array([[1.0], [2.0]])[:, np.newaxis]
    reference = native(0.0, q, u, r)
    given = {"t": 0.0, "q": q.tolist(), "u": u.tolist(), "r": r.tolist()}
    (found,) = run_text(sb.generate_code(eqs, names, "python", parameters={}), tmp_path, [given])
    assert [part["shape"] for part in found["values"]] == [list(part.shape) for part in reference]
    worst = max(condition(eqs, state) for state in states)
    ours, theirs = np.array(flat(found)), np.concatenate([part.ravel() for part in reference])
    # Sines of other libraries, and no fma: some eps, amplified by the linear system.
    assert np.abs(ours - theirs).max() < 100 * EPS * worst * max(1.0, np.abs(theirs).max())


@pytest.mark.parametrize("name", ["spring_mass_damper", "rr_robot", "spinning_top_omega", "spatial_four_bar"])
def test_examples_as_plain_evaluation(name: str, tmp_path: Path) -> None:
    eqs = equations_of(name)
    sequence, _ = form_sequence(eqs, ["xdot", "kinetic_energy"])
    rng = np.random.default_rng(4)
    states = [state_of(eqs, random_values(eqs, rng)) for _ in range(10)]
    points = [{"t": [0.5], "q": list(s.q), "u": list(s.u), "r": list(s.r)} for s in states]
    results = run_text(generate(sequence), tmp_path, [arguments(point) for point in points])
    for state, point, result in zip(states, points, results, strict=True):
        reference = np.array(expected(sequence, point))
        # Up to 2 ulp an operation, and what the linear system makes of them.
        tolerance = 2 * EPS * sequence.operation_count * condition(eqs, state)
        assert np.abs(np.array(flat(result)) - reference).max() < tolerance * max(1, np.abs(reference).max())


PYTHON_NAMES = (
    "lambda", "None", "np", "math", "f", "out", "batch", "namedtuple", "Outputs", "print", "match", "_",
    "__import__('os').abort()", '"""', "'''", "\\", "\\u0041", '\\"', "z1", "z2_3", "_saddle", "self", "{x}",
)  # fmt: skip


@pytest.mark.parametrize("name", ["f", "sin_table"])
def test_no_name_breaks_the_text(name: str, tmp_path: Path) -> None:
    for names in (HOSTILE, PYTHON_NAMES):
        text = generate(named(names), name)
        points = {"p": [0.1 * k for k in range(len(names))]}
        (found,) = run_text(text, tmp_path, [arguments(points)], name)
        reference = [*(math.sin(x) for x in points["p"]), 0.0]
        assert flat(found) == pytest.approx(reference, rel=4 * EPS)


def test_the_table_of_names_can_be_read_back() -> None:
    names = (*HOSTILE, *(name for name in PYTHON_NAMES if name not in HOSTILE))
    text = generate(named(names))
    told = ast.get_docstring(ast.parse(text), clean=False)
    assert told is not None
    rows = re.findall(r'^  p\[(\d+)\]  (\w+)  (".*")$', told, flags=re.MULTILINE)
    assert [json.loads(row[2]) for row in rows] == list(names)
    assert len({row[1].lower() for row in rows}) == len(names)
    for k, row in enumerate(rows):
        assert f"    {row[1]} = p[{k}]\n" in text


def test_nothing_to_compute(tmp_path: Path) -> None:
    (found,) = run_text(generate(Sequence((), (), (), (), (), ())), tmp_path, [arguments({})])
    assert found == {"fields": [], "values": []}


def test_results_are_named_tuples(tmp_path: Path) -> None:
    text = sb.generate_code(equations_of("slider_crank"), ["udot", "lambda", "s*2"], "python")
    q, u, p = [0.0, 0.0, 1.4], [0.0] * 3, [1.0, 1.5, 0.8, 0.02, 0.15, 0.4, 1.0, 9.81]
    (found,) = run_text(text, tmp_path, [{"t": 0.0, "q": q, "u": u, "r": [0.0], "p": p}])
    assert found["fields"] == ["udot", "x_lambda", "s_2"]
    assert flat(found)[-1] == 2.8


def test_too_short_arguments_are_told(tmp_path: Path) -> None:
    text = (
        generate(single(op.ADD, 2)) + "\ntry:\n    f(0.0, [1.0], ())\nexcept ValueError as e:\n    print(e)\n"
    )
    path = tmp_path / "short.py"
    path.write_text(text, encoding="ascii")
    done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout == "coordinates q need 2 numbers on their last axis\n"


def test_the_text_of_a_small_sequence() -> None:
    operations = (Operation(op.SYMBOL, (), 0), Operation(op.SYMBOL, (), 1), Operation(op.SYMBOL, (), 2),
                  Operation(op.SIN, (0,)), Operation(op.MUL, (1, 3)), Operation(op.ADD, (2, 4)))  # fmt: skip
    inputs = (Input("theta", "q", 0), Input("mass", "p", 3), Input("t", "t", 0))
    text = generate(Sequence(inputs, (), (), (), operations, (Output("torque", (), (5,)),)), "torque_of")
    assert "math" not in text and "saddle" not in text and "namedtuple" not in text
    assert text.split("@np.errstate")[1].splitlines()[1:] == [
        "def torque_of(t, q, u, r=(), p=()):",
        '    """Return torque; see the module."""',
        "    t = np.asarray(t, dtype=float)",
        '    q = _columns("coordinates q", q, 1)',
        '    u = _columns("speeds u", u, 0)',
        '    r = _columns("inputs r", r, 0)',
        '    p = _columns("parameters p", p, 4)',
        "    batch = np.broadcast_shapes(t.shape, q.shape[1:], u.shape[1:], r.shape[1:], p.shape[1:])",
        "    theta = q[0]",
        "    mass = p[3]",
        "    z3 = np.sin(theta)",
        "    z4 = mass * z3",
        "    z5 = t + z4",
        "    out = np.empty(batch + (1,))",
        "    out[..., 0] = z5",
        "    return out[..., 0:1].reshape(batch + ())",
    ]


def test_the_same_text_every_time() -> None:
    sequence, _ = random_sequence(3, 300, (*EXACT, *LIBRARY))
    assert generate(sequence) == generate(sequence)
    assert generate(sequence).isascii() and generate(sequence).count("def symbody_solve_saddle(") == 1


@pytest.mark.parametrize("name", ["", "1f", "lambda", "a b", "np", "x" * 42, "f;", "z1", "_f"])
def test_functions_need_a_python_name(name: str) -> None:
    with pytest.raises(CompileError, match="cannot be the name") as caught:
        generate(single(op.ADD, 2), name)
    assert caught.value.problems[0].code == "compile.name"


def test_values_no_output_needs_are_left_out() -> None:
    operations = (Operation(op.SYMBOL, (), 0), Operation(op.EXP, (0,)), Operation(op.LOG, (0,)))
    sequence = Sequence((Input("x", "q", 0),), (), (), (), operations, (Output("y", (), (2,)),))
    assert "np.exp(" not in generate(sequence)


def test_languages_have_names() -> None:
    eqs = equations_of("spring_mass_damper")
    assert sb.generate_code(eqs, "udot", "Python") == sb.generate_code(eqs, "udot", "python")
    with pytest.raises(CompileError, match="did you mean 'python'"):
        sb.generate_code(eqs, "udot", "pyton")
