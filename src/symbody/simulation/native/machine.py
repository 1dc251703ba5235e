"""The integrator as machine code: `symbody.kernels.step_machine`, compiled once on a computer."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Collection, Mapping
from functools import cache
from typing import Any, Final, NamedTuple

from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.single_flight import once

_POINTER: Final = ctypes.c_void_p
_INTEGER: Final = ctypes.c_int64
_REAL: Final = ctypes.c_double
_RECORD: Final = [_POINTER] * 5  # times, t, x, breaks, pieces

# Results and arguments, f and g and the block first.
# What `advance_motion` takes, in this order; behind it how many steps.
LOOP: Final = (
    "f", "k", "j", "g", "e", "a", "c", "h", "s", "d", "w", "run", "implicit", "monitor", "held", "Q", "jumps",
    "modes", "times", "t", "x", "breaks", "pieces", "H", "Y", "Z",
)  # fmt: skip

_SIGNATURES: Final[Mapping[str, tuple[Any, list[Any]]]] = {
    "begin": (_INTEGER, [_POINTER, _POINTER, *_RECORD[:4]]),
    "advance": (_INTEGER, [*[_POINTER] * 4, *_RECORD, _INTEGER]),
    "advance_motion": (_INTEGER, [*[_POINTER] * len(LOOP), _INTEGER]),
    "break_off": (_INTEGER, [_POINTER] * 10),
    "begin_given": (_INTEGER, [_POINTER, *_RECORD[:4]]),
    "keep_given": (None, [_POINTER, _POINTER, *_RECORD, _REAL]),
    "process_given": (_INTEGER, [*[_POINTER] * 10, _INTEGER]),
    "project": (_REAL, [_POINTER, _POINTER, _REAL, _POINTER]),
    "longest_step": (None, [_POINTER, _REAL, _POINTER]),
    "take_samples": (_INTEGER, [*[_POINTER] * 4, _REAL, _POINTER]),
    "show_values": (None, [_POINTER, _POINTER]),
    "is_due": (_INTEGER, [_POINTER, _REAL]),
    "run_cases": (
        _INTEGER,
        [
            *[_POINTER] * 9,
            _INTEGER,
            *[_POINTER] * 2,
            _INTEGER,
            _POINTER,
            *[_INTEGER] * 2,
            *[_POINTER] * 11,
            _INTEGER,
        ],
    ),
    # How many cases, of which size, in which rows; times, t, x, verdicts; how many steps.
    "run_lanes": (_INTEGER, [*[_POINTER] * 4, _INTEGER, _INTEGER, *[_POINTER] * 5, _INTEGER]),
}


class StepMachine(NamedTuple):
    """The kernels of one motion as functions of addresses and numbers.

    None of the functions of this file holds the interpreter's lock.
    """

    begin: Callable[..., int]
    advance: Callable[..., int]
    project: Callable[..., float]
    longest_step: Callable[..., None]


class GivenSteps(NamedTuple):
    """The kernels of steps that others take."""

    begin_given: Callable[..., int]
    keep_given: Callable[..., None]
    process_given: Callable[..., int]
    break_off: Callable[..., int]


class SampleKernels(NamedTuple):
    """The kernels of held values outside the compiled loop."""

    take_samples: Callable[..., int]
    show_values: Callable[..., None]
    is_due: Callable[..., int]


@cache
def advance_motion(features: frozenset[str]) -> Callable[..., int]:
    """Return the loop of motions that have something, see `symbody.kernels.features`, ready to be called."""
    light = "EVENTS" not in features or bool(features & {"MODES", "JUMPS", "IMPLICIT"})
    return _functions("motion_loop", "advance_motion", light=light, features=features)[0]


@once
def sample_kernels() -> SampleKernels:
    """Return what takes samples, ready to be called."""
    return SampleKernels(*_functions("sampling", *SampleKernels._fields, light=True))


@once
def given_steps() -> GivenSteps:
    """Return what keeps steps that others take, ready to be called."""
    return GivenSteps(*_functions("given_steps", *GivenSteps._fields))


@once
def step_machine() -> StepMachine:
    """Return the integrator of one motion, ready to be called."""
    # All of LLVM's passes would take three times as long, and save 0 to 5 % of a small motion.
    return StepMachine(*_functions("step_machine", *StepMachine._fields, light=True, features=()))


@cache
def many_motions(features: frozenset[str]) -> Callable[..., int]:
    """Return `run_cases` for motions that have something, ready to be called."""
    return _functions("many_motions", "run_cases", light=True, features=features)[0]


@once
def lane_motions() -> Callable[..., int]:
    """Return `run_lanes`, ready to be called."""
    return _functions("lane_motions", "run_lanes", features=())[0]


def _functions(
    module: str, *names: str, light: bool = False, features: Collection[str] | None = None
) -> list[Callable[..., Any]]:
    addresses = load_kernels(module, names, light=light, features=features)
    kinds = [
        ctypes.CFUNCTYPE(result, *arguments) for result, arguments in map(_SIGNATURES.__getitem__, names)
    ]
    return [kind(addresses[name]) for kind, name in zip(kinds, names, strict=True)]
