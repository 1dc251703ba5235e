"""LLVM functions around the pieces: all of them for one point, and for batches of points."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from symbody.codegen.llvm.numbers import declarations
from symbody.codegen.llvm.runtime import GATHER, SCATTER, lane_counts, lane_sincos
from symbody.codegen.llvm.saddles import LANE_SADDLES, SADDLE
from symbody.codegen.llvm.trig import SINCOS_NAME
from symbody.codegen.llvm.writing import GROUPS, PARAMETERS, first_status

# Doubles in a line of the cache: registers that reach over the end of one take twice the time.
ALIGNMENT: Final = 8

_ARGUMENTS: Final = ", ".join(f"ptr %{name}" for name in (*GROUPS, "out", "work"))
_ARRAYS: Final = (*GROUPS, "out")
_BATCH: Final = ", ".join(f"ptr %{a}, i64 %{a}.stride" for a in _ARRAYS)
# The kernels by their names without sizes.
_SADDLES: Final = {SADDLE: "i64, i64, ptr, ptr, ptr, ptr, ptr, ptr", LANE_SADDLES: "i64, i64, ptr, ptr, ptr"}
_SADDLE_CALL: Final = re.compile(rf"@(({SADDLE}|{LANE_SADDLES})(?:_\w+)?)\(")
_OWN: Final = {
    "llvm.memset.p0.i64": "void @llvm.memset.p0.i64(ptr, i8, i64, i1)",
    SINCOS_NAME: f"{{double, double}} @{SINCOS_NAME}(double)",
    GATHER: f"void @{GATHER}(ptr, i64, i64, ptr)",
    SCATTER: f"void @{SCATTER}(ptr, i64, i64, ptr)",
}


def entry_function(name: str, pieces: Sequence[str], *, whole_lines: bool) -> str:
    """Return the function that calls `pieces` in order and returns the first status that is not 0.

    Parameters
    ----------
    whole_lines : bool
        Whether the work array is read and written in registers of several numbers; see `ALIGNMENT`.
    """
    lines = list(_align_pointer("%work", "%lines")) if whole_lines else []
    arguments = _ARGUMENTS.replace("%work", "%lines") if whole_lines else _ARGUMENTS
    status = "0"
    for k, piece in enumerate(pieces):
        lines.append(f"%r{k} = call i32 @{piece}({arguments})")
        lines.extend(first_status(status, f"%r{k}", f"%s{k}"))
        status = f"%s{k}"
    body = "\n".join([*lines, f"ret i32 {status}"])
    return f"define i32 @{name}({PARAMETERS}) nounwind {{\n{body}\n}}\n"


def batch_function(name: str, function: str) -> str:
    """Return the function that calls `function` for many points.

    ``int name(long count, const double *t, long t_stride, ..., double *out, long out_stride, double *work)``
    with 64-bit counts; strides in doubles, 0 for what is the same at every point. It computes every point
    and returns the first status that is not 0.
    """
    lines = list(_pointers(1))
    arguments = ", ".join([f"ptr %{a}.k" for a in _ARRAYS] + ["ptr %work"])
    lines.append(f"%code = call i32 @{function}({arguments})")
    return _loop(name, lines)


def lane_batch_function(name: str, function: str, sizes: Mapping[str, int], width: int) -> str:
    """Return the function that calls `function`, which is in lanes, for count times `width` points.

    Parameters
    ----------
    sizes : mapping of str to int
        Numbers in each group and in "out"; so many, times `width`, come first in `work`.
    """
    lines = [*_pointers(width), *_align_pointer("%work", "%lines"), "%first = icmp eq i64 %k, 0"]
    arguments = []
    place = 0
    for array in _ARRAYS:
        size = sizes[array]
        lines.append(f"%{array}.l = getelementptr double, ptr %lines, i64 {place}")
        arguments.append(f"ptr %{array}.l")
        place += size * width
        if size and array != "out":  # what all points share is spread over the lanes once
            lines.append(f"%{array}.differs = icmp ne i64 %{array}.stride, 0")
            lines.append(f"%{array}.needed = or i1 %first, %{array}.differs")
            lines.append(f"%{array}.size = select i1 %{array}.needed, i64 {size}, i64 0")
            lines.append(
                f"call void @{GATHER}(ptr %{array}.k, i64 %{array}.stride, i64 %{array}.size, ptr %{array}.l)"
            )
    lines.append(f"%rest = getelementptr double, ptr %lines, i64 {place}")
    lines.append(f"%code = call i32 @{function}({', '.join(arguments)}, ptr %rest)")
    lines.append(f"call void @{SCATTER}(ptr %out.k, i64 %out.stride, i64 {sizes['out']}, ptr %out.l)")
    return _loop(name, lines)


def _align_pointer(given: str, name: str) -> Iterator[str]:
    """Yield the lines that move a pointer up to where a line of the cache begins."""
    yield f"{name}.at = ptrtoint ptr {given} to i64"
    yield f"{name}.end = add i64 {name}.at, {8 * ALIGNMENT - 1}"
    yield f"{name}.start = and i64 {name}.end, {-8 * ALIGNMENT}"
    yield f"{name} = inttoptr i64 {name}.start to ptr"


def declaration(function: str) -> str:
    """Return the declaration of a piece defined in another module."""
    return f"declare i32 @{function}({', '.join(['ptr'] * 8)}) nounwind\n"


def all_declarations(text: str) -> str:
    """Return declarations of all functions that `text` calls and does not define."""
    known = dict(_OWN)
    for n in lane_counts():
        vector = f"<{n} x double>"
        known[lane_sincos(n)] = f"{{{vector}, {vector}}} @{lane_sincos(n)}({vector})"
    known |= {name: f"i64 @{name}({_SADDLES[kind]})" for name, kind in _SADDLE_CALL.findall(text)}
    own = [f"declare {known[name]} nounwind\n" for name in known if f"@{name}(" in text]
    for n in lane_counts():
        name = f"llvm.masked.store.v{n}f64.p0"
        if f"@{name}(" in text:
            own.append(f"declare void @{name}(<{n} x double>, ptr, i32, <{n} x i1>)\n")
    return "".join(own) + declarations(text)


def _pointers(step: int) -> Iterator[str]:
    for a in _ARRAYS:
        yield f"%{a}.point = mul i64 %k, {step}"
        yield f"%{a}.offset = mul i64 %{a}.point, %{a}.stride"
        yield f"%{a}.k = getelementptr double, ptr %{a}, i64 %{a}.offset"


def _loop(name: str, step: Sequence[str]) -> str:
    """Return a function that does `step`, which sets %code, for %k from 0 to %count."""
    lines = [
        "start:",
        "%any = icmp sgt i64 %count, 0",
        "br i1 %any, label %loop, label %end",
        "loop:",
        "%k = phi i64 [0, %start], [%k.next, %loop]",
        "%before = phi i32 [0, %start], [%status, %loop]",
        *step,
        *first_status("%before", "%code", "%status"),
        "%k.next = add i64 %k, 1",
        "%more = icmp slt i64 %k.next, %count",
        "br i1 %more, label %loop, label %end",
        "end:",
        "%result = phi i32 [0, %start], [%status, %loop]",
        "ret i32 %result",
    ]
    body = "\n".join(lines)
    return f"define i32 @{name}(i64 %count, {_BATCH}, ptr %work) nounwind {{\n{body}\n}}\n"
