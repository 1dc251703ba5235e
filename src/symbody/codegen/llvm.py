"""Machine code from a sequence: text, LLVM's code generator, the addresses of two functions.

No optimization passes run: the graph the sequence comes from is folded and shared already, and
passes cost 80 % more time for no speed. The functions hold no state; what they need is passed in.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence as Items
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Final

from symbody.errors import EnvironmentFault, Problem

try:
    import llvmlite.binding as binding
    from llvmlite import ir
    from llvmlite.binding import ffi
except (ImportError, OSError) as error:
    raise EnvironmentFault(
        Problem("environment.llvmlite", "", "equations cannot be compiled: llvmlite does not load",
                str(error).partition("\n")[0], "pip install --force-reinstall llvmlite")
    ) from error  # fmt: skip

from symbody.codegen.llvm_functions import (
    SADDLE_NAME,
    batch_function,
    declaration,
    entry_function,
    library_declarations,
    piece_function,
)
from symbody.codegen.llvm_trig import SINCOS_NAME, define_sincos
from symbody.codegen.pieces import PIECE_SIZE, Plan, plan_pieces
from symbody.codegen.saddle_llvm import define_solve_saddle
from symbody.expr.sequence import Sequence

NAME: Final = "symbody_f"
BATCH_NAME: Final = "symbody_f_batch"

PARALLEL_ABOVE: Final = 50_000  # operations, about a second of compiling
# The small code model reaches constants relative to the instruction, where the one for code anywhere in
# memory loads a 64-bit address before each. It wants code and constants within 2 GB of each other, which
# JITLink grants; LLVM has no finished JITLink for Windows.
SMALL: Final = sys.platform != "win32"

MODULE_PIECES: Final = 8  # pieces in each module when several are compiled at once


@dataclass(frozen=True, slots=True, eq=False)
class NativeFunction:
    """Compiled code, valid as long as this object lives.

    Attributes
    ----------
    address : int
        Of ``int (const double *t, *q, *u, *r, *p, *c, double *out, double *work)``. All outputs one
        after the other, row-major, go to `out`. It returns 0, or k + 1 if kernel k could not be solved
        and its results are nan. Groups that are not read may be NULL and may overlap; `out` and `work`
        must not overlap anything. Reentrant with a `work` of its own for every thread.
    batch_address : int
        Of ``int (int64 count, const double *t, int64 t_stride, ..., double *out, int64 out_stride,
        double *work)``: the same for `count` points, strides in doubles, 0 for what all points share.
        It computes every point and returns the first status that is not 0.
    work_size : int
        Doubles in `work`; it may be NULL if this is 0.
    operations : int
        Operations of one evaluation.
    ir : str
        The LLVM text, empty unless it was asked for.
    """

    address: int
    batch_address: int
    work_size: int
    operations: int
    ir: str = field(repr=False)
    library: binding.ResourceTracker = field(repr=False)


def compile_sequence(
    sequence: Sequence, *, piece_size: int = PIECE_SIZE, keep_ir: bool = False
) -> NativeFunction:
    """Compile `sequence` for this processor.

    Parameters
    ----------
    piece_size : int
        About how many operations go into one machine function; results do not depend on it.
    keep_ir : bool
        Keep the LLVM text, about 80 bytes an operation.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    plan = plan_pieces(sequence, piece_size)
    texts = _module_texts(sequence, plan)
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    library = _load(_object_codes(texts))
    ir_text = "\n".join(texts) if keep_ir else ""
    return NativeFunction(
        library[NAME], library[BATCH_NAME], plan.work_size, sequence.operation_count, ir_text, library
    )


def _module_texts(sequence: Sequence, plan: Plan) -> list[str]:
    """Return the text of each module; the functions call each other across modules."""
    names = [f"{NAME}_{k}" for k in range(len(plan.pieces))]
    functions = [
        piece_function(sequence, plan, piece, name) for piece, name in zip(plan.pieces, names, strict=True)
    ]
    entry = entry_function(NAME, names) + batch_function(BATCH_NAME, NAME)
    if len(sequence.operations) <= PARALLEL_ABOVE:
        bodies = ["".join(functions) + entry]
    else:
        groups = range(0, len(functions), MODULE_PIECES)
        bodies = ["".join(functions[k : k + MODULE_PIECES]) for k in groups]
        bodies.append("".join(declaration(name) for name in names) + entry)
    texts = [body + library_declarations(body) for body in bodies]
    runtime = _runtime(texts)
    return [*texts, runtime] if runtime else texts


def _runtime(texts: Items[str]) -> str:
    """Return the module of the functions of our own that `texts` call, empty if there are none."""
    module = ir.Module("symbody_runtime")
    used = False
    for name, define in ((SINCOS_NAME, define_sincos), (SADDLE_NAME, define_solve_saddle)):
        if any(f"@{name}(" in text for text in texts):
            define(module).linkage = "external"  # called from other modules
            used = True
    return str(module) if used else ""


def _object_codes(texts: Items[str]) -> list[bytes]:
    if len(texts) <= 2:
        return [_object_code(text) for text in texts]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(_object_code_unlocked, texts))


def _object_code(text: str) -> bytes:
    module = binding.parse_assembly(text, binding.create_context())
    return bytes(_target_machine().emit_object(module))


def _object_code_unlocked(text: str) -> bytes:
    """Compile `text` while other threads compile others.

    llvmlite guards every call by one lock, so threads gain nothing through it. LLVM itself asks only
    that threads share no context and no target machine [LLVM Programmer's Manual, "Threads and LLVM"].
    """
    module = binding.parse_assembly(text, binding.create_context())
    machine = _target_machine()
    locked = ffi.lib.LLVMPY_TargetMachineEmitToMemory
    emit = ctypes.CDLL(ffi.lib._name)["LLVMPY_TargetMachineEmitToMemory"]
    emit.argtypes, emit.restype = locked.argtypes, locked.restype
    with ffi.OutputString() as message:
        buffer = emit(machine, module, 1, message)
        if not buffer:
            raise RuntimeError(str(message))
    try:
        start, size = ffi.lib.LLVMPY_GetBufferStart(buffer), ffi.lib.LLVMPY_GetBufferSize(buffer)
        return ctypes.string_at(start, size)
    finally:
        ffi.lib.LLVMPY_DisposeMemoryBuffer(buffer)


def _load(codes: Items[bytes]) -> binding.ResourceTracker:
    """Bring object code into memory."""
    linker = binding.create_lljit_compiler(_target_machine(), use_jit_link=SMALL)
    builder = binding.JITLibraryBuilder().add_current_process()
    for code in codes:
        builder.add_object_img(code)
    return builder.export_symbol(NAME).export_symbol(BATCH_NAME).link(linker, NAME)


def _target_machine() -> binding.TargetMachine:
    """Return the code generator for this processor."""
    return binding.Target.from_default_triple().create_target_machine(
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
        opt=1,
        reloc="pic" if SMALL else "default",
        codemodel="small" if SMALL else "jitdefault",
        jit=True,
    )
