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
        self._library = compiled_c(code, "casadi")
        self._out = [np.empty(function.numel_out(k)) for k in range(function.n_out())]
        self._iw, self._w = (
            np.empty(max(1, function.sz_iw()), dtype=np.int64),
            np.empty(max(1, function.sz_w())),
        )
        self._arguments = (ctypes.c_void_p * max(5, function.sz_arg()))()
        self._results = (ctypes.c_void_p * max(1, function.sz_res()))(*(out.ctypes.data for out in self._out))

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
