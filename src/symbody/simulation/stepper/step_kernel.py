"""The kernel that computes one step, as machine code."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import NamedTuple

from symbody.codegen.kernel_call import kernel_call
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.single_flight import once

_POINTER = ctypes.c_void_p
_STEP = ctypes.CFUNCTYPE(ctypes.c_int64, *[_POINTER] * 4, ctypes.c_int64)


class StepKernel(NamedTuple):
    """Where the kernel lies, and a function that releases the interpreter's lock while it runs."""

    address: int
    unlocked: Callable[..., int]


@once
def step_kernel() -> StepKernel:
    """Return the kernel, ready to be called."""
    address = load_kernels("stepping", ("step",))["step"]
    return StepKernel(address, _STEP(address))


def bound_step(pointers: tuple[int, int, int, int], trials: int) -> Callable[[], int]:
    """Return a function that tries so many steps of the integrator with numbers at these places."""
    kernel = step_kernel()
    quick = kernel_call(kernel.address, pointers, trials)

    def call_slowly() -> int:
        return kernel.unlocked(*pointers, trials)

    return call_slowly if quick is None else quick
