"""Calls of native code with NumPy arrays: over a batch, and for one point."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.machine import lanes as widest
from symbody.codegen.llvm.native import NativeFunction, compile_sequence
from symbody.codegen.llvm.portable import compile_portable
from symbody.errors import Problem, SimulationError
from symbody.expr.sequences.sequence import KernelNode, Sequence
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
GROUPS: Final = ("t", "q", "u", "r", "p", "c")
_POINTER: Final = ctypes.c_void_p
_LONG: Final = ctypes.c_int64
_BYTES: Final = 8
_DOUBLE: Final = np.dtype(np.float64)
_SINGLE: Final = ctypes.CFUNCTYPE(ctypes.c_int, *[_POINTER] * (len(GROUPS) + 2))
_BATCH: Final = ctypes.CFUNCTYPE(
    ctypes.c_int, _LONG, *([_POINTER, _LONG] * len(GROUPS)), _POINTER, _LONG, _POINTER
)


# Lanes compile in about 40 us an operation and save about 0.1 ns an operation and point.
_POINTS_THAT_PAY: Final = 300_000

# Operations that are worth a thread: about a millisecond. One takes a tenth of that to start, and on a
# machine with other work several until it gets a processor, while the caller waits.
_WORTH_A_THREAD: Final = 5_000_000


class NativeCall:
    """Native code of one sequence, called over a batch.

    Parameters
    ----------
    sequence : Sequence
        What is computed.
    quick : bool
        Compile faster for slower calls.
    lanes : bool or None
        Whether batches are computed in lanes; None when so many points have been asked for that it pays.
        Results do not depend on it.
    portable : bool
        Whether no operation is fused; there are no lanes then.

    Attributes
    ----------
    native : NativeFunction
        The code for one point, held alive.
    """

    def __init__(
        self,
        sequence: Sequence,
        *,
        quick: bool = False,
        lanes: bool | None = None,
        portable: bool = False,
    ) -> None:
        self.sequence, self.output_size = sequence, sequence.output_size
        self.native: NativeFunction = (
            compile_portable(sequence) if portable else compile_sequence(sequence, quick=quick)
        )
        self._point = _SINGLE(self.native.address)
        self._points_left = {None: _POINTS_THAT_PAY, True: 0, False: sys.maxsize}[
            False if portable else lanes
        ]
        self._in_lanes: SingleFlight[None, NativeFunction] = SingleFlight()
        self._work = sequence.operation_count + sum(_kernel_work(kernel) for kernel in sequence.kernels)

    def __call__(self, given: Mapping[str, Floats], batch: tuple[int, ...], threads: int = 1) -> Floats:
        """Return (*batch, outputs) by at most `threads`; groups that are missing or empty are not read."""
        count = math.prod(batch)
        out = np.empty((count, self.output_size))
        points = _PointArrays(tuple(_rows(given.get(group), batch, count) for group in GROUPS), out)
        lanes = self._lanes_for(count)
        useful = max(1, min(threads, count * self._work // _WORTH_A_THREAD))
        part = max(1, -(-count // useful))
        if lanes is not None:  # whole lanes in each part but the last
            part = -(-part // lanes.width) * lanes.width
        starts = range(0, count, part)
        if len(starts) < 2:
            check_status(self._run_points(0, count, points, lanes))
        else:
            with ThreadPoolExecutor(len(starts) - 1) as pool:  # this thread takes the first part
                others = pool.map(
                    lambda k: self._run_points(k, min(k + part, count), points, lanes), starts[1:]
                )
                codes = [self._run_points(0, part, points, lanes), *others]
            check_status(next(filter(None, codes), 0))
        return out.reshape((*batch, out.shape[1]))

    def at_point(self, **given: Floats) -> Floats:
        """Return the outputs at one point, from the groups that are read, (n,) each.

        Raises
        ------
        SimulationError
            If a kernel could not be solved.
        """
        out, work = np.empty(self.output_size), np.empty(self.native.work_size)
        # Native code reads doubles that lie one after the other: slices and other byte orders are copied.
        arrays = {
            group: x if x.dtype is _DOUBLE and x.flags.c_contiguous else np.require(x, _DOUBLE, ["A", "C"])
            for group, x in given.items()
        }
        places = [address(arrays[group]) if group in arrays else None for group in GROUPS]
        check_status(self._point(*places, address(out), address(work)))
        return out

    def _lanes_for(self, count: int) -> NativeFunction | None:
        """Return the code in lanes if this batch is to use it, compiling it when it first is."""
        if count < widest():
            return None
        self._points_left -= count
        if self._points_left > 0:
            return None
        return self.in_lanes()

    def in_lanes(self) -> NativeFunction:
        """Return the code for several points at once, compiled when it is first asked for."""
        return self._in_lanes.get(None, lambda: compile_sequence(self.sequence, in_lanes=True))

    def _run_points(self, start: int, stop: int, points: _PointArrays, lanes: NativeFunction | None) -> int:
        """Compute some of the points and return the first status that is not 0."""
        blocks = 0 if lanes is None else (stop - start) // lanes.width
        # The scalar code computes the same again to find which point failed first, and how.
        if lanes is not None and blocks and points.compute(lanes, start, blocks) == 0:
            start += blocks * lanes.width
        return points.compute(self.native, start, stop - start)


@dataclass(frozen=True, slots=True)
class _PointArrays:
    """Rows of all groups with the distances of two rows, and rows of results."""

    rows: tuple[tuple[Floats, int], ...]
    out: Floats

    def compute(self, function: NativeFunction, start: int, count: int) -> int:
        """Call `function` for `count` points or blocks of points from row `start` on."""
        work, size = np.empty(function.work_size), self.out.shape[1]
        arguments = []
        for array, stride in self.rows:
            arguments += [address(array) + _BYTES * start * stride, stride]
        arguments += [address(self.out) + _BYTES * start * size, size, address(work)]
        return int(_BATCH(function.batch_address)(count, *arguments))


def _kernel_work(kernel: KernelNode) -> int:
    """Return about how many operations a kernel takes."""
    return (kernel.n + kernel.m) ** 3


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
    if values.ndim == 2 and values.shape[0] == count and values.flags.c_contiguous:
        return values, size
    return np.ascontiguousarray(np.broadcast_to(values, (*batch, size))).reshape(count, size), size
