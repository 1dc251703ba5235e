"""`EventWatch`: finds the events of a run slice by slice, and where it has to be cut."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.errors import Problem, UsageError
from symbody.simulation.events.crossings import TOUCHING, Crossing, crossings, find_missed_return, samples
from symbody.simulation.events.events import Event, Occurrence
from symbody.simulation.methods.constraints import PROJECTED
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.segments import Cut, steps_before
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import INSTANT

Floats = NDArray[np.float64]

# Slices where events may change the motion: what is computed beyond them is thrown away.
_ACTING_STEPS: Final = 64
_RECORDING_STEPS: Final = 1024
# So many events of one kind at one instant are one too many.
_MOST_ACTING: Final = 10
_MOST_RECORDED: Final = 100
_SIMULTANEOUS: Final = 1e-12
# A value that changes by such a share of its largest within such a share of the run has jumped.
_BESIDE: Final = 1e-10
_TORN: Final = 0.25
# Newton's method closes a state after an action in a few rounds.
_MOST_ROUNDS: Final = 8


class EventFunctions:
    """Values and actions of events, compiled.

    Parameters
    ----------
    problem : SimulationProblem
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

    def __init__(
        self, problem: SimulationProblem, events: Sequence[Event], tolerances: Floats | None
    ) -> None:
        self._problem = problem
        self._events = tuple(events)
        self._tolerances = tolerances
        self._values = problem.compile_outputs([str(event.expression) for event in events])
        self._check_shapes()
        maps = {place: event.mapping for place, event in enumerate(events) if event.mapping}
        self._maps = {
            k: problem.compile_outputs([str(value) for value in new.values()]) for k, new in maps.items()
        }
        self._check_actions()
        self._places = {k: [problem.eqs.state_names.index(name) for name in new] for k, new in maps.items()}

    def _check_shapes(self) -> None:
        outputs = zip(self._events, self._values.outputs, strict=True)
        problems = [
            Problem("simulation.event_shape", f"event {event.label!r}", f"its value has shape {output.shape}",
                    "an event watches one number", "name one component, such as 'reaction J Fx'")
            for event, output in outputs if output.shape
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)

    def _check_actions(self) -> None:
        problems = [
            Problem("simulation.event_shape", f"event {self._events[k].label!r}",
                    f"the new value of {name} has shape {output.shape}",
                    "a coordinate or speed is one number", "name one component, such as 'reaction J Fx'")
            for k, function in self._maps.items()
            for name, output in zip(self._events[k].mapping, function.outputs, strict=True) if output.shape
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)

    @cached_property
    def _projection(self) -> CompiledFunction:
        return self._problem.compile_outputs(PROJECTED)

    @cached_property
    def _energy(self) -> CompiledFunction:
        return self._problem.compile_outputs("energy")

    @property
    def may_wrap(self) -> list[bool]:
        """Whether each value reads an angle that jumps by a turn."""
        angles = self._problem.eqs.measured_angles
        return [any(name in str(event.expression) for name in angles) for event in self._events]

    def values(self, t: Floats, x: Floats) -> Floats:
        """Return the values (events, N) at times (N,) and states (n, N)."""
        q, u = self._split_state(x)
        found = self._problem.evaluate(self._values, t, q, u)
        return np.array(found if len(self._events) > 1 else [found], dtype=np.float64)

    def project(self, t: float, x: Floats) -> Floats:
        """Return a state moved back onto the constraints.

        Raises
        ------
        SimulationError
            If its mass matrix is singular.
        """
        if self._tolerances is None:
            return x
        result = x.copy()
        q, u = self._split_state(result)  # views
        for _ in range(_MOST_ROUNDS):
            found = self._call(self._projection, t, result)
            residual, move = found[0], found[1]
            if (np.abs(residual) <= self._tolerances).all():
                break
            q[: move.size] += move
        u += found[3]
        return result

    def apply_action(self, place: int, t: float, x: Floats) -> Floats:
        """Return the state after an event's action; energy that comes or goes counts as work."""
        found = self._call(self._maps[place], t, x)
        result = x.copy()
        result[self._places[place]] = np.ravel(found)
        result = self.project(t, result)
        result[-1] += self._call(self._energy, t, result) - self._call(self._energy, t, x)
        return result

    def name_states(self, x: Floats) -> dict[str, float]:
        """Return a state by name."""
        return dict(zip(self._problem.eqs.state_names, x.tolist(), strict=False))

    def _call(self, function: CompiledFunction, t: float, x: Floats) -> Any:
        q, u = self._split_state(x)
        return function(t, q, u, self._problem.laws.evaluate(t, q, u))

    def _split_state(self, x: Floats) -> tuple[Floats, Floats]:
        n_u, n = len(self._problem.eqs.speed_names), len(self._problem.eqs.state_names)
        return x[n_u:n], x[:n_u]


class EventWatch:
    """Looks for events between slices; what it finds does not depend on where the slices end.

    The newest step is looked at only when the next one is known: an extremum needs both sides.

    Parameters
    ----------
    events : sequence of Event
        In the order in which simultaneous ones happen.
    functions : EventFunctions
        Their values and actions.
    span : float
        Length of the run [s].
    just_happened : sequence of int
        Places of the events that happened at its start: their values have to leave zero first.
    """

    def __init__(
        self,
        events: Sequence[Event],
        functions: EventFunctions,
        span: float,
        just_happened: Sequence[int] = (),
    ) -> None:
        self.occurrences: list[Occurrence] = []
        self.chattering = ""
        self._events = tuple(events)
        self._functions = functions
        self._wrapping = functions.may_wrap
        self._span = span
        self._recent = [
            deque[float](maxlen=_MOST_RECORDED if event.action == "record" else _MOST_ACTING)
            for event in self._events
        ]
        self._largest = np.zeros(len(self._events))
        self._start(0, just_happened)

    def _start(self, first: int, just_happened: Sequence[int]) -> None:
        """Begin a stretch of smooth motion with step number `first`."""
        self._first = self._sampled = first
        self._just_happened = just_happened
        self._t = np.zeros(0)
        self._g = np.zeros((len(self._events), 0))
        self._later: list[Crossing] = []

    @property
    def most_steps(self) -> int:
        """How many steps a slice may have."""
        return _RECORDING_STEPS if all(event.action == "record" for event in self._events) else _ACTING_STEPS

    def look(self, breaks: Floats, pieces: Floats, steps: int, is_over: bool) -> Cut | None:
        """Return where the run has to be cut, if anywhere in its first `steps` steps; see `Watch`."""
        if steps == self._first:
            return None
        dense = DenseOutput(breaks[self._first : steps + 1], pieces[self._first : steps])
        zeros = self._later
        if steps > self._sampled:
            zeros = [*zeros, *self._sample(dense, breaks[self._sampled : steps + 1])]
            self._sampled = steps
        direction = 1.0 if dense.breaks[-1] >= dense.breaks[0] else -1.0
        horizon = dense.breaks[-1] if is_over else dense.breaks[-2]
        last = int(np.searchsorted(direction * self._t, direction * horizon))
        zeros += crossings(lambda t: self._values(dense, t), self._t, self._g, last, self._largest)
        self._largest = np.maximum(self._largest, np.abs(self._g[:, : last + 1]).max(axis=1))
        self._t, self._g = self._t[last:], self._g[:, last:]
        self._later = [crossing for crossing in zeros if direction * (crossing.t - horizon) > 0.0]
        due = [crossing for crossing in zeros if direction * (crossing.t - horizon) <= 0.0]
        cut = self._happen(dense, [c for c in due if self._counts(dense, c)], direction)
        if cut is not None and cut.after is not None:
            self._start(steps_before(breaks, steps, cut.t), self._just_happened)
        return cut

    def _values(self, dense: DenseOutput, t: Floats) -> Floats:
        inside = np.clip(t, *sorted((dense.breaks[0], dense.breaks[-1])))  # nodes may stray by rounding
        return self._functions.values(inside, dense(inside))

    def _sample(self, dense: DenseOutput, breaks: Floats) -> Iterator[Crossing]:
        """Add the samples of new steps; yield what the start of a stretch hides."""

        def values(t: Floats) -> Floats:
            return self._values(dense, t)

        t, g = samples(values, breaks)
        if self._t.size:
            self._t, self._g = np.append(self._t, t[1:]), np.hstack([self._g, g[:, 1:]])
            return
        first = np.abs(g[:, t <= breaks[1]] if t[-1] >= t[0] else g[:, t >= breaks[1]]).max(axis=1)
        is_zero = np.abs(g[:, 0]) <= TOUCHING * first
        if (g[is_zero, 0] != 0.0).any():
            is_zero &= np.abs(g[:, 0]) <= self._rounding_errors(float(t[0]), dense(t[:1])[:, 0])
        is_zero[list(self._just_happened)] = True
        g[is_zero, 0] = 0.0
        self._t, self._g = t, g
        for place in np.flatnonzero(is_zero):
            back = find_missed_return(values, int(place), t, g[place])
            if back is None:
                continue
            if back[1]:
                yield back[0]
            elif place in self._just_happened:  # its action leads back at once: that is chattering already
                recent = self._recent[place]
                recent.extend([back[0].t] * (recent.maxlen or 0))
                yield back[0]

    def _rounding_errors(self, t: float, x: Floats) -> Floats:
        """Return how much values change where time or one state does by a share of `TOUCHING`.

        A value that is the difference of larger ones is not known better; one of a small state alone is.
        """
        shares = np.concatenate([[0.0, 0.0], np.tile([-TOUCHING, TOUCHING], x.size)])
        states = np.repeat(x[:, np.newaxis], shares.size, axis=1)
        states[np.repeat(np.arange(x.size), 2), np.arange(2, shares.size)] *= 1.0 + shares[2:]
        times = np.full(shares.size, t)
        times[:2] *= 1.0 - TOUCHING, 1.0 + TOUCHING
        here = self._functions.values(np.array([t]), x[:, np.newaxis])
        changed: Floats = np.abs(self._functions.values(times, states) - here).max(axis=1)
        return changed

    def _counts(self, dense: DenseOutput, crossing: Crossing) -> bool:
        """Return whether a zero is the event: one of its direction, and no jump of an angle."""
        if self._events[crossing.place].direction not in (0, crossing.direction):
            return False
        if not self._wrapping[crossing.place]:
            return True
        beside = crossing.t + _BESIDE * self._span * np.array([-1.0, 1.0])
        before, behind = self._values(dense, beside)[crossing.place]
        return bool(abs(behind - before) <= _TORN * self._largest[crossing.place])

    def _happen(self, dense: DenseOutput, due: list[Crossing], direction: float) -> Cut | None:
        """Note what happened; return the first cut."""
        for group in _simultaneous(due, direction, _SIMULTANEOUS * max(self._span, abs(dense.breaks[-1]))):
            t = group[0].t
            x = dense(t)
            acting = [c for c in group if self._events[c.place].action != "record"]
            if acting:
                x = self._functions.project(t, x)
            after = x
            for crossing in group:
                event = self._events[crossing.place]
                self.occurrences.append(Occurrence(event.label, crossing.t, self._functions.name_states(x)))
                if self._chatters(crossing):
                    return Cut(t, x, None, Status.CHATTERING)
                if event.action == "stop":
                    return Cut(t, x, None)
                if event.mapping:
                    after = self._functions.apply_action(crossing.place, t, after)
            if acting:
                self._just_happened = [c.place for c in group]
                return Cut(t, x, after)
        return None

    def _chatters(self, crossing: Crossing) -> bool:
        recent = self._recent[crossing.place]
        recent.append(crossing.t)
        if len(recent) < (recent.maxlen or 0) or abs(recent[-1] - recent[0]) > INSTANT * self._span:
            return False
        self.chattering = self._events[crossing.place].label
        return True


def _simultaneous(found: list[Crossing], direction: float, within: float) -> Iterator[list[Crossing]]:
    """Yield zeros in the order of the motion, those of one moment together and in the order of the events."""
    group: list[Crossing] = []
    for crossing in sorted(found, key=lambda c: direction * c.t):
        if group and abs(crossing.t - group[0].t) > within:
            yield sorted(group, key=lambda c: c.place)
            group = []
        group.append(crossing)
    if group:
        yield sorted(group, key=lambda c: c.place)
