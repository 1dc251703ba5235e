"""Calling native functions from tests: arrays in, arrays out."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from collections.abc import Sequence as Items

from symbody.codegen.llvm.native import NativeFunction
from symbody.codegen.pieces import plan_pieces
from symbody.expr.sequences.sequence import Sequence

GROUPS = ("t", "q", "u", "r", "p", "c")

_POINTER = ctypes.c_void_p
SIGNATURE = ctypes.CFUNCTYPE(ctypes.c_int, *[_POINTER] * 8)
BATCH = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64, *[_POINTER, ctypes.c_int64] * 7, _POINTER)


def doubles(values: Items[float]) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * max(1, len(values)))(*values)


def call_address(
    address: int, sequence: Sequence, inputs: Mapping[str, Items[float]], work_size: int
) -> tuple[int, list[float]]:
    """Return status and outputs; groups that `inputs` lacks are NULL."""
    given = [doubles(inputs[group]) if group in inputs else None for group in GROUPS]
    out, work = doubles([0.0] * sequence.output_size), doubles([0.0] * work_size)
    status = SIGNATURE(address)(*given, out, work)
    return status, list(out)[: sequence.output_size]


def call(
    function: NativeFunction, sequence: Sequence, inputs: Mapping[str, Items[float]]
) -> tuple[int, list[float]]:
    return call_address(function.address, sequence, inputs, function.work_size)


def pieces_of(sequence: Sequence, size: int) -> int:
    return len(plan_pieces(sequence, size).pieces)
