"""Native code against plain evaluation, bit for bit."""

from __future__ import annotations

import math
import random
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import pytest

from symbody.codegen.llvm import native
from symbody.codegen.llvm.native import NativeFunction, compile_sequence
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import FLOATS, Arithmetic, evaluate_sequence
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence
from tests.codegen.native import BATCH, GROUPS, call, doubles, pieces_of
from tests.codegen.sequences import (
    EXACT,
    LIBRARY,
    MECHANICAL,
    TRIGONOMETRIC,
    Inputs,
    random_sequence,
    same_bits,
    single,
)
from tests.tiers import cases

ALL = (*EXACT, *LIBRARY, *TRIGONOMETRIC)

# Every special case of IEEE 754, and ordinary numbers.
NUMBERS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.5,
    3.0,
    1e-310,
    5e-324,
    1e200,
    -1.7e308,
    math.inf,
    -math.inf,
    math.nan,
)


def apply(function: NativeFunction, sequence: Sequence, *arguments: float) -> float:
    status, (value,) = call(function, sequence, {"q": arguments})
    assert status == 0
    return value


def unary(code: int) -> Callable[[float], float]:
    sequence = single(code, 1)
    function = compile_sequence(sequence)
    return lambda x: apply(function, sequence, x)


@pytest.fixture(scope="module")
def arithmetic() -> Arithmetic:
    """Plain evaluation with our own sine and cosine, tested in test_llvm_trig, and floor keeping -0."""
    ours = {op.SIN: unary(op.SIN), op.COS: unary(op.COS), op.FLOOR: lambda x: math.copysign(floor(x), x)}
    return replace(FLOATS, functions=FLOATS.functions | ours)


def floor(x: float) -> float:
    return FLOATS.functions[op.FLOOR](x)


def check(sequence: Sequence, inputs: Inputs, arithmetic: Arithmetic, piece_size: int) -> None:
    function = compile_sequence(sequence, piece_size=piece_size)
    status, ours = call(function, sequence, inputs)
    assert status == 0
    theirs = [value for output in evaluate_sequence(sequence, inputs, arithmetic) for value in output]
    assert same_bits(ours, theirs)


@pytest.mark.parametrize("seed", range(12))
def test_random_sequences_agree_to_the_last_bit(seed: int, arithmetic: Arithmetic) -> None:
    sequence, inputs = random_sequence(seed, 300, ALL)
    assert pieces_of(sequence, 2000) == 1
    check(sequence, inputs, arithmetic, 2000)


@pytest.mark.parametrize("seed", cases(range(12), fast=range(3)))
def test_cutting_does_not_change_a_bit(seed: int, arithmetic: Arithmetic) -> None:
    sequence, inputs = random_sequence(seed, 300, ALL)
    assert pieces_of(sequence, 17) > 8
    check(sequence, inputs, arithmetic, 17)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(100, 500))
def test_many_random_sequences_agree(seed: int, arithmetic: Arithmetic) -> None:
    sequence, inputs = random_sequence(seed, 300, ALL)
    check(sequence, inputs, arithmetic, random.Random(seed).choice((5, 40, 2000)))


@pytest.mark.exhaustive
@pytest.mark.parametrize("codes", [(*EXACT, *LIBRARY), (*MECHANICAL, *TRIGONOMETRIC)])
def test_long_sequences_agree(codes: tuple[int, ...], arithmetic: Arithmetic) -> None:
    """60,000 operations: several modules, compiled at once.

    Not all codes together: sequences are made with the sines of Python, and ranks and comparisons turn a
    last bit into another sequence of events after so many operations.
    """
    sequence, inputs = random_sequence(1, 60_000, codes)
    check(sequence, inputs, arithmetic, 2000)


def test_modules_compiled_at_once_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    sequence, inputs = random_sequence(7, 3000, ALL)
    alone = call(compile_sequence(sequence, piece_size=50), sequence, inputs)
    monkeypatch.setattr(native, "PARALLEL_ABOVE", 100)
    function = compile_sequence(sequence, piece_size=50, keep_ir=True)
    assert function.ir.count("declare i32 @symbody_f_1(") == 1  # the entry is in a module of its own
    together = call(function, sequence, inputs)
    assert together[0] == alone[0] == 0
    assert same_bits(together[1], alone[1])


UNARY = sorted((op.UNARY_FUNCTIONS - {op.SIGN, op.SIN, op.COS}) | {op.NEG})


@pytest.mark.parametrize("code", UNARY, ids=[op.NAMES[code] for code in UNARY])
def test_functions_of_special_numbers(code: int, arithmetic: Arithmetic) -> None:
    function = unary(code)
    for x in NUMBERS:
        assert same_bits([function(x)], [arithmetic.functions[code](x)]), x


BINARY = (op.ADD, op.SUB, op.MUL, op.DIV, op.ATAN2, op.MIN, op.MAX)


@pytest.mark.parametrize("code", BINARY, ids=[op.NAMES[code] for code in BINARY])
def test_operations_on_special_numbers(code: int) -> None:
    sequence = single(code, 2)
    function = compile_sequence(sequence)
    for x in NUMBERS:
        for y in NUMBERS:
            assert same_bits([apply(function, sequence, x, y)], [FLOATS.functions[code](x, y)]), (x, y)


def test_sign() -> None:
    sign = unary(op.SIGN)
    expected = [0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, -1.0, math.nan]
    assert same_bits([sign(x) for x in NUMBERS], expected)


def test_smaller_and_larger_of_no_number() -> None:
    """What is no number stays so, whichever operand it is."""
    smaller, larger = single(op.MIN, 2), single(op.MAX, 2)
    for sequence in (smaller, larger):
        function = compile_sequence(sequence)
        assert math.isnan(apply(function, sequence, math.nan, 1.0))
        assert math.isnan(apply(function, sequence, 1.0, math.nan))


def test_products_and_sums_are_not_contracted_unless_asked() -> None:
    # (1 + e)(1 - e) = 1 - e**2 rounds to 1, so the sum is 0; fused it is -e**2.
    e = 2.0**-30
    symbols = tuple(Operation(op.SYMBOL, (), k) for k in range(3))
    inputs = tuple(Input(f"x{k}", "q", k) for k in range(3))
    plain = (*symbols, Operation(op.MUL, (0, 1)), Operation(op.ADD, (3, 2)))
    for operations, expected in ((plain, 0.0), ((*symbols, Operation(op.FMA, (0, 1, 2))), -(e**2))):
        outputs = (Output("y", (), (len(operations) - 1,)),)
        sequence = Sequence(inputs, (), (), (), operations, outputs)
        assert apply(compile_sequence(sequence), sequence, 1 + e, 1 - e, -1.0) == expected


@pytest.mark.parametrize("exponent", [1, 2, 3, 7, 13, 64, 1000])
def test_whole_powers_square_from_the_lowest_bit_up(exponent: int) -> None:
    sequence = single(op.POW, 1, exponent)
    x = 1.0123456789
    (expected,) = evaluate_sequence(sequence, {"q": [x]})[0]
    assert apply(compile_sequence(sequence), sequence, x) == expected


@pytest.mark.parametrize("exponent", [0.5, 2.0, Fraction(1, 3), -1, 0])
def test_other_powers_are_those_of_the_library(exponent: float | Fraction) -> None:
    sequence = single(op.POW, 1, exponent)
    assert apply(compile_sequence(sequence), sequence, 1.7) == math.pow(1.7, exponent)


CONSTANTS = (
    Fraction(1, 3),
    Fraction(1, 10),
    2**60 + 1,
    -(10**300),
    Fraction(1, 10**320),
    0.1,
    -0.0,
    1.7e308,
    Fraction(10**400, 10**399 + 1),
)


def test_constants_are_rounded_correctly() -> None:
    operations = [
        Operation(op.FLOAT if isinstance(value, float) else op.RATIONAL, (), k)
        for k, value in enumerate(CONSTANTS)
    ]
    operations.append(Operation(op.PI, ()))
    output = Output("y", (len(operations),), tuple(range(len(operations))))
    sequence = Sequence((), CONSTANTS, (), (), tuple(operations), (output,))
    status, values = call(compile_sequence(sequence), sequence, {})
    assert status == 0
    assert same_bits(values, [*(float(value) for value in CONSTANTS), math.pi])


def test_too_large_a_constant_is_refused() -> None:
    with pytest.raises(CompileError, match="401 digits is too large") as caught:
        compile_sequence(single(op.ADD, 1, 10**400))
    assert caught.value.problems[0].code == "compile.large_constant"


class Table:
    name = "tyre table"

    def __call__(self, *arguments: float) -> float:
        return arguments[0]

    def derivative(self, position: int) -> Table:
        return self


def test_functions_of_the_user_are_refused_by_name() -> None:
    operations = (Operation(op.SYMBOL, ()), Operation(op.CALL, (0,)))
    sequence = Sequence((Input("x", "q", 0),), (), (), (Table(),), operations, (Output("y", (), (1,)),))
    with pytest.raises(CompileError, match="cannot call tyre table") as caught:
        compile_sequence(sequence)
    assert caught.value.problems[0].code == "compile.user_function"


def test_nothing_to_compute() -> None:
    sequence = Sequence((), (), (), (), (), ())
    function = compile_sequence(sequence)
    assert function.work_size == 0
    assert call(function, sequence, {}) == (0, [])


def test_unread_groups_may_be_null_and_gaps_are_skipped() -> None:
    operations = (Operation(op.SYMBOL, (), 0),)
    sequence = Sequence((Input("x", "p", 5),), (), (), (), operations, (Output("y", (2,), (0, 0)),))
    assert call(compile_sequence(sequence), sequence, {"p": [0, 0, 0, 0, 0, 2.5]}) == (0, [2.5, 2.5])


def kernels(count: int) -> Sequence:
    """``m udot = F`` with m = q[k], F = u[k], one kernel each; a mass <= 0 makes it fail."""
    inputs = tuple(Input(f"{group}{k}", group, k) for k in range(count) for group in "qu")
    operations = [Operation(op.SYMBOL, (), k) for k in range(2 * count)]
    picks = []
    for k in range(count):
        operations.append(Operation(op.SADDLE, (2 * k, 2 * k + 1), k))
        operations.append(Operation(op.PICK, (len(operations) - 1,), 0))
        picks.append(len(operations) - 1)
    outputs = (Output("udot", (count,), tuple(picks)),)
    return Sequence(inputs, (), (KernelNode(1, 0),) * count, (), tuple(operations), outputs)


@pytest.mark.parametrize("piece_size", [1, 2000])
def test_the_first_kernel_that_fails_is_told(piece_size: int) -> None:
    sequence = kernels(3)
    function = compile_sequence(sequence, piece_size=piece_size)
    forces = [8.0, 8.0, 8.0]
    for masses, expected in (
        ([2.0, 4.0, 1.0], 0),
        ([2.0, -4.0, 1.0], 2),
        ([2.0, 4.0, math.nan], 3),
        ([0.0, -4.0, 1.0], 1),
    ):
        status, values = call(function, sequence, {"q": masses, "u": forces})
        assert status == expected
        good = [8.0 / m if m > 0 else math.nan for m in masses]
        assert same_bits(values, good)


def diagonal(sizes: tuple[int, ...]) -> Sequence:
    """``M udot = F`` with a diagonal M = diag(q) and F = u for each size, one kernel after the other."""
    count = max(sizes)
    inputs = tuple(Input(f"{group}{k}", group, k) for k in range(count) for group in "qu")
    operations = [*(Operation(op.SYMBOL, (), k) for k in range(2 * count)), Operation(op.RATIONAL, (), 0)]
    zero = len(operations) - 1
    picks = []
    for kernel, n in enumerate(sizes):
        M = [2 * i if i == j else zero for i in range(n) for j in range(n)]
        operations.append(Operation(op.SADDLE, (*M, *(2 * i + 1 for i in range(n))), kernel))
        solution = len(operations) - 1
        for i in range(n):
            operations.append(Operation(op.PICK, (solution,), i))
            picks.append(len(operations) - 1)
    kernels = tuple(KernelNode(n, 0) for n in sizes)
    return Sequence(
        inputs, (0,), kernels, (), tuple(operations), (Output("udot", (len(picks),), tuple(picks)),)
    )


def test_zeros_of_a_large_matrix_are_cleared_at_once() -> None:
    sequence = diagonal((7, 1, 5))
    function = compile_sequence(sequence, keep_ir=True)
    masses, forces = [float(2**k) for k in range(7)], [float(3 * k + 1) for k in range(7)]
    wanted = [forces[k] / masses[k] for n in (7, 1, 5) for k in range(n)]  # exact: masses are powers of two
    # what the kernel before left in the same places has to go
    assert call(function, sequence, {"q": masses, "u": forces}) == (0, wanted)
    assert function.ir.count("call void @llvm.memset") == 2
    assert "store double 0x0000000000000000" not in function.ir


def run_batch(
    function: NativeFunction,
    sequence: Sequence,
    count: int,
    arrays: dict[str, tuple[list[float], int]],
    stride: int,
) -> tuple[int, list[float]]:
    held = {group: doubles(values) for group, (values, _) in arrays.items()}
    arguments: list[object] = []
    for group in GROUPS:
        arguments += [held.get(group), arrays[group][1] if group in arrays else 0]
    out = doubles([-7.0] * max(1, stride * count))
    work = doubles([0.0] * function.work_size)
    return BATCH(function.batch_address)(count, *arguments, out, stride, work), list(out)


def test_batches_stride_share_and_leave_gaps() -> None:
    sequence, inputs = random_sequence(3, 200, ALL)
    function = compile_sequence(sequence, piece_size=50)
    source = random.Random(1)
    points = [inputs | {"q": [x + source.uniform(-0.1, 0.1) for x in inputs["q"]]} for _ in range(5)]
    arrays = {group: (values, 0) for group, values in inputs.items()}
    size = len(inputs["q"])
    arrays["q"] = ([x for point in points for x in (*point["q"], 99.0)], size + 1)
    stride = sequence.output_size + 2
    status, values = run_batch(function, sequence, 5, arrays, stride)
    assert status == 0
    for k, point in enumerate(points):
        row = values[k * stride : (k + 1) * stride]
        assert same_bits(row[:-2], call(function, sequence, point)[1])
        assert row[-2:] == [-7.0, -7.0]


def test_a_batch_returns_the_first_failure_and_computes_the_rest() -> None:
    sequence = kernels(2)
    function = compile_sequence(sequence)
    masses = [1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 2.0, 4.0]
    status, values = run_batch(function, sequence, 4, {"q": (masses, 2), "u": ([8.0, 8.0], 0)}, 2)
    assert status == 2
    assert same_bits(values, [8.0, 8.0, 8.0, math.nan, math.nan, 8.0, 4.0, 2.0])


@pytest.mark.parametrize("count", [0, -3])
def test_an_empty_batch_touches_nothing(count: int) -> None:
    function = compile_sequence(kernels(1))
    assert BATCH(function.batch_address)(count, *[None, 0] * 7, None) == 0


def test_threads_share_a_function() -> None:
    sequence, inputs = random_sequence(11, 600, ALL)
    function = compile_sequence(sequence, piece_size=100)
    points = [inputs | {"p": [x * (1 + 0.01 * k) for x in inputs["p"]]} for k in range(40)]
    expected = [call(function, sequence, point) for point in points]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            found = list(pool.map(lambda point: call(function, sequence, point), points))
            assert all(a[0] == b[0] and same_bits(a[1], b[1]) for a, b in zip(found, expected, strict=True))


def test_compiling_in_threads() -> None:
    sequences = [random_sequence(seed, 200, ALL) for seed in range(4)]
    with ThreadPoolExecutor(4) as pool:
        functions = list(pool.map(lambda pair: compile_sequence(pair[0]), sequences))
    for function, (sequence, inputs) in zip(functions, sequences, strict=True):
        again = compile_sequence(sequence)
        assert same_bits(call(function, sequence, inputs)[1], call(again, sequence, inputs)[1])


def test_functions_outlive_each_other() -> None:
    first, second = single(op.ADD, 2), single(op.MUL, 2)
    functions = [compile_sequence(first), compile_sequence(second)]
    assert functions[0].address != functions[1].address
    assert apply(functions[1], second, 3.0, 4.0) == 12.0
    del functions[1]
    assert apply(functions[0], first, 3.0, 4.0) == 7.0


def test_what_a_function_tells_of_itself() -> None:
    sequence, _ = random_sequence(5, 300, ALL)
    function = compile_sequence(sequence, piece_size=40, keep_ir=True)
    assert function.operations == sequence.operation_count
    assert function.work_size > 0
    assert "define i32 @symbody_f(" in function.ir
    assert "fast" not in function.ir
    assert compile_sequence(sequence).ir == ""
    assert compile_sequence(sequence, piece_size=40, keep_ir=True).ir == function.ir


def test_a_missing_compiler_is_told_with_its_cure() -> None:
    program = (
        "import sys; sys.modules['llvmlite'] = None\n"
        "from symbody.errors import EnvironmentFault\n"
        "try:\n    import symbody.codegen.llvm.native\n"
        "except EnvironmentFault as fault:\n    print(fault, fault.exit_code)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "[environment.llvmlite]" in done.stdout
    assert "pip install" in done.stdout
    assert done.stdout.rstrip().endswith("5")
