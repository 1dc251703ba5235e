"""Steps that are motions of their own: for methods and mechanisms that the compiled loop does not know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.equations.solving.modal_equations import switches
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.simulation.drive import Driven, drive
from symbody.simulation.events.events import EventSide, ModeChange, Occurrence
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.held_law import HeldLaw, held_later
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sampling.held_signals import held_signals
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import Ending, Steps
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.step_problem import StepProblem
from symbody.simulation.stepper.watched_steps import OTHERWISE, no_sides, split_sides, with_sides

Floats = NDArray[np.float64]


def why_separate(problem: StepProblem, numbers: StepNumbers) -> str:
    """Return why steps have to be motions of their own, empty where the compiled loop can take them."""
    settings = problem.settings
    eqs = settings.moving
    if held_later(eqs):
        return "values are sampled"
    if isinstance(settings.integrator, Stiff | GeneralizedAlpha):
        return f"sb.{type(settings.integrator).__name__}() restarts in each step"
    if not isinstance(settings.constraints, Projection | Baumgarte | None):
        return f"sb.{type(settings.constraints).__name__}() restarts in each step"
    if switches(eqs.formed):
        return "joints may stick or ropes go slack"
    if eqs.formed.elimination is not None:
        return "pivots of dependent speeds are monitored"
    if eqs.plans.get("may jump", lambda: may_jump(eqs)):
        return "prescribed rates may jump"
    if settings.constraints is None and is_overconstrained(problem.problem, numbers.t, numbers.x[:-1].copy()):
        return "some constraints are redundant only where all loops are closed"
    return ""


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
        self.modes: tuple[ModeChange, ...] = ()
        self._problem = problem
        self._numbers = numbers
        self._sides: tuple[EventSide, ...] = no_sides(problem)
        self._last: Trajectory | None = None
        self._posed: tuple[bytes, SimulationProblem] | None = None
        self._sampler = self._make_sampler()

    def go_on(self) -> int:
        """Take a step; return `OTHERWISE` where it did not come to its end."""
        numbers, settings = self._numbers, self._problem.settings
        start = numbers.t
        self.check()
        with numbers.unless_it_fails():
            end = numbers.next_end()
            run, _, sides = self._run(start, end)
        self._last, self.occurrences, self.modes = run, run.events, run.modes
        self._sides = sides[: len(settings.events)] or no_sides(self._problem)
        self._show_samples()
        arrived = run.status is Status.SUCCESS
        if run.t.size:
            x = np.concatenate([run.u[:, -1], run.q[:, -1], run.s[:, -1], numbers.x[-1:] + run["work"][-1]])
            numbers.arrive(end if arrived else float(run.t[-1]), x, at_end=arrived)
        else:
            numbers.count_from(start)
        return at.FINISHED if arrived else OTHERWISE

    def _run(self, start: float, end: float) -> Driven:
        """Return the motion of a step."""
        if self._sampler is not None:
            self._sampler.begin_anew()
        x = np.append(self._numbers.x[:-1], 0.0)
        motion = self._problem.integration(x, (start, end), self._pose())
        return drive(replace(motion, sides=self._sides))

    def check(self) -> None:
        """Refuse a step that leaves a table which must not be left."""
        start = self._numbers.t
        self._problem.check_tables(start, start + float(self._numbers.array[stepping.DURATION]))

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
        self.occurrences, self._sides = (), no_sides(self._problem)
        self._posed, self._sampler = None, self._make_sampler(initial)

    def snapshot(self) -> Floats:
        """Return what samples and events follow from; else each motion follows from its first state."""
        samples = np.zeros(0) if self._sampler is None else self._sampler.snapshot()
        return with_sides(samples, self._sides)

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        samples, self._sides = split_sides(kept, self._problem)
        if self._sampler is not None:
            self._sampler.resume(samples)
            self._show_samples()

    def follow(self, others: Steps) -> None:
        """Go on with held values and events of others, which computed with other values of parameters."""
        if isinstance(others, SeparateMotions):
            self._sides = others._sides
        if isinstance(others, SeparateMotions) and self._sampler is not None and others._sampler is not None:
            self._sampler.follow(others._sampler, self._numbers.t)
            self._show_samples()

    def copy(self, problem: StepProblem, numbers: StepNumbers) -> SeparateMotions:
        """Return what goes on from here with other numbers."""
        made = SeparateMotions(problem, numbers)
        made.resume(self.snapshot())
        return made

    def rebind(self) -> None:
        """Go on with the numbers where they lie now: each motion reads them anew."""

    def _make_sampler(self, others: Mapping[str, Value] | None = None) -> Sampler | None:
        """Return what samples held values, from their values at the start on."""
        settings, problem = self._problem.settings, self._problem
        span = settings.t_start, settings.t_start + settings.dt
        initial = {**settings.initial, **(others or {})}
        held = held_signals(settings.eqs, span, problem.parameters, initial, {})
        if not held.names:
            return None
        held.place(problem.own_laws)
        self._show(held.active)
        return held.active

    def _show_samples(self) -> None:
        if self._sampler is not None:
            self._show(self._sampler)

    def _show(self, sampler: Sampler) -> None:
        """Write held values to the inputs at present."""
        names = tuple(self._problem.problem.laws.callbacks)
        for name in sampler.names:
            self._numbers.inputs[names.index(name)] = sampler.current(name)

    def _pose(self) -> SimulationProblem:
        """Return the equations with the inputs of this step, and with compiled functions while these stay."""
        names = tuple(self._problem.problem.laws.callbacks)
        given = [k for k, name in enumerate(names) if name in self._problem.settings.held]
        inputs = self._numbers.inputs[given].tobytes()
        if self._posed is None or self._posed[0] != inputs:
            problem, laws = self._problem.problem, self._problem.own_laws
            formulas: Mapping[str, Value] = {**self._held_values(), **laws.formulas}
            own = self._sampler
            live = {} if own is None else {name: HeldLaw(own, name) for name in own.names}
            now = InputLaws(
                formulas, {**laws.callbacks, **live}, (), laws.tables, coordinates=laws.coordinates
            )
            self._posed = (
                inputs,
                SimulationProblem(problem.eqs, problem.parameters, now, problem.scales, sampler=own),
            )
        return self._posed[1]

    def _held_values(self) -> dict[str, float]:
        names = tuple(self._problem.problem.laws.callbacks)
        values = zip(names, self._numbers.inputs.tolist(), strict=True)
        return {name: value for name, value in values if name in self._problem.settings.held}
