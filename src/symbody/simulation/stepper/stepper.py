"""`Stepper`: a motion that goes on by one step whenever its caller wants, with inputs given step by step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NoReturn, Self

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.named_values import check_mappings
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import permanent_equations, switches
from symbody.errors import Problem, SimulationError, UsageError
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.model.first_values import FirstValue, Initial, by_priority
from symbody.simulation.events.events import Event, Occurrence, check_events
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.inputs.input_laws import Law
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.methods.moreau_jean import MoreauJean
from symbody.simulation.simulate import check_arguments
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import CompiledSteps, Ending, Steps
from symbody.simulation.stepper.fmu_steps import FmuSteps
from symbody.simulation.stepper.hybrid_steps import HybridSteps
from symbody.simulation.stepper.numbers import (
    StepNumbers,
    checked_inputs,
    missing_values,
    read_only,
    set_inputs,
    state_values,
    unknown_name,
)
from symbody.simulation.stepper.saved_stepper import (
    SavedStepper,
    kind_of,
    other_kind,
    read_saved,
    saved_parameters,
)
from symbody.simulation.stepper.separate_motions import SeparateMotions
from symbody.simulation.stepper.step_problem import (
    StepperSettings,
    StepProblem,
    checked_duration,
    checked_start,
    close_again,
    first_state,
    inputs_read,
    nearest_state,
    own_laws,
    split_inputs,
    step_problem,
)

Floats = NDArray[np.float64]


class OwnCopies(ABC):
    """Motions that `copy.copy` and `copy.deepcopy` copy by their own method, and that are not pickled."""

    @abstractmethod
    def copy(self) -> Self:
        """Return another that goes on from here by itself."""

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Self:
        return self.copy()

    def __reduce__(self) -> NoReturn:
        kind = type(self).__name__
        raise UsageError(
            Problem("stepper.pickle", kind, f"a {kind} cannot be pickled",
            "it contains addresses of machine code",
                    "pass on the bytes of save(), and restore() them in one created with the same arguments")
        )  # fmt: skip


class Stepper(OwnCopies):
    """A motion that advances by one step of `dt` at each call of `step`.

    It serves loops of the caller's own: controllers, games, hardware in the loop, reinforcement learning. A
    step takes as many steps of the integrator as the tolerances need, so that the motion is that of
    `simulate` with inputs that are constant over each step. Loops stay closed. One stepper serves one thread
    at a time.

    Parameters
    ----------
    eqs : EquationSet
        The equations of motion, from `form_equations`.
    dt : float
        Length of each step [s].
    parameters, initial, guess : mapping of name to number or formula
        As for `simulate`.
    inputs : mapping of name to law, or names, optional
        Laws as for `simulate`, FMUs among them: those without one are given by `step`. Or the names of those
        that are given, the others being 0. By default all are given.
    integrator, constraints : optional
        By default ``Explicit()`` and ``Projection()``. With `Stiff`, `GeneralizedAlpha`, `GGL` and
        `Partition` each step is a motion of its own, some milliseconds long: see `notes`.
    events : Event or sequence of Event
        One that stops ends its step early; the next continues from there.
    t : float
        Time at the start [s].
    rtol, atol, scales : optional
        As for `simulate`; sizes follow from the state at the start.
    max_steps : int
        How many steps of the integrator one step may take.

    Raises
    ------
    CompileError, FormulationError, UsageError, AssemblyError
        If names, values or tables make no sense, or initial values do not fit.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F"))
    >>> stepper = sb.Stepper(sb.form_equations(sb.Model("cart", [rail], inputs=["F"])), dt=0.1)
    >>> for _ in range(10):
    ...     state = stepper.step(F=4.0)
    >>> round(stepper["x"], 9), round(stepper["x_dot"], 9)
    (1.0, 2.0)
    """

    _go_on: Callable[[], int]

    @named_after(3)
    @checked_arguments
    def __init__(
        self, eqs: EquationSet, dt: float, parameters: Mapping[str, Value] | None = None,
        initial: Mapping[str, FirstValue] | None = None,
        inputs: Mapping[str, Law] | Iterable[str] | None = None, integrator: Integrator | None = None,
        constraints: Constraints | None = None, events: Event | Sequence[Event] = (), *,
        guess: Mapping[str, FirstValue] | None = None, t: float = 0.0, rtol: float = 1e-8,
        atol: float | None = None, scales: Mapping[str, float] | None = None, max_steps: int = 100_000,
    ) -> None:  # fmt: skip
        check_arguments(
            eqs, 0.0, integrator, constraints, initial=initial, guess=guess, parameters=parameters
        )
        duration, start = checked_duration("dt", dt), checked_start(t)
        held, laws, fmus = split_inputs(eqs, inputs)
        moving = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
        settings = StepperSettings(
            eqs, moving, duration, *by_priority(initial or {}, guess or {}), start, held, dict(laws),
            integrator, constraints, check_events(events, eqs), rtol, atol, scales, max_steps, fmus,
        )  # fmt: skip
        own = own_laws(settings, start)
        self._input_notes = (
            *(
                f"input {name} has no formula and is 0"
                for name in eqs.input_names
                if name not in {*held, *laws}
            ),
            *own.notes,
        )
        self._settings, self._names = settings, inputs_read(settings, own)
        self._lay_out(StepNumbers.fresh(eqs.state_names, self._names, settings.inputs_of_steps))
        self._numbers.begin(start, duration, state_values(first_state(settings, dict(parameters or {}))))
        self._status = Status.SUCCESS
        self._use(dict(parameters or {}), None)

    def step(self, duration: float | None = None, /, **inputs: float) -> Self:
        """Advance by `dt`, or once by another duration [s]; `inputs` hold their values in later steps.

        Returns
        -------
        Stepper
            This stepper, at the end of the step; at the event if one stopped it: `status` says so.

        Raises
        ------
        UsageError
            If an input has no name, value or finite number, or `simulate` rejects the motion.
        SimulationError
            If the motion cannot continue, or a function of an input fails; the stepper stays at the time
            it reached.
        """
        if duration is not None:
            return self._step_once(duration, inputs)
        if inputs:
            set_inputs(self._numbers.array, self._places, inputs)
        if not self._has_all_inputs:
            self._check_inputs()
        code = self._go_on()
        if code != at.FINISHED:
            self._end(code)
        else:
            self._status = Status.SUCCESS
        return self

    @property
    def t(self) -> float:
        """Time [s]."""
        return self._numbers.array.item(stepping.NOW)

    @property
    def q(self) -> Floats:
        """The coordinates (n_q,), a view that steps renew."""
        return self._q

    @property
    def u(self) -> Floats:
        """The speeds (n_u,), a view that steps renew."""
        return self._u

    @property
    def s(self) -> Floats:
        """The states of signals (n_s,), a view that steps renew."""
        return self._s

    @property
    def dt(self) -> float:
        """Length of each step [s]."""
        return self._settings.dt

    @property
    def status(self) -> Status:
        """How the last step ended: `Status.SUCCESS`, or `Status.STOPPED` by an event."""
        return self._status

    @property
    def events(self) -> tuple[Occurrence, ...]:
        """What happened in the last step: (name, t, state), in order."""
        return self._steps.occurrences

    @property
    def modes(self) -> dict[str, str]:
        """The modes of joints that stick and slip, ropes and stops, by name, in which the last step ended."""
        return self._steps.modes

    @property
    def parameters(self) -> dict[str, Value]:
        """The values of parameters that differ from the model."""
        return dict(self._problem.parameters)

    @property
    def inputs(self) -> dict[str, float]:
        """The inputs that steps give, with their values at present; those without a value are missing."""
        item, missing = self._numbers.array.item, self._numbers.unset_inputs
        return {name: item(k) for name, k in self._places.items() if name not in missing}

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader should know: inputs that are 0, and why steps are slow where they are."""
        return (*self._input_notes, *self._slow)

    @checked_arguments
    def __getitem__(self, name: str) -> float | Floats:
        """Return a coordinate, a speed, a signal, or any output or expression at present.

        Raises
        ------
        FormulationError
            If the name is neither an output nor an expression.
        UsageError
            If it depends on an input that has no value yet.
        """
        place = self._numbers.state_places.get(name)
        if place is not None:
            return self._numbers.array.item(place)
        moving = self._steps.motion_problem
        function = moving.compile_outputs(name, quick=True)
        with self._steps.at_present():
            inputs = self._problem.inputs_now(self._numbers, moving)
        value = np.asarray(function.of_state(self.t, self._numbers.x[:-1], inputs))
        if not (self._has_all_inputs or np.isfinite(value).all()):
            self._check_inputs()
        return float(value) if value.ndim == 0 else value

    def _ipython_key_completions_(self) -> list[str]:
        """Return what notebooks offer behind ``stepper["``: all outputs by their kinds."""
        return [each.name for each in self._settings.eqs.listed_outputs]

    def state(self) -> State:
        """Return the state at present, with accelerations and multipliers.

        Raises
        ------
        UsageError
            If an input has no value yet.
        """
        self._check_inputs()
        inputs_now = self._problem.inputs_now(self._numbers, self._steps.motion_problem)
        inputs = dict(zip(self._names, inputs_now, strict=False))
        return nearest_state(self._problem, self._numbers, self._problem.parameters, inputs)

    @checked_arguments
    def set(self, **values: Value) -> Self:
        """Change values of parameters, or of inputs that steps give; return this stepper.

        Coordinates and speeds stay as they are. Loops that other lengths open are closed by the least move,
        and then speeds by the least kinetic energy of the change.

        Raises
        ------
        UsageError, CompileError, FormulationError, AssemblyError
            If a name is unknown, a value impossible, or the loops do not close; nothing has changed then.
        """
        inputs = {name: value for name, value in values.items() if name in self._places}
        chosen = {name: value for name, value in values.items() if name not in inputs}
        unknown = [name for name in chosen if name not in self._settings.eqs.parameter_names]
        if unknown:
            words = (*self._settings.eqs.parameter_names, *self._places)
            raise UsageError(*(unknown_name("parameter or input", name, words) for name in unknown))
        checked_inputs(inputs, self._places)
        if chosen:
            parameters = {**self._problem.parameters, **chosen}
            moved = close_again(self._problem, self._numbers, parameters)
            self._use(parameters, self._problem, moved)
        set_inputs(self._numbers.array, self._places, inputs)
        return self

    @checked_arguments
    def reset(self, initial: Mapping[str, FirstValue] | None = None, /, **values: Value | Initial) -> Self:
        """Go back to the start, there with other initial values where they are given; return this stepper.

        Parameters keep their values, inputs lose theirs: the next motion does not depend on the last one.

        Raises
        ------
        AssemblyError
            If the values do not fit, or a name is unknown; nothing has changed then.
        """
        check_mappings(initial=initial)
        others, near = by_priority({**(initial or {}), **values}, {})
        first = first_state(self._settings, self._problem.parameters, others, near)
        self._numbers.begin(self._settings.t_start, self.dt, state_values(first))
        self._has_all_inputs = False
        self._steps.restart(others)
        self._take(self._problem, self._steps, self._slow, Status.SUCCESS)
        return self

    def copy(self) -> Self:
        """Return a stepper that continues from here independently; compiled functions are shared."""
        other = object.__new__(type(self))
        other._settings, other._names, other._input_notes = self._settings, self._names, self._input_notes
        other._lay_out(self._numbers.copy())
        problem = step_problem(self._settings, self._problem.parameters, other._numbers, self._problem)
        other._take(problem, self._steps.copy(problem, other._numbers), self._slow, self._status)
        other._steps.occurrences = self._steps.occurrences
        return other

    def save(self) -> bytes:
        """Return all that further steps depend on, bit for bit; see `restore`."""
        return SavedStepper(
            kind_of(self._settings), self._problem.parameters, self._status, self.events,
            self._numbers.array, self._steps.snapshot(),
        ).to_bytes()  # fmt: skip

    @checked_arguments
    def restore(self, saved: bytes) -> Self:
        """Continue from what `save` returned, here or in another process; return this stepper.

        The bytes hold numbers and names, no code. Further steps are the same bit for bit on the same machine.

        Raises
        ------
        UsageError
            If the bytes are damaged, or a stepper of other equations or settings has saved them.
        """
        content, numbers, problem = read_saved(saved), self._numbers, self._problem
        if content.kind != kind_of(self._settings) or content.numbers.size != numbers.array.size:
            raise other_kind()
        steps, slow = self._steps, self._slow
        with numbers.unless_it_fails():
            numbers.take(content.numbers)
            if content.parameters != saved_parameters(problem.parameters):
                problem = step_problem(self._settings, content.parameters, numbers, problem)
                steps, slow = steps_of(problem, numbers)
            if steps.snapshot().size != content.kept.size:
                raise other_kind()
            steps.resume(content.kept)
            numbers.take(content.numbers)
        self._has_all_inputs = False
        self._take(problem, steps, slow, content.status)
        steps.occurrences = content.events
        return self

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {self[name]:.6g}" for name in self._settings.eqs.coordinate_names[:4])
        return f"Stepper({self._settings.eqs.model.name!r}, dt={self.dt:g}): t = {self.t:.9g} s, {values}"

    def _lay_out(self, numbers: StepNumbers) -> None:
        """Use these numbers where they lie now."""
        n_u = len(self._settings.eqs.speed_names)
        n, x = n_u + len(self._settings.eqs.coordinate_names), numbers.x
        self._numbers, self._places, self._has_all_inputs = numbers, numbers.places, False
        self._u, self._q, self._s = map(read_only, (x[:n_u], x[n_u:n], x[n:-1]))

    def _use(
        self, parameters: Mapping[str, Value], before: StepProblem | None, moved: Floats | None = None
    ) -> None:  # fmt: skip
        """Go on with values of parameters from the present state, or from where it moved."""
        numbers = self._numbers
        with numbers.unless_it_fails():
            if moved is not None:
                numbers.x[:-1] = moved
            problem = step_problem(self._settings, parameters, numbers, before)
            steps, slow = steps_of(problem, numbers)
        if before is not None:
            steps.follow(self._steps)
        self._take(problem, steps, slow, self._status)

    def _take(self, problem: StepProblem, steps: Steps, slow: tuple[str, ...], status: Status) -> None:
        """Take further steps by these."""
        self._problem, self._steps, self._slow, self._status = problem, steps, slow, status
        self._go_on = steps.go_on

    def _check_inputs(self) -> None:
        """Take note that all inputs have values; raises UsageError if one has none."""
        if missing := self._numbers.unset_inputs:
            raise missing_values(missing)
        self._has_all_inputs = True

    def _step_once(self, duration: float, inputs: Mapping[str, float]) -> Self:
        self._numbers.set_duration(checked_duration("step", duration))
        try:
            return self.step(**inputs)
        finally:
            self._numbers.set_duration(self.dt)

    def _end(self, code: int) -> None:
        """Bring a step to its end that did not come to it at once.

        Raises SimulationError if the motion cannot go on.
        """
        ending = self._steps.end(code)
        self._status = ending.status
        if not ending.status.success:
            raise broken_off(self.t, ending)


def steps_of(problem: StepProblem, numbers: StepNumbers) -> tuple[Steps, tuple[str, ...]]:
    """Return what takes the steps of a problem, and a note on why they are slow where they are."""
    eqs, reason = problem.settings.moving, why_separate(problem, numbers)
    may_jump_here = eqs.plans.get("may jump", lambda: may_jump(eqs))
    has_instants = problem.settings.events or held_later(eqs) or switches(eqs.formed) or may_jump_here
    kind = SeparateMotions if reason else HybridSteps if has_instants else CompiledSteps
    steps: Steps = kind(problem, numbers)
    notes = (f"each step is a separate simulation, which is slow: {reason}",) if reason else ()
    return (FmuSteps(steps, problem, numbers) if problem.settings.fmus else steps), notes


def why_separate(problem: StepProblem, numbers: StepNumbers) -> str:
    """Return why steps have to be motions of their own, empty where the compiled loop can take them."""
    settings = problem.settings
    eqs = settings.moving
    if isinstance(settings.integrator, Stiff | GeneralizedAlpha | MoreauJean):
        return f"sb.{type(settings.integrator).__name__}() restarts in each step"
    if not isinstance(settings.constraints, Projection | Baumgarte | None):
        return f"sb.{type(settings.constraints).__name__}() restarts in each step"
    if eqs.formed.elimination is not None:
        return "pivots of dependent speeds are monitored"
    always = replace(problem.problem, eqs=permanent_equations(eqs))  # ropes may be slack
    if settings.constraints is None and is_overconstrained(always, numbers.t, numbers.x[:-1].copy()):
        return "some constraints are redundant only where all loops are closed"
    return ""


def broken_off(t: float, ending: Ending) -> SimulationError:
    """Return what to say about a step that did not come to its end."""
    return SimulationError(
        Problem("stepper.broke_off", f"t = {t:.9g} s", f"the step was aborted: {ending.note}",
                ending.status.value, "reset() the stepper, or restore() a state saved before")
    )  # fmt: skip
