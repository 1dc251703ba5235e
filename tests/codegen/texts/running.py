"""Texts run by the tools they are for, each in a process or library of its own; results row-major, flat."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from symbody.codegen.texts import fortran, javascript, rust
from symbody.codegen.texts.languages import TEXTS
from symbody.expr.sequences.sequence import Sequence
from tests.codegen.tools import runnable

Point = dict[str, list[float]]
GFORTRAN, OCTAVE, JULIA = shutil.which("gfortran"), shutil.which("octave-cli"), shutil.which("julia")
RUSTC, NODE = runnable("rustc"), shutil.which("node")
# JAX is large: it may live in an environment of its own.
JAX = sys.executable if importlib.util.find_spec("jax") else os.environ.get("SYMBODY_JAX_PYTHON")
CASADI = sys.executable if importlib.util.find_spec("casadi") else None
# Arguments that a model does not read, equality that it asks for, and what inlining of a kernel without rows
# makes gcc believe.
STRICT = (
    "-std=f2008", "-Wall", "-Wextra", "-Werror", "-Wno-unused-dummy-argument", "-Wno-compare-reals",
    "-Wno-maybe-uninitialized", "-O2",
)  # fmt: skip

FORTRAN = pytest.param("fortran", marks=pytest.mark.skipif(GFORTRAN is None, reason="needs gfortran"))
MATLAB = pytest.param("matlab", marks=pytest.mark.skipif(OCTAVE is None, reason="needs octave-cli"))
CASADI_ = pytest.param("casadi", marks=pytest.mark.skipif(CASADI is None, reason="needs the package casadi"))
JULIA_ = pytest.param("julia", marks=pytest.mark.skipif(JULIA is None, reason="needs julia"))
RUST = pytest.param("rust", marks=pytest.mark.skipif(RUSTC is None, reason="needs rustc"))
JAVASCRIPT = pytest.param("javascript", marks=pytest.mark.skipif(NODE is None, reason="needs node"))
JAX_ = pytest.param(
    "jax",
    marks=[
        pytest.mark.skipif(JAX is None, reason="needs jax here or an interpreter in SYMBODY_JAX_PYTHON"),
        pytest.mark.exhaustive,  # some seconds to compile each
    ],
)
ALL = (FORTRAN, MATLAB, CASADI_, JULIA_, RUST, JAVASCRIPT, JAX_)

IN_PIECES: dict[str, Callable[..., str]] = {
    "fortran": fortran.generate,
    "rust": rust.generate,
    "javascript": javascript.generate,
}


def run(
    language: str, sequence: Sequence, points: list[Point], folder: Path, name: str = "f", **options: int
) -> list[list[float]]:
    """What the text of the sequence gives at each point; arguments as long as the first point has them."""
    names = {group: [f"{group}{k}" for k in range(len(points[0].get(group, ())))] for group in "qurpc"}
    write = partial(IN_PIECES[language], **options) if options else TEXTS[language]
    return RUNNERS[language](write(sequence, name, names), sequence, points, folder, name)


def _groups(sequence: Sequence) -> str:
    return "tqurpc" if sequence.group_size("c") else "tqurp"


def _done(command: list[str], folder: Path, given: str = "") -> str:
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr[-4000:] + done.stdout[-2000:]
    return done.stdout


def fortran_library(text: str, folder: Path, *options: str) -> ctypes.CDLL:
    (folder / "f.f90").write_text(text, encoding="ascii")
    assert GFORTRAN is not None
    _done([GFORTRAN, *(options or STRICT), "-shared", "-fPIC", "-o", "f.so", "f.f90"], folder)
    return ctypes.CDLL(str(folder / "f.so"))


def _fortran(
    text: str, sequence: Sequence, points: list[Point], folder: Path, name: str
) -> list[list[float]]:
    function = fortran_library(text, folder)[name.lower()]
    results = []
    for point in points:
        given = [np.array(point.get(group, [0.0])) for group in _groups(sequence)]
        made = [np.zeros(output.shape, order="F") for output in sequence.outputs]
        function(*(ctypes.c_void_p(array.ctypes.data) for array in (*given, *made)))
        results.append([float(x) for array in made for x in array.ravel()])
    return results


def _octave(text: str, sequence: Sequence, points: list[Point], folder: Path, name: str) -> list[list[float]]:
    (folder / f"{name}.m").write_text(text, encoding="ascii")
    made = [f"y{k}" for k in range(len(sequence.outputs))]
    lines = ["1;"]
    for point in points:
        given = [_row(point.get(group, [0.0])) for group in _groups(sequence)]
        lines.append(f"[{', '.join(made)}] = {name}({', '.join(given)});")
        for word, output in zip(made, sequence.outputs, strict=True):
            # Columns first in memory: reversed axes give the row-major order.
            turned = f"permute({word}, {len(output.shape)}:-1:1)" if len(output.shape) > 1 else word
            lines.append(f"printf('%.17g ', {turned});" if output.values else "")
        lines.append("printf('\\n');")
    (folder / "caller.m").write_text("\n".join(lines) + "\n", encoding="ascii")
    assert OCTAVE is not None
    return _numbers(_done([OCTAVE, "-q", "--no-init-file", "caller.m"], folder))


def _row(values: list[float]) -> str:
    return "[" + " ".join(repr(float(x)) for x in values) + "]"


def _numbers(printed: str) -> list[list[float]]:
    return [[float(word) for word in line.split()] for line in printed.splitlines()]


JULIA_CALLER = """
include("f.jl")
using .symbody_{name}
flat(x::Number) = [x]
flat(x::AbstractArray) = vec(permutedims(x, ndims(x):-1:1))
flat(x::NamedTuple) = vcat(map(flat, values(x))...)
for point in [{points}]
    println(join(string.(Float64.(flat({name}(point...)))), " "))
end
"""


def _julia(text: str, sequence: Sequence, points: list[Point], folder: Path, name: str) -> list[list[float]]:
    (folder / "f.jl").write_text(text, encoding="ascii")
    told = []
    for point in points:
        t, *rest = ([float(x) for x in point.get(group, [0.0])] for group in _groups(sequence))
        told.append(f"({t[0]!r}, {', '.join(f'Float64{values!r}' for values in rest)})")
    caller = (
        JULIA_CALLER.format(name=name, points=", ".join(told)).replace("inf", "Inf").replace("nan", "NaN")
    )
    (folder / "caller.jl").write_text(caller, encoding="ascii")
    assert JULIA is not None
    return _numbers(_done([JULIA, "--startup-file=no", "caller.jl"], folder))


# Numbers go in and out as bits; a matrix is flattened by its rows.
RUST_CALLER = """
mod made;

trait Flat {{ fn put(&self, line: &mut Vec<String>); }}
impl Flat for f64 {{
    fn put(&self, line: &mut Vec<String>) {{ line.push(format!("{{:016x}}", self.to_bits())); }}
}}
impl<T: Flat, const N: usize> Flat for [T; N] {{
    fn put(&self, line: &mut Vec<String>) {{ for x in self {{ x.put(line); }} }}
}}

fn main() {{
    for line in std::io::stdin().lines() {{
        let text = line.unwrap();
        let given: Vec<f64> = text.split_whitespace()
            .map(|word| f64::from_bits(u64::from_str_radix(word, 16).unwrap())).collect();
        let out = made::{name}(given[0]{slices});
        let mut line = Vec::new();
        {put}
        println!("{{}}", line.join(" "));
    }}
}}
"""


def _rust(text: str, sequence: Sequence, points: list[Point], folder: Path, name: str) -> list[list[float]]:
    (folder / "made.rs").write_text(text, encoding="ascii")
    slices, start = "", 1
    for group in _groups(sequence)[1:]:
        stop = start + max(len(points[0].get(group, ())), sequence.group_size(group))
        slices += f", given[{start}..{stop}].try_into().unwrap()"
        start = stop
    words = re.findall(r"^    pub (\w+): ", text, re.MULTILINE)
    put = " ".join(f"out.{word}.put(&mut line);" for word in words)
    caller = RUST_CALLER.format(name=name, slices=slices, put=put)
    (folder / "caller.rs").write_text(caller, encoding="ascii")
    assert RUSTC is not None
    _done(
        [RUSTC, "--edition", "2021", "-D", "warnings", "-A", "dead_code", "-O", "caller.rs", "-o", "caller"],
        folder,
    )
    lines = []
    for point in points:
        values = [x for group in _groups(sequence) for x in point.get(group, [0.0] if group == "t" else [])]
        lines.append(" ".join(struct.pack(">d", x).hex() for x in values))
    printed = _done([str(folder / "caller")], folder, "\n".join(lines))
    return [
        [struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()]
        for line in printed.splitlines()
    ]


NODE_CALLER = """
import {{ {name}, outputs }} from "./made.mjs";
import {{ readFileSync }} from "node:fs";
const kept = outputs();
const bits = new Float64Array(1), bytes = new BigUint64Array(bits.buffer);
const read = (word) => {{ bytes[0] = BigInt("0x" + word); return bits[0]; }};
const write = (x) => {{ bits[0] = x; return bytes[0].toString(16).padStart(16, "0"); }};
const flat = (made) => Object.values(made).flatMap((x) => (typeof x === "number" ? [x] : [...x]));
for (const line of readFileSync(0, "utf8").split("\\n").filter((text) => text)) {{
    const [t, ...groups] = line.split(";").map((part) => part.split(" ").filter((w) => w).map(read));
    const once = flat({name}(t[0], ...groups)).map(write).join(" ");
    {name}(t[0], ...groups, kept);
    if (flat(kept).map(write).join(" ") !== once) throw new Error("another result when filled again");
    console.log(once);
}}
"""


def _node(text: str, sequence: Sequence, points: list[Point], folder: Path, name: str) -> list[list[float]]:
    (folder / "made.mjs").write_text(text, encoding="ascii")
    (folder / "caller.mjs").write_text(NODE_CALLER.format(name=name), encoding="ascii")
    lines = []
    for point in points:
        groups = (point.get(group, [0.0] if group == "t" else []) for group in _groups(sequence))
        lines.append(";".join(" ".join(struct.pack(">d", x).hex() for x in values) for values in groups))
    assert NODE is not None
    printed = _done([NODE, "caller.mjs"], folder, "\n".join(lines))
    return [
        [struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()]
        for line in printed.splitlines()
    ]


PYTHON_CALLER = """
import json, sys
import numpy as np
from made import {name} as function
{prepare}
for line in sys.stdin:
    given = json.loads(line, parse_constant=float)
    made = function(*given)
    made = made if isinstance(made, (tuple, list)) else [made]
    print(" ".join(repr(float(x)) for each in made for x in np.asarray(each).ravel()))
"""


def _python(interpreter: str | None, prepare: str) -> Callable[..., list[list[float]]]:
    def runner(
        text: str, sequence: Sequence, points: list[Point], folder: Path, name: str
    ) -> list[list[float]]:
        (folder / "made.py").write_text(text, encoding="ascii")
        (folder / "caller.py").write_text(PYTHON_CALLER.format(name=name, prepare=prepare), encoding="ascii")
        lines = []
        for point in points:
            given = [point.get(group, [0.0] if group == "t" else []) for group in _groups(sequence)]
            lines.append(json.dumps([given[0][0], *given[1:]]))
        assert interpreter is not None
        path = f"import sys; sys.path.insert(0, {str(folder)!r}); import caller"
        return _numbers(_done([interpreter, "-I", "-c", path], folder, "\n".join(lines)))

    return runner


RUNNERS: dict[str, Callable[..., list[list[float]]]] = {
    "fortran": _fortran,
    "matlab": _octave,
    "julia": _julia,
    "rust": _rust,
    "javascript": _node,
    "jax": _python(JAX, "import jax\nfunction = jax.jit(function)"),
    "casadi": _python(CASADI, ""),
}
