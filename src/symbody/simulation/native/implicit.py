"""Runs of the compiled loop by the generalized-alpha method; see `kernels.implicit.implicit_machine`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.pack import pack
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.native.runge_kutta import Tableau
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


@once
def begin_implicit() -> Callable[..., int]:
    """Return `kernels.implicit.implicit_machine.begin_implicit`, ready to be called."""
    place = load_kernels("implicit_machine", ("begin_implicit",), light=True)["begin_implicit"]
    return ctypes.CFUNCTYPE(_INTEGER, *[_POINTER] * 7)(place)


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


class ImplicitPart:
    """Implicit steps in the compiled loop; see `native.description.LoopPart`.

    Parameters
    ----------
    functions : ImplicitFunctions
        The compiled functions.
    array : array
        See `symbody.kernels.implicit.implicit_block`.
    """

    feature = "IMPLICIT"

    def __init__(self, functions: ImplicitFunctions, array: Floats) -> None:
        self._functions, self.array = functions, array

    def begin(self, rhs: int, block: Floats, places: Sequence[Floats]) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        return begin_implicit()(rhs, address(block), address(self.array), *map(address, places))

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return functions and numbers of implicit steps."""
        _, turns, derivatives = (function.address for function in self._functions)
        return {"k": turns, "j": derivatives, "implicit": self.array}

    def answer(self, code: int) -> None:
        """Do nothing: it wants no room."""
