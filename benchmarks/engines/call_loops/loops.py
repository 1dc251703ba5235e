"""The compiled loops: what a call takes to a program that is compiled itself."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

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


def compiled_c(source: str, stem: str, folder: Path | None = None) -> tuple[ctypes.CDLL, Path]:
    """Return C text as a library, and its file; compiled if the folder does not have it.

    Parameters
    ----------
    source : str
        The text.
    stem : str
        How the file's name begins.
    folder : Path, optional
        An empty one where compiling is timed; that of `kept_folder` if None.

    Raises
    ------
    OSError
        If there is no C compiler.
    """
    compiler = c_compiler()
    if compiler is None:
        raise OSError("there is no C compiler")
    key = hashlib.sha256((source + " ".join(FLAGS)).encode()).hexdigest()[:12]
    library = (folder or kept_folder()) / f"{stem}_{key}.so"
    if not library.is_file():
        library.parent.mkdir(parents=True, exist_ok=True)
        text = library.with_suffix(".c")
        text.write_text(source, encoding="utf-8")
        half_done = library.with_suffix(f".{os.getpid()}")
        subprocess.run([compiler, *FLAGS, str(text), "-o", str(half_done), "-lm"], check=True)
        half_done.replace(library)
    return ctypes.CDLL(str(library)), library


@cache
def loops() -> ctypes.CDLL:
    """Return the loops."""
    library, _ = compiled_c(SOURCE.read_text(encoding="utf-8"), "call_loops")
    for name in ("time_symbody", "time_casadi", "time_mujoco"):
        getattr(library, name).restype = ctypes.c_double
    return library


def rows(*groups: Floats) -> list[object]:
    """Return address and width of each array of rows."""
    found: list[object] = []
    for group in groups:
        found += [ctypes.c_void_p(group.ctypes.data), ctypes.c_long(group.shape[1])]
    return found


def nanoseconds_a_call(
    address: int | None,
    q: Floats,
    u: Floats,
    r: Floats,
    *,
    out: int,
    work: int,
    constants: Floats | None = None,
) -> float:
    """Return what a call of a function in symbody's form takes, state after state [ns].

    Parameters
    ----------
    address : int
        Of the function ``f(t, q, u, r, p, c, out, work)``.
    q, u, r : arrays
        Inputs, one state a row.
    out, work : int
        Numbers it writes, and those it needs to work.
    constants : array, optional
        What a compiled function of symbody takes as c.
    """
    buffers = [np.zeros(0) if constants is None else constants, np.empty(out), np.zeros(work)]
    pointers = [ctypes.c_void_p(buffer.ctypes.data) for buffer in buffers]
    given = rows(q, u, r)
    took: float = loops().time_symbody(ctypes.c_void_p(address), ctypes.c_long(len(q)), *given, *pointers)
    return took
