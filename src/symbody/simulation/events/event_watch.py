"""`EventWatch`: finds the events of a run, and where it has to be cut, by `kernels.events.event_watch`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.kernels import block as run_at
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import RESTS, ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.record_layout import exists
from symbody.kernels.samples.sampling import ONE_INSTANT
from symbody.simulation.events.event_functions import EventFunctions
from symbody.simulation.events.events import Event, EventSide, GapEvent, ModeEnd, Occurrence
from symbody.simulation.events.watch_arrays import with_cut_fit
from symbody.simulation.native.description import Record
from symbody.simulation.native.machine import given_steps

if TYPE_CHECKING:
    from symbody.simulation.hybrid.switching import SwitchingModes

Floats = NDArray[np.float64]

_FIRST_ROOM: Final = 64  # for what happens


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
    modes : SwitchingModes, optional
        The modes of joints, ropes and stops, which the last events end.

    Attributes
    ----------
    ending : str
        What an event did that ended the run, in words: it happened again and again, or its action set a state
        to what is not finite. Empty if none did.
    """

    feature = "EVENTS"

    def __init__(
        self, functions: EventFunctions, span: float, sides: Sequence[EventSide] = (),
        modes: SwitchingModes | None = None,
    ) -> None:  # fmt: skip
        self.ending = ""
        self.modes = modes
        self._functions = functions
        self._block = functions.make_block(span)
        for event, given in zip(self._monitor.events, sides, strict=False):
            event.goes_through = event.side = given.side
            event.just_happened, event.largest = given.has_happened, given.largest
            event.was, event.done = given.was, given.done
        self._happened = np.zeros((_FIRST_ROOM + ZEROS_PER_EVENT * len(functions.events), self._row))
        if modes is not None:
            modes.prepare(self._block)

    @property
    def _monitor(self) -> EventMonitor:
        return EventMonitor(self._block)

    @property
    def _row(self) -> int:
        return self._monitor.states + 2

    @property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """What has happened, in the order of the motion."""
        names = self._functions.state_names
        rows = self._happened[: self._monitor.happened]
        labels = [event.label for event in self._functions.events]
        return tuple(
            Occurrence(labels[int(row[0])], row[1], dict(zip(names, row[2:], strict=False)))
            for row in rows.tolist()
            if not isinstance(self._functions.events[int(row[0])], ModeEnd)
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Where values were not numbers, or passed a pole: nothing happened there."""
        pairs = zip(self._functions.events, self._monitor.events, strict=True)
        told = [(event.label, seen) for event, seen in pairs if not isinstance(event, GapEvent)]
        seen = [
            (one.no_number, one.no_number_time, one.pole, one.pole_time, one.waits, one.waits_time)
            for _, one in told
        ]
        return value_notes([label for label, _ in told], np.array(seen).reshape(-1, 6))

    def sides_at(self, t: float) -> tuple[EventSide, ...]:
        """Return where the values stand at the end of the run [s]: those of the last samples.

        Where held values were sampled at the end, no sample is behind that: the values stand where they did.
        """
        own = self._monitor
        seen = own.seen != 0 and own.t_last == t
        rows = self._happened[: own.happened, :2].tolist()
        now = {int(place) for place, when in rows if when == t}
        sides = []
        for place, event in enumerate(own.events):
            is_left = seen and event.at_zero == 0.0
            has_happened = place in now or (not is_left and event.just_happened != 0.0)
            value = event.g_last if is_left else 0.0
            if own.seen == 0:
                value = event.goes_through or event.side
            side = 0.0 if has_happened else float((value > 0.0) - (value < 0.0))
            was, done = (side, 0.0) if side else (event.was, event.done)
            sides.append(EventSide(side, float(has_happened), event.largest, was, done))
        return tuple(sides)

    @property
    def acted_state(self) -> Floats | None:
        """The state in which a motion goes on outside after actions at its end; None without any."""
        own = self._monitor
        return np.array(own.after) if own.hands_over and own.has_acted and not own.culprit else None

    def state_behind(self, t: float) -> Floats | None:
        """Return the state (u, q, s, work) that actions set where a run ends [s]; None without any."""
        own = self._monitor
        if own.culprit or own.cut != t:
            return None
        rows = self._happened[: own.happened, :2].tolist()
        width = ONE_INSTANT * abs(t)
        acted = any(self._functions.events[int(k)].mapping for k, when in rows if abs(when - t) <= width)
        return np.array(own.after) if acted else None

    @property
    def actor(self) -> str:
        """The name of the event that has acted last."""
        return self._functions.events[self._monitor.actor - 1].label

    @property
    def has_ended_mode(self) -> bool:
        """Whether a mode has ended where the motion ends, which is to go on in others."""
        return self.modes is not None and self.modes.note_ends(self._block, self._functions.addresses[0])

    @property
    def last_time(self) -> float:
        """When something happened last [s]."""
        return float(self._happened[self._monitor.happened - 1, 1])

    @property
    def longest_step(self) -> float:
        """How long the next step may be, which is taken again [s]; 0 if none is."""
        return self._monitor.bound

    def hand_over(self) -> None:
        """Let the motion end where a mode does, for methods outside the loop in which modes change."""
        self._monitor.hands_over = float(self.modes is not None)

    def forget_last(self) -> None:
        """Forget the last occurrence."""
        self._monitor.happened -= 1

    def process(self, block: Floats, record: Record, code: int) -> int:
        """Let events happen in the steps so far, the last of which ended with a code; return the code."""
        self._prepare(block)
        _, *places = record.arrays
        is_over = code not in (run_at.RUNNING, run_at.FULL)
        found = run_at.NO_EVENT_ROOM
        while found == run_at.NO_EVENT_ROOM:
            self._monitor.happened_room = len(self._happened)
            arrays = map(address, (block, self._block, *places, self._happened))
            found = given_steps().process_given(*self._functions.addresses, *arrays, int(is_over))
            self.answer(found)
        return code if found == run_at.RUNNING else found

    @property
    def array(self) -> Floats:
        """See `symbody.kernels.events.event_monitor`."""
        return self._block

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return the functions of events, what is watched, and where it is written down what happens."""
        self._prepare(block)
        self._monitor.happened_room = len(self._happened)
        values, actions, closing = self._functions.addresses
        return {"e": values, "a": actions, "c": closing, "monitor": self._block, "H": self._happened}

    def answer(self, code: int) -> None:
        """Make room, or raise a fault, if the code of a loop asks for it; note what ended the motion."""
        if code == run_at.NO_EVENT_ROOM:
            self._make_room()
        if code == run_at.EVENT_FAULT:
            self._functions.raise_fault(self._monitor.fault)
        if self.modes is not None:
            self.ending = self.modes.ending_note(code, self.actor) or self.ending
        self._note_ending()

    @property
    def hands_over(self) -> bool:
        """Whether the motion ends where modes are to be decided, and goes on outside."""
        return self._monitor.hands_over != 0.0

    def break_off(self, block: Floats, record: Record) -> None:
        """End an interrupted run at the event that would have changed it, if one was computed."""
        self._prepare(block)
        _, *places = record.arrays
        arrays = (block, self._block, *places, self._happened)
        given_steps().break_off(*self._functions.addresses, *map(address, arrays))

    def _prepare(self, block: Floats) -> None:
        """Fit the block to a run of the compiled loop."""
        run = Run(block)
        rows = run.method.dense_rows
        if not exists(self._monitor.cut_fit):
            self._block = with_cut_fit(self._block, rows)
        monitor = self._monitor
        monitor.direction, monitor.piece_rows = run.goal.direction, rows

    def _note_ending(self) -> None:
        monitor = self._monitor
        if not monitor.culprit:
            return
        event, place = self._functions.events[monitor.culprit - 1], monitor.bad_place
        if monitor.unmet:
            names = self._functions.state_names
            values = {name: float(monitor.after[names.index(name)]) for name in event.mapping}
            self.ending = unmet_note(event, values)
        elif place:
            self.ending = spoiled_note(event, place - 1, monitor.bad_value)
        else:
            self.ending = chattering_note(event.label, monitor.unturned != 0.0)

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
    if why == RESTS:
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
