"""`ModeRecord`: the modes of a motion, and the impacts of ropes and stops, as its kernel wrote them down."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.modal_equations import ModalEquations
from symbody.equations.solving.unilateral import element_words
from symbody.kernels.modes.mode_problem import HOLDS
from symbody.kernels.modes.mode_state import mode_input
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch
from symbody.simulation.events.events import ModeChange, Occurrence
from symbody.simulation.inputs.held_law import HeldRecord

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

_FIRST_ROOM: Final = 16
_MOST_NOTES: Final = 20  # of shocks
_MODES: Final = (-1, 0, 1)
IMPACT: Final = -1  # no mode of a stop: its place among the words is that of an impact
MODE_WORDS: Final[Mapping[str, Mapping[int, str]]] = MappingProxyType(
    {
        "joint": {HOLDS: "sticks", 1: "slips forward", -1: "slips backward"},
        "contact": {HOLDS: "sticks", 1: "slips"},
        "rope": {HOLDS: "taut", 1: "slack"},
        "stop": {HOLDS: "closed", 1: "open", IMPACT: "impact"},
    }
)


class ModalElements(NamedTuple):
    """The elements that have modes, in the order of a `ModeSwitch`.

    Attributes
    ----------
    joints, gaps : tuple of str
        Joints and contacts that stick and slip; then ropes, stops and contacts whose gaps close.
    kinds : tuple of str
        What each is, one of `MODE_WORDS`: the contact of a gap is a stop.
    subjects : tuple of str
        What each is called in sentences.
    """

    joints: tuple[str, ...] = ()
    gaps: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    subjects: tuple[str, ...] = ()

    @property
    def words(self) -> list[Mapping[int, str]]:
        """What the modes of each are called."""
        return [MODE_WORDS[kind] for kind in self.kinds]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.joints, *self.gaps)


def modal_elements(modal: ModalEquations) -> ModalElements:
    """Return the elements of equations with modes."""
    words = [element_words(modal.eqs.formed, name) for name in modal.names]
    gaps = ["rope" if kind == "rope" else "stop" for kind, _ in words[len(modal.joints) :]]
    slips = ["contact" if len(modal.laws_of(name)) > 1 else "joint" for name in modal.joints]
    return ModalElements(modal.joints, modal.gaps, (*slips, *gaps), tuple(map(" ".join, words)))


class ModeRecord:
    """Modes along a motion; the law of the inputs that hold them.

    Parameters
    ----------
    names : sequence of str
        Of the inputs.
    elements : ModalElements
    state_names : sequence of str
        Of the states that are written down, behind which the work stands.
    switch : ModeSwitch
        Holds the modes at present, and how many rows there are.

    Attributes
    ----------
    rows : (room, 3 + elements + states) array
        What `kernels.modes.mode_state.record` writes.
    """

    def __init__(
        self, names: Sequence[str], elements: ModalElements, state_names: Sequence[str], switch: ModeSwitch
    ) -> None:
        self._places = {name: place for place, name in enumerate(names)}
        self._elements, self._state_names = elements, tuple(state_names)
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
        words = zip(self._elements.names, self._elements.words, self._switch.elements, strict=True)
        return {name: words_of[int(element.mode)] for name, words_of, element in words}

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
        """Return a mode at present, with the heading of a contact."""
        return mode_input(self._switch, self._places[name])

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
    def inputs(self) -> HeldRecord | None:
        """The modes from each decision on, as the equations read them; None before there are any."""
        rows = self._decisions
        return HeldRecord(tuple(self._places), rows[:, 0], rows[:, 1:].T) if len(rows) else None

    @property
    def changes(self) -> tuple[ModeChange, ...]:
        """The first mode of each element, and all changes."""
        impact = MODE_WORDS["stop"][IMPACT]
        return tuple(
            ModeChange(t, name, mode) for t, name, mode, _ in self._changes(has_first=True) if mode != impact
        )

    @property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """The changes of modes and the impacts of stops as events, each with the state before it."""
        return tuple(
            Occurrence(f"{name} {mode}", t, dict(zip(self._state_names, state.tolist(), strict=False)))
            for t, name, mode, state in self._changes(has_first=False)
        )

    def _changes(self, *, has_first: bool) -> Iterator[tuple[float, str, str, Floats]]:
        """Yield when which element changes its mode, to which, and the state before."""
        rows, names = self._rows_so_far, self._elements.names
        words, count = mode_words(self._elements), len(names)
        found = mode_changes(rows, self._elements)
        for place, element, word, is_first in zip(*(part.tolist() for part in found), strict=True):
            if has_first or not is_first:
                mode = words[word].removeprefix(f"{names[element]} ")
                yield float(rows[place, 1]), names[element], mode, rows[place, 3 + count :]

    @property
    def notes(self) -> Iterator[str]:
        """The impacts in words."""
        return shock_notes(self._rows_so_far, self._elements)


def mode_words(elements: ModalElements) -> tuple[str, ...]:
    """Return what happens when each element goes over to each of the modes -1, 0, 1; -1 of ropes is none."""
    pairs = zip(elements.names, elements.words, strict=True)
    return tuple(f"{name} {words.get(mode, '')}" for name, words in pairs for mode in _MODES)


def mode_changes(
    rows: Floats, elements: ModalElements, first: Sequence[int] = (0,)
) -> tuple[Places, Places, Places, NDArray[np.bool_]]:
    """Return which rows of a record change which of the elements: rows, elements, places in `mode_words`.

    Parameters
    ----------
    first : sequence of int
        Where the rows of each of several motions begin.

    Returns
    -------
    rows, elements, words, are_first : arrays
        The last says whether it is the first mode of the element, which no change led to.
    """
    count, joints = len(elements.names), len(elements.joints)
    modes, shocks = rows[:, 3 : 3 + count].copy(), rows[:, 0] == SHOCK
    modes[~shocks] = np.rint(modes[~shocks])  # those of contacts contain a heading
    are_stops = np.array([kind == "stop" for kind in elements.kinds], dtype=np.bool_)
    is_struck = shocks[:, np.newaxis] & (modes != 0.0) & (np.arange(count) >= joints)
    starts = np.zeros(len(rows), dtype=np.bool_)
    starts[[k for k in first if k < len(rows)]] = True
    for k in np.flatnonzero(shocks).tolist():  # what a shock does not pull stays in its mode
        before = np.full(count, np.nan) if starts[k] else modes[k - 1]
        modes[k] = np.where(is_struck[k] & ~are_stops, float(HOLDS), before)
    before = np.full_like(modes, np.nan)
    before[1:] = modes[:-1]
    before[starts] = np.nan
    place, element = np.nonzero((modes != before) & ~np.isnan(modes))
    words = len(_MODES) * element + modes[place, element].astype(np.intp) - _MODES[0]
    are_first = np.isnan(before[place, element]) & ~shocks[place]
    impact, stop = np.nonzero(is_struck & are_stops)
    order = np.argsort(np.append(place, impact), kind="stable")
    found = (
        np.append(place, impact),
        np.append(element, stop),
        np.append(words, len(_MODES) * stop + IMPACT - _MODES[0]),
        np.append(are_first, np.zeros(impact.size, dtype=np.bool_)),
    )
    return found[0][order], found[1][order], found[2][order], found[3][order]


def shock_notes(rows: Floats, elements: ModalElements) -> Iterator[str]:
    """Yield the shocks of ropes in a record in words, and how often each stop and contact was struck."""
    shocks = rows[rows[:, 0] == SHOCK]
    impulses = shocks[:, 3 : 3 + len(elements.names)]
    are_ropes = np.array([kind == "rope" for kind in elements.kinds], dtype=np.bool_)
    with_ropes = shocks[(impulses[:, are_ropes] > 0.0).any(axis=1)] if are_ropes.any() else shocks[:0]
    for row in with_ropes[:_MOST_NOTES]:
        pairs = zip(elements.names, elements.kinds, row[3:].tolist(), strict=False)
        pulls = " and ".join(
            f"{name} by {impulse:.6g} N s" for name, kind, impulse in pairs if impulse and kind == "rope"
        )
        yield f"at t = {row[1]:.9g} s ropes go taut with an impact: {pulls}; {row[2]:.6g} J are lost"
    others = with_ropes[_MOST_NOTES:]
    if len(others):
        yield (
            f"{len(others)} more impacts of ropes until t = {others[-1, 1]:.9g} s; "
            f"{others[:, 2].sum():.6g} J are lost"
        )
    for place, (subject, kind) in enumerate(zip(elements.subjects, elements.kinds, strict=True)):
        struck = shocks[impulses[:, place] > 0.0] if kind == "stop" else shocks[:0]
        if len(struck):
            times = f"{len(struck)} impacts" if len(struck) > 1 else "an impact"
            yield (
                f"{subject}: {times}, the last at t = {struck[-1, 1]:.9g} s; "
                f"{struck[:, 2].sum():.6g} J are lost, by Poisson's law for all impacts of one instant"
            )
