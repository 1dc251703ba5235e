"""Sequences on the disk, found by what they were made from: the equations need not be formed again.

The key holds the identity of the equations, what was asked of them, and what object code depends on too, for
the functions of this machine fold constants. Small sequences are not stored: they are formed in milliseconds.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import Any, Final

from symbody.codegen.llvm.machine import environment
from symbody.codegen.llvm.stored_module import written_by
from symbody.codegen.signature import Signature
from symbody.expr.graph import Constant
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence
from symbody.storage import load_stored, store

SMALLEST: Final = 500  # operations
_CODE: Final = "i"  # 32 bits on every machine


def sequence_key(equations: bytes, asked: bytes) -> bytes:
    """Return the key of a sequence of `equations`; empty, so that nothing is stored, if one of them is."""
    writers = written_by()
    if not (equations and asked and writers):
        return b""
    return b"\n".join([b"sequence", equations, writers, environment().encode(), asked])


def read_sequence(key: bytes) -> tuple[Sequence, Signature] | None:
    """Return the sequence stored under `key` and its arguments, or None."""
    content = load_stored(key) if key else None
    if content is None:
        return None
    head, _, body = content.partition(b"\n")
    header = json.loads(head)
    columns = array(_CODE)
    columns.frombytes(body)
    return _sequence(header, columns), Signature(*(tuple(names) for names in header["signature"]))


def store_sequence(key: bytes, sequence: Sequence, signature: Signature) -> bool:
    """Store a sequence if that pays, and return whether it did."""
    if not key or len(sequence.operations) < SMALLEST or sequence.functions:
        return False
    names = (signature.q, signature.u, signature.r, signature.p, signature.s)
    header = _as_mapping(sequence) | {"signature": names}
    store(key, json.dumps(header).encode() + b"\n" + _columns(sequence).tobytes())
    return True


def _as_mapping(sequence: Sequence) -> dict[str, object]:
    """Return a sequence without its operations as a mapping; programs are short and stand in it whole."""
    return {
        "inputs": [(entry.name, entry.group, entry.position) for entry in sequence.inputs],
        "constants": [_constant_text(value) for value in sequence.constants],
        "kernels": [(kernel.n, kernel.m) for kernel in sequence.kernels],
        "operations": len(sequence.operations),
        "outputs": [(output.name, output.shape, output.values) for output in sequence.outputs],
        "programs": [(_as_mapping(program), _columns(program).tolist()) for program in sequence.programs],
    }


def _columns(sequence: Sequence) -> array[int]:
    """Return codes, data, numbers of operands, and operands one after the other."""
    columns = array(_CODE, (operation.op for operation in sequence.operations))
    columns.extend(operation.datum for operation in sequence.operations)
    columns.extend(len(operation.operands) for operation in sequence.operations)
    columns.extend(k for operation in sequence.operations for k in operation.operands)
    return columns


def _sequence(header: Mapping[str, Any], columns: array[int]) -> Sequence:
    """Return the sequence that `_told` and `_columns` were made of."""
    return Sequence(
        tuple(Input(*entry) for entry in header["inputs"]),
        tuple(_constant(text) for text in header["constants"]),
        tuple(KernelNode(n, m) for n, m in header["kernels"]),
        (),
        tuple(_operations(columns, header["operations"])),
        tuple(Output(name, tuple(shape), tuple(values)) for name, shape, values in header["outputs"]),
        tuple(_sequence(inside, array(_CODE, numbers)) for inside, numbers in header["programs"]),
    )


def _operations(columns: array[int], count: int) -> Iterator[Operation]:
    """Return operations from `_columns`."""
    bounds = accumulate(columns[2 * count : 3 * count], initial=3 * count)
    operands = columns.tolist()
    data = columns[count : 2 * count]
    for code, datum, (start, stop) in zip(columns, data, pairwise(bounds), strict=False):
        yield Operation(code, tuple(operands[start:stop]), datum)


def _constant_text(value: Constant) -> str:
    return value.hex() if isinstance(value, float) else str(value)


def _constant(text: str) -> Constant:
    """Return the number that `_constant_text` wrote; floats have a point or are not finite."""
    if "x" in text or text.strip("+-") in ("inf", "nan"):
        return float.fromhex(text)
    value = Fraction(text)
    return value.numerator if "/" not in text else value
