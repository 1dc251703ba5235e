"""Ropes that are taut or slack.

While a rope is taut a constraint holds its ends at its length, and its tension is watched; it goes slack
where that comes to zero. While it is slack it does nothing, and the distance of its ends is watched; where
that reaches its length the rope goes taut, with a shock if the ends still move apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.ropes import AT_LENGTH
from symbody.analysis.modes.mode_decision import UNDECIDED, Opening
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.ropes import rope_words, ropes, slacken, with_words
from symbody.kernels.modes.mode_problem import HOLDS, LOOSE
from symbody.simulation.events.events import Event, LevelEvent
from symbody.simulation.hybrid.modes import HybridState, Modes, ModeTrial, evaluate_outputs
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

SLACK: Final = 0
TAUT: Final = 1
_WORDS: Final = MappingProxyType({SLACK: "slack", TAUT: "taut"})
_SLOW: Final = 1e-3  # of speeds: ends that approach faster do not come back at once
# Rows of the motion of the ropes.
_MOTION: Final = ("rope_slack", "rope_slack_dot", "rope_length")
_SLACKNESS, RATE, _LENGTH = range(3)


@dataclass(frozen=True, slots=True)
class RopeElements:
    """The ropes of a mechanism.

    Attributes
    ----------
    names : tuple of str
        Of the ropes.
    problem : SimulationProblem
        The equations with all of them taut.
    """

    names: tuple[str, ...]
    problem: SimulationProblem
    default: int = SLACK
    free: int = SLACK

    @property
    def motion_outputs(self) -> tuple[str, ...]:
        """Slackness, its rate, and the length."""
        return tuple(f"{word} {name}" for word in _MOTION for name in self.names)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Tensions."""
        return tuple(f"rope_tension {name}" for name in self.names)

    def apply_modes(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations without the ropes that are slack."""
        slack = [name for name, mode in zip(self.names, modes, strict=True) if mode == SLACK]
        return with_words(slacken(formed, slack), rope_words(self.problem.eqs.formed))

    def openings(
        self, state: HybridState, motion: Floats, accelerations: Mapping[str, float]
    ) -> dict[str, Opening]:
        """Return slack for ropes that are shorter or whose ends approach; the others are undecided.

        A rope that is taut again before its ends have measurably approached stays taut.
        """
        openings: dict[str, Opening] = {}
        tight = self.tight(state.before, motion)
        for k, name in enumerate(self.names):
            rate = self._approach(state, k, motion)
            back = -accelerations.get(name, 0.0)
            is_slack = name in state.forced_modes or not tight[k]
            if rate > state.small * state.length:
                is_fast = rate > _SLOW / BALANCED * state.small * state.length
                is_slack |= is_fast or not rate**2 <= 2.0 * back * AT_LENGTH * motion[_LENGTH, k]
            openings[name] = Opening(LOOSE, is_decided=True) if is_slack else UNDECIDED
        return openings

    def mode_of(self, kernel_mode: int) -> int:
        """Return taut for what holds."""
        return TAUT if kernel_mode == HOLDS else SLACK

    def _approach(self, state: HybridState, place: int, motion: Floats) -> float:
        """Return the rate at which the ends of a rope approach; 0 where the rope was taut, whatever drift."""
        return 0.0 if state.before.get(self.names[place]) == TAUT else float(motion[RATE, place])

    def tight(self, before: Mapping[str, int], motion: Floats) -> NDArray[np.bool_]:
        """Return which ropes are at their length: those that were taut are, whatever drift there is."""
        were = np.array([before.get(name) == TAUT for name in self.names], dtype=np.bool_)
        closed: NDArray[np.bool_] = were | (motion[_SLACKNESS] <= AT_LENGTH * motion[_LENGTH])
        return closed

    def end_event(self, trial: ModeTrial, place: int, mode: int) -> Event:
        """Return what ends a mode: no tension, or the rope's length."""
        name = f"end of {self.word(mode)}: rope {self.names[place]}"
        word = rope_words(self.problem.eqs.formed)[self.names[place]]
        if mode == SLACK:
            motion = self.motion_values(trial.t, trial.x)[:, place]
            # At its length up to rounding it is exactly there: an event has to leave zero first.
            start = motion[_SLACKNESS] if abs(motion[_SLACKNESS]) <= AT_LENGTH * motion[_LENGTH] else 0.0
            return LevelEvent(word, -1, "stop", name, float(start))
        return LevelEvent(word, 1, "stop", name, self._limit(trial, place))

    def forced_modes(self, trial: ModeTrial, place: int, mode: int) -> Mapping[str, int]:
        """Return that a rope without tension goes slack; one at its length may do either."""
        return {self.names[place]: SLACK} if mode == TAUT else {}

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        return _WORDS[mode]

    def motion_values(self, t: float, x: Floats) -> Floats:
        """Return slackness, its rate, and length of the ropes."""
        values = np.array(evaluate_outputs(self.problem, self.motion_outputs, t, x), dtype=np.float64)
        return values.reshape(len(_MOTION), -1)

    def longer_ropes(self, t: float, x: Floats) -> list[str]:
        """Return the ropes whose ends are farther apart than they are long."""
        motion = self.motion_values(t, x)
        longer = motion[_SLACKNESS] < -AT_LENGTH * motion[_LENGTH]
        return [name for name, is_longer in zip(self.names, longer, strict=True) if is_longer]

    def _limit(self, trial: ModeTrial, place: int) -> float:
        """Return the tension that is rounding: that of the mass the rope moves, by what cancels."""
        return trial.mechanism.numbers(trial.t, trial.x).slight_effort(self.names[place])


def rope_elements(problem: SimulationProblem) -> RopeElements:
    """Return the ropes of a mechanism."""
    return RopeElements(ropes(problem.eqs.formed), problem)
