"""The kernel `solve_saddle` as machine code: for any size, for long loops, for one size, and in lanes.

For a small size the kernel is written out, without loops and scratch; where rows of J depend on others it
hands over to the one for any size. All give the same bits.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from llvmlite import ir

from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.unrolling import unroll_kernel
from symbody.codegen.llvm.loops import INTEGER, POINTER, Array, count, integer
from symbody.codegen.llvm.machine import lanes, light_code, optimized_code

KERNEL: Final = "solve_saddle"
SADDLE: Final = kernel_name(KERNEL)
LANE_SADDLES: Final = "symbody_solve_saddles"  # as many systems as there are lanes
_LONG: Final = "_long"
_IN_LANES: Final = kernel_name("", 2).removeprefix(kernel_name(""))

# n (n + m)^2 up to which a kernel is written out, for a half to a quarter of the time of loops. Larger ones
# take more than 0.3 s to compile, and more room than the processor keeps for instructions.
_MOST_WORK: Final = 1000
# Coordinates from which loops compute several entries at once; that takes 0.7 s to compile, saves 20 to 40 %.
_LONG_FROM: Final = 12


def saddle_function(n: int, m: int, width: int = 1) -> str:
    """Return the name of the function that solves systems of this size, in lanes or not."""
    name = LANE_SADDLES if width > 1 else SADDLE
    if n >= 1 and m <= n and n * (n + m) ** 2 <= _MOST_WORK:
        return f"{name}_{n}_{m}"
    return name + _LONG if width == 1 and n >= _LONG_FROM else name


def saddle_text(name: str) -> tuple[str, Callable[[str], bytes]]:
    """Return the LLVM text of one of these functions, and what makes object code of it."""
    known = re.fullmatch(rf"({SADDLE}|{LANE_SADDLES})_(\d+)_(\d+)({_IN_LANES})?", name)
    if known and known[1] == SADDLE:
        return _text_of_size(int(known[2]), int(known[3]), lanes() if known[4] else 1), light_code
    if name.startswith(LANE_SADDLES):
        return _lanes_text(name, name.replace(LANE_SADDLES, SADDLE)), light_code
    width = lanes() if name.endswith(_IN_LANES) else 1
    text = llvm_text(read_kernels(KERNEL), [KERNEL], width)
    if not name.endswith(_LONG):
        return text, light_code
    return text.replace(f"@{SADDLE}(", f"@{name}("), lambda text: optimized_code(text, vectors=True)


def _text_of_size(n: int, m: int, width: int) -> str:
    """Return ``long name(long n, long m, M, J, F, gamma, result, work)`` for one n and m."""
    inner = f"{KERNEL}_{n}_{m}"
    kernels = read_kernels(KERNEL, "solve_independent")
    tree = unroll_kernel(kernels, "solve_independent", {"n": n, "m": m}, "work", f"independent_{n}_{m}")
    flag = "" if width == 1 else ", ptr %mixed"
    arrays = ", ".join(f"ptr noalias %{name}" for name in ("M", "J", "F", "gamma", "result"))
    given = arrays.replace(" noalias", "")
    sizes, other = "i64 %n, i64 %m", kernel_name(KERNEL, width)
    return "\n".join([
        llvm_text({tree.name: tree}, [], width),
        f"declare i64 @{other}(i64, i64, {', '.join(['ptr'] * (6 if width == 1 else 7))})",
        f"define i64 @{kernel_name(inner, width)}({sizes}, {arrays}, ptr noalias %work{flag}) {{",
        f"  %status = call i64 @{kernel_name(tree.name, width)}({given}{flag})",
        "  %depends = icmp eq i64 %status, 2",
        "  br i1 %depends, label %any, label %done",
        "any:",
        f"  %other = call i64 @{other}({sizes}, {given}, ptr %work{flag})",
        "  ret i64 %other",
        "done:",
        "  ret i64 %status",
        "}",
        "",
    ])  # fmt: skip


def _lanes_text(name: str, alone: str) -> str:
    """Return ``long name(long n, long m, const double *arguments, double *results, double *work)``.

    All lanes at once if their pivots are the same; if not, the scalar kernel `alone`, lane after lane.
    `arguments` are M, J, F and gamma in lanes. It returns 0, or 1 if any lane has no solution. `work` holds
    the scratch of the kernel in lanes, or, for one lane, the arguments, the results and the scratch of the
    kernel.
    """
    module = ir.Module("symbody_saddles")
    signature = ir.FunctionType(INTEGER, [INTEGER, INTEGER, POINTER, POINTER, POINTER])
    function = ir.Function(module, signature, name=name)
    b = ir.IRBuilder(function.append_basic_block("entry"))
    n, m = function.args[:2]
    given, results, work = (Array(b, place) for place in function.args[2:])
    sizes = [b.mul(n, n), b.mul(m, n), n, m]
    places = [work]
    for size in sizes:
        places.append(places[-1].offset_by(size))
    solution = places.pop()
    solved = b.add(b.add(n, m), integer(1))
    scratch = solution.offset_by(solved)
    total = b.add(b.add(sizes[0], sizes[1]), b.add(n, m))
    width, failed, mixed = integer(lanes()), b.alloca(INTEGER), b.alloca(ir.IntType(8))
    together = [given]
    for size in sizes[:-1]:
        together.append(together[-1].offset_by(b.mul(size, width)))
    pointers = [array.pointer for array in (*together, results, work)]
    b.store(ir.Constant(ir.IntType(8), 0), mixed)
    status = b.call(_kernel(module, alone + _IN_LANES, 7), [n, m, *pointers, mixed])
    is_mixed = b.icmp_unsigned("!=", b.load(mixed, typ=ir.IntType(8)), ir.Constant(ir.IntType(8), 0))
    with b.if_then(b.not_(b.or_(is_mixed, b.icmp_unsigned("!=", status, integer(0))))):
        b.ret(integer(0))
    b.store(integer(0), failed)
    with count(b, integer(0), width) as lane:
        with count(b, integer(0), total) as k:
            work.store(k, given.load(b.add(b.mul(k, width), lane)))
        pointers = [array.pointer for array in (*places, solution, scratch)]
        status = b.call(_kernel(module, alone, 6), [n, m, *pointers])
        b.store(b.or_(b.load(failed, typ=INTEGER), status), failed)
        with count(b, integer(0), solved) as k:
            results.store(b.add(b.mul(k, width), lane), solution.load(k))
    b.ret(b.load(failed, typ=INTEGER))
    return str(module)


def _kernel(module: ir.Module, name: str, pointers: int) -> ir.Function:
    """Return a kernel that is compiled beside the module."""
    return ir.Function(module, ir.FunctionType(INTEGER, [INTEGER, INTEGER, *[POINTER] * pointers]), name=name)
