"""One motion to compute: equations with the values of parameters, and the laws of inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales
from symbody.codegen.compile import Value, form_sequence
from symbody.codegen.function import CompiledFunction, Signature
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.sequence import Sequence as Program
from symbody.simulation.events.events import Event
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, find_breakpoints
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.methods.constraints import PROJECTED
from symbody.simulation.native.dense_output import DenseOutput
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]

_MOST_ROUNDS = 8


@dataclass(frozen=True, slots=True)
class Task:
    """Equations with the values of parameters, the laws of all inputs, and what counts as large."""

    eqs: EquationSet
    parameters: Mapping[str, Value]
    laws: InputLaws
    scales: Scales
    # Functions already compiled; they follow from the fields above.
    _functions: SingleFlight[tuple[EquationSet, tuple[str, ...], bool, bool], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False, compare=False
    )
    _sequences: SingleFlight[tuple[EquationSet, tuple[str, ...]], tuple[Program, Signature]] = field(
        default_factory=SingleFlight, repr=False, compare=False
    )
    _breakpoints: dict[tuple[EquationSet, tuple[str, ...]], tuple[list[float], Breakpoints]] = field(
        default_factory=dict, repr=False, compare=False
    )

    def compiled(self, outputs: str | Sequence[str], *, quick: bool = False) -> CompiledFunction:
        """Return a function of t, q and u, and of the inputs that are asked for; `quick` for few calls."""
        is_one = isinstance(outputs, str)
        key = (self.eqs, (outputs,) if isinstance(outputs, str) else tuple(outputs), is_one, quick)

        def compiled() -> CompiledFunction:
            return CompiledFunction(*self._formed(outputs), quick=quick)

        return self._functions.get(key, compiled)

    def _formed(self, outputs: str | Sequence[str]) -> tuple[Program, Signature]:
        names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        return self._sequences.get(
            (self.eqs, names),
            lambda: form_sequence(self.eqs, outputs, self.parameters, (), self.laws.formulas),
        )

    def breakpoints(self, span: tuple[float, float], watched: Sequence[str] = ()) -> Breakpoints:
        """Return where what depends on time alone changes, in the equations and in expressions `watched`."""
        found = NO_BREAKPOINTS
        for outputs in (("xdot", "power"), tuple(watched)):
            key = self.eqs, outputs
            if outputs and (key not in self._breakpoints or not _holds(self._breakpoints[key][0], span)):
                functions = time_functions(self._formed(outputs)[0], self.laws.tables)
                pieces = NO_BREAKPOINTS if functions is None else find_breakpoints(functions, span)[0]
                self._breakpoints[key] = sorted(span), pieces
            if outputs:
                found = found.united(self._breakpoints[key][1])
        return found

    def evaluated(self, function: CompiledFunction, t: Floats, q: Floats, u: Floats) -> Any:
        """Return what a function gives at times (N,) with q (n_q, N) and u (n_u, N)."""
        return function(t, q.T, u.T, self.laws.values(t, q, u))

    def interpreted(self, output: str, t: float, q: Iterable[float], u: Iterable[float]) -> float:
        """Return a number at one state, without compiling for it."""
        sequence, _ = form_sequence(self.eqs, output, self.parameters, (), self.laws.formulas)
        q, u = list(q), list(u)
        asked = self.laws.at(t, np.array(q), np.array(u)) if self.laws.asked else []
        return float(evaluate_sequence(sequence, {"t": [t], "q": q, "u": u, "r": asked})[0][0])

    @property
    def is_closed(self) -> bool:
        """Whether states have to be projected."""
        return bool(self.eqs.multiplier_names or self.eqs.quaternions)


def _holds(known: Sequence[float], span: tuple[float, float]) -> bool:
    """Return whether a span lies in one that is known."""
    return known[0] <= min(span) and max(span) <= known[1]


@dataclass(frozen=True, slots=True)
class Evaluator:
    """Computes outputs that are not stored, each compiled when it is first asked for."""

    task: Task
    work: DenseOutput | None

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; q is (n_q, N), u is (n_u, N)."""
        return self.together((name,), t, q, u)[0]

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, all that are compiled in one function."""
        special = {name: self._special(name, t, q, u) for name in names}
        plain = tuple(name for name, values in special.items() if values is None)
        made: dict[str, Floats] = {}
        if plain:
            outputs = plain[0] if len(plain) == 1 else plain
            values = self.task.evaluated(self.task.compiled(outputs, quick=True), t, q, u)
            made = dict(zip(plain, (values,) if len(plain) == 1 else values, strict=True))
        angles = self.task.eqs.measured_angles
        return [
            _in_time(name, made[name], angles) if (array := special[name]) is None else array
            for name in names
        ]

    def _special(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats | None:
        """Return what is not compiled as it stands; None for all else."""
        if name == "work" and self.work is not None:
            done: Floats = self.work(t)[0]
            return done
        if name == "constraint_violation":
            return self._violation("constraints", t, q, u)
        if name == "velocity_violation":
            sizes = self.task.scales.displacements(self.task.eqs)[:, np.newaxis]
            fastest = np.abs(u / sizes).max(axis=0, initial=0.0)
            violation = self._violation("velocity_constraints", t, q, u)
            moving = fastest > 0.0
            return np.where(moving, violation / np.where(moving, fastest, 1.0), violation)
        return None

    def _violation(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the largest constraint over its scale at each time."""
        task = self.task
        if not task.eqs.multiplier_names:
            return np.zeros_like(t)
        values = task.evaluated(task.compiled(name, quick=True), t, q, u)
        scales = task.scales.constraints(task.eqs)[: values.shape[-1]]
        largest: Floats = np.abs(values / scales).max(axis=-1, initial=0.0)
        return largest


def _in_time(name: str, values: Floats, angles: Sequence[str]) -> Floats:
    """Return values with time last; angles measured within half a turn go on."""
    symbol = name[1:-1] if name.startswith("(") and name.endswith(")") else name
    return np.unwrap(values) if values.ndim == 1 and symbol in angles else np.moveaxis(values, 0, -1)


class EventFunctions:
    """Values and actions of events, compiled.

    Parameters
    ----------
    task : Task
        What moves.
    events : sequence of Event
        At least one.
    tolerances : (n_h,) array or None
        How far each constraint may stay open after an action; None where nothing is projected.

    Raises
    ------
    FormulationError
        If an expression has no meaning.
    UsageError
        If it is not a number but a vector or matrix.
    """

    def __init__(self, task: Task, events: Sequence[Event], tolerances: Floats | None) -> None:
        self._task = task
        self._events = tuple(events)
        self._tolerances = tolerances
        self._values = task.compiled([str(event.expression) for event in events])
        self._check_shapes()
        maps = {place: event.mapping for place, event in enumerate(events) if event.mapping}
        self._maps = {k: task.compiled([str(value) for value in new.values()]) for k, new in maps.items()}
        self._places = {k: [task.eqs.state_names.index(name) for name in new] for k, new in maps.items()}

    def _check_shapes(self) -> None:
        outputs = zip(self._events, self._values.sequence.outputs, strict=True)
        problems = [
            Problem("simulation.event_shape", f"event {event.label!r}", f"its value has shape {output.shape}",
                    "an event watches one number", "name one component, such as 'reaction J Fx'")
            for event, output in outputs if output.shape
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)

    @cached_property
    def _closing(self) -> CompiledFunction:
        return self._task.compiled(PROJECTED)

    @cached_property
    def _energy(self) -> CompiledFunction:
        return self._task.compiled("energy")

    @property
    def wrapping(self) -> list[bool]:
        """Whether each value reads an angle that jumps by a turn."""
        angles = self._task.eqs.measured_angles
        return [any(name in str(event.expression) for name in angles) for event in self._events]

    def values(self, t: Floats, x: Floats) -> Floats:
        """Return the values (events, N) at times (N,) and states (n, N)."""
        q, u = self._parted(x)
        found = self._task.evaluated(self._values, t, q, u)
        return np.array(found if len(self._events) > 1 else [found], dtype=np.float64)

    def closed(self, t: float, x: Floats) -> Floats:
        """Return a state moved back onto the constraints.

        Raises
        ------
        SimulationError
            If its mass matrix is singular.
        """
        if self._tolerances is None:
            return x
        result = x.copy()
        q, u = self._parted(result)  # views
        for _ in range(_MOST_ROUNDS):
            found = self._at(self._closing, t, result)
            residual, move = found[0], found[1]
            if (np.abs(residual) <= self._tolerances).all():
                break
            q += move
        u += found[3]
        return result

    def after(self, place: int, t: float, x: Floats) -> Floats:
        """Return the state after an event's action; energy that comes or goes counts as work."""
        found = self._at(self._maps[place], t, x)
        result = x.copy()
        result[self._places[place]] = np.ravel(found)
        result = self.closed(t, result)
        result[-1] += self._at(self._energy, t, result) - self._at(self._energy, t, x)
        return result

    def named(self, x: Floats) -> dict[str, float]:
        """Return a state by name."""
        return dict(zip(self._task.eqs.state_names, x.tolist(), strict=False))

    def _at(self, function: CompiledFunction, t: float, x: Floats) -> Any:
        q, u = self._parted(x)
        return function(t, q, u, self._task.laws.at(t, q, u))

    def _parted(self, x: Floats) -> tuple[Floats, Floats]:
        n_u, n = len(self._task.eqs.speed_names), len(self._task.eqs.state_names)
        return x[n_u:n], x[:n_u]
