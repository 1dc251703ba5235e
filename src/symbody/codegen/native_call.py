"""Calls of native code with NumPy arrays: over a batch, and for one point without ceremony."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from threading import local
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.llvm import NativeFunction, compile_sequence
from symbody.errors import Problem, SimulationError
from symbody.expr.sequence import Sequence

Floats = NDArray[np.float64]
GROUPS: Final = ("t", "q", "u", "r", "p", "c")
_POINTER: Final = ctypes.c_void_p
_LONG: Final = ctypes.c_int64
_SINGLE: Final = ctypes.CFUNCTYPE(ctypes.c_int, *[_POINTER] * (len(GROUPS) + 2))
_BATCH: Final = ctypes.CFUNCTYPE(
    ctypes.c_int, _LONG, *([_POINTER, _LONG] * len(GROUPS)), _POINTER, _LONG, _POINTER
)


class NativeCall:
    """Native code of one sequence, called over a batch.

    Attributes
    ----------
    sequence : Sequence
        What is computed.
    native : NativeFunction
        The code, held alive.
    """

    def __init__(self, sequence: Sequence) -> None:
        self.sequence = sequence
        self.native: NativeFunction = compile_sequence(sequence)
        self._call = _BATCH(self.native.batch_address)

    def __call__(self, given: Mapping[str, Floats], batch: tuple[int, ...]) -> Floats:
        """Return (*batch, outputs); groups that are missing or empty are not read."""
        count = int(np.prod(batch, dtype=np.int64))
        size = self.sequence.output_size
        out = np.empty((count, size))
        work = np.empty(self.native.work_size)
        held, arguments = [], []
        for group in GROUPS:
            rows, stride = _rows(given.get(group), batch, count)
            held.append(rows)
            arguments += [rows.ctypes.data, stride]
        check_status(self._call(count, *arguments, out.ctypes.data, size, work.ctypes.data))
        return out.reshape((*batch, size))


class SinglePoint(local):
    """Scratch of one thread for calls at a single point, addresses taken once.

    Parameters
    ----------
    call : NativeCall
        What is called.
    sizes : mapping of group to int
        Numbers in each group.
    """

    def __init__(self, call: NativeCall, sizes: Mapping[str, int]) -> None:
        self.groups = {group: np.zeros(sizes.get(group, 0)) for group in GROUPS}
        self.out = np.empty(call.sequence.output_size)
        self._work = np.empty(call.native.work_size)
        self._function = _SINGLE(call.native.address)
        arrays = [*self.groups.values(), self.out, self._work]
        self._addresses = [array.ctypes.data for array in arrays]

    def run(self) -> Floats:
        """Return the outputs for what stands in `groups`; a view that the next call overwrites."""
        check_status(self._function(*self._addresses))
        return self.out


def check_status(status: int) -> None:
    """Raise what a native status means.

    Raises
    ------
    SimulationError
        If a kernel could not be solved.
    """
    if status:
        raise SimulationError(
            Problem("numerics.singular_mass", "", "the mass matrix is singular on the admissible velocities",
                    "a body without mass or inertia can move freely", "give it mass or inertia")
        )  # fmt: skip


def _rows(values: Floats | None, batch: tuple[int, ...], count: int) -> tuple[Floats, int]:
    """Return a contiguous array of rows and the distance of two rows; 0 repeats the one row."""
    if values is None or values.shape[-1] == 0:
        return np.zeros(1), 0
    if values.ndim == 1 or values.shape[:-1] == (1,) * (values.ndim - 1):
        return np.ascontiguousarray(values).reshape(-1), 0
    size = values.shape[-1]
    return np.ascontiguousarray(np.broadcast_to(values, (*batch, size))).reshape(count, size), size
