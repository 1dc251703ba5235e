"""Machine code of a sequence on the disk, found by the sequence: its text need not be written again.

The key holds all that code follows from: operations, constants, where inputs are read and outputs written,
what is asked of the compiler, the processor, the versions, and the files of this package that write the text,
so that nothing stale is found after an update or while they are worked on.
"""

from __future__ import annotations

import json
from array import array
from dataclasses import dataclass
from hashlib import sha256
from itertools import accumulate, pairwise
from pathlib import Path

import symbody.kernels
from symbody.codegen.llvm.machine import environment
from symbody.expr.fingerprints import shapes
from symbody.expr.opcodes import NAMES
from symbody.expr.sequences.sequence import Sequence
from symbody.single_flight import once
from symbody.storage import load_stored, store


@dataclass(frozen=True, slots=True)
class Module:
    """Object code of one function.

    Attributes
    ----------
    codes : tuple of bytes
        Of the modules that are linked together.
    work_size : int
        Doubles of scratch that the function needs.
    calls : tuple of str
        The functions of `runtime` that it calls.
    """

    codes: tuple[bytes, ...]
    work_size: int
    calls: tuple[str, ...]


def key_of(sequence: Sequence, *asked: int) -> bytes:
    """Return the key of a sequence and of the numbers that are `asked` of the compiler.

    It is empty, so that nothing is stored, if the files that write the text cannot be read.
    """
    writers = written_by()
    if not writers:
        return b""
    operations = array("q")
    for code, operands, datum in sequence.operations:
        operations.extend((code, datum, len(operands), *operands))
    rest = (
        [(entry.group, entry.position) for entry in sequence.inputs],
        sequence.constants,
        [(kernel.n, kernel.m) for kernel in sequence.kernels],
        [output.values for output in sequence.outputs],
        [program.word for program in sequence.programs],
        asked,
        environment(),
    )
    return b"\n".join([writers, repr(rest).encode(), operations.tobytes()])


def read_module(key: bytes) -> Module | None:
    """Return the module stored under `key`, or None."""
    content = load_stored(key) if key else None
    if content is None:
        return None
    head, _, body = content.partition(b"\n")
    header = json.loads(head)
    bounds = accumulate(header["sizes"], initial=0)
    codes = tuple(body[start:stop] for start, stop in pairwise(bounds))
    return Module(codes, header["work_size"], tuple(header["calls"]))


def store_module(key: bytes, module: Module) -> None:
    """Store a module, if it has a key."""
    if key:
        header = {
            "sizes": [len(code) for code in module.codes],
            "work_size": module.work_size,
            "calls": module.calls,
        }
        store(key, json.dumps(header).encode() + b"\n" + b"".join(module.codes))


@once
def written_by() -> bytes:
    """Return a hash of the files and numbers that texts are written by; nothing if they cannot be read."""
    digest, files = sha256(repr(NAMES).encode()), writing_files()
    for file in files:
        digest.update(sha256(file.read_bytes()).digest())
    return digest.digest() if files else b""


def writing_files() -> list[Path]:
    """Return the files that sequences are formed, paired and written by, in folders at any depth."""
    codegen, kernels = Path(__file__).parent.parent, Path(symbody.kernels.__file__).parent
    files = [file for folder in (codegen, kernels) for file in sorted(folder.rglob("*.py"))]
    return [*files, Path(shapes.__file__)] if files else []
