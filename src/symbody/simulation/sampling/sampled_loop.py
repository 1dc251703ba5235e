"""`SampledLoop`: held values inside the compiled loop of a motion."""

from __future__ import annotations

from collections.abc import Sequence

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
from symbody.simulation.native.description import LoopCall, RightHandSide
from symbody.simulation.native.machine import (
    advance_sampled,
    advance_sampled_watched,
    sample_kernels,
)
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

    def advance(self, call: LoopCall) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        code = run_at.NO_SAMPLE_ROOM
        while code == run_at.NO_SAMPLE_ROOM:
            own = self.sampler.block, self._numbers
            arrays = map(address, (call.block, *own, *call.record.arrays, self.sampler.record))
            code = advance_sampled()(call.rhs, call.projector, self.address, *arrays, call.trials)
            self.make_room(code)
        return code

    def advance_watched(
        self, call: LoopCall, functions: tuple[int, ...], watch: Floats, happened: Floats
    ) -> int:
        """Try up to so many steps, and let events happen; return a code of `symbody.kernels.block`.

        Parameters
        ----------
        functions : (3,) int
            Those of `kernels.event_watch.look`.
        watch : array
            See `symbody.kernels.events.event_monitor`.
        """
        self.show_watch(watch)
        code = run_at.NO_SAMPLE_ROOM
        while code == run_at.NO_SAMPLE_ROOM:
            own = self.sampler.block, self._numbers
            places = (call.block, watch, *own, *call.record.arrays, happened, self.sampler.record)
            code = advance_sampled_watched()(
                call.rhs, call.projector, *functions, self.address, *map(address, places), call.trials
            )
            self.make_room(code)
        return code

    @property
    def arrays(self) -> tuple[Floats, Floats]:
        """The block of the held values, and the numbers of their function."""
        return self.sampler.block, self._numbers

    @property
    def rows(self) -> Floats:
        """Where samples are written down."""
        return self.sampler.record

    def show_watch(self, watch: Floats) -> None:
        """Show the functions of events all values."""
        monitor = EventMonitor(watch)
        for numbers in (monitor.numbers, monitor.actions):
            if exists(numbers):
                sample_kernels().show_values(address(self.sampler.block), address(numbers.array))

    def make_room(self, code: int) -> None:
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
