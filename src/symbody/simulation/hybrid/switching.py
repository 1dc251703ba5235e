"""Motions whose equations change at events: parts in one set of modes each, one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import Verdict
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.ropes import ropes
from symbody.equations.solving.sticking import switching_joints
from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Event, Occurrence
from symbody.simulation.execution import execute
from symbody.simulation.hybrid.concatenate import concatenate
from symbody.simulation.hybrid.impact import RopeImpact, rope_impact
from symbody.simulation.hybrid.modes import (
    HybridMechanism,
    HybridState,
    Modes,
    ModeTrial,
    evaluate_outputs,
    find_modes,
)
from symbody.simulation.hybrid.rate_jumps import jump_times
from symbody.simulation.hybrid.ropes import TAUT, rope_elements
from symbody.simulation.hybrid.stick_slip import stick_slip_joints
from symbody.simulation.methods.integration import MotionPlan
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import AT_REST, INSTANT

Floats = NDArray[np.float64]
# So many changes at one instant are one too many.
_MOST_CHANGES: Final = 50
_MOST_NOTES: Final = 20  # of impacts
_UNDETERMINED: Final = MappingProxyType(
    {
        Verdict.NONE: "no combination of sticking and slipping is consistent with the friction of the joints",
        Verdict.TWO: "two combinations of sticking and slipping, with different accelerations, are "
        "consistent with the friction of the joints",
        Verdict.NOT_FOUND: "no combination of sticking and slipping was found that is consistent with "
        "the friction of the joints",
    }
)


def switches(formed: EquationsOfMotion) -> bool:
    """Return whether equations change at events: joints stick and slip, ropes are taut or slack."""
    return bool(switching_joints(formed) or ropes(formed))


def hybrid_mechanism(problem: SimulationProblem) -> HybridMechanism:
    """Return a mechanism with its joints that stick and slip, and its ropes."""
    kinds = (stick_slip_joints(problem.eqs.formed), rope_elements(problem))
    return HybridMechanism(problem, tuple(kind for kind in kinds if kind.names))


def run_switching(plan: MotionPlan, *, goes_on: bool = False) -> Trajectory:
    """Return the motion of a mechanism with joints that stick and slip, or with ropes.

    Parameters
    ----------
    goes_on : bool
        Whether another motion goes on at the end, so that a jump of prescribed rates there is one of this.

    Raises
    ------
    UsageError
        If the motion runs backwards, an event sets new values, or prescribed rates jump.
    """
    integration = plan.integration
    problem, (start, _), x = integration.problem, integration.span, integration.state
    _check(integration.span, integration.events)
    _check_motions(problem, x, integration.span, goes_on)
    mechanism = hybrid_mechanism(problem)
    has_ropes = bool(ropes(problem.eqs.formed))
    history = _History(mechanism, plan)
    state = history.state(problem, start, x, {}, {})
    while True:
        impact = rope_impact(mechanism, rope_elements(problem), state) if has_ropes else None
        if impact is not None and not impact.impulses:
            return history.end(Status.SINGULAR, state, "no speeds were found that keep the ropes taut")
        if impact is not None:
            state = history.note_impact(impact, state)
        modes, verdict = find_modes(mechanism, state)
        if modes is None:
            return history.end(Status.FRICTION, state, _UNDETERMINED[verdict])
        history.note_modes(state, modes)
        next_state = history.run_part(modes, state)
        if next_state is None:
            return history.trajectory()
        state = next_state
        if history.chatters(state.t):
            return replace(history.trajectory(), status=Status.CHATTERING)


@dataclass(frozen=True, slots=True)
class _History:
    """The parts of a motion so far, and the events between them.

    Attributes
    ----------
    plan : Plan
        Of the whole motion.
    part_modes : list of tuple
        The modes of each part.
    jumps : dict of int to float
        By how much the energy jumped before each part [J]: in impacts, and where speeds came to rest.
    fastest : list of float
        The largest speeds so far, over displacements as large as the mechanism [1/s].
    """

    mechanism: HybridMechanism
    plan: MotionPlan
    parts: list[Trajectory] = field(default_factory=list)
    part_modes: list[Modes] = field(default_factory=list)
    occurrences: list[Occurrence] = field(default_factory=list)
    changes: list[float] = field(default_factory=list)
    jumps: dict[int, float] = field(default_factory=dict)
    impacts: list[RopeImpact] = field(default_factory=list)
    modes: dict[str, int] = field(default_factory=dict)
    fastest: list[float] = field(default_factory=list)

    def state(
        self,
        problem: SimulationProblem,
        t: float,
        x: Floats,
        before: Mapping[str, int],
        forced_modes: Mapping[str, int],
    ) -> HybridState:
        """Return a state, after noting how fast the mechanism was until then."""
        scales, n_u = problem.scales, len(problem.eqs.speed_names)
        rates = np.abs(x[:n_u] / scales.displacements(problem.eqs))
        self.fastest.append(float(rates.max(initial=1.0 / scales.time)))
        return HybridState(t, x, before, forced_modes, AT_REST * max(self.fastest), scales.length)

    def run_part(self, modes: Modes, state: HybridState) -> HybridState | None:
        """Add the part of the motion in some modes; return the state in which they end, if they do."""
        mechanism = self.mechanism
        t, x = state.t, mechanism.fit_speeds(modes, state.t, state.x)
        if x is not state.x:
            energies = [evaluate_outputs(mechanism.problem, ("energy",), t, y)[0] for y in (state.x, x)]
            place = len(self.parts)
            self.jumps[place] = self.jumps.get(place, 0.0) + float(energies[1] - energies[0])
        trial = ModeTrial(mechanism, modes, t, x)
        elements = list(mechanism.elements)
        ends = [kind.end_event(trial, k, mode) for (kind, k), mode in zip(elements, modes, strict=True)]
        part = execute(self._plan_part(mechanism.problem_in(modes), t, x, ends))
        labels = [event.label for event in ends]
        self.occurrences.extend(event for event in part.events if event.name not in labels)
        self.part_modes.append(modes)
        last = part.events[-1] if part.events else None
        if part.status is not Status.STOPPED or last is None or last.name not in labels:
            self.parts.append(part)
            return None
        times = self.plan.integration.times
        self.parts.append(
            part if times is None or part.t[-1] in np.asarray(times) else _drop_last_sample(part)
        )
        self.changes.append(last.t)
        return self._find_state_after(modes, labels.index(last.name), last, part)

    def _find_state_after(self, modes: Modes, place: int, last: Occurrence, part: Trajectory) -> HybridState:
        """Return the state in which one element ended its mode."""
        problem = self.mechanism.problem_in(modes)
        x = np.array([last.state[name] for name in problem.eqs.state_names])
        kind, k = list(self.mechanism.elements)[place]
        forced_modes = kind.forced_modes(ModeTrial(self.mechanism, modes, last.t, x), k, modes[place])
        sizes = problem.scales.displacements(problem.eqs)[:, np.newaxis]
        self.fastest.append(float(np.abs(part.u / sizes).max(initial=0.0)))
        return self.state(problem, last.t, x, dict(self.modes), forced_modes)

    def note_impact(self, impact: RopeImpact, state: HybridState) -> HybridState:
        """Note an impact, return the state after it; both states are samples, of `times` the one after."""
        if self.plan.integration.times is None:
            if not self.parts:
                self._add_state(state)
        elif self.parts and self.parts[-1].t.size and self.parts[-1].t[-1] == impact.t:
            self.parts[-1] = _drop_last_sample(self.parts[-1])
        self.jumps[len(self.parts)] = impact.change
        self.impacts.append(impact)
        for name in impact.impulses:
            if self.modes.get(name) != TAUT:
                self.occurrences.append(self._occurrence(f"{name} taut", state))
            self.modes[name] = TAUT
        return self.state(self.mechanism.problem, impact.t, impact.x, {}, {})

    def note_modes(self, state: HybridState, modes: Modes) -> None:
        """Note which modes have changed."""
        for (kind, place), mode in zip(self.mechanism.elements, modes, strict=True):
            name = kind.names[place]
            if self.modes.get(name, mode) != mode:
                self.occurrences.append(self._occurrence(f"{name} {kind.word(mode)}", state))
            self.modes[name] = mode

    def chatters(self, t: float) -> bool:
        """Return whether modes change again and again within an instant."""
        start, end = self.plan.integration.span
        recent = self.changes[-_MOST_CHANGES:]
        return len(self.changes) > _MOST_CHANGES and t - recent[0] < INSTANT * (end - start)

    def trajectory(self) -> Trajectory:
        """Return the motion so far."""
        run = concatenate(self.parts, self.occurrences, self.jumps, self.part_modes)
        notes = [impact.note for impact in self.impacts[:_MOST_NOTES]]
        others = self.impacts[_MOST_NOTES:]
        if others:
            lost = sum(impact.lost for impact in others)
            notes.append(
                f"{len(others)} more impacts of ropes until t = {others[-1].t:.9g} s; {lost:.6g} J are lost"
            )
        return replace(run, notes=(*run.notes, *notes))

    def end(self, status: Status, state: HybridState, why: str) -> Trajectory:
        """Return the motion up to a state in which it cannot go on."""
        if not self.parts:
            self._add_state(state)
        run = self.trajectory()
        return replace(run, status=status, notes=(*run.notes, f"at t = {state.t:.9g} s {why}"))

    def _add_state(self, state: HybridState) -> None:
        """Add the motion that consists of one state."""
        modes = tuple(kind.default for kind, _ in self.mechanism.elements)
        integration = replace(
            self.plan.integration, problem=self.mechanism.problem_in(modes), x0=np.append(state.x, 0.0),
            span=(state.t, state.t), times=None, events=(),
        )  # fmt: skip
        self.parts.append(execute(replace(self.plan, integration=integration)))
        self.part_modes.append(modes)

    def _occurrence(self, name: str, state: HybridState) -> Occurrence:
        names = self.mechanism.problem.eqs.state_names
        return Occurrence(name, state.t, dict(zip(names, state.x.tolist(), strict=True)))

    def _plan_part(
        self, problem: SimulationProblem, t: float, x: Floats, ends: Sequence[Event]
    ) -> MotionPlan:
        """Return the plan of the motion from a state on, in modes that end at events."""
        whole = self.plan.integration
        steps = sum(part.statistics.accepted + (part.statistics.rejected or 0) for part in self.parts)
        times = None if whole.times is None else np.asarray(whole.times)
        if times is not None and self.parts:
            times = times[times >= t if self.impacts and self.impacts[-1].t == t else times > t]
        events = (*whole.events, *ends)
        part = whole.part(x, (t, whole.span[1]), times, steps, problem, events)
        return replace(self.plan, integration=part)


def _drop_last_sample(part: Trajectory) -> Trajectory:
    """Return a motion without its last sample."""
    stored = {name: values[..., :-1] for name, values in part.stored.items()}
    return replace(part, t=part.t[:-1], q=part.q[:, :-1], u=part.u[:, :-1], s=part.s[:, :-1], stored=stored)


def _check_motions(problem: SimulationProblem, x: Floats, span: tuple[float, float], goes_on: bool) -> None:
    """Refuse prescribed rates that jump: what friction and ropes transmit in an instant is not computed.

    Raises
    ------
    UsageError
        See above.
    """
    times, _ = jump_times(problem, x, span, at_end=goes_on)
    if times:
        raise UsageError(
            Problem("simulation.struck_friction", "motion", f"prescribed rates jump at t = {times[0]:.9g} s",
                    "joints that stick and slip, and ropes, would be hit by the jump as well",
                    "prescribe a motion without corners, for instance with smoothstep; or give friction a "
                    "v0, and replace ropes by springs that only pull")
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
                "joints that stick and slip, and ropes, would have to be reinitialized", cure)
        for event in events if event.mapping
    ]  # fmt: skip
    if span[1] < span[0]:
        problems.append(
            Problem("simulation.stick_slip_backwards", "t_end", "the motion runs backwards",
                    "how long a joint sticks, or a rope is taut, depends on the motion before", cure)
        )  # fmt: skip
    if problems:
        raise UsageError(*problems)
