"""Pinocchio's algorithms of one robot as C that CasADi writes and the machine's compiler optimizes."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi
import numpy as np

from benchmarks.engines.call_loops.loops import Floats, compiled_c, loops, rows


def instructions(program: Path, model: Path, task: str, folder: Path) -> int:
    """Return the number of instructions of a function, whose C stands in ``folder/task.c`` then."""
    command = [program, model, task, f"{folder}"]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


class CasadiCalls:
    """A function of q, v and x, from its C."""

    def __init__(self, source: Path) -> None:
        library, path = compiled_c(source.read_text(encoding="utf-8"), source.stem, source.parent)
        function: Any = casadi.external("f", str(path))
        self._library, self.function = library, function
        self._out = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
        self._iw = np.empty(max(1, function.sz_iw()), dtype=np.int64)
        self._w = np.empty(max(1, function.sz_w()))
        self._arguments = (ctypes.c_void_p * max(5, function.sz_arg()))()
        pointers = [out.ctypes.data for out in self._out]
        pointers += [0] * (function.sz_res() - len(pointers))
        self._results = (ctypes.c_void_p * len(pointers))(*pointers)

    def results(self, q: Floats, v: Floats, x: Floats) -> list[Floats]:
        """Return each output at each state as a matrix, computed by the same code."""
        found: list[list[Floats]] = [[] for _ in self._out]
        for k in range(len(q)):
            self.nanoseconds(q[k : k + 1], v[k : k + 1], x[k : k + 1])
            for j, out in enumerate(self._out):
                pattern = self.function.sparsity_out(j)
                full = np.zeros(pattern.shape)
                full[pattern.row(), pattern.get_col()] = out
                found[j].append(full[:, 0] if full.shape[1] == 1 else full)
        return [np.array(x) for x in found]

    def nanoseconds(self, q: Floats, v: Floats, x: Floats) -> float:
        """Return what a call takes, state after state [ns]."""
        took: float = loops().time_casadi(
            ctypes.cast(self._library.f, ctypes.c_void_p),
            ctypes.c_long(len(q)),
            *rows(q, v, x),
            self._results,
            self._arguments,
            ctypes.c_void_p(self._iw.ctypes.data),
            ctypes.c_void_p(self._w.ctypes.data),
        )
        return took

    def from_python(self, q: Floats, v: Floats, x: Floats) -> Callable[[int], object]:
        """Return a call for a state by its number: with buffers, as CasADi advises for speed."""
        buffer, trigger = self.function.buffer()
        given = [np.empty(group.shape[1]) for group in (q, v, x)]
        taken = [np.empty(self.function.nnz_out(k)) for k in range(self.function.n_out())]
        for k, array in enumerate(given):
            buffer.set_arg(k, memoryview(array))
        for k, array in enumerate(taken):
            buffer.set_res(k, memoryview(array))
        kept = list(zip(list(q), list(v), list(x), strict=True))
        first, second, third = given

        def call(k: int) -> object:
            first[:], second[:], third[:] = kept[k]
            trigger()
            return [array.copy() for array in taken]

        call.buffer = buffer  # type: ignore[attr-defined]  # `trigger` does not keep it alive

        return call
