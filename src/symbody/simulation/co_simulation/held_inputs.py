"""`HeldInputs`: inputs that are held between samples which are taken between pieces of a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.co_simulation.fmu_unit import open_unit
from symbody.simulation.co_simulation.sampled_unit import SampledUnit, by_instance, make_reader, read_values
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inputs.time_functions import function_of_time
from symbody.simulation.sampling.sampled_loop import SampledLoop
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]

# Shares of the shortest step within which two times are one.
_ONE_INSTANT: Final = 1e-6
_ZERO: Final = Table((0.0, 1.0), (0.0, 0.0))


class HeldInputs:
    """Inputs that FMUs compute, and sampled signals where a method does not take their samples on the way.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.
    fmus : mapping of str to FmuInput
        The inputs that FMUs compute.
    span : tuple of float
        Of the motion [s].
    x : array
        Its first state (u, q, s).
    stack : ExitStack
        Closes the FMUs.
    sampler : Sampler or None
        Holds the signals that are sampled here.

    Attributes
    ----------
    problem : SimulationProblem
        With what is held at present as constants.
    width : float
        Times closer to a sample are the same time [s].

    Raises
    ------
    UsageError
        If the motion runs backwards, or an FMU cannot be used.
    SimulationError
        If an FMU fails, or cannot be given what it reads.
    """

    def __init__(
        self, problem: SimulationProblem, fmus: Mapping[str, FmuInput], span: tuple[float, float], x: Floats,
        stack: ExitStack, sampler: Sampler | None,
    ) -> None:  # fmt: skip
        _check_direction(fmus, span)
        self._first = problem
        self._sampler = sampler
        if sampler is not None:
            sampler.rewind(span[0])
        self._is_switched = (bool(fmus) or sampler is not None) and _is_switched(problem)
        self._held = dict.fromkeys(fmus, 0.0)
        self._record: list[tuple[float, dict[str, float]]] = []  # samples, and what was held from then on
        self._units = [_unit(problem, group, self._held, (span[0], x), stack) for group in by_instance(fmus)]
        periods = [unit.period for unit in self._units]
        self.width = _ONE_INSTANT * min(periods, default=0.0)
        self._sampled = _with_values(problem, self._held) if fmus else problem
        self.problem = self._with_signals()

    @property
    def due(self) -> float:
        """When the next sample is taken [s]; infinite without any."""
        first = math.inf if self._sampler is None else self._sampler.next_due
        return min([first, *(unit.due for unit in self._units)])

    def is_due(self, t: float) -> bool:
        """Return whether a sample is due at a time."""
        signals = self._sampler is not None and self._sampler.is_due(t)
        return signals or any(unit.due <= t + self.width for unit in self._units)

    def sample(self, t: float, x: Floats) -> None:
        """Take the samples that are due at a time and state (u, q, s): of signals, then of FMUs.

        All FMUs compute from the values held until now.

        Raises
        ------
        SimulationError
            If an FMU fails, or a value is not finite.
        """
        self.sample_signals(t, x)
        due = [unit for unit in self._units if unit.due <= t + self.width]
        given = [read_values(self._with_signals(), unit.reader, t, x) for unit in due]
        for unit, values in zip(due, given, strict=True):
            self._held = {**self._held, **unit.sample(values)}
        if due:
            self._record.append((t, self._held))
            self._sampled = _with_values(self._sampled, self._held)
        if self._is_switched:
            self._sampled = self._sampled.with_other_times()
        self.problem = self._with_signals()

    def sample_signals(self, t: float, x: Floats) -> None:
        """Take the samples of signals that are due at a time and state."""
        if self._sampler is not None and self._sampler.is_due(t):
            SampledLoop(self._sampled, self._sampler).take(t, np.append(x, 0.0))

    def _with_signals(self) -> SimulationProblem:
        """Return the problem with the sampled signals as constants, too."""
        sampler = self._sampler
        if sampler is None:
            return self._sampled
        values = {name: sampler.current(name) for name in sampler.names}
        return replace(_with_values(self._sampled, values), sampler=None)

    def problem_of_record(self, end: float) -> SimulationProblem:
        """Return the problem of a motion until a time with tables of what FMUs computed."""
        if not self._record:
            return self._first
        t = [time for time, _ in self._record]
        times = [time for pair in zip(t, [*t[1:], max(end, t[-1])], strict=True) for time in pair]
        tables = {
            name: _steps(times, [held[name] for _, held in self._record for _ in range(2)])
            for name in self._held
        }
        return replace(self._first, laws=_with_tables(self._first.laws, tables))


def _check_direction(fmus: Mapping[str, FmuInput], span: tuple[float, float]) -> None:
    start, end = span
    if fmus and end < start:
        raise UsageError(
            Problem("fmu_input.backwards", ", ".join(f"input {name}" for name in fmus),
                    f"the motion runs from t = {start:g} s back to {end:g} s", "FMUs can only step forward",
                    "give a t_end after the start")
        )  # fmt: skip


def _unit(
    problem: SimulationProblem, group: Mapping[str, FmuInput], held: Mapping[str, float],
    first: tuple[float, Floats], stack: ExitStack,
) -> SampledUnit:  # fmt: skip
    """Return an FMU, initialized at a first time and state."""
    reader = make_reader(problem, group)
    values = read_values(_with_values(problem, held), reader, *first)
    return SampledUnit(group, stack.enter_context(open_unit(group, first[0], values)), reader, first[0])


def _is_switched(problem: SimulationProblem) -> bool:
    """Return whether inputs by FMUs decide when formulas that depend on time change."""
    functions = function_of_time(problem.compile_outputs(("xdot", "power")), problem.laws.tables)
    if functions is None:
        return False
    switches_there = functions.known_switches.size + functions.open_switches.size
    return switches_there > 0 and any(group == "r" for group, _ in functions.names)


def _steps(times: Sequence[float], values: Sequence[float]) -> Table:
    if times[0] == times[-1]:
        times = [times[0] - 1.0, *times[1:]]
    return Table(times, values)


def _with_values(problem: SimulationProblem, held: Mapping[str, float]) -> SimulationProblem:
    """Return a problem whose inputs have constant values."""
    tables = {name: _ZERO.shift_values(value) for name, value in held.items()}
    return replace(problem, laws=_with_tables(problem.laws, tables))


def _with_tables(laws: InputLaws, tables: Mapping[str, Table]) -> InputLaws:
    places = {name: place for place, name in enumerate(laws.callbacks)}
    return replace(
        laws,
        callbacks={**laws.callbacks, **{name: table.reader() for name, table in tables.items()}},
        tables={**laws.tables, **{places[name]: table for name, table in tables.items()}},
    )
