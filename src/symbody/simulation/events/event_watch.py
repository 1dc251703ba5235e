"""`EventWatch`: finds the events of a run, and where it has to be cut, by `kernels.events.event_watch`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.kernels import block as run_at
from symbody.kernels.events import watch_block as at
from symbody.simulation.events.event_functions import EventFunctions
from symbody.simulation.events.events import Event, EventSide, Occurrence
from symbody.simulation.events.watch_arrays import event_rows, with_cut_fit
from symbody.simulation.native.description import LoopCall, Record
from symbody.simulation.native.machine import address, watched_motion
from symbody.simulation.native.segments import Cut, HeldValues
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

# Steps of integrators that take theirs in Python between two looks: what is computed beyond an event that
# changes the motion is thrown away.
_ACTING_STEPS: Final = 64
_RECORDING_STEPS: Final = 1024
_FIRST_ROOM: Final = 64  # for what happens
_ENDINGS: Final = {
    at.CHATTERS: Status.CHATTERING,
    at.SPOILS: Status.NOT_FINITE,
    at.MISSES: Status.UNMET_ACTION,
}


class EventWatch:
    """Looks for events in the steps of a run; what it finds does not depend on when it looks.

    Parameters
    ----------
    functions : EventFunctions
        The events.
    span : float
        Length of the run [s].
    sides : sequence of EventSide
        Where the values of the first events stood when the motion was interrupted that goes on here.

    Attributes
    ----------
    ending : str
        What an event did that ended the run, in words: it happened again and again, or its action set a state
        to what is not finite. Empty if none did.
    """

    def __init__(self, functions: EventFunctions, span: float, sides: Sequence[EventSide] = ()) -> None:
        self.ending = ""
        self._functions = functions
        self._block = functions.make_block(span)
        for row, given in zip(event_rows(self._block), sides, strict=False):
            row[[at.GOES_THROUGH, at.SIDE]] = given.side
            row[[at.JUST_HAPPENED, at.LARGEST]] = given.has_happened, given.largest
            row[[at.WAS, at.DONE]] = given.was, given.done
        self._happened = np.zeros((_FIRST_ROOM + at.ZEROS_PER_EVENT * len(functions.events), self._row))

    @property
    def _row(self) -> int:
        return int(self._block[at.STATES]) + 2

    @property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """What has happened, in the order of the motion."""
        names = self._functions.state_names
        rows = self._happened[: int(self._block[at.HAPPENED])]
        labels = [event.label for event in self._functions.events]
        return tuple(
            Occurrence(labels[int(row[0])], row[1], dict(zip(names, row[2:], strict=False)))
            for row in rows.tolist()
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Where values were not numbers, or passed a pole: nothing happened there."""
        labels = [event.label for event in self._functions.events]
        return value_notes(labels, event_rows(self._block)[:, at.NO_NUMBER : at.WAITS_TIME + 1])

    def sides_at(self, t: float) -> tuple[EventSide, ...]:
        """Return where the values stand at the end of the run [s]: those of the last samples."""
        own = self._block
        seen = own.item(at.SEEN) != 0.0 and own.item(at.T_LAST) == t
        rows = self._happened[: int(own[at.HAPPENED]), :2].tolist()
        now = {int(place) for place, when in rows if when == t}
        sides = []
        for place, row in enumerate(event_rows(own).tolist()):
            is_left = seen and row[at.AT_ZERO] == 0.0
            has_happened = place in now or (not is_left and row[at.JUST_HAPPENED] != 0.0)
            stands = is_left and not has_happened
            value = row[at.G_LAST] if stands else 0.0
            side = float((value > 0.0) - (value < 0.0))
            was, done = (side, 0.0) if side else (row[at.WAS], row[at.DONE])
            sides.append(EventSide(side, float(has_happened), row[at.LARGEST], was, done))
        return tuple(sides)

    @property
    def most_steps(self) -> int:
        """How many steps may be taken between two looks."""
        recording = all(event.action == "record" for event in self._functions.events)
        return _RECORDING_STEPS if recording else _ACTING_STEPS

    def forget_last(self) -> None:
        """Forget the last occurrence."""
        self._block[at.HAPPENED] -= 1.0

    def look(self, breaks: Floats, pieces: Floats, steps: int, is_over: bool) -> Cut | None:
        """Return where a run has to be cut, if anywhere in its first `steps` steps.

        Parameters
        ----------
        breaks, pieces : arrays
            Those of `DenseOutput`, with room for more. After a cut that goes on, the next step follows the
            one that was cut.
        """
        if steps == 0:
            return None
        block = self._block
        block[at.DIRECTION] = 1.0 if breaks[steps] >= breaks[0] else -1.0
        block[at.PIECE_ROWS] = pieces.shape[1]
        code = at.NO_ROOM
        while code == at.NO_ROOM:
            block[at.HAPPENED_ROOM] = len(self._happened)
            arrays = map(address, (block, breaks, pieces, self._happened))
            code = watched_motion().look(*self._functions.addresses, *arrays, steps, int(is_over))
            if code == at.NO_ROOM:
                self._make_room()
        if code == at.NOTHING_YET:
            return None
        if code == at.FAILS:
            self._functions.raise_fault(int(block[at.FAULT]))
        n = self._row - 2
        before, after = (block[int(block[place]) :][:n].copy() for place in (at.BEFORE, at.AFTER))
        self._note_ending()
        status = _ENDINGS.get(code, Status.STOPPED)
        return Cut(float(block[at.CUT]), before, after if code == at.GOES_ON else None, status)

    def advance(self, call: LoopCall, held: HeldValues | None = None) -> int:
        """Try up to so many steps of the compiled loop, and let events happen; return the loop's code."""
        self._prepare(call.block)
        functions = self._functions.addresses
        code = run_at.NO_EVENT_ROOM
        while code == run_at.NO_EVENT_ROOM:
            self._block[at.HAPPENED_ROOM] = len(self._happened)
            if held is not None:
                code = held.advance_watched(call, functions, self._block, self._happened)
            else:
                arrays = map(address, (call.block, self._block, *call.record.arrays, self._happened))
                code = watched_motion().advance_watched(
                    call.rhs, call.projector, *functions, *arrays, call.trials
                )
            if code == run_at.NO_EVENT_ROOM:
                self._make_room()
        if code == run_at.EVENT_FAULT:
            self._functions.raise_fault(int(self._block[at.FAULT]))
        self._note_ending()
        return code

    def break_off(self, block: Floats, record: Record) -> None:
        """End an interrupted run at the event that would have changed it, if one was computed."""
        self._prepare(block)
        _, *places = record.arrays
        arrays = (block, self._block, *places, self._happened)
        watched_motion().break_off(*self._functions.addresses, *map(address, arrays))

    def _prepare(self, block: Floats) -> None:
        """Fit the block to a run of the compiled loop."""
        own, rows = self._block, int(block[run_at.METHOD + run_at.DENSE_ROWS])
        if own[at.CUT_FIT] == 0.0:
            own = self._block = with_cut_fit(own, rows)
        own[at.DIRECTION], own[at.PIECE_ROWS] = block[run_at.DIRECTION], rows

    def _note_ending(self) -> None:
        block, culprit = self._block, int(self._block[at.CULPRIT])
        if not culprit:
            return
        event, place = self._functions.events[culprit - 1], int(block[at.BAD_PLACE])
        if block[at.UNMET]:
            names = self._functions.state_names
            values = block[int(block[at.AFTER]) :][: len(names)]
            self.ending = unmet_note(event, {name: values.item(names.index(name)) for name in event.mapping})
        elif place:
            self.ending = spoiled_note(event, place - 1, float(block[at.BAD_VALUE]))
        else:
            self.ending = chattering_note(event.label, block[at.UNTURNED] != 0.0)

    def _make_room(self) -> None:
        self._happened = np.concatenate([self._happened, np.zeros_like(self._happened)])


def unmet_note(event: Event, values: Mapping[str, float]) -> str:
    """Return what to say about an action that sets what the constraints do not admit."""
    listed = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
    return (
        f"the action of event {event.label!r} sets {listed}: no state near the previous one satisfies the "
        f"constraints with these values; set fewer values, so that the others can adjust, or set consistent "
        f"values"
    )


def spoiled_note(event: Event, place: int, value: float) -> str:
    """Return what to say about an action that sets a state to what is not finite."""
    name, formula = list(event.mapping.items())[place]
    return (
        f"the action of event {event.label!r} sets {name} to {value:g}: {str(formula)!r} is not finite in "
        f"the state before the event; use a formula that is finite wherever the event happens"
    )


def chattering_note(label: str, goes_on: bool) -> str:
    """Return what to say about an event that chatters; `goes_on` if its action at a start turned nothing."""
    if goes_on:
        return (
            f"event {label!r} happens at the start, where its value is zero, and after its action the value "
            f"is zero again and moves in the same direction; let the action reverse the value or move it "
            f"away from zero, or start away from zero"
        )
    return f"event {label!r} happens again and again"


def value_notes(labels: Sequence[str], seen: Floats) -> tuple[str, ...]:
    """Return notes on values that were not numbers, had poles, or rested at zero.

    Parameters
    ----------
    seen : (events, 6) array
        Whether and when a value was first no number, whether and when it had its first pole [s], why and
        since when an event waits for its value to leave zero.
    """
    notes: list[str] = []
    waiting: dict[tuple[float, float], list[str]] = {}
    for label, (is_none, since, has_pole, t, why, when) in zip(labels, seen.tolist(), strict=True):
        if is_none:
            notes.append(
                f"event {label!r}: its value is not a number at t = {since:.6g} s, so the event cannot "
                f"happen there; use a formula that is defined everywhere"
            )
        if has_pole:
            notes.append(
                f"event {label!r}: its value changes sign at t = {t:.6g} s at a pole, not at a zero; use a "
                f"formula without poles, such as the denominator"
            )
        if why:
            waiting.setdefault((why, when), []).append(repr(label))
    return (*notes, *(_waiting_note(found, *key) for key, found in waiting.items()))


def _waiting_note(labels: Sequence[str], why: float, t: float) -> str:
    name = (
        f"event {labels[0]}: its value is" if len(labels) == 1 else f"events {', '.join(labels)}: values are"
    )
    if why == at.RESTS:
        return (
            f"{name} zero at t = {t:.6g} s with zero first and second derivatives: the event does not "
            f"happen there until another action, sample or jump changes these derivatives, or the value "
            f"leaves zero"
        )
    return (
        f"{name} zero at t = {t:.6g} s with no sign before it, and direction = 0 does not say from which "
        f"side it passes zero: the event does not happen until the value leaves zero; give direction = 1 or "
        f"-1"
    )
