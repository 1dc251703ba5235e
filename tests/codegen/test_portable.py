"""Portable functions: C, JavaScript and Python give the bits of the machine code."""

from __future__ import annotations

import ctypes
import json
import pickle
import random
import shutil
import subprocess
from collections.abc import Sequence as Items
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.codegen.signature import Signature
from symbody.expr.expression import Expr, cos, saddle_entry, sin, sqrt, symbol
from symbody.expr.graph import Graph, KernelNode, Symbol
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from tests.tiers import cases

Floats = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
OPTIONS = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]


def by_machine(f: sb.CompiledFunction, points: Items[Items[Floats]]) -> Floats:
    rows = []
    for q, u, r, p in points:
        found = f(0.25, q, u, r, p)
        parts = found if isinstance(found, tuple) else (found,)
        rows.append(np.concatenate([np.ravel(part) for part in parts]))
    return np.array(rows)


def by_c(f: sb.CompiledFunction, points: Items[Items[Floats]], folder: Path, size: int) -> Floats:
    (folder / "f.c").write_text(f.source("c"))
    subprocess.run(["gcc", *OPTIONS, "f.c", "-o", "f.so", "-lm"], cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "f.so"))
    pointer = ctypes.POINTER(ctypes.c_double)
    rows = []
    for groups in points:
        arrays = [np.array([0.25]), *map(np.ascontiguousarray, groups), np.zeros(1)]
        out, work = np.zeros(size), np.zeros(library.f_work_size() + 1)
        assert library.f(*(array.ctypes.data_as(pointer) for array in (*arrays, out, work))) == 0
        rows.append(out)
    return np.array(rows)


def by_javascript(f: sb.CompiledFunction, points: Items[Items[Floats]], folder: Path) -> Floats:
    data = json.dumps([[group.tolist() for group in groups] for groups in points])
    text = "x => Object.is(x, -0) ? '-0.0' : String(x).replace('Infinity', 'inf')"
    program = f"""import {{ f }} from './f.mjs';
for (const groups of {data}) console.log(Array.from(f(0.25, ...groups), {text}).join(' '));"""
    (folder / "f.mjs").write_text(f.source("javascript"))
    (folder / "main.mjs").write_text(program)
    run = subprocess.run(["node", "main.mjs"], cwd=folder, check=True, capture_output=True, text=True)
    return np.array([[float(word) for word in line.split()] for line in run.stdout.splitlines()])


def by_python(f: sb.CompiledFunction, points: Items[Items[Floats]]) -> Floats:
    space: dict[str, Any] = {}
    exec(f.source("python"), space)
    return np.array([space["f"](0.25, *(group.tolist() for group in groups)) for groups in points])


def check_bits(f: sb.CompiledFunction, points: Items[Items[Floats]], folder: Path) -> None:
    if shutil.which("gcc") is None or shutil.which("node") is None:
        pytest.skip("needs gcc and node")
    expected = by_machine(f, points)
    assert np.isfinite(expected).any()
    for name, found in {
        "python": by_python(f, points),
        "c": by_c(f, points, folder, expected.shape[1]),
        "javascript": by_javascript(f, points, folder),
    }.items():
        np.testing.assert_array_equal(found, expected, err_msg=name)
        np.testing.assert_array_equal(np.signbit(found), np.signbit(expected), err_msg=name)


def random_points(f: sb.CompiledFunction, count: int, seed: int) -> list[list[Floats]]:
    rng = np.random.default_rng(seed)
    return [[rng.normal(size=len(f.signature.names(group))) for group in "qurp"] for _ in range(count)]


FAST = ("slider_crank", "spinning_top")


@pytest.mark.parametrize(
    "name",
    [
        path.stem if path.stem in FAST else pytest.param(path.stem, marks=pytest.mark.exhaustive)
        for path in sorted(EXAMPLES.glob("*/*.toml"))
    ],
)
def test_examples_have_the_same_bits_in_all_languages(name: str, tmp_path: Path) -> None:
    (path,) = EXAMPLES.glob(f"*/{name}.toml")
    eqs = sb.form_equations(sb.load_model(path))
    outputs = ["xdot", "power", "energy", "lambda"]
    if eqs.signal_state_names:
        pytest.skip("points have no states of signals")
    f = sb.compile(eqs, outputs, portable=True)
    points = random_points(f, 10, 1)
    first = np.array([*sb.assemble(eqs).q.values()])
    points = [[first + 0.01 * q, *rest] for q, *rest in points]
    check_bits(f, points, tmp_path)
    usual = by_machine(sb.compile(eqs, outputs), points)
    np.testing.assert_allclose(by_machine(f, points), usual, rtol=1e-6, atol=1e-6 * np.abs(usual).max())


def random_function(seed: int) -> sb.CompiledFunction:
    """A linear system, whose entries are random formulas in q, u and p, and these formulas."""
    rng, graph = random.Random(seed), Graph()
    n = rng.randint(1, 5)
    m = rng.randint(0, n)
    names = {group: [f"{group}{k}" for k in range(3)] for group in "qup"}
    symbols = [symbol(graph, Symbol(name)) for group in names.values() for name in group]
    values: list[Expr] = list(symbols)
    for _k in range(30):
        a, b = rng.choice(values), rng.choice(values)
        makers = [
            lambda a=a, b=b: a + b, lambda a=a, b=b: a * b, lambda a=a, b=b: a - b * a,
            lambda a=a, b=b: sin(a + b), lambda a=a, b=b: cos(a) * b, lambda a=a: sqrt(a * a + 1),
            lambda a=a, b=b: a / (b * b + 1), lambda a=a: a**3,
        ]  # fmt: skip
        values.append(rng.choice(makers)())
    entries = [rng.choice(values) for _k in range(n * n + m * n + n + m)]
    # Positive definite, and finite whatever the formulas are.
    mass = [
        sin(entries[min(i, j) * n + max(i, j)]) / n + (2 if i == j else 0) for i in range(n) for j in range(n)
    ]
    rows, rest = [sin(x) for x in entries[n * n : n * n + m * n]], entries[n * n + m * n :]
    operands = tuple(x.index for x in (*mass, *rows, *rest))
    kernel = graph.kernel(KernelNode(n, m))
    solved = [saddle_entry(graph, kernel, operands, k) for k in range(n + m)]
    roots = [Roots("solved", (len(solved),), tuple(x.index for x in solved))]
    roots.append(Roots("values", (len(values),), tuple(x.index for x in values)))
    places = {
        x.index: Input(name, name[0], int(name[1]))
        for x, name in zip(symbols, [name for group in names.values() for name in group], strict=True)
    }
    signature = Signature(tuple(names["q"]), tuple(names["u"]), (), tuple(names["p"]))
    return sb.CompiledFunction(build_sequence(graph, roots, places), signature, portable=True)


@pytest.mark.parametrize("seed", cases(range(2), fast=[0]))
def test_random_systems_have_the_same_bits_in_all_languages(seed: int, tmp_path: Path) -> None:
    f = random_function(seed)
    check_bits(f, random_points(f, 10, seed), tmp_path)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(100, 200))
def test_a_thousand_random_systems_have_the_same_bits_in_all_languages(seed: int, tmp_path: Path) -> None:
    f = random_function(seed)
    check_bits(f, random_points(f, 10, seed), tmp_path)


def test_free_parameters_batches_and_copies_have_the_same_bits() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    f = sb.compile(eqs, "udot", free=["m2"], portable=True, lanes=True)
    points = random_points(f, 20, 3)
    points = [[*groups[:3], np.abs(groups[3]) + 1.0] for groups in points]
    expected = by_machine(f, points)
    np.testing.assert_array_equal(by_python(f, points), expected)
    batch = f(0.25, *(np.array(group) for group in zip(*points, strict=True)))
    np.testing.assert_array_equal(batch, expected)
    np.testing.assert_array_equal(by_machine(pickle.loads(pickle.dumps(f)), points), expected)


def test_other_languages_are_refused() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    with pytest.raises(sb.CompileError) as caught:
        sb.compile(eqs, "udot", portable=True).source("fortran")
    assert caught.value.problems[0].code == "compile.portable_language"
