"""Steps that are motions of their own: for methods and mechanisms that the compiled loop does not know."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.kernels import block as at
from symbody.simulation.drive import Driven, drive
from symbody.simulation.events.events import EventSide, Occurrence
from symbody.simulation.hybrid.switching import switching_modes
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import Ending, Steps
from symbody.simulation.stepper.hybrid_steps import (
    OTHERWISE,
    modes_at_present,
    no_sides,
    split_sides,
    with_sides,
)
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.step_problem import StepProblem

Floats = NDArray[np.float64]


class SeparateMotions:
    """Steps each of which is a motion as `simulate` computes it; see `compiled_steps.Steps`.

    Parameters
    ----------
    problem : StepProblem
        What moves.
    numbers : StepNumbers
        Time, state and inputs.
    """

    def __init__(self, problem: StepProblem, numbers: StepNumbers) -> None:
        self.occurrences: tuple[Occurrence, ...] = ()
        self.modes: dict[str, str] = {}
        self._problem = problem
        self._numbers = numbers
        self._sides: tuple[EventSide, ...] = no_sides(problem)
        self._last: Trajectory | None = None
        self._sampler = problem.sampler()
        self._posed = problem.with_samples(self._sampler)
        self._modes = switching_modes(self._posed)  # those of motions are their own
        self.motion_problem = self._posed if self._modes is None else self._modes.problem

    def at_present(self) -> AbstractContextManager[None]:
        """Let the modes be those of the present state and inputs, while outputs are computed."""
        return modes_at_present(self._modes, self._numbers)

    def go_on(self) -> int:
        """Take a step; return `OTHERWISE` where it did not come to its end."""
        numbers, settings = self._numbers, self._problem.settings
        start = numbers.t
        self.check()
        with numbers.unless_it_fails():
            end = numbers.next_end()
            run, _, sides = self._run(start, end)
        self._last, self.occurrences = run, run.events
        self.modes = {change.name: change.mode for change in run.modes}
        self._sides = sides[: len(settings.events)] or no_sides(self._problem)
        arrived = run.status is Status.SUCCESS
        if run.t.size:
            x = np.concatenate([run.u[:, -1], run.q[:, -1], run.s[:, -1], numbers.x[-1:] + run["work"][-1]])
            numbers.arrive(end if arrived else float(run.t[-1]), x, at_end=arrived)
        else:
            numbers.count_from(start)
        return at.FINISHED if arrived else OTHERWISE

    def _run(self, start: float, end: float) -> Driven:
        if self._sampler is not None:
            self._sampler.begin_anew()
        x = np.append(self._numbers.x[:-1], 0.0)
        motion = self._problem.integration(x, (start, end), self._posed.with_other_times())
        return drive(replace(motion, sides=self._sides))

    def check(self) -> None:
        """Refuse a step that leaves a table which must not be left."""
        self._problem.check_tables(self._numbers)

    def end(self, code: int) -> Ending:
        """Return how the last step ended; `code` says only that it was not as usual."""
        if self._last is None:
            return Ending(Status.NOT_STARTED, f"code {code}")
        if self._last.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        note = "" if self._last.status.success else "; ".join(self._last.notes[-1:])
        return Ending(self._last.status, note)

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from time and state at present, with other held values where `initial` has some."""
        self.occurrences, self.modes, self._sides = (), {}, no_sides(self._problem)
        fresh = self._problem.sampler(initial)
        if self._sampler is not None and fresh is not None:
            self._sampler.resume(fresh.block)

    def snapshot(self) -> Floats:
        """Return what samples and events follow from; else each motion follows from its first state."""
        samples = np.zeros(0) if self._sampler is None else self._sampler.snapshot()
        return with_sides(samples, self._sides)

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        samples, self._sides = split_sides(kept, self._problem)
        if self._sampler is not None:
            self._sampler.resume(samples)

    def follow(self, others: Steps) -> None:
        """Go on with held values and events of others, which computed with other values of parameters."""
        if isinstance(others, SeparateMotions):
            self._sides = others._sides
        if isinstance(others, SeparateMotions) and self._sampler is not None and others._sampler is not None:
            self._sampler.follow(others._sampler, self._numbers.t)

    def copy(self, problem: StepProblem, numbers: StepNumbers) -> SeparateMotions:
        """Return what goes on from here with other numbers."""
        made = SeparateMotions(problem, numbers)
        made.resume(self.snapshot())
        return made

    def rebind(self) -> None:
        """Go on with the numbers where they lie now: each motion reads them anew."""
