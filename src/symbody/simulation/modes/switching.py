"""Motions whose equations change at events: parts in one set of modes each, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.state import State
from symbody.equations.formed import Formed
from symbody.equations.solving.ropes import ropes
from symbody.equations.solving.sticking import switching_joints
from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Event, Occurrence
from symbody.simulation.methods.request import Request
from symbody.simulation.modes.impulses import struck_times
from symbody.simulation.modes.joined import joined
from symbody.simulation.modes.modes import Mechanism, Modes, Moment, Trial, outputs_at, resolved
from symbody.simulation.modes.ropes import TAUT, ropes_of
from symbody.simulation.modes.shock import Shock, shock
from symbody.simulation.modes.stick_slip import sticking
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from symbody.simulation.task import Task
from symbody.tolerances import AT_REST, INSTANT

Floats = NDArray[np.float64]
# From a task, a first state, a span, what makes a request, and events to a motion.
Move = Callable[[Task, State, tuple[float, float], "partial[Request]", tuple[Event, ...]], Trajectory]

# So many changes at one instant are one too many.
_MOST_CHANGES: Final = 50
_MOST_TOLD: Final = 20  # shocks
_UNDETERMINED: Final = "no way of sticking and slipping fits the friction of the joints at rest"


def switches(formed: Formed) -> bool:
    """Return whether equations change at events: joints stick and slip, ropes are taut or slack."""
    return bool(switching_joints(formed) or ropes(formed))


def run_switching(
    task: Task,
    first: State,
    span: tuple[float, float],
    wanted: partial[Request],
    events: tuple[Event, ...],
    move: Move,
) -> Trajectory:
    """Return the motion of a mechanism with joints that stick and slip, or with ropes.

    `wanted` holds the times, the most steps and the progress of the whole.

    Raises
    ------
    UsageError
        If the motion runs backwards, or an event sets new values.
    """
    _check(span, events)
    _check_motions(task, first, span)
    rope = ropes_of(task)
    mechanism = Mechanism(task, tuple(kind for kind in (sticking(task.eqs.formed), rope) if kind.names))
    story = _Story(mechanism, move, wanted, span, events)
    moment = story.moment(task, span[0], np.array([*first.u.values(), *first.q.values()]), {}, {})
    while True:
        hit = shock(rope, moment) if rope.names else None
        if hit is not None and not hit.impulses:
            return story.ended(Status.SINGULAR, moment, "no speeds were found at which the ropes are taut")
        if hit is not None:
            moment = story.struck(hit, moment)
        modes = resolved(mechanism, moment)
        if modes is None:
            return story.ended(Status.FRICTION, moment, _UNDETERMINED)
        story.tell(moment, modes)
        found = story.moved(modes, moment)
        if found is None:
            return story.whole()
        moment = found
        if story.chatters(moment.t):
            return replace(story.whole(), status=Status.CHATTERING)


@dataclass(frozen=True, slots=True)
class _Story:
    """The parts of a motion so far, and what is told of it.

    Attributes
    ----------
    jumps : dict of int to float
        By how much the energy jumped before each part [J]: in shocks, and where speeds came to rest.
    fastest : list of float
        The largest speeds so far, over displacements as large as the mechanism [1/s].
    """

    mechanism: Mechanism
    move: Move
    wanted: partial[Request]
    span: tuple[float, float]
    events: tuple[Event, ...]
    parts: list[Trajectory] = field(default_factory=list)
    told: list[Occurrence] = field(default_factory=list)
    changes: list[float] = field(default_factory=list)
    jumps: dict[int, float] = field(default_factory=dict)
    shocks: list[Shock] = field(default_factory=list)
    modes: dict[str, int] = field(default_factory=dict)
    fastest: list[float] = field(default_factory=list)

    def moment(
        self, task: Task, t: float, x: Floats, before: Mapping[str, int], forced: Mapping[str, int]
    ) -> Moment:
        """Return a moment, after noting how fast the mechanism was until then."""
        scales, n_u = task.scales, len(task.eqs.speed_names)
        rates = np.abs(x[:n_u] / scales.displacements(task.eqs))
        self.fastest.append(float(rates.max(initial=1.0 / scales.time)))
        return Moment(t, x, before, forced, AT_REST * max(self.fastest), scales.length)

    def moved(self, modes: Modes, moment: Moment) -> Moment | None:
        """Add the part of the motion in some modes; return the moment they end, None if they do not."""
        t, x = moment.t, self.mechanism.held(modes, moment.t, moment.x)
        energies = [outputs_at(self.mechanism.task, ("energy",), t, state)[0] for state in (moment.x, x)]
        place = len(self.parts)
        self.jumps[place] = self.jumps.get(place, 0.0) + float(energies[1] - energies[0])
        trial = Trial(self.mechanism, modes, t, x)
        places = list(self.mechanism.places)
        watched = [kind.event(trial, k, mode) for (kind, k), mode in zip(places, modes, strict=True)]
        task = self.mechanism.of(modes)
        part = self.move(task, _state(task, t, x), (t, self.span[1]), self._rest(t), (*self.events, *watched))
        ends = [event.label for event in watched]
        self.told.extend(event for event in part.events if event.name not in ends)
        last = part.events[-1] if part.events else None
        if part.status is not Status.STOPPED or last is None or last.name not in ends:
            self.parts.append(part)
            return None
        times = self.wanted.keywords["times"]
        self.parts.append(part if times is None or part.t[-1] in np.asarray(times) else _without_end(part))
        self.changes.append(last.t)
        k = ends.index(last.name)
        x = np.array([last.state[name] for name in task.eqs.state_names])
        kind, place = places[k]
        forced = kind.forced(Trial(self.mechanism, modes, last.t, x), place, modes[k])
        sizes = task.scales.displacements(task.eqs)[:, np.newaxis]
        self.fastest.append(float(np.abs(part.u / sizes).max(initial=0.0)))
        return self.moment(task, last.t, x, dict(self.modes), forced)

    def struck(self, hit: Shock, moment: Moment) -> Moment:
        """Note a shock, return the moment after it; both states are samples, of `times` the one after."""
        if self.wanted.keywords["times"] is None:
            if not self.parts:
                self.parts.append(self._alone(moment))
        elif self.parts and self.parts[-1].t.size and self.parts[-1].t[-1] == hit.t:
            self.parts[-1] = _without_end(self.parts[-1])
        self.jumps[len(self.parts)] = hit.change
        self.shocks.append(hit)
        for name in hit.impulses:
            if self.modes.get(name) != TAUT:
                self.told.append(self._occurrence(f"{name} taut", moment))
            self.modes[name] = TAUT
        return self.moment(self.mechanism.task, hit.t, hit.x, {}, {})

    def tell(self, moment: Moment, modes: Modes) -> None:
        """Note which modes have changed."""
        for (kind, place), mode in zip(self.mechanism.places, modes, strict=True):
            name = kind.names[place]
            if self.modes.get(name, mode) != mode:
                self.told.append(self._occurrence(f"{name} {kind.word(mode)}", moment))
            self.modes[name] = mode

    def chatters(self, t: float) -> bool:
        """Return whether modes change again and again within an instant."""
        start, end = self.span
        recent = self.changes[-_MOST_CHANGES:]
        return len(self.changes) > _MOST_CHANGES and t - recent[0] < INSTANT * (end - start)

    def whole(self) -> Trajectory:
        """Return the motion so far."""
        run = joined(self.parts, self.told, self.jumps)
        notes = [hit.told for hit in self.shocks[:_MOST_TOLD]]
        rest = self.shocks[_MOST_TOLD:]
        if rest:
            lost = sum(hit.lost for hit in rest)
            notes.append(
                f"{len(rest)} more shocks of ropes until t = {rest[-1].t:.9g} s; {lost:.6g} J are lost"
            )
        return replace(run, notes=(*run.notes, *notes))

    def ended(self, status: Status, moment: Moment, why: str) -> Trajectory:
        """Return the motion up to a moment at which it cannot go on."""
        if not self.parts:
            self.parts.append(self._alone(moment))
        run = self.whole()
        return replace(run, status=status, notes=(*run.notes, f"at t = {moment.t:.9g} s {why}"))

    def _alone(self, moment: Moment) -> Trajectory:
        """Return the motion that consists of one state."""
        modes = tuple(kind.default for kind, _ in self.mechanism.places)
        task, t = self.mechanism.of(modes), moment.t
        return self.move(task, _state(task, t, moment.x), (t, t), partial(self.wanted, times=None), ())

    def _occurrence(self, name: str, moment: Moment) -> Occurrence:
        names = self.mechanism.task.eqs.state_names
        return Occurrence(name, moment.t, dict(zip(names, moment.x.tolist(), strict=True)))

    def _rest(self, t: float) -> partial[Request]:
        """Return what is wanted of the rest of a motion."""
        times, tell = self.wanted.keywords["times"], self.wanted.keywords["progress"]
        spent = sum(part.statistics.accepted + (part.statistics.rejected or 0) for part in self.parts)
        start, end = self.span
        done = (t - start) / (end - start) if self.parts else 0.0
        if times is not None and self.parts:
            times = np.asarray(times, dtype=np.float64)
            is_left = times >= t if self.shocks and self.shocks[-1].t == t else times > t
            times = times[is_left] if times.ndim == 1 else times

        def told(share: float) -> bool | None:
            answer: bool | None = tell(done + share * (1.0 - done))
            return answer

        left = self.wanted.keywords["max_steps"] - spent
        return partial(self.wanted, times=times, max_steps=left, progress=None if tell is None else told)


def _without_end(part: Trajectory) -> Trajectory:
    """Return a motion without its last sample."""
    stored = {name: values[..., :-1] for name, values in part.stored.items()}
    return replace(part, t=part.t[:-1], q=part.q[:, :-1], u=part.u[:, :-1], stored=stored)


def _state(task: Task, t: float, x: Floats) -> State:
    eqs, n_u = task.eqs, len(task.eqs.speed_names)
    q = dict(zip(eqs.coordinate_names, x[n_u:].tolist(), strict=True))
    u = dict(zip(eqs.speed_names, x[:n_u].tolist(), strict=True))
    return State(eqs, q, u, {}, {}, 0.0, {}, t)


def _check_motions(task: Task, first: State, span: tuple[float, float]) -> None:
    """Refuse prescribed rates that jump: what friction and ropes transmit in an instant is not computed.

    Raises
    ------
    UsageError
        See above.
    """
    times, _ = struck_times(task, first, span)
    if times:
        raise UsageError(
            Problem("simulation.struck_friction", "motion", f"prescribed rates jump at t = {times[0]:.9g} s",
                    "joints that stick and slip, and ropes, would be struck as well",
                    "prescribe a motion without corners, as by smoothstep; or give friction a v0, and "
                    "replace ropes by springs that only pull")
        )  # fmt: skip


def _check(span: tuple[float, float], events: tuple[Event, ...]) -> None:
    """Refuse what has no meaning together with sticking and ropes.

    Raises
    ------
    UsageError
        See above.
    """
    cure = "give friction a v0, and replace ropes by springs that only pull: their laws are smooth then"
    problems = [
        Problem("simulation.stick_slip_event", f"event {event.label!r}", "it sets new values",
                "joints that stick and slip, and ropes, would have to be looked at anew", cure)
        for event in events if event.mapping
    ]  # fmt: skip
    if span[1] < span[0]:
        problems.append(
            Problem("simulation.stick_slip_backwards", "t_end", "the motion runs backwards",
                    "what sticks, or is taut, does not tell since when", cure)
        )  # fmt: skip
    if problems:
        raise UsageError(*problems)
