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

from symbody.analysis.ropes import AT_LENGTH
from symbody.equations.formed import Formed
from symbody.equations.solving.ropes import rope_rows, rope_words, ropes, slackened, with_words
from symbody.expr.saddle import solve_saddle
from symbody.simulation.events.events import Event
from symbody.simulation.modes.modes import Modes, Moment, Trial, outputs_at
from symbody.simulation.task import Task
from symbody.tolerances import BALANCED, CANCELLED

Floats = NDArray[np.float64]

SLACK: Final = 0
TAUT: Final = 1
_WORDS: Final = MappingProxyType({SLACK: "slack", TAUT: "taut"})
_SLOW: Final = 1e-3  # of speeds: ends that approach faster do not come back at once
# Rows of what is seen of the ropes, and of what is known of them in some modes.
_SEEN: Final = ("rope_slack", "rope_slack_dot", "rope_length")
_SLACKNESS, RATE, _LENGTH = range(3)
_OUTPUTS: Final = ("rope_slack_ddot", "rope_tension", "rope_size")
_ACCELERATION, _TENSION, _SIZE = range(3)


@dataclass(frozen=True, slots=True)
class Ropes:
    """The ropes of a mechanism.

    Attributes
    ----------
    names : tuple of str
        Of the ropes.
    task : Task
        The equations with all of them taut.
    """

    names: tuple[str, ...]
    task: Task
    default: int = SLACK

    @property
    def seen(self) -> tuple[str, ...]:
        """Slackness, its rate, and the length."""
        return tuple(f"{word} {name}" for word in _SEEN for name in self.names)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Second rate of the slackness, tension, and what cancels in that rate."""
        return tuple(f"{word} {name}" for word in _OUTPUTS for name in self.names)

    def applied(self, formed: Formed, modes: Modes) -> Formed:
        """Return equations without the ropes that are slack."""
        slack = [name for name, mode in zip(self.names, modes, strict=True) if mode == SLACK]
        return with_words(slackened(formed, slack), rope_words(self.task.eqs.formed))

    def ways(self, moment: Moment, seen: Floats) -> list[tuple[int, ...]]:
        """Return slack for ropes that are shorter or whose ends approach; others stay taut if they can."""
        ways: list[tuple[int, ...]] = []
        tight = self.tight(moment.before, seen)
        for k, name in enumerate(self.names):
            parting = self._approach(moment, k, seen) > _SLOW / BALANCED * moment.small * moment.length
            if name in moment.forced or not tight[k] or parting:
                ways.append((SLACK,))
            else:
                ways.append((TAUT, SLACK))
        return ways

    def _approach(self, moment: Moment, place: int, seen: Floats) -> float:
        """Return the rate at which the ends of a rope approach; 0 where the rope was taut, whatever drift."""
        return 0.0 if moment.before.get(self.names[place]) == TAUT else float(seen[RATE, place])

    def tight(self, before: Mapping[str, int], seen: Floats) -> NDArray[np.bool_]:
        """Return which ropes are at their length: those that were taut are, whatever drift there is."""
        were = np.array([before.get(name) == TAUT for name in self.names], dtype=np.bool_)
        closed: NDArray[np.bool_] = were | (seen[_SLACKNESS] <= AT_LENGTH * seen[_LENGTH])
        return closed

    def overload(self, modes: Modes, found: Floats) -> Floats:
        """Return how hard taut ropes would have to push."""
        return np.where([mode == TAUT for mode in modes], -found[_TENSION], -np.inf)

    def relieved(self, place: int, found: Floats) -> int:
        """Return slack."""
        return SLACK

    def fits(self, trial: Trial, place: int, at: int, is_open: bool) -> bool:
        """Return whether a taut rope pulls, or the ends of a slack one at its length do not move apart."""
        found, seen = trial.found(self)[:, place], self.seen_at(trial.t, trial.x)
        rate = 0.0 if trial.moment is None else self._approach(trial.moment, place, seen)
        is_parting = trial.moment is not None and rate > trial.moment.small * trial.moment.length
        if trial.modes[at] == TAUT:
            pulls = bool(found[_TENSION] >= -BALANCED / CANCELLED * self._limit(trial, place))
            if not (pulls and is_parting):
                return pulls
            # What comes back before its ends have come closer than can be told has not left.
            back = -trial.other(at, SLACK).found(self)[_ACCELERATION, place]
            return bool(rate**2 <= 2.0 * back * AT_LENGTH * seen[_LENGTH, place])
        return not is_open or is_parting or bool(found[_ACCELERATION] >= -BALANCED * found[_SIZE])

    def event(self, trial: Trial, place: int, mode: int) -> Event:
        """Return what ends a mode: no tension, or the rope's length."""
        name = f"end of {self.word(mode)}: rope {self.names[place]}"
        word = rope_words(self.task.eqs.formed)[self.names[place]]
        if mode == SLACK:
            seen = self.seen_at(trial.t, trial.x)[:, place]
            # At its length up to rounding it is exactly there: an event has to leave zero first.
            start = seen[_SLACKNESS] if abs(seen[_SLACKNESS]) <= AT_LENGTH * seen[_LENGTH] else 0.0
            return Event(f"{word} - ({float(start)!r})", direction=-1, action="stop", name=name)
        limit = self._limit(trial, place)
        return Event(f"{word} - {limit!r}", direction=1, action="stop", name=name)

    def forced(self, trial: Trial, place: int, mode: int) -> Mapping[str, int]:
        """Return that a rope without tension goes slack; one at its length may do either."""
        return {self.names[place]: SLACK} if mode == TAUT else {}

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        return _WORDS[mode]

    def seen_at(self, t: float, x: Floats) -> Floats:
        """Return what is seen of the ropes."""
        values = np.array(outputs_at(self.task, self.seen, t, x), dtype=np.float64)
        return values.reshape(len(_SEEN), -1)

    def _limit(self, trial: Trial, place: int) -> float:
        """Return the tension that is rounding: that of the mass the rope moves, by what cancels."""
        mass, rows = outputs_at(self.task, ("mass_matrix", "jacobian"), trial.t, trial.x)
        row = rope_rows(self.task.eqs.formed, self.names)[place]
        others = [k for k in range(len(rows)) if k not in rope_rows(self.task.eqs.formed, self.names)]
        chosen = rows[[*others, row]]
        gamma = [*[0.0] * len(others), 1.0]
        solution = solve_saddle(mass.ravel().tolist(), chosen.ravel().tolist(), [0.0] * len(mass), gamma)
        moved = abs(solution.multipliers[-1]) if solution.ok else 0.0
        return float(CANCELLED * moved * trial.found(self)[_SIZE, place])


def ropes_of(task: Task) -> Ropes:
    """Return the ropes of a mechanism."""
    return Ropes(ropes(task.eqs.formed), task)
