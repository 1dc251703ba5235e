"""The compiled loops: what a call takes to a program that is compiled itself."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction

Floats = NDArray[np.float64]

SOURCE: Final = Path(__file__).with_name("call_loops.c")
FLAGS: Final = ("-O3", "-march=native", "-fPIC", "-shared", "-w")
VARIABLE: Final = "SYMBODY_BENCHMARKS"


def kept_folder() -> Path:
    """Return the folder in which compiled peers are kept."""
    return Path(os.environ.get(VARIABLE, "") or Path.home() / ".cache" / "symbody_benchmarks")


def c_compiler() -> str | None:
    """Return the C compiler, if there is one."""
    return shutil.which(os.environ.get("CC", "")) or shutil.which("cc") or shutil.which("gcc")


def compiled_c(source: str, stem: str) -> ctypes.CDLL:
    """Return C text as a library, compiled if the same text was not before.

    Raises
    ------
    OSError
        If there is no C compiler.
    """
    compiler = c_compiler()
    if compiler is None:
        raise OSError("there is no C compiler")
    key = hashlib.sha256((source + " ".join(FLAGS)).encode()).hexdigest()[:12]
    library = kept_folder() / f"{stem}_{key}.so"
    if not library.is_file():
        library.parent.mkdir(parents=True, exist_ok=True)
        text = library.with_suffix(".c")
        text.write_text(source, encoding="utf-8")
        half_done = library.with_suffix(f".{os.getpid()}")
        subprocess.run([compiler, *FLAGS, str(text), "-o", str(half_done), "-lm"], check=True)
        half_done.replace(library)
    return ctypes.CDLL(str(library))


@cache
def loops() -> ctypes.CDLL:
    """Return the loops."""
    library = compiled_c(SOURCE.read_text(encoding="utf-8"), "call_loops")
    for name in ("time_symbody", "time_casadi", "time_mujoco"):
        getattr(library, name).restype = ctypes.c_double
    return library


def rows(*groups: Floats) -> list[object]:
    """Return address and width of each array of rows."""
    found: list[object] = []
    for group in groups:
        found += [ctypes.c_void_p(group.ctypes.data), ctypes.c_long(group.shape[1])]
    return found


def nanoseconds_a_call(f: CompiledFunction, q: Floats, u: Floats, r: Floats, scratch: float = 0.0) -> float:
    """Return what a call of a compiled function takes, state after state [ns]; `scratch` fills its own."""
    constants = f.constants()
    out, work = np.empty(sum(len(o.values) for o in f.sequence.outputs)), np.full(f.work_size, scratch)
    given = rows(q, u, r)
    buffers: Sequence[Floats] = (constants, out, work)
    pointers = [ctypes.c_void_p(buffer.ctypes.data) for buffer in buffers]
    took: float = loops().time_symbody(ctypes.c_void_p(f.address), ctypes.c_long(len(q)), *given, *pointers)
    return took
