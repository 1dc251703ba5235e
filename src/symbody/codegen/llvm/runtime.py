"""Functions of our own that generated code calls: compiled once in a process, or read from the disk.

Lanes hold the same quantity of several points side by side: entry k of an array of W lanes lies at k W.
"""

from __future__ import annotations

from typing import Final

import llvmlite.binding as binding
from llvmlite import ir

from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.llvm.loops import INTEGER, POINTER, Array, count, integer
from symbody.codegen.llvm.machine import (
    SMALL,
    THOROUGH,
    environment,
    lanes,
    object_codes,
    optimized_code,
    target_machine,
)
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by
from symbody.codegen.llvm.trig import SINCOS_NAME, define_lane_sincos, define_sincos
from symbody.single_flight import once

GATHER: Final = "symbody_gather"
SCATTER: Final = "symbody_scatter"
SADDLE: Final = "solve_saddle"
SADDLE_NAME: Final = kernel_name(SADDLE)
LANE_SADDLE: Final = "symbody_solve_saddles"


def lane_counts() -> tuple[int, ...]:
    """Return the numbers of lanes that code is made for here."""
    return tuple(width for width in (2, 4, 8) if width <= lanes())


def lane_sincos(width: int) -> str:
    """Return the name of the sines and cosines of so many angles."""
    return f"{SINCOS_NAME}_{width}"


class Runtime:
    """The functions in memory.

    Attributes
    ----------
    addresses : mapping of name to int
    """

    def __init__(self) -> None:
        names = [SINCOS_NAME, SADDLE_NAME, LANE_SADDLE, GATHER, SCATTER, *map(lane_sincos, lane_counts())]
        builder = binding.JITLibraryBuilder().add_current_process()
        for code in _codes():
            builder.add_object_img(code)
        for name in names:
            builder.export_symbol(name)
        linker = binding.create_lljit_compiler(target_machine(), use_jit_link=SMALL)
        self._library = builder.link(linker, "symbody_runtime")
        self.addresses = {name: int(self._library[name]) for name in names}


@once
def runtime() -> Runtime:
    """Return the functions, ready to be called."""
    return Runtime()


def _codes() -> tuple[bytes, ...]:
    key = written_by() and written_by() + environment().encode()
    known = read_module(key)
    if known is None:
        codes = *map(optimized_code, kernel_texts()), *object_codes([text()], THOROUGH)
        known = Module(codes, 0, calls_runtime=False)
        store_module(key, known)
    return known.codes


def kernel_texts() -> list[str]:
    """Return the kernels as LLVM text, for one system and for as many as there are lanes."""
    kernels = read_kernels(SADDLE)
    return [llvm_text(kernels, [SADDLE], width) for width in (1, lanes())]


def text() -> str:
    """Return all other functions as LLVM text."""
    module = ir.Module("symbody_runtime")
    define_sincos(module).linkage = "external"
    for width in lane_counts():
        define_lane_sincos(module, lane_sincos(width), width)
    _define_lane_saddle(module)
    _define_gather(module)
    _define_scatter(module)
    return str(module)


def _define_gather(module: ir.Module) -> None:
    """``void gather(const double *rows, long stride, long size, double *lanes)``: `size` entries of rows."""
    b, (rows, stride, size, place) = _begin(module, GATHER, [POINTER, INTEGER, INTEGER, POINTER])
    width = lanes()
    sources = [Array(b, rows).offset_by(b.mul(stride, integer(lane))) for lane in range(width)]
    with count(b, integer(0), size) as k:
        target = Array(b, place).offset_by(b.mul(k, integer(width)))
        for lane, source in enumerate(sources):
            target.store(integer(lane), source.load(k))
    b.ret_void()


def _define_scatter(module: ir.Module) -> None:
    """``void scatter(double *rows, long stride, long size, const double *lanes)``: the way back."""
    b, (rows, stride, size, place) = _begin(module, SCATTER, [POINTER, INTEGER, INTEGER, POINTER])
    width = lanes()
    targets = [Array(b, rows).offset_by(b.mul(stride, integer(lane))) for lane in range(width)]
    with count(b, integer(0), size) as k:
        source = Array(b, place).offset_by(b.mul(k, integer(width)))
        for lane, target in enumerate(targets):
            target.store(k, source.load(integer(lane)))
    b.ret_void()


def _define_lane_saddle(module: ir.Module) -> None:
    """``long lanes(long n, long m, const double *arguments, double *results, double *work)``.

    All lanes at once if their pivots are the same; if not, the scalar kernel, lane after lane. `arguments`
    are M, J, F and gamma in lanes. It returns 0, or 1 if any lane has no solution. `work` holds the scratch
    of the kernel in lanes, or, for one lane, the arguments, the results and the scratch of the kernel.
    """
    signature = ir.FunctionType(INTEGER, [INTEGER, INTEGER, POINTER, POINTER, POINTER])
    function = ir.Function(module, signature, name=LANE_SADDLE)
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
    status = b.call(_kernel(module, kernel_name(SADDLE, lanes()), 7), [n, m, *pointers, mixed])
    is_mixed = b.icmp_unsigned("!=", b.load(mixed, typ=ir.IntType(8)), ir.Constant(ir.IntType(8), 0))
    with b.if_then(b.not_(b.or_(is_mixed, b.icmp_unsigned("!=", status, integer(0))))):
        b.ret(integer(0))
    b.store(integer(0), failed)
    with count(b, integer(0), width) as lane:
        with count(b, integer(0), total) as k:
            work.store(k, given.load(b.add(b.mul(k, width), lane)))
        pointers = [array.pointer for array in (*places, solution, scratch)]
        status = b.call(_kernel(module, SADDLE_NAME, 6), [n, m, *pointers])
        b.store(b.or_(b.load(failed, typ=INTEGER), status), failed)
        with count(b, integer(0), solved) as k:
            results.store(b.add(b.mul(k, width), lane), solution.load(k))
    b.ret(b.load(failed, typ=INTEGER))


def _kernel(module: ir.Module, name: str, pointers: int) -> ir.Function:
    """Return a kernel that is compiled beside the module."""
    return ir.Function(module, ir.FunctionType(INTEGER, [INTEGER, INTEGER, *[POINTER] * pointers]), name=name)


def _begin(
    module: ir.Module, name: str, kinds: list[ir.Type]
) -> tuple[ir.IRBuilder, tuple[ir.Argument, ...]]:
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), name=name)
    return ir.IRBuilder(function.append_basic_block("entry")), function.args
