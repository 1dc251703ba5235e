"""`ModeRecord`: the modes of a motion, and the shocks of ropes, as its kernel wrote them down."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.modes.mode_problem import HOLDS
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch
from symbody.simulation.events.events import ModeChange, Occurrence
from symbody.simulation.inputs.held_law import HeldRecord

Floats = NDArray[np.float64]

_FIRST_ROOM: Final = 16
_MOST_NOTES: Final = 20  # of shocks
JOINT_WORDS: Final = MappingProxyType({HOLDS: "sticks", 1: "slips forward", -1: "slips backward"})
ROPE_WORDS: Final = MappingProxyType({HOLDS: "taut", 1: "slack"})


class ModeRecord:
    """Modes along a motion; the law of the inputs that hold them.

    Parameters
    ----------
    names : sequence of str
        Of the inputs.
    joints, ropes : sequence of str
        The elements.
    state_names : sequence of str
        Of the states that are written down, behind which the work stands.
    switch : ModeSwitch
        Holds the modes at present, and how many rows there are.

    Attributes
    ----------
    rows : (room, 3 + elements + states) array
        What `kernels.modes.switch_modes.record` writes.
    """

    def __init__(
        self, names: Sequence[str], joints: Sequence[str], ropes: Sequence[str], state_names: Sequence[str],
        switch: ModeSwitch,
    ) -> None:  # fmt: skip
        self._places = {name: place for place, name in enumerate(names)}
        self._joints, self._ropes, self._state_names = tuple(joints), tuple(ropes), tuple(state_names)
        self._switch = switch
        self.rows: Floats = np.zeros((_FIRST_ROOM, 3 + len(self._places) + len(self._state_names) + 1))

    def grow(self) -> None:
        """Make room for as many more rows."""
        self.rows = np.concatenate([self.rows, np.zeros_like(self.rows)])

    def begin_anew(self) -> None:
        """Forget all but the last modes."""
        decisions = np.flatnonzero(self._rows_so_far[:, 0] != SHOCK)
        if decisions.size:
            self.rows[0] = self.rows[decisions[-1]]
        self._switch.recorded = min(decisions.size, 1)

    @property
    def present(self) -> dict[str, str]:
        """The modes at present, in words; none before they are decided."""
        if not self._switch.known:
            return {}
        elements = zip((*self._joints, *self._ropes), self._switch.elements, strict=True)
        return {name: self._word(name, element.mode) for name, element in elements}

    @property
    def _rows_so_far(self) -> Floats:
        return self.rows[: self._switch.recorded]

    @property
    def _decisions(self) -> Floats:
        """Times in the first column, modes behind it."""
        rows = self._rows_so_far
        rows = rows[rows[:, 0] != SHOCK]
        return np.column_stack([rows[:, 1], rows[:, 3 : 3 + len(self._places)]])

    def current(self, name: str) -> float:
        """Return a mode at present."""
        return float(self._switch.elements[self._places[name]].mode)

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a mode at times (N,) in order; of two equal ones at a change the first is before it."""
        rows = self._decisions
        if not len(rows):
            return np.full(np.shape(t), self.current(name))
        times, t = rows[:, 0], np.atleast_1d(t)
        places = np.maximum(np.searchsorted(times, t, side="right") - 1, 0)
        first = np.flatnonzero((t[:-1] == t[1:]) & np.isin(t[:-1], times[1:]))
        places[first] = np.maximum(np.searchsorted(times, t[first], side="left") - 1, 0)
        values: Floats = rows[places, 1 + self._places[name]]
        return values

    @property
    def changes(self) -> tuple[ModeChange, ...]:
        """The first mode of each element, and all changes."""
        return tuple(ModeChange(t, name, mode) for t, name, mode, _ in self._changes(has_first=True))

    @property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """The changes of modes as events, each with the state before it."""
        return tuple(
            Occurrence(f"{name} {mode}", t, dict(zip(self._state_names, state.tolist(), strict=False)))
            for t, name, mode, state in self._changes(has_first=False)
        )

    def _changes(self, *, has_first: bool) -> Iterator[tuple[float, str, str, Floats]]:
        """Yield when which element changes its mode, to which, and the state before."""
        last_modes: dict[str, float] = {}
        count = len(self._places)
        for row in self._rows_so_far:
            t, state = float(row[1]), row[3 + count :]
            for k, name in enumerate((*self._joints, *self._ropes)):
                mode = float(row[3 + k])
                if row[0] == SHOCK and (mode == 0.0 or name not in self._ropes):
                    continue
                mode = HOLDS if row[0] == SHOCK else mode
                if last_modes.get(name) != mode and (has_first or name in last_modes or row[0] == SHOCK):
                    yield t, name, self._word(name, int(mode)), state
                last_modes[name] = mode

    def _word(self, name: str, mode: int) -> str:
        return ROPE_WORDS[mode] if name in self._ropes else JOINT_WORDS[mode]

    @property
    def notes(self) -> Iterator[str]:
        """The shocks of ropes in words."""
        rows = self._rows_so_far
        shocks = rows[rows[:, 0] == SHOCK]
        for row in shocks[:_MOST_NOTES]:
            pairs = zip(self._ropes, row[3 + len(self._joints) :].tolist(), strict=False)
            pulls = " and ".join(f"{name} by {impulse:.6g} N s" for name, impulse in pairs if impulse)
            yield f"at t = {row[1]:.9g} s ropes go taut with an impact: {pulls}; {row[2]:.6g} J are lost"
        others = shocks[_MOST_NOTES:]
        if len(others):
            yield (
                f"{len(others)} more impacts of ropes until t = {others[-1, 1]:.9g} s; "
                f"{others[:, 2].sum():.6g} J are lost"
            )


def held_modes(
    inputs: tuple[str, ...], elements: Sequence[str], changes: Sequence[ModeChange]
) -> HeldRecord | None:
    """Return the modes of elements along a motion as inputs that are held; None without any."""
    if not changes:
        return None
    numbers = {word: float(mode) for words in (JOINT_WORDS, ROPE_WORDS) for mode, word in words.items()}
    times = np.unique([change.t for change in changes])
    values = np.empty((len(inputs), times.size))
    for change in changes:
        values[elements.index(change.name), np.searchsorted(times, change.t) :] = numbers[change.mode]
    return HeldRecord(inputs, times, values)
