"""`Request`: one motion that is wanted, as the integrators that take single steps read it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import PROJECTED, Projection, projector_of
from symbody.simulation.methods.explicit import (
    checked_rtol,
    checked_single_atol,
    checked_span,
    checked_times,
    goal_of,
)
from symbody.simulation.methods.stepping import Course, StepEnds
from symbody.simulation.native.interface import Projector
from symbody.simulation.native.loop import project_row
from symbody.simulation.native.places import COUNTS
from symbody.simulation.native.run import Progress, RawRun
from symbody.simulation.native.segments import Watch
from symbody.simulation.task import Task

Floats = NDArray[np.float64]

NOTHING: Final = np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class Request:
    """What moves, from which state, how far and how carefully.

    Attributes
    ----------
    x0 : (n_u + n_q + 1,) array
        Speeds, coordinates, and the work done before.
    watch : Watch, optional
        Looks for events.
    atol : float, optional
        Absolute tolerance of every state; None follows the scales of the task.
    before : RawRun, optional
        A run that was broken off where this one starts.
    breakpoints : Breakpoints
        Where what depends on time alone changes.
    """

    task: Task
    x0: Floats
    span: tuple[float, float]
    times: ArrayLike | None = None
    rtol: float = 1e-8
    atol: float | None = None
    max_steps: int = 1_000_000
    progress: Progress | None = None
    watch: Watch | None = None
    before: RawRun | None = None
    breakpoints: Breakpoints = NO_BREAKPOINTS

    def __post_init__(self) -> None:
        object.__setattr__(self, "span", checked_span(self.span))
        object.__setattr__(self, "times", checked_times(self.times, *self.span))
        object.__setattr__(self, "rtol", checked_rtol(self.rtol))
        object.__setattr__(self, "atol", checked_single_atol(self.atol))

    @property
    def eqs(self) -> EquationSet:
        """The equations."""
        return self.task.eqs

    @property
    def tolerances(self) -> Floats:
        """The absolute tolerance of each speed and coordinate (n_u + n_q,)."""
        return self.task.scales.tolerances(self.eqs, self.state, self.atol)

    @property
    def n_u(self) -> int:
        """Number of speeds."""
        return len(self.eqs.speed_names)

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return len(self.eqs.coordinate_names)

    @property
    def state(self) -> Floats:
        """The first state without the work."""
        return self.x0[:-1].copy()

    def compiled(self, outputs: str | Sequence[str], eqs: EquationSet | None = None) -> Called:
        """Return a function of time and state, by default of these equations."""
        task = self.task if eqs is None else replace(self.task, eqs=eqs)
        return Called(task.compiled(outputs), self.task.laws, self.n_u)

    def step_ends(self, share: float = 1.0) -> StepEnds:
        """Return what bounds the steps, each by a share of the piece of time it is in."""
        own = self.breakpoints
        bounds = replace(own, longest=share * own.longest)
        goal = goal_of(self.span, self.rtol, np.zeros(1), np.inf, [bounds])
        return StepEnds(goal, np.zeros(COUNTS, dtype=np.int64))

    def quaternions(self) -> list[list[int]]:
        """Return the places of each quaternion in q."""
        names = self.eqs.coordinate_names
        return [[names.index(name) for name in four] for four in self.eqs.quaternions]

    def projection(self, method: Projection) -> Closing | None:
        """Return what brings states back onto the constraints; None if there are none."""
        if not self.task.is_closed:
            return None
        function = self.task.compiled(PROJECTED)
        projector = projector_of(function, self.eqs, self.task.scales, method, self.atol)
        return Closing(function, projector, self.rtol, self.tolerances)

    def course(self, closed: Callable[[Floats, Floats], Floats] | None = None) -> Course:
        """Return the course to march; samples are brought onto the constraints by `closed`."""
        n_u, function = self.n_u, self.task.compiled("power")

        def power(t: Floats, x: Floats) -> Floats:
            values: Floats = self.task.evaluated(function, t, x[:, n_u:].T, x[:, :n_u].T)
            return values

        def unchanged(t: Floats, x: Floats) -> Floats:
            return x

        times = None if self.times is None else np.asarray(self.times)
        return Course(
            self.x0,
            *self.span,
            times,
            int(self.max_steps),
            self.progress,
            power,
            closed or unchanged,
            self.watch,
            self.before,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Called:
    """A compiled function of time and of a state x = (u, q), with the inputs that are no formulas."""

    function: CompiledFunction
    laws: InputLaws
    n_u: int

    def __call__(self, t: float, x: Floats, more: Floats = NOTHING) -> Any:
        """Return the outputs; `more` are arguments behind the inputs."""
        u, q = x[: self.n_u], x[self.n_u :]
        asked = self.laws.at(t, q, u) if self.laws.asked else NOTHING
        return self.function(t, q, u, np.concatenate([asked, more]))


@dataclass(frozen=True, slots=True, eq=False)
class Closing:
    """Brings states back onto the constraints; `function` keeps the compiled code alive."""

    function: CompiledFunction
    projector: Projector
    rtol: float
    atol: Floats

    def one(self, t: float, x: Floats) -> tuple[Floats, float]:
        """Return a closed state, and its distance from `x` over the tolerated error."""
        rows = x[np.newaxis].copy()
        moved = float(project_row(self.projector, self.rtol, self.atol, t, rows, 0))
        return rows[0], moved

    def all(self, t: Floats, x: Floats) -> Floats:
        """Return closed states; those out of reach stay what they are."""
        rows = np.ascontiguousarray(x)
        for k, time in enumerate(t):
            kept = rows[k].copy()
            if not np.isfinite(project_row(self.projector, self.rtol, self.atol, float(time), rows, k)):
                rows[k] = kept
        return rows
