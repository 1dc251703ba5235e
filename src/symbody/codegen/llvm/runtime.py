"""Functions of our own that generated code calls: each compiled once in a process, or read from the disk.

Lanes hold the same quantity of several points side by side: entry k of an array of W lanes lies at k W.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import count as numbers
from typing import Final

import llvmlite.binding as binding
from llvmlite import ir

from symbody.codegen.llvm.loops import INTEGER, POINTER, Array, count, integer
from symbody.codegen.llvm.machine import SMALL, THOROUGH, environment, lanes, object_codes, target_machine
from symbody.codegen.llvm.saddles import saddle_text
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by
from symbody.codegen.llvm.trig import SINCOS_NAME, define_lane_sincos, define_sincos
from symbody.single_flight import SingleFlight, once

GATHER: Final = "symbody_gather"
SCATTER: Final = "symbody_scatter"
_DECLARED: Final = re.compile(r'^declare .*?@"?(symbody_\w+)"?\(', re.MULTILINE)
_LIBRARIES: Final[SingleFlight[str, binding.ResourceTracker]] = SingleFlight()
_LOADED: Final = numbers()


def lane_counts() -> tuple[int, ...]:
    """Return the numbers of lanes that code is made for here."""
    return tuple(width for width in (2, 4, 8) if width <= lanes())


def lane_sincos(width: int) -> str:
    """Return the name of the sines and cosines of so many angles."""
    return f"{SINCOS_NAME}_{width}"


def called_functions(text: str) -> list[str]:
    """Return the functions of ours that LLVM text declares and does not define."""
    return _DECLARED.findall(text)


def address(name: str) -> int:
    """Return the address of one of the functions, which is valid as long as the process lives."""
    return int(_LIBRARIES.get(name, lambda: load(_module(name), name))[name])


def load(module: Module, *names: str) -> binding.ResourceTracker:
    """Bring object code into memory, with the functions that it calls, and return those of these names."""
    builder = binding.JITLibraryBuilder().add_current_process()
    for code in module.codes:
        builder.add_object_img(code)
    for name in module.calls:
        builder.import_symbol(name, address(name))
    for name in names:
        builder.export_symbol(name)
    return builder.link(_linker(), f"symbody_{next(_LOADED)}")


@once
def _linker() -> binding.LLJIT:
    """Return what brings code into memory; it takes longer to make than a function to link."""
    return binding.create_lljit_compiler(target_machine(), use_jit_link=SMALL)


def _module(name: str) -> Module:
    key = written_by() and b"\n".join([written_by(), environment().encode(), name.encode()])
    module = read_module(key)
    if module is None:
        text, compile_text = function_text(name)
        module = Module((compile_text(text),), 0, tuple(called_functions(text)))
        store_module(key, module)
    return module


def function_text(name: str) -> tuple[str, Callable[[str], bytes]]:
    """Return the LLVM text of one of the functions, and what makes object code of it."""
    if not name.startswith((SINCOS_NAME, GATHER, SCATTER)):
        return saddle_text(name)
    module = ir.Module(name)
    if name == GATHER:
        _define_gather(module)
    elif name == SCATTER:
        _define_scatter(module)
    elif name == SINCOS_NAME:
        define_sincos(module).linkage = "external"
    else:
        define_sincos(module).linkage = "internal"
        define_lane_sincos(module, name, int(name.removeprefix(f"{SINCOS_NAME}_")))
    return str(module), lambda text: object_codes([text], THOROUGH)[0]


def _define_gather(module: ir.Module) -> None:
    """``void gather(const double *rows, long stride, long size, double *lanes)``: `size` entries of rows."""
    b, (rows, stride, size, place) = _begin(module, GATHER)
    width = lanes()
    sources = [Array(b, rows).offset_by(b.mul(stride, integer(lane))) for lane in range(width)]
    with count(b, integer(0), size) as k:
        target = Array(b, place).offset_by(b.mul(k, integer(width)))
        for lane, source in enumerate(sources):
            target.store(integer(lane), source.load(k))
    b.ret_void()


def _define_scatter(module: ir.Module) -> None:
    """``void scatter(double *rows, long stride, long size, const double *lanes)``: the way back."""
    b, (rows, stride, size, place) = _begin(module, SCATTER)
    width = lanes()
    targets = [Array(b, rows).offset_by(b.mul(stride, integer(lane))) for lane in range(width)]
    with count(b, integer(0), size) as k:
        source = Array(b, place).offset_by(b.mul(k, integer(width)))
        for lane, target in enumerate(targets):
            target.store(k, source.load(integer(lane)))
    b.ret_void()


def _begin(module: ir.Module, name: str) -> tuple[ir.IRBuilder, tuple[ir.Argument, ...]]:
    kinds = [POINTER, INTEGER, INTEGER, POINTER]
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), name=name)
    return ir.IRBuilder(function.append_basic_block("entry")), function.args
