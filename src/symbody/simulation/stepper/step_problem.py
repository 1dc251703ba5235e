"""The equations of a stepper with values of parameters, and with inputs that are given step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.simulation.inputs.held_law import HeldLaw, held_later
from symbody.simulation.inputs.input_laws import Callback, InputLaws, input_laws
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.motion import Motion
from symbody.simulation.sampling.held_signals import held_signals
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.settings import WINDOW, StepperSettings

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StepInputs:
    """The inputs that keep their values from step to step; 0 before one is given."""

    numbers: StepNumbers
    names: tuple[str, ...]

    def current(self, name: str) -> float:
        """Return a value at present."""
        value = self.numbers.inputs.item(self.names.index(name))
        return value if value == value else 0.0

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at times (N,) of a step."""
        return np.full(np.shape(t), self.current(name))


@dataclass(frozen=True, slots=True, eq=False)
class StepProblem:
    """What moves, and how exactly.

    Attributes
    ----------
    own_laws : InputLaws
        Of the inputs that have laws; `problem` has those that are held too.
    tolerances : tuple of float
        The absolute error of each state (u, q, s, work) that is tolerated; as at the start.
    """

    settings: StepperSettings
    parameters: Mapping[str, Value]
    problem: SimulationProblem
    own_laws: InputLaws
    tolerances: tuple[float, ...]

    def inputs_now(self, numbers: StepNumbers, moving: SimulationProblem) -> Floats:
        """Return the inputs that functions of what moves take at present; NaN where none was given yet."""
        n_u = len(self.settings.eqs.speed_names)
        laws = moving.laws
        values = np.array(laws.evaluate(numbers.t, numbers.x[n_u:-1].copy(), numbers.x[:n_u].copy()))
        for place, name in enumerate(laws.callbacks):
            if name in self.settings.held:
                values[place] = numbers.inputs[place]
        return values

    def sampler(self, others: Mapping[str, Value] | None = None) -> Sampler | None:
        """Return what samples the held values of signals, from their values at the start on.

        Values in `others` count instead of those at the start; None where nothing is sampled.
        """
        settings = self.settings
        span = settings.t_start, settings.t_start + settings.dt
        held = held_signals(settings.eqs, span, self.parameters, {**settings.initial, **(others or {})}, {})
        if not held.names:
            return None
        held.place(self.problem.laws)
        return held.active

    def with_samples(self, sampler: Sampler | None) -> SimulationProblem:
        """Return the equations with held values of signals that are sampled on the way."""
        if sampler is None:
            return self.problem
        laws = self.problem.laws.with_held({name: HeldLaw(sampler, name) for name in sampler.names})
        return replace(self.problem, laws=laws, sampler=sampler)

    def integration(
        self, x: Floats, span: tuple[float, float], problem: SimulationProblem | None = None
    ) -> Motion:
        """Return a motion from x = (u, q, work)."""
        settings = self.settings
        return Motion(
            problem or self.problem, x, span, None, settings.rtol, settings.atol, settings.max_steps, None,
            settings.events, settings.integrator, settings.constraints,
        )  # fmt: skip

    def check_tables(self, start: float, end: float) -> None:
        """Refuse a step that leaves a table which must not be left.

        Raises
        ------
        UsageError
            Naming the input.
        """
        for name, table in self.settings.bounded_tables.items():
            table.check_span(name, start, end)


def own_laws(settings: StepperSettings, t: float) -> InputLaws:
    """Return the laws of the inputs that are not held."""
    names = [name for name in settings.eqs.input_names if name not in settings.held]
    return input_laws(names, settings.laws, (t, t), len(settings.eqs.coordinate_names))


def step_problem(
    settings: StepperSettings,
    parameters: Mapping[str, Value],
    numbers: StepNumbers,
    before: StepProblem | None = None,
) -> StepProblem:
    """Return the equations with values of parameters; what counts as large stays as it was `before`."""
    parameter_set(settings.eqs, parameters).require_possible()
    laws, own = own_laws(settings, numbers.t), dict(parameters)
    scales = _scales(settings, parameters, numbers.x) if before is None else before.problem.scales
    problem = SimulationProblem(settings.moving, own, _all_laws(settings, laws, numbers), scales)
    made = StepProblem(settings, own, problem, laws, () if before is None else before.tolerances)
    if before is not None:
        return made
    motion = made.integration(numbers.x, (numbers.t, numbers.t + settings.dt))
    return replace(made, tolerances=(*motion.tolerances.tolist(), work_tolerance(motion)))


def first_state(
    settings: StepperSettings,
    parameters: Mapping[str, Value],
    other: Mapping[str, Value] | None = None,
    near: Mapping[str, Value] | None = None,
) -> State:
    """Return the state at the start, or there with `other` values that hold and guesses `near`."""
    laws = own_laws(settings, settings.t_start)
    held = held_later(settings.eqs)  # they have values before their first samples
    guess = {**settings.guess, **(near or {})}
    kept = {name: value for name, value in settings.initial.items() if name not in (near or {})}
    given = {**kept, **(other or {})}
    initial = {name: value for name, value in given.items() if name not in held}
    if held:  # so that impossible values change nothing
        held_signals(settings.eqs, (settings.t_start, settings.t_start), parameters, given, {})
    return assemble(
        settings.eqs, initial, guess, parameters=parameters, inputs=laws.formulas, t=settings.t_start,
        scales=settings.scales,
    )  # fmt: skip


def inputs_read(settings: StepperSettings, laws: InputLaws) -> tuple[str, ...]:
    """Return the inputs that compiled functions take: those held, and those with laws in Python."""
    return tuple(name for name in settings.eqs.input_names if name not in laws.formulas)


def _all_laws(settings: StepperSettings, laws: InputLaws, numbers: StepNumbers) -> InputLaws:
    names = inputs_read(settings, laws)
    given = {name: law for name, law in laws.callbacks.items() if not isinstance(law, HeldLaw)}
    held = StepInputs(numbers, names)
    callbacks: dict[str, Callback] = {name: given.get(name, HeldLaw(held, name)) for name in names}
    own = tuple(laws.callbacks)
    tables = {names.index(own[place]): table for place, table in laws.tables.items()}
    return InputLaws(laws.formulas, callbacks, laws.notes, tables, coordinates=laws.coordinates)


def _scales(settings: StepperSettings, parameters: Mapping[str, Value], x: Floats) -> Scales:
    names = settings.eqs.coordinate_names
    q = dict(zip(names, x[len(settings.eqs.speed_names) :][: len(names)].tolist(), strict=True))
    scales = mechanism_scales(settings.eqs, dict(parameters), settings.scales, q)
    return scales.fit_span(0.0, WINDOW * settings.dt)
