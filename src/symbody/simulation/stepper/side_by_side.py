"""Blocks of steppers that are stepped side by side: one for each register, all in one array."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.codegen.llvm.machine import lanes
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.lanes.lane_block import LaneGroup
from symbody.simulation.native.lane_blocks import aligned_zeros, make_lane_block
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.stepper.compiled_steps import CompiledSteps

Floats = NDArray[np.float64]

_POINTER: Final = ctypes.c_void_p
_INTEGER: Final = ctypes.c_int64
# Trials of each lane between two looks at Ctrl-C.
_SLICE: Final = 1000
_VECTORS: Final = ("state_old", "stage", "state_new", "error_1", "error_2", "tolerances")


@cache
def step_all(features: frozenset[str]) -> Callable[..., int]:
    """Return the kernel that steps all lanes, ready to be called; `features` as for `step_kernel`."""
    kind = ctypes.CFUNCTYPE(_INTEGER, *[_POINTER] * 5, _INTEGER, _POINTER, *[_INTEGER] * 4)
    return kind(load_kernels("lane_stepping", ("step_all",), light=True, features=features)["step_all"])


class LaneBlocks:
    """The blocks of motions that are stepped together, and what steps them.

    Parameters
    ----------
    steps : sequence of CompiledSteps
        One for each lane; their blocks lie in this one from now on.
    rows : (N, size) array
        The numbers of the lanes, which steps renew.
    tableau : Tableau
        The method.

    Attributes
    ----------
    code : tuple of int
        Where the functions of all lanes lie.
    """

    def __init__(self, steps: Sequence[CompiledSteps], rows: Floats, tableau: Tableau) -> None:
        first, width = steps[0], lanes()
        largest = max((motion.block for motion in steps), key=len)
        wide = first.lane_function
        pattern = make_lane_block(largest, first.right_hand_side, wide.work_size, tableau)
        self._count, groups = len(steps), -(-len(steps) // width)
        self._all = aligned_zeros(groups * pattern.size).reshape(groups, pattern.size)
        self._all[:] = pattern
        begin, size = int(pattern[LaneGroup.layout["runs"]]), LaneGroup(pattern).run_size
        self._own = self._all[:, begin:].reshape(groups, width, size)
        self._width, self._size = width, size
        self._functions, self.code = first, first.code  # keeps the compiled code alive
        self._under_way = False
        self._kernel = step_all(first.features)
        self._arguments = (
            first.right_hand_side.address, wide.address, first.projects_by, first.gap_function,
            address(self._all), pattern.size, address(rows), rows.shape[1], self._count,
        )  # fmt: skip
        for lane in range(groups * width):  # lanes without a motion compute what the first one does
            self._fill(lane, steps[lane if lane < self._count else 0].block)
        for lane, motion in enumerate(steps):
            motion.move_to(self._row(lane))

    def take(self, lane: int, steps: CompiledSteps) -> bool:
        """Let other steps go on in a lane; return whether there is room for them."""
        if steps.block.size > self._size:
            return False
        Run(self._row(lane)).cases.current = -1
        self._fill(lane, steps.block)
        steps.move_to(self._row(lane))
        return True

    def step(self) -> bool:
        """Take a step in all lanes; return whether all came to its end."""
        begins = not self._under_way
        self._under_way = True
        kernel = self._kernel
        code = kernel(*self._arguments, begins, _SLICE)
        while code == at.RUNNING:
            code = kernel(*self._arguments, False, _SLICE)
        self._under_way = False
        return bool(code == at.FINISHED)

    @property
    def codes(self) -> list[int]:
        """How the last step of each lane ended."""
        codes: Floats = self._own[:, :, Run.layout["cases.lane_code"]].ravel()[: self._count]
        return [int(code) for code in codes]

    def _row(self, lane: int) -> Floats:
        row: Floats = self._own[lane // self._width, lane % self._width]
        return row

    def _fill(self, lane: int, block: Floats) -> None:
        """Fill the registers of a lane from the block of its motion."""
        group, run, width = LaneGroup(self._all[lane // self._width]), Run(block), self._width
        slopes = run.method.stage_rows * run.states
        narrow, wide = run.numbers, group.numbers
        for registers, own, size in (
            *((getattr(group, name), getattr(run, name), run.states) for name in _VECTORS),
            (group.slopes, run.slopes, slopes),
            (wide.parameters, narrow.parameters, narrow.parameter_count),
            (wide.constants, narrow.constants, narrow.constant_count),
        ):
            filled = np.asarray(registers)[: size * width].reshape(size, width)
            filled[:, lane % width] = np.asarray(own)[:size]
