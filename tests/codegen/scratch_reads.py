"""Machine code that watches its own scratch: which words it reads before anything has written them.

Before every load, and after every store, of LLVM's text stands a call that hands over the address and the size.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import llvmlite.binding as binding

from symbody.codegen.llvm import runtime
from symbody.codegen.llvm.machine import QUICK, SMALL, THOROUGH, object_codes, target_machine
from symbody.codegen.llvm.native import BATCH_NAME, NAME, compile_sequence
from symbody.expr.sequences.sequence import Sequence

LOAD = re.compile(r"^\s*\S+ = load ([^,]+), ptr (\S+?)(, align \d+)?$")
STORE = re.compile(r"^\s*store (<.+?>|\S+) .+, ptr (\S+?)(, align \d+)?$")
CLEAR = re.compile(r"^\s*(?:tail )?call void @llvm\.memset\.p0\.i64\(ptr (\S+), i8 0, i64 (\d+), i1 false\)$")
UNSEEN = re.compile(r".* = load .*ptr ")
VECTOR = re.compile(r"<(\d+) x double>")
SIZES = {"double": 8, "i64": 8, "i32": 4, "i8": 1, "ptr": 8}
SEEN = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)


def size(kind: str) -> int:
    vector = VECTOR.fullmatch(kind.strip())
    return 8 * int(vector[1]) if vector else SIZES[kind.strip()]


def watched_text(text: str) -> str:
    """LLVM text with a call at every load and store but those of the stack, which have typed pointers."""

    def lines() -> Iterator[str]:
        for line in text.splitlines():
            load, store, clear = LOAD.match(line), STORE.match(line), CLEAR.match(line)
            if load:
                yield f"call void @watch_read(ptr {load[2]}, i64 {size(load[1])})"
            yield line
            if store:
                yield f"call void @watch_write(ptr {store[2]}, i64 {size(store[1])})"
            if clear:
                yield f"call void @watch_write(ptr {clear[1]}, i64 {clear[2]})"

    declared = "declare void @watch_read(ptr, i64)\ndeclare void @watch_write(ptr, i64)\n"
    unseen = [line for line in text.splitlines() if UNSEEN.match(line) and not LOAD.match(line)]
    assert not unseen, f"these loads are written otherwise: {unseen}"
    return "\n".join(lines()) + "\n" + declared


@dataclass(frozen=True)
class Watched:
    """A sequence compiled with a watch on its scratch.

    Attributes
    ----------
    unwritten : list of int
        Bytes that were read before they were written, by all calls so far.
    reads : list of int
        How many words of the scratch each call read.
    """

    address: int
    batch_address: int
    work: Any
    work_size: int
    width: int
    unwritten: list[int] = field(default_factory=list)
    written: bytearray = field(default_factory=bytearray)
    reads: list[int] = field(default_factory=lambda: [0])
    kept: list[Any] = field(default_factory=list)


@cache
def watched_function(name: str) -> tuple[bytes, tuple[str, ...]]:
    """The code of a function of the runtime, and the functions that it calls."""
    text = runtime.function_text(name)[0]
    return object_codes([watched_text(text)], THOROUGH)[0], tuple(runtime.called_functions(text))


def watched_runtime(names: list[str]) -> list[bytes]:
    """The code of functions of the runtime, and of those that they call."""
    codes: dict[str, bytes] = {}
    while names:
        name = names.pop()
        if name not in codes:
            codes[name], called = watched_function(name)
            names.extend(called)
    return list(codes.values())


def watched(
    sequence: Sequence, *, in_lanes: bool = False, piece_size: int = 2000, leave_out: str = "\0"
) -> Watched:
    """Compile `sequence` and the runtime, both with the watch, without the lines that contain `leave_out`."""
    plain = compile_sequence(sequence, in_lanes=in_lanes, piece_size=piece_size, keep_ir=True)
    work = (ctypes.c_double * (plain.work_size + 1))()
    start, end = ctypes.addressof(work), ctypes.addressof(work) + 8 * plain.work_size
    found = Watched(0, 0, work, plain.work_size, plain.width)
    found.written.extend(bytes(8 * plain.work_size))

    def read(address: int, count: int) -> None:
        if start <= address < end:
            found.reads[0] += 1
            first = address - start
            found.unwritten.extend(k for k in range(first, first + count) if not found.written[k])

    def write(address: int, count: int) -> None:
        if start <= address < end:
            found.written[address - start : address - start + count] = b"\1" * count

    text = "\n".join(line for line in plain.ir.splitlines() if leave_out not in line)
    called = [name for name in runtime.called_functions(text) if not name.startswith(NAME)]
    codes = [*object_codes([watched_text(text)], QUICK), *watched_runtime(called)]
    watch = {"watch_read": SEEN(read), "watch_write": SEEN(write)}
    builder = binding.JITLibraryBuilder().add_current_process()
    for code in codes:
        builder.add_object_img(code)
    for name, function in watch.items():
        builder.import_symbol(name, ctypes.cast(function, ctypes.c_void_p).value)
    linker = binding.create_lljit_compiler(target_machine(), use_jit_link=SMALL)
    library = builder.export_symbol(NAME).export_symbol(BATCH_NAME).link(linker, "watched")
    found.kept.extend([library, linker, watch])
    return Watched(
        library[NAME], library[BATCH_NAME], work, plain.work_size, plain.width,
        found.unwritten, found.written, found.reads, found.kept,
    )  # fmt: skip
