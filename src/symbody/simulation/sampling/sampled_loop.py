"""`SampledLoop`: held values inside the compiled loop of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.native_call import check_status
from symbody.errors import Problem, UsageError
from symbody.expr.sequences.sequence import Output
from symbody.kernels import block as run_at
from symbody.kernels.block import FunctionNumbers, Run
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.record_layout import exists
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import RightHandSide
from symbody.simulation.native.machine import sample_kernels
from symbody.simulation.sampling.sampler import HeldValue, Sampler
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]


class SampledLoop:
    """Takes the samples of one motion.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.
    sampler : Sampler
        The values, which may come from a motion before.

    Attributes
    ----------
    address : int
        Where the function of new values lies.

    Raises
    ------
    FormulationError
        If a formula of a value has no meaning.
    UsageError
        If it is not a number but a vector or matrix.
    """

    feature = "SAMPLES"

    def __init__(self, problem: SimulationProblem, sampler: Sampler) -> None:
        self.sampler = sampler
        laws = problem.laws
        self._function = problem.compile_outputs(sampler.formulas)
        check_numbers(sampler.values, self._function.outputs)
        self._callback = CallbackFunction(self._function, laws) if laws.need_python else None
        self.address = self._function.address if self._callback is None else self._callback.address
        self._numbers = function_numbers(
            RightHandSide(
                0, len(problem.eqs.speed_names), laws.held_now(), np.zeros(0),
                self._function.constants(), self._function.work_size, laws.table_numbers(),
            )
        )  # fmt: skip

    def begin(self, block: Floats) -> None:
        """Go back to where a motion begins, and show the right-hand side all values."""
        run = Run(block)
        self.sampler.rewind(run.time)
        sample_kernels().show_values(address(self.sampler.block), address(run.numbers.array))

    def take(self, t: float, x: Floats) -> None:
        """Take the samples that are due at a time and state (u, q, s, ..).

        Raises
        ------
        SimulationError
            If a function fails.
        """
        sampler = self.sampler
        if not sample_kernels().is_due(address(sampler.block), t):
            return
        if sampler.hold.recorded == sampler.hold.room:
            sampler.grow()
        places = map(address, (self._numbers, sampler.block, sampler.record))
        if sample_kernels().take_samples(self.address, *places, t, address(x)):
            self._raise_fault()

    def show_inputs(self, slots: NDArray[np.intp], values: Floats) -> None:
        """Set other inputs of the function of new values."""
        np.asarray(FunctionNumbers(self._numbers).inputs)[slots] = values

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return the function, values, its numbers, and where samples are written down."""
        sampler = self.sampler
        return {"h": self.address, "held": sampler.block, "Q": self._numbers, "Y": sampler.record}

    def show_watch(self, watch: Floats) -> None:
        """Show the functions of events all values."""
        monitor = EventMonitor(watch)
        for numbers in (monitor.numbers, monitor.actions):
            if exists(numbers):
                sample_kernels().show_values(address(self.sampler.block), address(numbers.array))

    def answer(self, code: int) -> None:
        """Make room for as many more samples, or raise a fault, if the code of a loop asks for it."""
        if code == run_at.NO_SAMPLE_ROOM:
            self.sampler.grow()
        if code == run_at.SAMPLE_FAULT:
            self._raise_fault()

    def _raise_fault(self) -> None:
        """Raise what a law of an input raised, or what the status of the function means."""
        if self._callback is not None and self._callback.error is not None:
            raise self._callback.error
        check_status(self.sampler.hold.fault)


def check_numbers(values: Sequence[HeldValue], outputs: Sequence[Output]) -> None:
    """Refuse values that are vectors or matrices.

    Raises
    ------
    UsageError
        Naming them.
    """
    problems = [
        Problem("signal.no_number", f"signal {value.name}", f"its value has shape {output.shape}",
                "a signal is a single number at each time", "name one component, such as 'reaction A Fx'")
        for value, output in zip(values, outputs, strict=True) if output.shape
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
