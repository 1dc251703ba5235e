"""The compiled kernels give the bits of the reference; the C text holds under the sanitizers."""

from __future__ import annotations

import ctypes
import math
import shutil
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest
from llvmlite import ir

from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.llvm.loops import INTEGER, POINTER, REAL, Array, count, integer
from symbody.codegen.llvm.machine import optimized_code, target_machine
from symbody.codegen.llvm.runtime import address
from symbody.codegen.llvm.saddles import saddle_function
from symbody.expr.sequences.saddle import solve_saddle
from symbody.kernels.linear.solve_saddle import work_size
from tests.saddle_systems import systems

Arguments = tuple[list[float], list[float], list[float], list[float]]
Kernel = Callable[[Arguments], tuple[int, list[float]]]
COMPILER = shutil.which("gcc") or shutil.which("clang")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror"]
EXPORT_C = """
int kernel(int n, int m, const double *M, const double *J, const double *F, const double *gamma,
           double *result, double *work);
int kernel(int n, int m, const double *M, const double *J, const double *F, const double *gamma,
           double *result, double *work)
{
    return symbody_solve_saddle(n, m, M, J, F, gamma, result, work);
}
"""
# Reads systems, allocates exactly what the interface promises, writes status and results.
MAIN_C = r"""
#include <stdio.h>
#include <stdlib.h>
static double *read_doubles(size_t count)
{
    double *array = malloc(count * sizeof *array);
    for (size_t i = 0; i < count; i++)
        if (scanf("%lf", array + i) != 1) exit(2);
    return array;
}
int main(void)
{
    int n, m, size;
    while (scanf("%d %d %d", &n, &m, &size) == 3) {
        size_t N = (size_t)n, R = (size_t)m;
        double *M = read_doubles(N * N), *J = read_doubles(R * N);
        double *F = read_doubles(N), *gamma = read_doubles(R);
        double *result = malloc((N + R + 1) * sizeof *result), *work = malloc((size_t)size * sizeof *work);
        printf("%d", symbody_solve_saddle(n, m, M, J, F, gamma, result, work));
        for (size_t i = 0; i < N + R + 1; i++) printf(" %a", result[i]);
        printf("\n");
        free(M), free(J), free(F), free(gamma), free(result), free(work);
    }
    return 0;
}
"""


def edge_cases() -> list[Arguments]:
    """Systems without size, without solution, and with numbers at the ends of the range."""
    nan, inf, tiny, huge = math.nan, math.inf, 5e-324, 1e300
    unit = [1.0, 0.0, 0.0, 1.0]
    return [
        ([], [], [], []),
        ([], [], [], [1.0, 2.0]),
        (unit, [], [1.0, 2.0], []),
        ([0.0] * 4, [], [1.0, 2.0], []),
        ([0.0] * 4, [1.0, 1.0, 1.0, -1.0], [1.0, 2.0], [0.5, 0.25]),
        ([1.0, 1.0, 1.0, 1.0], [0.0, 0.0], [1.0, 2.0], [0.0]),
        ([1.0, 1.0, 1.0, 1.0], [1.0, -1.0], [1.0, 2.0], [0.0]),
        ([1.0, 0.0, 0.0, -1.0], [], [1.0, 1.0], []),
        (unit, [1.0, nan], [1.0, 1.0], [0.0]),
        (unit, [1.0, 1.0, inf, 1.0], [1.0, 1.0], [0.0, 0.0]),
        ([nan, 0.0, 0.0, 1.0], [1.0, 1.0], [1.0, 1.0], [0.0]),
        ([inf, 0.0, 0.0, 1.0], [1.0, 1.0], [1.0, 1.0], [0.0]),
        (unit, [1.0, 1.0], [nan, 1.0], [0.0]),
        (unit, [3.0, 4.0] * 4, [1.0, 1.0], [5.0] * 4),
        ([tiny, 0.0, 0.0, tiny], [tiny, 0.0], [tiny, tiny], [tiny]),
        ([huge, 0.0, 0.0, 1e-300], [1e-200, 1e200], [1.0, 1.0], [1.0]),
        ([1e-310, 0.0, 0.0, 1e-309], [1e-308, 2e-308], [1e-310, 1e-309], [1e-308]),
        ([1.7e308], [1.7e308], [1.0], [1.0]),
    ]


def random_cases(seed: int, number: int) -> list[Arguments]:
    """Solvable systems, every fifth of them robbed of its masses."""
    cases = [system.arguments for system in systems(seed, number)]
    return [([0.0] * len(c[0]), *c[1:]) if k % 5 == 4 else c for k, c in enumerate(cases)]


def bits(values: list[float]) -> list[bytes]:
    """Exact identity of doubles; every NaN is the same."""
    return [b"nan" if math.isnan(value) else struct.pack("<d", value) for value in values]


def reference(arguments: Arguments) -> tuple[int, list[float]]:
    solution = solve_saddle(*arguments)
    return int(not solution.ok), [*solution.udot, *solution.multipliers, float(solution.rank)]


def kernel_at(address: int, integer: type[ctypes.c_int] | type[ctypes.c_int64] = ctypes.c_int) -> Kernel:
    pointer = ctypes.POINTER(ctypes.c_double)
    call = ctypes.CFUNCTYPE(integer, integer, integer, *[pointer] * 6)(address)

    def kernel(arguments: Arguments) -> tuple[int, list[float]]:
        n, m = len(arguments[2]), len(arguments[3])
        given = [(ctypes.c_double * max(len(part), 1))(*part) for part in arguments]
        result = (ctypes.c_double * (n + m + 1))()
        work = (ctypes.c_double * max(work_size(n, m), 1))()
        return call(n, m, *given, result, work), list(result)

    return kernel


def compiled_module(module: ir.Module) -> llvm.ExecutionEngine:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=1)
    parsed = llvm.parse_assembly(str(module))
    parsed.verify()
    engine = llvm.create_mcjit_compiler(parsed, machine)
    engine.finalize_object()
    return engine


def kernel_library(width: int) -> llvm.ResourceTracker:
    """Machine code of `solve_saddle`, in lanes if the width is larger than 1."""
    code = optimized_code(llvm_text(read_kernels("solve_saddle"), ["solve_saddle"], width))
    builder = llvm.JITLibraryBuilder().add_current_process().add_object_img(code)
    builder.export_symbol(kernel_name("solve_saddle", width))
    return builder.link(llvm.create_lljit_compiler(target_machine()), f"test_{width}")


@pytest.fixture(scope="module")
def llvm_kernel() -> Iterator[Kernel]:
    library = kernel_library(1)
    yield kernel_at(library[kernel_name("solve_saddle")], ctypes.c_int64)
    del library


@pytest.fixture(scope="module", params=["-O0", "-O2", "-O3"])
def c_kernel(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Kernel:
    if COMPILER is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("saddle")
    source, library = folder / "kernel.c", folder / "kernel.so"
    source.write_text(PREAMBLE + saddle_text(C) + EXPORT_C)
    command = [COMPILER, *STRICT, request.param, "-shared", "-fPIC", str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True, capture_output=True)
    address = ctypes.cast(ctypes.CDLL(str(library)).kernel, ctypes.c_void_p).value
    assert address is not None
    return kernel_at(address)


def check_bits(kernel: Kernel, cases: list[Arguments]) -> None:
    for arguments in cases:
        status, result = kernel(arguments)
        expected_status, expected = reference(arguments)
        assert status == expected_status
        assert bits(result) == bits(expected)


def test_llvm_kernel_gives_the_bits_of_the_reference(llvm_kernel: Kernel) -> None:
    check_bits(llvm_kernel, edge_cases() + random_cases(1, 200))


def test_c_kernel_gives_the_bits_of_the_reference(c_kernel: Kernel) -> None:
    check_bits(c_kernel, edge_cases() + random_cases(2, 200))


def chosen_kernel(arguments: Arguments) -> tuple[int, list[float]]:
    """What compiled sequences call for a size: written out, for long loops, or for any size."""
    name = saddle_function(len(arguments[2]), len(arguments[3]))
    return kernel_at(address(name), ctypes.c_int64)(arguments)


@pytest.mark.exhaustive
def test_kernels_chosen_by_size_give_the_bits_of_the_reference() -> None:
    cases = edge_cases() + random_cases(6, 150)
    names = {saddle_function(len(F), len(gamma)) for _, _, F, gamma in cases}
    assert len(names) > 10 and {"symbody_solve_saddle", "symbody_solve_saddle_long"} < names
    check_bits(chosen_kernel, cases)


def test_rows_and_coordinates_in_any_order_of_pivots() -> None:
    """Rows that come in the order of their distance from each other, reversed, and mixed."""
    rng = np.random.default_rng(1)
    cases: list[Arguments] = []
    for _ in range(60):
        n, m = 5, int(rng.integers(0, 5))
        A = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-4, 4, n)
        J = rng.normal(size=(m, n)) * (rng.random((m, n)) < 0.6) + 1e-3 * rng.normal(size=n)
        parts = (A @ A.T, J, rng.normal(size=n), rng.normal(size=m))
        cases.append(tuple(part.ravel().tolist() for part in parts))
    check_bits(chosen_kernel, cases)


@pytest.mark.exhaustive
def test_kernels_chosen_by_size_on_two_thousand_systems() -> None:
    check_bits(chosen_kernel, random_cases(7, 2000))


@pytest.mark.exhaustive
def test_llvm_kernel_on_two_thousand_systems(llvm_kernel: Kernel) -> None:
    check_bits(llvm_kernel, random_cases(3, 2000))


@pytest.mark.exhaustive
def test_c_kernel_on_two_thousand_systems(c_kernel: Kernel) -> None:
    check_bits(c_kernel, random_cases(4, 2000))


def test_edge_cases_are_what_they_claim() -> None:
    outcomes = [reference(arguments) for arguments in edge_cases()]
    assert [status for status, _ in outcomes] == [0, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0]
    ranks = [int(result[-1]) for _, result in outcomes]
    assert ranks == [0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]


def test_c_text_under_sanitizers(tmp_path: Path) -> None:
    if COMPILER is None:
        pytest.skip("no C compiler")
    source, program = tmp_path / "main.c", tmp_path / "main"
    source.write_text(PREAMBLE + saddle_text(C) + MAIN_C)
    sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"]
    command = [COMPILER, *STRICT, *sanitizers, str(source), "-o", str(program), "-lm"]
    built = subprocess.run(command, capture_output=True, text=True)
    if "cannot find" in built.stderr:
        pytest.skip("no sanitizer libraries")
    assert built.returncode == 0, built.stderr
    cases = edge_cases() + random_cases(5, 100)
    lines = []
    for M, J, F, gamma in cases:
        n, m = len(F), len(gamma)
        numbers = [x.hex() if math.isfinite(x) else str(x) for x in [*M, *J, *F, *gamma]]
        lines.append(" ".join([str(n), str(m), str(work_size(n, m)), *numbers]))
    run = subprocess.run([str(program)], input="\n".join(lines), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    for arguments, line in zip(cases, run.stdout.splitlines(), strict=True):
        status, *result = line.split()
        expected_status, expected = reference(arguments)
        assert int(status) == expected_status
        assert bits([float.fromhex(value) for value in result]) == bits(expected)


def test_loops_count() -> None:
    """Reverses entries, and writes their numbers behind them."""
    module = ir.Module()
    module.triple = llvm.get_default_triple()
    function = ir.Function(module, ir.FunctionType(INTEGER, [INTEGER, POINTER, POINTER]), name="scan")
    b = ir.IRBuilder(function.append_basic_block())
    n, given, out = function.args[0], Array(b, function.args[1]), Array(b, function.args[2])
    with count(b, integer(0), n) as j:
        out.store(b.sub(b.sub(n, j), integer(1)), given.load(j))
    with count(b, integer(0), n) as j:
        out.offset_by(n).store(j, b.sitofp(j, REAL))
    b.ret(n)
    engine = compiled_module(module)
    pointer = ctypes.POINTER(ctypes.c_double)
    scan = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, pointer, pointer)(
        engine.get_function_address("scan")
    )
    given_c, out_c = (ctypes.c_double * 3)(1.0, 2.0, -5.0), (ctypes.c_double * 6)()
    assert scan(0, given_c, out_c) == 0 and list(out_c) == [0.0] * 6
    assert scan(3, given_c, out_c) == 3
    assert list(out_c) == [-5.0, 2.0, 1.0, 0.0, 1.0, 2.0]
    engine.close()


def test_work_size_leaves_no_room_for_doubt() -> None:
    assert [work_size(n, m) for n, m in [(0, 0), (1, 0), (0, 1), (3, 2)]] == [0, 7, 4, 41]
    assert np.all(np.diff([work_size(n, 5) for n in range(20)]) > 0)
