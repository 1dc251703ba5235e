"""C text compiled by gcc against plain evaluation and native code, and names that try to break it."""

from __future__ import annotations

import ctypes
import json
import math
import re
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest

from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.texts.c import generate
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import FLOATS, evaluate_sequence
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence
from tests.codegen.native import call, call_address
from tests.codegen.sequences import (
    EXACT,
    GROUPS,
    LIBRARY,
    TRIGONOMETRIC,
    Inputs,
    random_sequence,
    same_bits,
    single,
)
from tests.tiers import rows

GCC = shutil.which("gcc")
needs_gcc = pytest.mark.skipif(GCC is None, reason="needs gcc")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")
# gcc computes functions of constants itself, correctly rounded, which the C library does not promise.
PLAIN = ("-fno-builtin",)
ALL = (*EXACT, *LIBRARY, *TRIGONOMETRIC)


def gcc(*arguments: str) -> None:
    assert GCC is not None
    done = subprocess.run([GCC, *arguments, "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]


def load(text: str, folder: Path, *options: str) -> ctypes.CDLL:
    source = folder / "f.c"
    source.write_text(text, encoding="ascii")
    gcc(*(options or (*STRICT, *PLAIN)), "-shared", "-fPIC", "-o", str(folder / "f.so"), str(source))
    return ctypes.CDLL(str(folder / "f.so"))


def run(library: ctypes.CDLL, sequence: Sequence, inputs: Inputs, name: str = "f") -> tuple[int, list[float]]:
    address = ctypes.cast(library[name], ctypes.c_void_p).value
    assert address is not None
    return call_address(address, sequence, inputs, library[f"{name}_work_size"]())


def expected(sequence: Sequence, inputs: Inputs) -> list[float]:
    return [value for output in evaluate_sequence(sequence, inputs) for value in output]


@needs_gcc
@pytest.mark.parametrize(("seed", "piece_size"), rows([(0, 2000), (1, 40), (2, 150)], fast=[(1, 40)]))
def test_random_sequences_agree_to_the_last_bit(seed: int, piece_size: int, tmp_path: Path) -> None:
    """Without floor: plain evaluation loses the sign of -0 there."""
    codes = tuple(code for code in ALL if code != op.FLOOR)
    sequence, inputs = random_sequence(seed, 300, codes)
    status, ours = run(load(generate(sequence, piece_size=piece_size), tmp_path), sequence, inputs)
    assert status == 0
    assert same_bits(ours, expected(sequence, inputs))


@needs_gcc
@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(100, 150))
def test_many_random_sequences_agree(seed: int, tmp_path: Path) -> None:
    sequence, inputs = random_sequence(seed, 300, (*EXACT, *LIBRARY))
    status, ours = run(load(generate(sequence), tmp_path), sequence, inputs)
    theirs = call(compile_sequence(sequence), sequence, inputs)
    assert status == theirs[0] == 0
    assert same_bits(ours, theirs[1])


@needs_gcc
@pytest.mark.exhaustive
def test_a_long_sequence_compiles_and_agrees(tmp_path: Path) -> None:
    sequence, inputs = random_sequence(4, 50_000, (*EXACT, *LIBRARY))
    status, ours = run(load(generate(sequence), tmp_path), sequence, inputs)
    theirs = call(compile_sequence(sequence), sequence, inputs)
    assert status == theirs[0] == 0
    assert same_bits(ours, theirs[1])


@needs_gcc
def test_compilers_that_like_to_contract_do_not(tmp_path: Path) -> None:
    """gcc fuses products and sums by default outside its ISO modes."""
    sequence, inputs = random_sequence(5, 250, (op.ADD, op.SUB, op.MUL, op.MUL, op.FMA))
    text = generate(sequence)
    library = load(text, tmp_path, "-std=gnu11", "-O3", "-march=native", "-Wall", "-Wextra", "-Werror")
    status, ours = run(library, sequence, inputs)
    assert status == 0
    assert same_bits(ours, expected(sequence, inputs))


@needs_gcc
def test_sines_differ_from_native_code_by_roundings_only(tmp_path: Path) -> None:
    """Ours are within 1.5 ulp, those of the C library within 1."""
    size = GROUPS["p"]
    operations = [Operation(op.SYMBOL, (), k) for k in range(size)]
    operations += [Operation(code, (k,)) for code in TRIGONOMETRIC for k in range(size)]
    inputs = tuple(Input(f"p{k}", "p", k) for k in range(size))
    values = tuple(range(size, 3 * size))
    sequence = Sequence(inputs, (), (), (), tuple(operations), (Output("y", (2, size), values),))
    points = {"p": [0.1, -2.0, 3.1415926, 11.0, 1e4, -12345.678, 99999.9, 1e-5, 1e6]}
    _, ours = call(compile_sequence(sequence), sequence, points)
    _, theirs = run(load(generate(sequence), tmp_path), sequence, points)
    for a, b in zip(ours, theirs, strict=True):
        assert abs(a - b) <= 2.5 * math.ulp(b)


MAIN = """
#include <stdio.h>
{declarations}
int main(void)
{{
{arrays}
    static double out[{size} + 1], work[{work} + 1];
    int status = f(t, q, u, r, p, c, out, work);
    for (int k = 0; k < {size}; k++) printf("%a\\n", out[k]);
    return status;
}}
"""


@pytest.mark.exhaustive
@needs_gcc
@pytest.mark.parametrize("piece_size", [60, 2000])
def test_sanitizers_find_nothing(piece_size: int, tmp_path: Path) -> None:
    sequence, inputs = random_sequence(8, 300, tuple(code for code in ALL if code != op.FLOOR))
    assert sequence.kernels
    text = generate(sequence, piece_size=piece_size)
    arrays = "\n".join(
        f"    static const double {group}[] = {{{', '.join(x.hex() for x in values)}}};"
        for group, values in inputs.items()
    )
    declarations = "\n".join(
        line for line in text.splitlines() if line.startswith("int f(") and line.endswith(";")
    )
    work = re.search(r"#define f_WORK_SIZE (\d+)", text)
    assert work
    main = MAIN.format(declarations=declarations, arrays=arrays, size=sequence.output_size, work=work[1])
    (tmp_path / "f.c").write_text(text, encoding="ascii")
    (tmp_path / "main.c").write_text(main, encoding="ascii")
    program = tmp_path / "program"
    sanitize = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
    gcc(*STRICT, *PLAIN, *sanitize, "-o", str(program), str(tmp_path / "f.c"), str(tmp_path / "main.c"))
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert same_bits([float.fromhex(line) for line in done.stdout.split()], expected(sequence, inputs))


SPECIAL = (0.0, -0.0, 2.5, -2.5, 1e300, math.inf, -math.inf, math.nan)


@needs_gcc
def test_special_numbers_are_treated_as_in_native_code(tmp_path: Path) -> None:
    """Every operation of two numbers at once."""
    codes = (op.ADD, op.SUB, op.MUL, op.DIV, op.ATAN2, op.MIN, op.MAX, op.POW)
    singles = (op.NEG, op.SQRT, op.ABS, op.SIGN, op.FLOOR, op.LOG, op.EXP, op.TANH)
    operations = [Operation(op.SYMBOL, (), 0), Operation(op.SYMBOL, (), 1)]
    operations += [Operation(code, (0, 1)) for code in codes] + [Operation(code, (0,)) for code in singles]
    for code in (op.LT, op.LE, op.EQ):
        operations.append(Operation(code, (0, 1)))
        operations.append(Operation(op.NOT, (len(operations) - 1,)))
        operations.append(Operation(op.SELECT, (len(operations) - 1, 0, 1)))
    values = tuple(k for k, operation in enumerate(operations) if operation.op not in op.CONDITIONS)
    inputs = (Input("x", "q", 0), Input("y", "q", 1))
    sequence = Sequence(inputs, (), (), (), tuple(operations), (Output("y", (len(values),), values),))
    library, function = load(generate(sequence), tmp_path), compile_sequence(sequence)
    for x in SPECIAL:
        for y in SPECIAL:
            point = {"q": [x, y]}
            assert same_bits(run(library, sequence, point)[1], call(function, sequence, point)[1]), (x, y)


@needs_gcc
def test_a_kernel_that_fails_is_told(tmp_path: Path) -> None:
    operations = [Operation(op.SYMBOL, (), k) for k in range(2)]
    for k in range(2):
        operations.append(Operation(op.SADDLE, (k, 0), k))
        operations.append(Operation(op.PICK, (len(operations) - 1,), 0))
    inputs = (Input("m1", "q", 0), Input("m2", "q", 1))
    output = Output("udot", (2,), (3, 5))
    sequence = Sequence(inputs, (), (KernelNode(1, 0),) * 2, (), tuple(operations), (output,))
    for size in (1, 2000):
        folder = tmp_path / str(size)
        folder.mkdir()
        library = load(generate(sequence, piece_size=size), folder)
        assert run(library, sequence, {"q": [2.0, 4.0]}) == (0, [1.0, 0.5])
        status, values = run(library, sequence, {"q": [2.0, -4.0]})
        assert status == 2
        assert same_bits(values, [1.0, math.nan])
        assert run(library, sequence, {"q": [-2.0, -4.0]})[0] == 1


HOSTILE = (
    "lambda", "double", "register", "main", "sin", "z1", "z12_3", "q1'", "x_{1}", "a b", "a_b", "A_B", "I",
    "*/ int main(void) { return 1; } /*", "end \\", "line\nbreak", '"; #error', "??/", "// x", "f", "S",
    "f_WORK_SIZE", "M_PI", "NAN", "work", "t", "status", "symbody_solve_saddle", "__func__", "_", "1", "E",
    "\U0001f600", "name\u202eeman", "x" * 128, "θ", "theta", "linux",
)  # fmt: skip


def named(names: tuple[str, ...]) -> Sequence:
    """The sine of every input, and the first input."""
    operations = [Operation(op.SYMBOL, (), k) for k in range(len(names))]
    sines = []
    for k in range(len(names)):
        operations.append(Operation(op.SIN, (k,)))
        sines.append(len(operations) - 1)
    inputs = tuple(Input(name, "p", k) for k, name in enumerate(names))
    outputs = (Output(names[0], (len(names),), tuple(sines)), Output("*/", (), (0,)))
    return Sequence(inputs, (), (), (), tuple(operations), outputs)


@needs_gcc
@pytest.mark.parametrize("name", ["f", "sin_table"])
def test_no_name_breaks_the_text(name: str, tmp_path: Path) -> None:
    sequence = named(HOSTILE)
    text = generate(sequence, name)
    library = load(text, tmp_path)
    points = {"p": [0.1 * k for k in range(len(HOSTILE))]}
    assert run(library, sequence, points, name) == (0, [*(math.sin(x) for x in points["p"]), 0.0])


def test_the_table_of_names_can_be_read_back() -> None:
    text = generate(named(HOSTILE))
    rows = re.findall(r'^ \*   p\[(\d+)\]  (\w+)  (".*")$', text, flags=re.MULTILINE)
    assert [json.loads(row[2]) for row in rows] == list(HOSTILE)
    words = [row[1] for row in rows]
    assert len({word.lower() for word in words}) == len(HOSTILE)
    for k, word in enumerate(words):
        assert f"const double {word} = p[{k}];" in text


def test_names_can_be_replaced() -> None:
    text = generate(named(("a", "b")), names={"a": "length of the rod"})
    assert 'length_of_the_rod  "length of the rod"' in text
    assert "const double b = p[1];" in text


def test_the_same_text_every_time() -> None:
    sequence, _ = random_sequence(3, 300, ALL)
    assert generate(sequence) == generate(sequence)
    assert generate(sequence).isascii()


def test_the_text_of_a_small_sequence() -> None:
    operations = (
        Operation(op.SYMBOL, (), 0),
        Operation(op.SYMBOL, (), 1),
        Operation(op.RATIONAL, (), 0),
        Operation(op.SIN, (0,)),
        Operation(op.MUL, (1, 3)),
        Operation(op.MUL, (2, 4)),
    )
    inputs = (Input("theta", "q", 0), Input("mass", "p", 3))
    sequence = Sequence(inputs, (Fraction(-1, 2),), (), (), operations, (Output("torque", (), (5,)),))
    body = generate(sequence, "torque_of").split("int torque_of(")[-1].splitlines()[1:]
    assert body == [
        "{",
        "    const double theta = q[0];",
        "    const double z3 = sin(theta);",
        "    const double mass = p[3];",
        "    const double z4 = mass * z3;",
        "    const double z5 = (-0.5) * z4;",
        "    out[0] = z5;",
        "    (void)t;",
        "    (void)u;",
        "    (void)r;",
        "    (void)c;",
        "    (void)work;",
        "    return 0;",
        "}",
    ]


def test_the_kernel_comes_only_where_it_is_called() -> None:
    assert "saddle" not in generate(single(op.ADD, 2))
    sequence, _ = random_sequence(1, 200, (op.SADDLE,))
    assert generate(sequence).count("static int symbody_solve_saddle(") == 1


def test_values_no_output_needs_are_left_out() -> None:
    operations = (Operation(op.SYMBOL, (), 0), Operation(op.EXP, (0,)), Operation(op.LOG, (0,)))
    sequence = Sequence((Input("x", "q", 0),), (), (), (), operations, (Output("y", (), (2,)),))
    assert "exp(" not in generate(sequence)


@pytest.mark.parametrize("name", ["", "1f", "int", "a b", "work", "x" * 42, "f;", "z1", "_f"])
def test_functions_need_a_c_name(name: str) -> None:
    with pytest.raises(CompileError, match="cannot be the name") as caught:
        generate(single(op.ADD, 2), name)
    assert caught.value.problems[0].code == "compile.name"


@needs_gcc
def test_nothing_to_compute(tmp_path: Path) -> None:
    sequence = Sequence((), (), (), (), (), ())
    assert run(load(generate(sequence), tmp_path), sequence, {}) == (0, [])


def test_plain_evaluation_is_the_reference_of_all_operations() -> None:
    """Every operation but leaves, kernels and user functions occurs in the random sequences."""
    drawn = set(ALL) | op.CONDITIONS
    assert drawn >= set(FLOATS.functions) | {op.POW, op.SADDLE}
