"""Joints that stick and slip, and ropes: their modes along a motion, and shocks at which ropes go taut."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeVerdict
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.ropes import ropes
from symbody.equations.solving.sticking import switching_joints
from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Event, Occurrence
from symbody.simulation.execution import MotionPiece
from symbody.simulation.hybrid.impact import Impact, separating_ropes, shock, strike
from symbody.simulation.hybrid.modes import (
    HybridMechanism,
    HybridState,
    Modes,
    ModeTrial,
    evaluate_outputs,
    find_modes,
)
from symbody.simulation.hybrid.rate_jumps import struck_friction
from symbody.simulation.hybrid.ropes import TAUT, RopeElements, rope_elements
from symbody.simulation.hybrid.stick_slip import stick_slip_joints
from symbody.simulation.motion import Motion
from symbody.simulation.pieces import MotionInstant, Pieces
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import AT_REST

Floats = NDArray[np.float64]
_MOST_NOTES: Final = 20  # of impacts
_UNDETERMINED: Final = MappingProxyType(
    {
        ModeVerdict.NONE: "no combination of sticking and slipping is consistent with the friction of the "
        "joints",
        ModeVerdict.TWO: "two combinations of sticking and slipping, with different accelerations, are "
        "consistent with the friction of the joints",
        ModeVerdict.NOT_FOUND: "no combination of sticking and slipping was found that is consistent with "
        "the friction of the joints",
    }
)
_SMOOTH: Final = "give friction a v0, and replace ropes by springs that only pull: their laws are smooth then"


def switches(formed: EquationsOfMotion) -> bool:
    """Return whether equations change at events: joints stick and slip, ropes are taut or slack."""
    return bool(switching_joints(formed) or ropes(formed))


class DeadEndError(Exception):
    """A motion cannot go on.

    Attributes
    ----------
    t : float
        When [s].
    status : Status
        The verdict.
    why : str
        In words, to stand behind the time.
    """

    def __init__(self, t: float, status: Status, why: str) -> None:
        super().__init__(why)
        self.t, self.status, self.why = t, status, why


class PieceStart(NamedTuple):
    """A state between two pieces of a motion.

    Attributes
    ----------
    x : array
        The state (u, q, s).
    before : mapping of name to mode, optional
        Modes that still matter: none where an action or an impact has changed the state, by default all.
    forced : mapping of name to mode
        Modes that an event has decided.
    """

    t: float
    x: Floats
    before: Mapping[str, int] | None = None
    forced: Mapping[str, int] = MappingProxyType({})


class SwitchingModes:
    """The modes of the joints that stick and slip, and of the ropes, along a motion.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.
    pieces : Pieces
        The motion so far.

    Attributes
    ----------
    modes : Modes
        Those of the present piece.
    ends : tuple of Event
        What ends them.
    known : dict of name to mode
        Those decided last.
    """

    def __init__(self, problem: SimulationProblem, pieces: Pieces) -> None:
        self.mechanism = hybrid_mechanism(problem)
        self.modes: Modes = ()
        self.ends: tuple[Event, ...] = ()
        self._pieces = pieces
        self.known: dict[str, int] = {}
        self._fastest = 0.0  # speeds over displacements as large as the mechanism [1/s]
        self._impacts: list[Impact] = []

    @property
    def problem(self) -> SimulationProblem:
        """The equations in the present modes."""
        return self.mechanism.problem_in(self.modes)

    @property
    def free(self) -> SimulationProblem:
        """The equations in which no joint is held and no rope is taut."""
        return self.mechanism.problem_in(tuple(kind.free for kind, _ in self.mechanism.elements))

    @property
    def ropes(self) -> RopeElements | None:
        """The ropes, if there are any."""
        return next((kind for kind in self.mechanism.kinds if isinstance(kind, RopeElements)), None)

    def use(self, problem: SimulationProblem) -> None:
        """Go on with other values of inputs."""
        self.mechanism = hybrid_mechanism(problem)

    def settle(self, state: PieceStart) -> Floats:
        """Let ropes strike and decide the modes; return the state (u, q, s) with speeds that fit them.

        Raises
        ------
        DeadEndError
            If there are no modes, or no speeds.
        """
        t, x = state.t, state.x
        before = self.known if state.before is None else state.before
        at = self._hybrid_state(t, x, before, state.forced)
        if self.ropes is not None and separating_ropes(self.ropes, at):
            found = shock(self.mechanism, self.ropes, at)
            if found is None:
                raise DeadEndError(t, Status.SINGULAR, "no speeds were found that keep the ropes taut")
            self._pieces.begin_behind(t, self._first_state(t, x))
            self._pieces.add_energy(found.change)
            x = self._note_impact(found, x).x
            at = self._hybrid_state(t, x, {}, {})
        modes, verdict = find_modes(self.mechanism, at)
        if modes is None:
            raise DeadEndError(t, Status.FRICTION, _UNDETERMINED[verdict])
        self._note_modes(modes, t, x)
        return self._begin(modes, t, x)

    def _hybrid_state(
        self, t: float, x: Floats, before: Mapping[str, int], forced: Mapping[str, int]
    ) -> HybridState:
        """Return a state, after noting how fast the mechanism was until then."""
        problem = self.mechanism.problem
        scales, n_u = problem.scales, len(problem.eqs.speed_names)
        rates = np.abs(x[:n_u] / scales.displacements(problem.eqs))
        self._fastest = max(self._fastest, float(rates.max(initial=1.0 / scales.time)))
        return HybridState(t, x, before, forced, AT_REST * self._fastest, scales.length)

    def _begin(self, modes: Modes, t: float, x: Floats) -> Floats:
        """Begin a piece in some modes; return the state with speeds that fit them."""
        mechanism = self.mechanism
        self.modes = modes
        fitted = mechanism.fit_speeds(modes, t, x)
        if fitted is not x:
            energies = [evaluate_outputs(mechanism.problem, ("energy",), t, y)[0] for y in (x, fitted)]
            self._pieces.add_energy(float(energies[1] - energies[0]))
        trial = ModeTrial(mechanism, modes, t, fitted)
        pairs = zip(mechanism.elements, modes, strict=True)
        self.ends = tuple(kind.end_event(trial, k, mode) for (kind, k), mode in pairs)
        return fitted

    def state_behind(self, piece: MotionPiece) -> PieceStart | None:
        """Return the state in which one element ended its mode; None where none did."""
        labels = [event.label for event in self.ends]
        last = piece.happened[-1] if piece.happened else None
        if last is None or last.name not in labels:
            return None
        place, problem = labels.index(last.name), self.problem
        x = np.array([last.state[name] for name in problem.eqs.state_names])
        kind, k = list(self.mechanism.elements)[place]
        forced = kind.forced_modes(ModeTrial(self.mechanism, self.modes, last.t, x), k, self.modes[place])
        return PieceStart(last.t, x, None, forced)

    def note_speeds(self, run: Trajectory) -> None:
        """Note how fast the mechanism was in a piece."""
        sizes = self.problem.scales.displacements(self.problem.eqs)[:, np.newaxis]
        self._fastest = max(self._fastest, float(np.abs(run.u / sizes).max(initial=0.0)))

    def strike(self, t: float, x: Floats, momenta: Floats) -> Impact | None:
        """Return what a jump of the momenta that prescribed rates give does; None if no speeds were found."""
        at = self._hybrid_state(t, x, self.known, {})
        found = strike(self.mechanism, self.ropes, at, momenta)
        return None if found is None else self._note_impact(found, x)

    def _note_impact(self, found: Impact, before: Floats) -> Impact:
        """Note an impact at a state, in which ropes may have gone taut."""
        if found.impulses:
            self._impacts.append(found)
        for name in found.impulses:
            if self.known.get(name) != TAUT:
                self._note(f"{name} taut", found.t, before)
            self.known[name] = TAUT
        return found

    def _note_modes(self, modes: Modes, t: float, x: Floats) -> None:
        for (kind, place), mode in zip(self.mechanism.elements, modes, strict=True):
            name = kind.names[place]
            if self.known.get(name, mode) != mode:
                self._note(f"{name} {kind.word(mode)}", t, x)
            self.known[name] = mode

    def _note(self, name: str, t: float, x: Floats) -> None:
        names = self.mechanism.problem.eqs.state_names
        self._pieces.occurrences.append(Occurrence(name, t, dict(zip(names, x.tolist(), strict=True))))

    def _first_state(self, t: float, x: Floats) -> Motion:
        """Return the motion that consists of one state."""
        default = tuple(kind.default for kind, _ in self.mechanism.elements)
        return self._pieces.plan(self.mechanism.problem_in(default), x, t, MotionInstant("start", t, t, t))

    def check_ropes(self, t: float, x: Floats, label: str) -> None:
        """Refuse a state, set by an event, in which a rope is longer than it can be.

        Raises
        ------
        DeadEndError
            See above.
        """
        if self.ropes is None:
            return
        longer = self.ropes.longer_ropes(t, x)
        if longer:
            why = (
                f"the action of event {label!r} moves the ends of {', '.join(longer)} farther apart than the "
                f"rope is long; set coordinates within its length"
            )
            raise DeadEndError(t, Status.UNMET_ACTION, why)

    @property
    def notes(self) -> Iterator[str]:
        """The impacts in words."""
        yield from (each.note for each in self._impacts[:_MOST_NOTES])
        others = self._impacts[_MOST_NOTES:]
        if others:
            lost = sum(each.lost or 0.0 for each in others)
            yield f"{len(others)} more impacts of ropes until t = {others[-1].t:.9g} s; {lost:.6g} J are lost"


def hybrid_mechanism(problem: SimulationProblem) -> HybridMechanism:
    """Return a mechanism with its joints that stick and slip, and its ropes."""
    kinds = (stick_slip_joints(problem.eqs.formed), rope_elements(problem))
    return HybridMechanism(problem, tuple(kind for kind in kinds if kind.names))


def check_backwards(span: tuple[float, float]) -> None:
    """Refuse motions that run backwards.

    Raises
    ------
    UsageError
        See above.
    """
    if span[1] < span[0]:
        raise UsageError(
            Problem("simulation.stick_slip_backwards", "t_end", "the motion runs backwards",
                    "how long a joint sticks, or a rope is taut, depends on the motion before", _SMOOTH)
        )  # fmt: skip


def check_strike(formed: EquationsOfMotion, t: float) -> None:
    """Refuse a jump of prescribed rates under friction that grows with reactions, which are infinite then.

    Raises
    ------
    UsageError
        See above.
    """
    names = struck_friction(formed, switches=True)
    if names:
        raise UsageError(
            Problem("simulation.struck_friction", "motion", f"prescribed rates jump at t = {t:.9g} s",
                    f"the reactions on which the friction of {', '.join(names)} depends are infinite there",
                    "prescribe a motion without corners, for instance with smoothstep; or give friction as a "
                    "force, or a v0")
        )  # fmt: skip
