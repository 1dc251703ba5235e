"""Runs of the compiled loop by the generalized-alpha method; see `kernels.implicit.implicit_machine`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Final, NamedTuple

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.pack import pack
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import Floats, Record, RightHandSide
from symbody.simulation.native.run import EVENT_SAMPLES, begin_again, show_room
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.native.segments import Jumps, Watch
from symbody.single_flight import once

_POINTER: Final = ctypes.c_void_p
_INTEGER: Final = ctypes.c_int64


# What the loop reads of a method of order 2: slopes at both ends, how steps may shrink and grow. More growth
# would stir up what the method has damped.
METHOD: Final = Tableau(
    order=2, stages=1, A=((), (1.0,)), c=(0.0, 1.0), error=((), ()), dense=(), exponent=1.0 / 3.0,
    memory=0.0, shrink=0.2, growth=2.0, stiff_bound=1.0,
)  # fmt: skip


class Weights(NamedTuple):
    """The numbers of the method of Chung and Hulbert for a spectral radius at infinite frequency."""

    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float

    @classmethod
    def for_radius(cls, rho: float) -> Weights:
        """Return those of second order with the least damping of slow motions."""
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        return cls(alpha_m, alpha_f, gamma, 0.25 * (gamma + 0.5) ** 2)


class ImplicitFunctions(NamedTuple):
    """Compiled functions of one motion: slopes of all states, rates of coordinates, derivatives."""

    slopes: RightHandSide
    turns: RightHandSide
    derivatives: RightHandSide


class _Machine(NamedTuple):
    """The kernels as functions of addresses; none holds the interpreter's lock."""

    begin_implicit: Callable[..., int]
    advance_implicit: Callable[..., int]


@once
def implicit_machine() -> _Machine:
    """Return the integrator, ready to be called."""
    names = _Machine._fields
    places = load_kernels("implicit_machine", names)
    begin = ctypes.CFUNCTYPE(_INTEGER, *[_POINTER] * 7)
    advance = ctypes.CFUNCTYPE(_INTEGER, *[_POINTER] * 11, _INTEGER)
    return _Machine(begin(places[names[0]]), advance(places[names[1]]))


def make_array(functions: ImplicitFunctions, n: int, n_q: int, rho: float, *, one_length: bool) -> Floats:
    """Return the array of an `ImplicitStep`, for n states with the work and n_q coordinates.

    With `one_length` all steps have that of the first but those that end at a jump or at the end.
    """
    n_u, n_v, weights = functions.slopes.n_u, n - 1 - n_q, Weights.for_radius(rho)
    return pack(
        ImplicitStep, **weights._asdict(), lag=0.0 if rho == 1.0 else weights.alpha_m - weights.alpha_f,
        states=n, speeds=n_u, coordinates=n_q, unknowns=n_v, rates_size=n - 1, one_length=one_length,
        rate_numbers=function_numbers(functions.turns),
        derivative_numbers=function_numbers(functions.derivatives),
    )  # fmt: skip


class ImplicitRun(NamedTuple):
    """All arguments of the integrator but the record.

    Attributes
    ----------
    functions : ImplicitFunctions
        The compiled functions.
    projector : int
        The address of what closes the constraints; 0 if nothing does.
    block, array : arrays
        See `symbody.kernels.block` and `symbody.kernels.implicit.implicit_block`.
    """

    functions: ImplicitFunctions
    projector: int
    block: Floats
    array: Floats

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        places = (self.block, self.array, record.wanted, record.t, record.x, record.breaks)
        return implicit_machine().begin_implicit(self.functions.slopes.address, *map(address, places))

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        if watch is None:
            return self._advance(record, trials)
        code = at.RUNNING
        for _ in range(trials):
            is_full = record.every_step and Run(self.block).counts.samples + EVENT_SAMPLES > record.t.size
            code = watch.process(self.block, record, at.FULL if is_full else self._advance(record, 1))
            if code == at.RESTARTED:
                code = self.begin_anew(record)
            if code != at.RUNNING:
                break
        return code

    def begin_anew(self, record: Record, jumps: Jumps | None = None) -> int:
        """Go on from another state; return a code of `symbody.kernels.block`."""
        run = Run(self.block)
        run.after_rejection, run.counts.failed_kernel = 0.0, 0
        return begin_again(self, record)

    def _advance(self, record: Record, trials: int) -> int:
        places = (self.block, self.array, *record.arrays)
        slopes, turns, derivatives = (function.address for function in self.functions)
        return implicit_machine().advance_implicit(
            slopes, turns, derivatives, self.projector, *map(address, places), trials
        )
