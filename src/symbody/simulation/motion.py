"""`Motion`: what moves, from which state, how far, how exactly and by which method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.state import State
from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.events.event_functions import EventFunctions, gap_events, watched_outputs
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.events.events import Event, EventSide
from symbody.simulation.hybrid.passed_jumps import PassedJumps
from symbody.simulation.hybrid.rate_jumps import NO_JUMPS, PlannedJumps
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import PROJECTED, Projection, make_projector, residual_share
from symbody.simulation.methods.explicit import (
    NO_FUNCTION,
    NOTHING_TO_PROJECT,
    check_rtol,
    check_single_atol,
    check_span,
    check_times,
    make_goal,
)
from symbody.simulation.methods.stepping import Course, StepEnds
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Projector
from symbody.simulation.native.machine import step_machine
from symbody.simulation.native.run import Progress, RawRun
from symbody.simulation.native.runge_kutta import DORMAND_PRINCE_8
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.single_flight import SingleFlight

if TYPE_CHECKING:
    from symbody.simulation.hybrid.impulsive_contacts import ImpulsiveContacts
    from symbody.simulation.hybrid.switching import SwitchingModes
    from symbody.simulation.methods.integration import Constraints, Integrator

Floats = NDArray[np.float64]

NOTHING: Final = np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What moves, from which state, how far, how exactly and by which method.

    Attributes
    ----------
    x0 : (n_u + n_q + 1,) array
        Speeds, coordinates, and the work done before.
    times : array, optional
        Samples to store; None stores every step.
    atol : float, optional
        Absolute tolerance of every state; None follows the scales of the problem.
    events : tuple of Event
        What is watched on the way.
    integrator, constraints : optional
        The method that is to compute it; None leaves the choice open.
    before : RawRun, optional
        A run that was broken off where this one starts.
    sides : tuple of EventSide
        Where the values of events stood at the end of the motion that goes on here; empty where it begins.
    modes : SwitchingModes, optional
        Decides which joints stick and which gaps are closed on the way.
    first_modes : array, optional
        Those with which it begins, by default the present ones; see `begin_modes`.
    jumps : PlannedJumps
        When prescribed rates jump.
    impulses : ImpulsiveContacts, optional
        What moves gaps and friction by impulses, in steps over impacts.

    Raises
    ------
    UsageError
        If the span, times or tolerances make no sense.
    """

    problem: SimulationProblem
    x0: Floats
    span: tuple[float, float]
    times: ArrayLike | None = None
    rtol: float = 1e-8
    atol: float | None = None
    max_steps: int = 1_000_000
    progress: Progress | None = None
    events: tuple[Event, ...] = ()
    integrator: Integrator | None = None
    constraints: Constraints | None = None
    before: RawRun | None = None
    sides: tuple[EventSide, ...] = ()
    modes: SwitchingModes | None = None
    first_modes: Floats | None = None
    jumps: PlannedJumps = NO_JUMPS
    impulses: ImpulsiveContacts | None = None
    _tolerances: list[Floats] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "span", check_span(self.span))
        object.__setattr__(self, "times", check_times(self.times, *self.span))
        object.__setattr__(self, "rtol", check_rtol(self.rtol))
        object.__setattr__(self, "atol", check_single_atol(self.atol))
        if self.modes is not None and self.first_modes is None:
            object.__setattr__(self, "first_modes", self.modes.snapshot())

    def begin_modes(self) -> None:
        """Go back to the modes with which it begins: it may have been computed before, by another method."""
        if self.modes is not None and self.first_modes is not None:
            self.modes.resume(self.first_modes)

    @property
    def eqs(self) -> EquationSet:
        """The equations."""
        return self.problem.eqs

    @property
    def rows(self) -> tuple[str, ...]:
        """The multipliers of the constraints that hold at the start."""
        idle = frozenset[str]() if self.modes is None else self.modes.idle_rows
        return tuple(name for name in self.eqs.multiplier_names if name not in idle)

    @property
    def permanent_problem(self) -> SimulationProblem:
        """The problem with those constraints alone that hold in all modes."""
        return self.problem.permanent or self.problem

    @property
    def tolerances(self) -> Floats:
        """The absolute tolerance of each speed and coordinate (n_u + n_q,)."""
        if not self._tolerances:  # two threads may both compute them
            self._tolerances.append(self.problem.scales.tolerances(self.eqs, self.state, self.atol))
        return self._tolerances[0]

    @property
    def n_u(self) -> int:
        """Number of speeds."""
        return len(self.eqs.speed_names)

    @property
    def state(self) -> Floats:
        """The first state without the work."""
        return self.x0[:-1].copy()

    @property
    def breakpoints(self) -> Breakpoints:
        """Where what depends on time alone changes."""
        return self.moving_problem.breakpoints(self.span, watched_outputs(self.events))

    @property
    def moving_problem(self) -> SimulationProblem:
        """The problem whose slopes are integrated: without efforts that a method finds by itself."""
        return self.problem if self.impulses is None else self.impulses.free_problem(self.problem)

    def part(
        self, x: Floats, span: tuple[float, float], times: Floats | None, steps_before: int,
        problem: SimulationProblem | None = None,
    ) -> Motion:  # fmt: skip
        """Return the problem of a part of this motion, from a state x = (u, q).

        Parameters
        ----------
        times : array or None
            The samples of this part.
        steps_before : int
            How many steps were tried before it.
        problem : optional
            Other equations.
        """
        (start, end), progress = self.span, self.progress
        first, length = (span[0] - start) / (end - start or 1.0), (span[1] - span[0]) / (end - start or 1.0)

        def scale(share: float) -> bool | None:
            return None if progress is None else progress(first + share * length)

        return replace(
            self, problem=problem or self.problem,
            x0=np.append(x, 0.0), span=span, times=times, max_steps=self.max_steps - steps_before,
            progress=None if progress is None else scale, sides=self.sides if span[0] == start else (),
            jumps=self.jumps.part(span),
        )  # fmt: skip

    def passed_jumps(self, watch: EventWatch | None) -> PassedJumps | None:
        """Return what passes the jumps of prescribed rates in one run; None without any."""
        ends_behind = watch is not None and watch.hands_over
        planned = self.jumps.part(self.span)
        if not planned.times:
            return None
        return PassedJumps(self.problem, planned, self.span, self.modes, ends_behind=ends_behind)

    def compile_outputs(self, outputs: str | Sequence[str], eqs: EquationSet | None = None) -> StateFunction:
        """Return a function of time and state, by default of these equations."""
        problem = self.problem if eqs is None else replace(self.problem, eqs=eqs)
        return StateFunction(problem.compile_outputs(outputs), self.problem.laws, self.n_u)

    def step_ends(self, share: float = 1.0) -> StepEnds:
        """Return what bounds the steps, each by a share of the piece of time it is in."""
        bounds = self.breakpoints
        bounds = replace(bounds, longest=share * bounds.longest)
        goal = make_goal(self.span, self.rtol, NOTHING, None, bounds)
        return StepEnds(
            make_block(NO_FUNCTION, NOTHING_TO_PROJECT, DORMAND_PRINCE_8, goal, NOTHING, self.span[0])
        )

    def projection(self, method: Projection) -> StateProjector | None:
        """Return what brings states back onto the constraints; None if there are none."""
        problem = self.moving_problem
        if not problem.is_closed:
            return None
        function = problem.compile_outputs(PROJECTED)

        def make() -> Projector:
            return make_projector(function, problem.eqs, problem.scales, method, self.atol)

        projector = problem.keep(("projector", method, self.atol), make)
        projector = projector._replace(inputs=problem.laws.held_now())
        return StateProjector(function, projector, self.rtol, self.tolerances, method)

    def event_watch(self, projection: Projection, *, hands_over: bool = False) -> EventWatch | None:
        """Return what looks for events, if there are any; states after actions are closed as by a method.

        Parameters
        ----------
        hands_over : bool
            Whether the motion ends where a mode does, or where an event acts beside modes.
        """
        modes = self.modes
        ends = () if modes is None else modes.ends
        problem = self.moving_problem
        watched = (*self.events, *gap_events(problem, self.integrator), *ends)
        if not watched:
            return None

        def make() -> EventFunctions:
            return EventFunctions(problem, watched, share, hands_over=hands_over and modes is not None)

        share = residual_share(projection, self.atol)
        key = ("events", watched, share, hands_over)
        is_plain = not problem.laws.need_python and not any(event.mapping for event in watched)
        functions = problem.keep(key, make).with_problem(problem) if is_plain else make()
        return EventWatch(functions, abs(self.span[1] - self.span[0]), self.sides, modes)

    def course(self, closing: StateProjector | None, watch: EventWatch | None) -> Course:
        """Return the course to march; samples are brought onto the constraints by `closing`."""
        n_u, function = self.n_u, self.problem.compile_outputs("power")

        def power(t: Floats, x: Floats) -> Floats:
            values: Floats = self.problem.evaluate(function, t, x[:, n_u:].T, x[:, :n_u].T)
            return values

        goal = make_goal(self.span, self.rtol, np.append(self.tolerances, 1.0), None, NO_BREAKPOINTS)
        goal = goal._replace(max_trials=int(self.max_steps))
        projector = NOTHING_TO_PROJECT if closing is None else closing.projector
        rhs = NO_FUNCTION._replace(n_u=n_u)
        block = make_block(rhs, projector, DORMAND_PRINCE_8, goal, self.x0, self.span[0])
        times = None if self.times is None else np.asarray(self.times)
        return Course(
            block, projector.address, times, self.progress, power, self.before, self.passed_jumps(watch)
        )


def first_numbers(first: State) -> Floats:
    """Return x = (u, q, s) of a first state, and behind it the work done before: none."""
    return np.array([*first.u.values(), *first.q.values(), *first.s.values(), 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class StateFunction:
    """A compiled function of time and of a state x = (u, q), with the inputs that are callbacks."""

    function: CompiledFunction
    laws: InputLaws
    n_u: int

    def __call__(self, t: float, x: Floats, more: Floats = NOTHING) -> Any:
        """Return the outputs; `more` are arguments behind the inputs."""
        u, q = x[: self.n_u], x[self.n_u :]
        inputs = self.laws.evaluate(t, q, u) if self.laws.callbacks else NOTHING
        return self.function(t, q, u, np.concatenate([inputs, more]))


@dataclass(frozen=True, slots=True, eq=False)
class StateProjector:
    """Brings states back onto the constraints, by a method; `function` keeps the compiled code alive."""

    function: CompiledFunction
    projector: Projector
    rtol: float
    atol: Floats
    method: Projection
    _blocks: SingleFlight[None, Floats] = field(default_factory=SingleFlight, init=False, repr=False)

    def _make_block(self) -> Floats:
        goal = make_goal((0.0, 1.0), self.rtol, self.atol, None, NO_BREAKPOINTS)
        rhs = NO_FUNCTION._replace(n_u=self.projector.n_u)
        return make_block(rhs, self.projector, DORMAND_PRINCE_8, goal, np.zeros(self.atol.size), 0.0)

    def _project(self, t: float, x: Floats) -> float:
        """Move a state onto the constraints; return how far over the tolerated error."""
        block = self._blocks.get(None, self._make_block)
        return step_machine().project(self.projector.address, address(block), t, address(x))

    def project_one(self, t: float, x: Floats) -> tuple[Floats, float]:
        """Return a closed state, and its distance from `x` over the tolerated error."""
        rows = x[np.newaxis].copy()
        return rows[0], self._project(t, rows[0])
