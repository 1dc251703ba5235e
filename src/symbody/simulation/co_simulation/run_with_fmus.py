"""`run_motion`: a motion in parts, between samples of FMUs, or of held values that its method cannot take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.co_simulation.fmu_unit import open_unit
from symbody.simulation.co_simulation.sampled_unit import (
    SampledUnit,
    by_instance,
    make_reader,
    read_values,
)
from symbody.simulation.hybrid.concatenate import at_times_asked, concatenate
from symbody.simulation.hybrid.rate_jumps import run_with_jumps
from symbody.simulation.hybrid.switching import run_switching, switches
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inputs.time_functions import function_of_time
from symbody.simulation.methods.closed_loops.partition import Partition
from symbody.simulation.methods.implicit.gear_gupta_leimkuhler import GGL
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.methods.integration import MotionPlan, SamplesMissedError
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sampling.sampled_loop import SampledLoop
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

# Shares of the shortest step within which two times are one.
_ONE_INSTANT: Final = 1e-6
_MOST_NOTES: Final = 8
_ZERO: Final = Table((0.0, 1.0), (0.0, 0.0))


def run_motion(plan: MotionPlan, inputs: Mapping[str, object]) -> tuple[Trajectory, SimulationProblem]:
    """Return a motion whose `inputs` FMUs may compute, and its problem with what they computed as tables.

    Raises
    ------
    UsageError
        If the motion runs backwards, or an FMU cannot be used.
    SimulationError
        If an FMU fails, or cannot be given what it reads.
    """
    fmus = {name: law for name, law in inputs.items() if isinstance(law, FmuInput)}
    problem = plan.integration.problem
    if fmus:
        is_between = isinstance(plan.integrator, Stiff | GeneralizedAlpha) or isinstance(
            plan.constraints, GGL | Partition
        )
        return _run_in_parts(plan, fmus, problem.sampler if is_between else None)
    try:
        return _run_part(plan), problem
    except SamplesMissedError:  # by the method asked for, or one that takes over
        return _run_in_parts(plan, {}, problem.sampler)


def _run_in_parts(
    plan: MotionPlan, inputs: Mapping[str, FmuInput], sampler: Sampler | None
) -> tuple[Trajectory, SimulationProblem]:
    start, end = plan.integration.span
    if end < start:
        raise UsageError(
            Problem("fmu_input.backwards", ", ".join(f"input {name}" for name in inputs),
                    f"the motion runs from t = {start:g} s back to {end:g} s", "FMUs can only step forward",
                    "give a t_end after the start")
        )  # fmt: skip
    groups = by_instance(inputs)
    problem = plan.integration.problem
    _ = plan.integration.breakpoints  # looked for once, and not in every part
    readers = [make_reader(problem, group) for group in groups]
    with ExitStack() as stack:
        held = dict.fromkeys(inputs, 0.0)
        x = plan.integration.state
        units = []
        for group, reader in zip(groups, readers, strict=True):
            values = read_values(_with_values(problem, held), reader, start, x)
            unit = stack.enter_context(open_unit(group, start, values))
            units.append(SampledUnit(group, unit, reader, start))
        return _Run(plan, units, held, sampler).go()


class _Run:
    """The motion so far.

    Parameters
    ----------
    plan : MotionPlan
        Of the whole motion.
    units : sequence of SampledUnit
        The FMUs, initialized.
    held : mapping of str to float
        The inputs before the first sample.
    sampler : Sampler or None
        Takes the samples of values that are held between parts; without one these take them.
    """

    def __init__(
        self,
        plan: MotionPlan,
        units: Sequence[SampledUnit],
        held: Mapping[str, float],
        sampler: Sampler | None,
    ) -> None:
        self._plan = plan
        self._units = units
        self._sampler = sampler
        if sampler is not None:
            sampler.rewind(plan.integration.span[0])
        steps = () if sampler is None else np.asarray(sampler.hold.steps).tolist()
        self._width = _ONE_INSTANT * min([*(unit.period for unit in units), *steps])
        self._held = dict(held)
        self._problem = self._held_problem()  # has what is held as constants
        self._is_switched = sampler is not None or _is_switched(plan.integration.problem)
        self._parts: list[Trajectory] = []
        self._record: list[tuple[float, dict[str, float]]] = []  # samples, and what was held from then on
        self._stored = 0  # samples of the motion
        self._steps = 0

    def go(self) -> tuple[Trajectory, SimulationProblem]:
        """Return the whole motion, and its problem with tables for what was held."""
        try:
            self._march()
        except KeyboardInterrupt:  # between two parts: what came before is kept
            if not self._parts:
                raise
            self._parts[-1] = replace(self._parts[-1], status=Status.INTERRUPTED)
        return self._whole(), self._problem_of_record(self._plan.integration.span[1])

    def _march(self) -> None:
        """Go from sample to sample until the motion ends."""
        integration = self._plan.integration
        (t, end), x = integration.span, integration.state
        while True:
            self._sample(t, x)
            stop = min([*(unit.due for unit in self._units), *self._due()])
            stop = end if stop >= end - self._width else stop
            part = self._part(x, (t, stop))
            if part.status is not Status.SUCCESS:
                return
            dense = part.dense_output
            x = np.zeros(0) if dense is None else dense.at_end()
            if stop == end:
                self._take_samples(end, x)
                return
            if integration.progress is not None:  # parts are too short for reports of their own
                share = (stop - integration.span[0]) / (end - integration.span[0])
                if integration.progress(share) is False:
                    raise KeyboardInterrupt
            t = stop

    def _due(self) -> list[float]:
        return [] if self._sampler is None else [self._sampler.next_due]

    def _take_samples(self, t: float, x: Floats) -> None:
        """Take the samples of held values that are due."""
        if self._sampler is not None and self._sampler.is_due(t):
            problem = _with_values(self._plan.integration.problem, self._held)
            SampledLoop(problem, self._sampler).take(t, np.append(x, 0.0))
            self._problem = self._held_problem()

    def _held_problem(self) -> SimulationProblem:
        """Return the problem with what is held as constants."""
        problem, sampler = self._plan.integration.problem, self._sampler
        if sampler is None:
            return _with_values(problem, self._held)
        sampled = {name: sampler.current(name) for name in sampler.names}
        return replace(_with_values(problem, {**self._held, **sampled}), sampler=None)

    def _sample(self, t: float, x: Floats) -> None:
        """Take samples, and let those FMUs compute that are due, all from the values held until now."""
        self._take_samples(t, x)
        due = [unit for unit in self._units if unit.due <= t + self._width]
        given = [read_values(self._problem, unit.reader, t, x) for unit in due]
        for unit, values in zip(due, given, strict=True):
            self._held = {**self._held, **unit.sample(values)}
        self._record.append((t, self._held))
        self._problem = self._held_problem()
        if self._is_switched:
            self._problem = self._problem.with_other_times()

    def _part(self, x: Floats, span: tuple[float, float]) -> Trajectory:
        integration = self._plan.integration
        part = integration.part(x, span, self._times(span), self._steps)
        sides = self._parts[-1].sides[: len(part.events)] if self._parts else part.sides
        part = replace(part, problem=self._problem, sides=sides)
        plan = replace(self._plan, integration=part)
        run = _run_part(plan)
        self._parts.append(run)
        self._stored += run.t.size
        self._steps += run.statistics.accepted + (run.statistics.rejected or 0)
        return run

    def _times(self, span: tuple[float, float]) -> Floats | None:
        """Return the times to store in a part; one at a sample belongs to the part behind."""
        integration = self._plan.integration
        if integration.times is None:
            return None
        times = np.asarray(integration.times, dtype=np.float64)
        is_last = span[1] == integration.span[1]
        last = times.size if is_last else int(np.searchsorted(times, span[1] - self._width))
        return np.clip(times[self._stored : last], *span)

    def _whole(self) -> Trajectory:
        integration = self._plan.integration
        run = concatenate(self._parts, [event for part in self._parts for event in part.events], {})
        if integration.times is not None:
            run = at_times_asked(run, np.asarray(integration.times), self._width)
        if len(run.notes) > _MOST_NOTES:
            more = f"{len(run.notes) - _MOST_NOTES} more notes on values between samples"
            run = replace(run, notes=(*run.notes[:_MOST_NOTES], more))
        return run

    def _problem_of_record(self, end: float) -> SimulationProblem:
        """Return the problem with tables of the values that were held."""
        if not self._held:
            return self._plan.integration.problem
        t = [time for time, _ in self._record]
        times = [time for pair in zip(t, [*t[1:], max(end, t[-1])], strict=True) for time in pair]
        tables = {
            name: _steps(times, [held[name] for _, held in self._record for _ in range(2)])
            for name in self._held
        }  # fmt: skip
        problem = self._plan.integration.problem
        return replace(problem, laws=_with_tables(problem.laws, tables))


def _is_switched(problem: SimulationProblem) -> bool:
    """Return whether inputs by FMUs decide when formulas that depend on time change."""
    functions = function_of_time(problem.compile_outputs(("xdot", "power")), problem.laws.tables)
    if functions is None:
        return False
    switches_there = functions.known_switches.size + functions.open_switches.size
    return switches_there > 0 and any(group == "r" for group, _ in functions.names)


def _run_part(plan: MotionPlan) -> Trajectory:
    return run_switching(plan) if switches(plan.integration.eqs.formed) else run_with_jumps(plan)


def _steps(times: list[float], values: list[float]) -> Table:
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
