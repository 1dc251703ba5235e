"""Our own recursion as C that CasADi writes and the machine's compiler optimizes."""

from __future__ import annotations

import ctypes
import runpy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import casadi
import numpy as np

import symbody as sb
from benchmarks.engines.call_loops.loops import Floats, compiled_c, loops, rows


class CasadiCalls:
    """A function in C by CasADi from the text that `generate_code` writes for it."""

    def __init__(self, eqs: sb.EquationSet, outputs: list[str]) -> None:
        with TemporaryDirectory() as folder:
            text = Path(folder, "f.py")
            text.write_text(sb.generate_code(eqs, outputs, "casadi", {}), encoding="utf-8")
            function: Any = runpy.run_path(str(text))["f"]
        generator: Any = casadi.CodeGenerator("f")
        generator.add(function)
        code = str(generator.dump())
        self.function = function
        self._library = compiled_c(code, "casadi")
        self._out = [np.empty(function.numel_out(k)) for k in range(function.n_out())]
        self._iw, self._w = (
            np.empty(max(1, function.sz_iw()), dtype=np.int64),
            np.empty(max(1, function.sz_w())),
        )
        self._arguments = (ctypes.c_void_p * max(5, function.sz_arg()))()
        self._results = (ctypes.c_void_p * max(1, function.sz_res()))(*(out.ctypes.data for out in self._out))

    def results(self, q: Floats, u: Floats, r: Floats) -> list[Floats]:
        """Return each output at each state, flat and row by row, computed by the same code."""
        found: list[list[Floats]] = [[] for _ in self._out]
        for k in range(len(q)):
            self.nanoseconds(q[k : k + 1], u[k : k + 1], r[k : k + 1])
            for j, out in enumerate(self._out):
                shape = self.function.size_out(j)
                found[j].append(out.reshape(shape, order="F").flatten())
        return [np.array(x) for x in found]

    def nanoseconds(self, q: Floats, u: Floats, r: Floats) -> float:
        """Return what a call takes, state after state [ns]."""
        took: float = loops().time_casadi(
            ctypes.cast(self._library.f, ctypes.c_void_p),
            ctypes.c_long(len(q)),
            *rows(q, u, r),
            self._results,
            self._arguments,
            ctypes.c_void_p(self._iw.ctypes.data),
            ctypes.c_void_p(self._w.ctypes.data),
        )
        return took
