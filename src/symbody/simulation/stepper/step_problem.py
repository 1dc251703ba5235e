"""What a stepper moves: its arguments, checked, equations with values of parameters, closed states."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble, close
from symbody.analysis.configurations.unsubstituted import with_followers
from symbody.analysis.constraint_evaluator import constraint_evaluator
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.equations.closing_equations import closing_equations
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.errors import Problem, UsageError
from symbody.kernels import stepping
from symbody.simulation.events.events import Event
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.held_law import HeldLaw, held_later
from symbody.simulation.inputs.input_laws import Callback, InputLaws, Law, input_laws, laws_of_tables
from symbody.simulation.inputs.tables import Table
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT, Constraints, Integrator, work_tolerance
from symbody.simulation.motion import Motion
from symbody.simulation.sampling.held_signals import held_signals
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.stepper.numbers import StepNumbers, state_values, unknown_name

Floats = NDArray[np.float64]


# What depends on time alone is looked at for so many steps ahead.
WINDOW: Final = 1000


@dataclass(frozen=True, slots=True, eq=False)
class StepperSettings:
    """What stays the same while a stepper moves.

    Attributes
    ----------
    eqs, moving : EquationSet
        The equations as given, and with the stabilizing terms of `Baumgarte`.
    initial, guess : mapping of name to number or formula
        Values at the start, as for `simulate`.
    t_start : float
        When that is [s].
    held : tuple of str
        Inputs that are constant in each step: those that steps give, and those that FMUs compute.
    laws : mapping of name to law
        Of other inputs; those without one are 0.
    max_steps : int
        How many steps of the integrator one step may take.
    """

    eqs: EquationSet
    moving: EquationSet
    dt: float
    initial: Mapping[str, Value]
    guess: Mapping[str, Value]
    t_start: float
    held: tuple[str, ...]
    laws: Mapping[str, Law]
    integrator: Integrator | None
    constraints: Constraints | None
    events: tuple[Event, ...]
    rtol: float
    atol: float | None
    scales: Mapping[str, float] | None
    max_steps: int
    fmus: Mapping[str, FmuInput] = field(default_factory=dict)

    @property
    def inputs_of_steps(self) -> tuple[str, ...]:
        """Inputs that steps give."""
        return tuple(name for name in self.held if name not in self.fmus)

    @property
    def bounded_tables(self) -> dict[str, Table]:
        """Inputs by tables that no step may leave."""
        laws = {name: Table(*law) if isinstance(law, tuple) else law for name, law in self.laws.items()}
        tables = {name: law for name, law in laws.items() if isinstance(law, Table)}
        return {name: table for name, table in tables.items() if table.outside == "error"}

    @property
    def method(self) -> Explicit | FixedStep:
        """The integrator of the compiled loop."""
        return self.integrator if isinstance(self.integrator, Explicit | FixedStep) else DEFAULT

    @property
    def projection(self) -> Projection | None:
        """What closes loops after each of its steps; None where `Baumgarte` holds them."""
        if isinstance(self.constraints, Baumgarte):
            return None
        return self.constraints if isinstance(self.constraints, Projection) else Projection()


def split_inputs(
    eqs: EquationSet, inputs: Mapping[str, Law] | Iterable[str] | None
) -> tuple[tuple[str, ...], Mapping[str, Law], Mapping[str, FmuInput]]:
    """Return the inputs that steps hold, in the order of the equations, the laws of others, and FMUs.

    Raises UsageError if it is neither a mapping nor names, or a name is unknown.
    """
    laws: Mapping[str, Law] = inputs if isinstance(inputs, Mapping) else {}
    sampled = held_later(eqs)
    open_names = tuple(name for name in eqs.input_names if name not in sampled)
    named: object = open_names if inputs is None else inputs
    names: tuple[object, ...] = tuple(named) if isinstance(named, Iterable) else (named,)
    if isinstance(named, str):
        names = (named,)
    problems = [
        Problem("stepper.inputs", "inputs", f"{name!r} is not the name of an input", "",
                'give laws, as {"F": "sin(t)"}, or names, as ["F"]')
        for name in names if not isinstance(name, str)
    ] or [
        unknown_name("input", str(name), open_names) for name in names if name not in open_names
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    if isinstance(inputs, Mapping):
        fmus = {name: law for name, law in laws.items() if isinstance(law, FmuInput)}
        kept = {name: law for name, law in laws.items() if name not in fmus}
        tables = {name: law for name, law in laws_of_tables(eqs).items() if name not in laws}
        laws = {**tables, **kept, **sampled}
        return tuple(name for name in eqs.input_names if name not in laws), laws, fmus
    tables = {name: law for name, law in laws_of_tables(eqs).items() if inputs is None or name not in names}
    held = tuple(name for name in eqs.input_names if name in names and name not in tables)
    return held, {**tables, **sampled}, {}


def checked_duration(name: str, value: object) -> float:
    """Return the length of a step [s]; raises UsageError if it is not a positive finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise UsageError(
            Problem("stepper.dt", name, f"{name} = {value!r} is not a valid step size",
                    "steps advance by a finite positive time", "give seconds, such as 0.001")
        )  # fmt: skip
    return float(value)


def checked_start(t: object) -> float:
    """Return the time at the start [s]; raises UsageError if it is not a finite number."""
    if isinstance(t, bool) or not isinstance(t, int | float) or not math.isfinite(t):
        raise UsageError(
            Problem("stepper.t", "t", f"t = {t!r} is not a valid time", "", "give finite seconds")
        )
    return float(t)


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

    def check_tables(self, numbers: StepNumbers) -> None:
        """Refuse a step that leaves a table which must not be left; raises UsageError naming the input."""
        for name, table in self.settings.bounded_tables.items():
            table.check_span(name, numbers.t, numbers.t + float(numbers.array[stepping.DURATION]))


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
    eqs, laws, own = settings.eqs, own_laws(settings, numbers.t), dict(parameters)
    everything = _all_laws(settings, laws, numbers)
    if before is not None:
        problem = SimulationProblem(settings.moving, own, everything, before.problem.scales)
        return StepProblem(settings, own, problem, laws, before.tolerances)
    q = dict(zip(eqs.coordinate_names, numbers.x[len(eqs.speed_names) :].tolist(), strict=False))
    scales = mechanism_scales(eqs, own, settings.scales, q).fit_span(0.0, WINDOW * settings.dt)
    made = StepProblem(settings, own, SimulationProblem(settings.moving, own, everything, scales), laws, ())
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


def close_again(problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value]) -> Floats | None:
    """Return the closed state (u, q, s) nearest to the present one with values of parameters.

    Of mechanisms in which nothing has to be closed None.
    """
    eqs, formulas, x = problem.settings.eqs, problem.own_laws.formulas, numbers.x[:-1].copy()
    whole = closing_equations(eqs)
    if not (whole.multiplier_names or whole.quaternions):
        return None
    if unilateral_elements(eqs.formed):  # which of them are taut follows from the state
        return state_values(nearest_state(problem, numbers, parameters, {}))
    scales = mechanism_scales(whole, parameters, problem.problem.scales.sizes)
    signals = x[len(eqs.speed_names) + len(eqs.coordinate_names) :]
    evaluator = constraint_evaluator(whole, parameters, formulas, numbers.t, scales, signals=signals)
    present = dict(zip(eqs.state_names, x.tolist(), strict=True))
    present = with_followers(eqs, present, problem.parameters)
    near = {name: present[name] for name in whole.coordinate_names}
    q, u = close(evaluator, {}, near, np.array([present[name] for name in whole.speed_names]))
    closed = dict(zip((*whole.coordinate_names, *whole.speed_names), [*q, *u], strict=True))
    return np.array([closed.get(name, present[name]) for name in eqs.state_names])


def nearest_state(
    problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value], inputs: Mapping[str, float]
) -> State:
    """Return the present state, closed, with accelerations and multipliers; `inputs` are those of steps."""
    eqs = problem.settings.eqs
    near = dict(zip(eqs.state_names, numbers.x.tolist(), strict=False))
    given = {**problem.own_laws.formulas, **inputs}
    return assemble(
        eqs, None, near, parameters=parameters, inputs=given, t=numbers.t, scales=problem.problem.scales.sizes
    )
