"""The integrator as machine code: `symbody.kernels.step_machine`, compiled once on a computer."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.simulation.native.description import Floats
from symbody.single_flight import once

_POINTER: Final = ctypes.c_void_p
_INTEGER: Final = ctypes.c_int64
_REAL: Final = ctypes.c_double
_RECORD: Final = [_POINTER] * 5  # times, t, x, breaks, pieces

# How many cases, of which size, in which rows; times, t, x, verdicts; how many steps.
_CASES: Final = [_INTEGER, _INTEGER, *[_POINTER] * 5, _INTEGER]

# Results and arguments, f and g and the block first.
_SIGNATURES: Final[Mapping[str, tuple[Any, list[Any]]]] = {
    "begin": (_INTEGER, [_POINTER, _POINTER, *_RECORD[:4]]),
    "advance": (_INTEGER, [_POINTER, _POINTER, _POINTER, *_RECORD, _INTEGER]),
    "project": (_REAL, [_POINTER, _POINTER, _REAL, _POINTER]),
    "longest_step": (None, [_POINTER, _REAL, _POINTER]),
    "run_cases": (_INTEGER, [*[_POINTER] * 3, *_CASES]),
    "run_lanes": (_INTEGER, [*[_POINTER] * 4, *_CASES]),
}


class StepMachine(NamedTuple):
    """The kernels as functions of addresses and numbers; none holds the interpreter's lock."""

    begin: Callable[..., int]
    advance: Callable[..., int]
    project: Callable[..., float]
    longest_step: Callable[..., None]
    run_cases: Callable[..., int]
    run_lanes: Callable[..., int]


@once
def step_machine() -> StepMachine:
    """Return the integrator, ready to be called."""
    addresses = load_kernels("lane_motions", tuple(_SIGNATURES))
    functions = [
        ctypes.CFUNCTYPE(result, *arguments)(addresses[name])
        for name, (result, arguments) in _SIGNATURES.items()
    ]
    return StepMachine(*functions)


def address(array: Floats) -> int:
    """Return where an array lies."""
    return array.ctypes.data
