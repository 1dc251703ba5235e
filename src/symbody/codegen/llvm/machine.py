"""LLVM's code generator: from text to object code, and what it makes code for."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence as Items
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

import llvmlite
import llvmlite.binding as binding
from llvmlite.binding import ffi

from symbody.expr.deadline import check
from symbody.single_flight import fork_safe_lock, once

# The small code model reaches constants relative to the instruction, where the one for code anywhere in
# memory loads a 64-bit address before each. It wants code and constants within 2 GB of each other, which
# JITLink grants; LLVM has no finished JITLink for Windows.
SMALL: Final = sys.platform != "win32"

# Held while several modules are compiled outside the lock of llvmlite.
_EMITTING: Final = fork_safe_lock()


def _begin_fork() -> None:
    """Wait until LLVM is at rest: what it holds while it compiles would be held in the copy for ever."""
    _EMITTING.acquire()
    ffi.lib._lock.__enter__()


def _end_fork() -> None:
    ffi.lib._lock.__exit__()
    _EMITTING.release()


if os.name == "posix":
    os.register_at_fork(before=_begin_fork, after_in_parent=_end_fork, after_in_child=_end_fork)

# LLVM's levels. With 0 it takes 0.3 to 0.5 of the time and calls take 1.5 to 3 times as long; so 1 pays from
# about 100,000 evaluations on.
QUICK: Final = 0
THOROUGH: Final = 1


@once
def _features() -> binding.targets.FeatureMap:
    """Return what this processor can do; looked up once, as it takes a millisecond."""
    return binding.get_host_cpu_features()


@once
def lanes() -> int:
    """Return how many doubles the widest registers of this processor hold, at least 2."""
    features = _features()
    return 8 if features.get("avx512f") else 4 if features.get("avx") else 2


def object_codes(texts: Items[str], level: int) -> list[bytes]:
    """Return the object code of each module; several are compiled at once."""
    if len(texts) < 2:
        return [_object_code(text, level) for text in texts]
    initialize()
    with _EMITTING, ThreadPoolExecutor(min(len(texts), os.cpu_count() or 1)) as pool:
        waiting = [pool.submit(_compile_without_lock, text, level) for text in texts]
        try:
            return [_in_time(piece) for piece in waiting]
        finally:  # leaving the pool waits for those that have begun
            for piece in waiting:
                piece.cancel()


def optimized_code(text: str, *, vectors: bool = False) -> bytes:
    """Return the object code of a module of loops and variables in memory, which LLVM's passes improve.

    No pass changes a result: the text grants no freedom to reorder or fuse operations. With `vectors`, loops
    compute several entries at once: twice the code, which pays for long loops.
    """
    initialize()
    module = binding.parse_assembly(text, binding.create_context())
    machine = target_machine()
    options = binding.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = vectors
    options.slp_vectorization = options.loop_unrolling = False
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def light_code(text: str) -> bytes:
    """Return the object code of a module whose variables move from memory to registers, and no more.

    Kernels of known sizes gain nothing by other passes; those of any size lose 10 % and compile in a third of
    the time.
    """
    initialize()
    module = binding.parse_assembly(text, binding.create_context())
    machine = target_machine()
    options = binding.create_pipeline_tuning_options(speed_level=1)
    builder = binding.create_pass_builder(machine, options)
    passes = binding.create_new_function_pass_manager()
    passes.add_sroa_pass()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)
    return bytes(machine.emit_object(module))


def _in_time(piece: Future[bytes]) -> bytes:
    code = piece.result()
    check()
    return code


def target_machine(level: int = THOROUGH) -> binding.TargetMachine:
    """Return the code generator for this processor."""
    initialize()
    return binding.Target.from_default_triple().create_target_machine(
        cpu=binding.get_host_cpu_name(),
        features=_features().flatten(),
        opt=level,
        reloc="pic" if SMALL else "default",
        codemodel="small" if SMALL else "jitdefault",
        jit=True,
    )


@once
def initialize() -> None:
    """Make LLVM ready for this processor, once in a process."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


@once
def environment() -> str:
    """Return the key of object code apart from its text."""
    features = _features().flatten()
    versions = f"{llvmlite.__version__} {binding.llvm_version_info}"
    return f"{versions} {binding.get_default_triple()} {binding.get_host_cpu_name()} {features} {SMALL}"


def _object_code(text: str, level: int) -> bytes:
    initialize()
    module = binding.parse_assembly(text, binding.create_context())
    return bytes(target_machine(level).emit_object(module))


def _compile_without_lock(text: str, level: int) -> bytes:
    """Compile `text` while other threads compile others.

    llvmlite guards every call by one lock, so threads gain nothing through it. LLVM itself asks only
    that threads share no context and no target machine [LLVM Programmer's Manual, "Threads and LLVM"].
    """
    initialize()
    module = binding.parse_assembly(text, binding.create_context())
    machine = target_machine(level)
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
