"""One text of a kernel, the same bits in every language that runs here."""

from __future__ import annotations

import ctypes
import math
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import llvmlite.binding as llvm
import pytest

from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.dialect import KernelDialect
from symbody.codegen.kernels.fortran_kernels import FORTRAN
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.matlab_kernels import MATLAB
from symbody.codegen.kernels.python_kernels import PYTHON
from symbody.codegen.kernels.reader import read_text
from symbody.codegen.kernels.rust_kernels import RUST
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.llvm.machine import optimized_code, target_machine
from symbody.kernels.language import Reals
from tests.codegen.kernels.kernel_rules import rules
from tests.codegen.test_saddle_kernels import bits
from tests.codegen.tools import runnable

VALUES = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    3.0,
    1e150,
    -1e300,
    5e-324,
    2.2e-308,
    1e-310,
    math.inf,
    -math.inf,
    math.nan,
]
PAIRS = [(x, y) for x in VALUES for y in VALUES]
SIZE = 15
TREES = read_text(Path(__file__).with_name("kernel_rules.py").read_text(encoding="utf-8"), "kernel_rules.py")


def to_hex(x: float) -> str:
    return struct.pack(">d", x).hex()


def from_hex(word: str) -> float:
    number: float = struct.unpack(">d", bytes.fromhex(word))[0]
    return number


@dataclass(frozen=True, slots=True)
class Runner:
    """A language, the program around its kernels, and how it is run.

    The program reads lines of two doubles as 16 hexadecimal digits and prints the results in the same way.
    """

    dialect: KernelDialect
    program: str
    file: str
    commands: Callable[[Path], list[list[str]]]
    tool: str


C_MAIN = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
int main(void) {
    uint64_t a, b;
    while (scanf("%lx %lx", &a, &b) == 2) {
        double x[2], out[15];
        memcpy(x, &a, 8); memcpy(x + 1, &b, 8);
        symbody_rules(x, out);
        for (int k = 0; k < 15; k++) { memcpy(&a, out + k, 8); printf("%016lx ", a); }
        printf("\\n");
    }
    return 0;
}
"""
JS_MAIN = """
const read = (word) => Buffer.from(word, "hex").readDoubleBE(0);
const write = (x) => { const b = Buffer.alloc(8); b.writeDoubleBE(x); return b.toString("hex"); };
for (const line of require("fs").readFileSync(0, "utf8").trim().split("\\n")) {
    const given = Float64Array.from(line.split(" "), read), out = new Float64Array(15);
    symbody_rules(given, 0, out, 0);
    console.log(Array.from(out, write).join(" "));
}
"""
PYTHON_MAIN = """
import struct, sys
for line in sys.stdin:
    given = [struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()]
    out = [0.0] * 15
    symbody_rules(given, 0, out, 0)
    print(*(struct.pack(">d", value).hex() for value in out))
"""
RUST_MAIN = """
use std::cell::Cell;
fn main() {
    for line in std::io::read_to_string(std::io::stdin()).unwrap().lines() {
        let given: Vec<Cell<f64>> = line.split(' ')
            .map(|word| Cell::new(f64::from_bits(u64::from_str_radix(word, 16).unwrap()))).collect();
        let out: Vec<Cell<f64>> = vec![Cell::new(0.0); 15];
        symbody_rules(&given, &out);
        for x in &out { print!("{:016x} ", x.get().to_bits()); }
        println!();
    }
}
"""
FORTRAN_MAIN = """
end module
program main
    use kernels
    use, intrinsic :: iso_fortran_env, only: int64
    integer(int64) :: words(2)
    real(dp) :: x(2), out(15)
    integer :: status
    do
        read (*, '(Z16, 1X, Z16)', iostat=status) words
        if (status /= 0) exit
        x = transfer(words, x)
        call symbody_rules(x, out)
        write (*, '(15(Z16.16, 1X))') transfer(out, words, 15)
    end do
end program
"""
MATLAB_MAIN = """
line = fgetl(stdin);
while ischar(line)
    words = strsplit(strtrim(line), ' ');
    out = symbody_rules([hex2num(words{1}); hex2num(words{2})], zeros(15, 1));
    printf('%s ', cellstr(num2hex(out)){:}); printf('\\n');
    line = fgetl(stdin);
end
"""
FORTRAN_HEAD = """\
module kernels
use, intrinsic :: iso_c_binding, only: dp => c_double
use, intrinsic :: ieee_arithmetic
implicit none
contains
"""


def compiled(*command: str) -> Callable[[Path], list[list[str]]]:
    """Commands that compile a file into a program, and run this."""
    return lambda file: [[word.format(file) for word in command] + ["-o", f"{file}.out"], [f"{file}.out"]]


RUNNERS = {
    "c": Runner(C, PREAMBLE + "{}" + C_MAIN, "k.c",
                lambda f: [["gcc", "-std=c99", "-O2", str(f), "-o", f"{f}.out", "-lm"], [f"{f}.out"]], "gcc"),
    "javascript": Runner(JAVASCRIPT, "{}" + JS_MAIN, "k.js", lambda f: [["node", str(f)]], "node"),
    "python": Runner(PYTHON, "import math\n{}" + PYTHON_MAIN, "k.py", lambda f: [[sys.executable, str(f)]], "sh"),
    "rust": Runner(RUST, "{}" + RUST_MAIN, "k.rs", compiled("rustc", "-A", "warnings", "-O", "{}"), "rustc"),
    "fortran": Runner(FORTRAN, FORTRAN_HEAD + "{}" + FORTRAN_MAIN, "k.f90",
                      compiled("gfortran", "-O1", "-ffp-contract=off", "{}"), "gfortran"),
    "matlab": Runner(MATLAB, "1;\n{}" + MATLAB_MAIN, "k.m",
                     lambda f: [["octave-cli", "-q", "--no-gui", str(f)]], "octave-cli"),
}  # fmt: skip


def python_results() -> list[list[float]]:
    """What Python makes of the kernel file itself."""
    results = []
    for x, y in PAIRS:
        out = Reals.zeros(SIZE)
        rules(Reals([x, y]), out)
        results.append([out[k] for k in range(SIZE)])
    return results


@pytest.mark.parametrize("name", RUNNERS)
def test_every_rule_gives_the_bits_of_the_kernel_file(name: str, tmp_path: Path) -> None:
    runner = RUNNERS[name]
    if runnable(runner.tool) is None:
        pytest.skip(f"needs {runner.tool}")
    file = tmp_path / runner.file
    file.write_text(runner.program.replace("{}", kernel_text(TREES, runner.dialect), 1))
    given = "".join(f"{to_hex(x)} {to_hex(y)}\n" for x, y in PAIRS)
    for command in runner.commands(file):
        run = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
    results = [[from_hex(word) for word in line.split()] for line in run.stdout.splitlines()]
    expected = python_results()
    assert len(results) == len(expected)
    for pair, result, exact in zip(PAIRS, results, expected, strict=True):
        if name == "matlab":  # Octave drops the sign of zeros that pass through its functions
            result, exact = ([x + 0.0 for x in numbers] for numbers in (result, exact))
        assert bits(result) == bits(exact), pair


@pytest.mark.parametrize("width", [1, 2, 4])
def test_every_rule_gives_the_bits_of_the_kernel_file_as_machine_code(width: int) -> None:
    """In lanes all lanes hold the same numbers, so that none goes its own way."""
    code = optimized_code(llvm_text(TREES, ["rules"], width))
    name = kernel_name("rules", width)
    builder = llvm.JITLibraryBuilder().add_current_process().add_object_img(code).export_symbol(name)
    library = builder.link(llvm.create_lljit_compiler(target_machine()), f"rules_{width}")
    pointer = ctypes.POINTER(ctypes.c_double)
    call = ctypes.CFUNCTYPE(None, pointer, pointer, ctypes.c_void_p)(library[name])
    for pair, exact in zip(PAIRS, python_results(), strict=True):
        given = (ctypes.c_double * (2 * width))(*(x for x in pair for _ in range(width)))
        out, mixed = (ctypes.c_double * (SIZE * width))(), (ctypes.c_byte * 1)()
        call(given, out, ctypes.addressof(mixed))
        for lane in range(width):
            assert bits(list(out)[lane::width]) == bits(exact), (pair, lane)
        is_nan = math.isnan(pair[0]) or math.isnan(pair[1])
        assert is_nan or not mixed[0]
