"""What prescribed rates that jump do to the speeds, by `symbody.kernels.configurations.strike`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from symbody.analysis.derivatives import partial_derivatives, with_outputs
from symbody.analysis.scales import Scales
from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.codegen.native_call import check_status
from symbody.equations.equation_set import EquationSet
from symbody.kernels.configurations.strike import FAULT, strike_room
from symbody.kernels.configurations.strike_problem import StrikeProblem
from symbody.kernels.pack import pack
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.single_flight import once

_MOMENTA: Final = "momenta of the speeds"
_TORN: Final = 1e-5  # of the mechanism's size: more than a motion has drifted by then
_POINTER: Final = ctypes.c_void_p


def strike_equations(eqs: EquationSet) -> EquationSet:
    """Return equations with the momenta of their speeds among the outputs."""
    formed = eqs.formed

    def make() -> EquationSet:
        momenta = partial_derivatives(eqs, _MOMENTA, [formed.kinetic_energy.index], formed.u)
        return with_outputs(eqs, [momenta])

    made: EquationSet = eqs.plans.get(_MOMENTA, make)
    return made


def strike_outputs(eqs: EquationSet) -> tuple[str, ...]:
    """Return what the function of a strike writes."""
    closed = ("constraints", "velocity_constraints", "jacobian") if eqs.multiplier_names else ()
    return (*closed, _MOMENTA, "mass_matrix", "energy")


def strike_block(eqs: EquationSet, scales: Scales, sizes: Sequence[int], numbers: Floats) -> Floats:
    """Return the array of a `StrikeProblem`, whose function has outputs of so many numbers."""
    n = len(eqs.speed_names)
    count, rows, *_ = sizes if eqs.multiplier_names else (0, 0)
    return pack(
        StrikeProblem, speeds=n, positions=count, rows=rows, out_size=sum(sizes), room=strike_room(n, rows),
        numbers=numbers, limits=_TORN * scales.constraints(eqs)[:count],
    )  # fmt: skip


class Strike:
    """A jump of prescribed rates at one state of a motion.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.

    Attributes
    ----------
    block : StrikeProblem
        What was found.
    """

    def __init__(self, problem: SimulationProblem) -> None:
        eqs, laws, none = strike_equations(problem.eqs), problem.laws, np.zeros(0)
        function = replace(problem, eqs=eqs).compile_outputs(strike_outputs(eqs), quick=True)
        self._callback = CallbackFunction(function, laws) if laws.callbacks else None
        self._address = function.address if self._callback is None else self._callback.address
        inputs = laws.held_now()
        numbers = RightHandSide(
            0, len(eqs.speed_names), inputs, none, function.constants(), function.work_size
        )
        sizes = [len(output.values) for output in function.outputs]
        self._array = strike_block(eqs, problem.scales, sizes, function_numbers(numbers))
        self.block = StrikeProblem(self._array)

    def find_momenta(self, before: float, behind: float, x: Floats) -> Floats | None:
        """Return how prescribed rates change the momenta between two times; None if positions jump."""
        state = np.ascontiguousarray(x)
        self._check(_kernels()[0](self._address, address(self._array), before, behind, address(state)))
        return None if self.block.torn else -np.asarray(self.block.momenta)

    def change_speeds(self, x: Floats) -> bool:
        """Set the speeds to those behind the jump; return whether there are any."""
        return bool(_kernels()[1](address(self._array), address(x)) == 0)

    def energy_gained(self, t: float, x: Floats) -> float:
        """Return by how much the energy has risen at the state behind the jump [J]."""
        state = np.ascontiguousarray(x)
        self._check(_kernels()[2](self._address, address(self._array), t, address(state)))
        return self.block.gained

    def _check(self, code: int) -> None:
        if self._callback is not None and self._callback.error is not None:
            raise self._callback.error
        if code == FAULT:
            check_status(code)


@once
def _kernels() -> list[Callable[..., int]]:
    """Return `find_momenta`, `change_speeds` and `find_gain`, ready to be called."""
    names, real, integer = ("find_momenta", "change_speeds", "find_gain"), ctypes.c_double, ctypes.c_int64
    kinds: list[list[Any]] = [
        [_POINTER, _POINTER, real, real, _POINTER],
        [_POINTER] * 2,
        [_POINTER, _POINTER, real, _POINTER],
    ]
    addresses = load_kernels("strike", names, light=True)
    return [
        ctypes.CFUNCTYPE(integer, *kind)(addresses[name]) for name, kind in zip(names, kinds, strict=True)
    ]
