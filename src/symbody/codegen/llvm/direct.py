"""The function in machine code that Python calls at a single point, for all compiled functions the same.

It reads arrays where they lie: the heads of objects and of arrays are part of the binary interfaces of
CPython and of NumPy, the same in all versions in use [numpy/ndarraytypes.h, PyArrayObject_fields]. What it
is not made for it leaves to the caller, by returning None.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import llvmlite.binding as binding

from symbody.codegen.llvm.machine import SMALL, THOROUGH, environment, object_codes, target_machine
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by
from symbody.single_flight import once

NAME: Final = "symbody_direct"
ARGUMENTS: Final = ("t", "q", "u", "r", "p")

# The arguments of the function, 8 bytes each, in this order: from `size_q` on numbers, before that addresses;
# `time` is room for the time, `parameters` has room for p at its beginning, and at `current` is a number that
# is not 0 where `constants` belong to what stands there.
SETTINGS: Final = (
    "code", "head", "constants", "parameters", "current", "work", "make_result", "array_type", "number_type",
    "float_type", "float64_type", "no_values", "none", "call", "take", "drop", "time", "size_q", "size_u",
    "size_r", "size_p",
)  # fmt: skip

# Bytes from the beginning of an object: its type; of an array: data, axes, shape, strides, type of entries,
# flags; of a float: its value.
_TYPE, _DATA, _AXES, _SHAPE, _STRIDES, _ENTRIES, _FLAGS, _VALUE = 8, 16, 24, 32, 40, 56, 64, 16
_ALIGNED: Final = 0x100


class Direct:
    """The function in memory: ``PyObject *(PyObject *settings, PyObject *const *arguments, Py_ssize_t)``."""

    def __init__(self) -> None:
        key = written_by() and written_by() + environment().encode() + NAME.encode()
        module = read_module(key)
        if module is None:
            module = Module(tuple(object_codes([text()], THOROUGH)), 0, ())
            store_module(key, module)
        builder = binding.JITLibraryBuilder().add_object_img(module.codes[0])
        linker = binding.create_lljit_compiler(target_machine(), use_jit_link=SMALL)
        self._library = builder.export_symbol(NAME).link(linker, NAME)
        self.address = int(self._library[NAME])


@once
def direct() -> Direct:
    """Return the function, ready to be called."""
    return Direct()


def text() -> str:
    """Return the function as LLVM text."""
    lines = [
        f"define ptr @{NAME}(ptr %self, ptr %given, i64 %count) nounwind {{",
        *_field("settings", "self", _DATA),
    ]
    for k, name in enumerate(SETTINGS):
        kind = "i64" if name.startswith("size_") else "ptr"
        lines.append(f"%{name}.at = getelementptr i8, ptr %settings, i64 {8 * k}")
        lines.append(f"%{name} = load {kind}, ptr %{name}.at")
    # The result is made first: that may let other threads run, which change what this call shares with theirs
    # and the arrays it was called with. From here to the end none does.
    lines += [
        "%result = call ptr %call(ptr %make_result)",
        "%lost = icmp eq ptr %result, null",
        "br i1 %lost, label %failed, label %made",
        "failed:",
        "ret ptr null",
        "made:",
    ]
    lines += _next("all", f"icmp eq i64 %count, {len(ARGUMENTS)}")
    for k, name in enumerate(ARGUMENTS):
        lines += _field(name, "given", 8 * k)
    lines += _time_is_a_float()
    for name in ARGUMENTS[1:]:
        lines += _is_array(name)
    lines += _constants_of_parameters()
    lines += [
        *_field("out", "result", _DATA),
        f"%t.value.at = getelementptr i8, ptr %t, i64 {_VALUE}",
        "%t.value = load double, ptr %t.value.at",
        "store double %t.value, ptr %time.at",
    ]
    for name in ARGUMENTS[1:-1]:  # an empty tuple has something there too, which is not read
        lines += _field(f"{name}.data", name, _DATA)
    data = ", ".join(f"ptr %{name}.data" for name in ARGUMENTS[1:])
    lines += [
        f"%status = call i32 %code(ptr %time.at, {data}, ptr %constants, ptr %out, ptr %work)",
        "%solved = icmp eq i32 %status, 0",
        "br i1 %solved, label %done, label %otherwise",
        "done:",
        "ret ptr %result",
        "otherwise:",
        "call void %drop(ptr %result)",
        "call void %take(ptr %none)",
        "ret ptr %none",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _constants_of_parameters() -> Iterator[str]:
    """Yield the lines that compute the constants where p differs from that of the call before.

    Parameters are compared as bits, so that one that is not a number is equal to itself, and 0 not to -0.
    """
    yield from _field("p.data", "p", _DATA)
    yield "%headless = icmp eq ptr %head, null"
    yield "br i1 %headless, label %ready, label %compare"
    yield "compare:"
    yield "%current.value = load i64, ptr %current"
    yield "%stale = icmp eq i64 %current.value, 0"
    yield "br i1 %stale, label %renew, label %next.p"
    yield "next.p:"
    yield "%k = phi i64 [0, %compare], [%k.after, %same.p]"
    yield "%over = icmp eq i64 %k, %size_p"
    yield "br i1 %over, label %ready, label %look.p"
    yield "look.p:"
    yield "%given.at = getelementptr i64, ptr %p.data, i64 %k"
    yield "%kept.at = getelementptr i64, ptr %parameters, i64 %k"
    yield "%given.p = load i64, ptr %given.at"
    yield "%kept.p = load i64, ptr %kept.at"
    yield "%equal.p = icmp eq i64 %given.p, %kept.p"
    yield "br i1 %equal.p, label %same.p, label %renew"
    yield "same.p:"
    yield "%k.after = add i64 %k, 1"
    yield "br label %next.p"
    yield "renew:"
    yield "br label %copy.p"
    yield "copy.p:"
    yield "%j = phi i64 [0, %renew], [%j.after, %move.p]"
    yield "%copied = icmp eq i64 %j, %size_p"
    yield "br i1 %copied, label %derive, label %move.p"
    yield "move.p:"
    yield "%from.at = getelementptr i64, ptr %p.data, i64 %j"
    yield "%to.at = getelementptr i64, ptr %parameters, i64 %j"
    yield "%moved = load i64, ptr %from.at"
    yield "store i64 %moved, ptr %to.at"
    yield "%j.after = add i64 %j, 1"
    yield "br label %copy.p"
    yield "derive:"
    yield "store i64 0, ptr %current"
    nothing = ", ".join(["ptr %time"] * 4)
    yield f"%derived = call i32 %head({nothing}, ptr %parameters, ptr null, ptr %constants, ptr %work)"
    yield from _next("derived.well", "icmp eq i32 %derived, 0")
    yield "store i64 1, ptr %current"
    yield "br label %ready"
    yield "ready:"


def _field(name: str, of: str, offset: int, kind: str = "ptr") -> Iterator[str]:
    yield f"%{name}.place = getelementptr i8, ptr %{of}, i64 {offset}"
    yield f"%{name} = load {kind}, ptr %{name}.place"


def _next(label: str, condition: str) -> Iterator[str]:
    """Yield the lines that continue at `label` if a condition holds, and return otherwise."""
    yield f"%{label}.holds = {condition}"
    yield f"br i1 %{label}.holds, label %{label}, label %otherwise"
    yield f"{label}:"


def _time_is_a_float() -> Iterator[str]:
    yield from _field("t.type", "t", _TYPE)
    yield "%t.plain = icmp eq ptr %t.type, %float_type"
    yield "%t.numpy = icmp eq ptr %t.type, %float64_type"
    yield from _next("t.known", "or i1 %t.plain, %t.numpy")


def _is_array(name: str) -> Iterator[str]:
    """Yield a check that an argument is a row of so many doubles, one after the other, or needs no values."""
    yield f"%{name}.nothing = icmp eq ptr %{name}, %no_values"
    yield f"%{name}.none = icmp eq i64 %size_{name}, 0"
    yield f"%{name}.absent = and i1 %{name}.nothing, %{name}.none"
    yield f"br i1 %{name}.absent, label %{name}.fits, label %{name}.check"
    yield f"{name}.check:"
    yield from _field(f"{name}.type", name, _TYPE)
    yield from _next(f"{name}.array", f"icmp eq ptr %{name}.type, %array_type")
    yield from _field(f"{name}.axes", name, _AXES, "i32")
    yield from _next(f"{name}.row", f"icmp eq i32 %{name}.axes, 1")
    yield from _field(f"{name}.shape", name, _SHAPE)
    yield f"%{name}.length = load i64, ptr %{name}.shape"
    yield from _next(f"{name}.long", f"icmp eq i64 %{name}.length, %size_{name}")
    yield from _field(f"{name}.strides", name, _STRIDES)
    yield f"%{name}.stride = load i64, ptr %{name}.strides"
    yield f"%{name}.close = icmp eq i64 %{name}.stride, 8"
    yield f"%{name}.short = icmp slt i64 %{name}.length, 2"
    yield from _next(f"{name}.dense", f"or i1 %{name}.close, %{name}.short")
    yield from _field(f"{name}.entries", name, _ENTRIES)
    yield from _next(f"{name}.numbers", f"icmp eq ptr %{name}.entries, %number_type")
    yield from _field(f"{name}.flags", name, _FLAGS, "i32")
    yield f"%{name}.aligned = and i32 %{name}.flags, {_ALIGNED}"
    yield from _next(f"{name}.placed", f"icmp ne i32 %{name}.aligned, 0")
    yield f"br label %{name}.fits"
    yield f"{name}.fits:"
