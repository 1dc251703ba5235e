"""Events of a motion whose steps another program takes: what has passed zero since the last look.

An importer of an FMU locates zeros of the values itself. All else is as in the search along steps: what that
would have found is noted, and happens in the same order by the same rules.
"""

from __future__ import annotations

from symbody.kernels.events.acting_events import starting_event
from symbody.kernels.events.event_location import add_zero, compute_values, sign
from symbody.kernels.events.event_monitor import GOES_ON, NOTHING_YET, SWITCHES, EventMonitor, MonitoredEvent
from symbody.kernels.events.event_starts import AWAY
from symbody.kernels.events.zeros_in_order import settle
from symbody.kernels.language import Function, Reals
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy


def look_at_sides(e: Function, monitor: EventMonitor, t: float, x: Reals) -> None:
    """Note on which side of zero each value is at a state from which a motion goes on."""
    compute_values(e, monitor, t, x)
    for k in range(monitor.event_count):
        event = monitor.events[k]
        event.side = left_side(monitor, event, monitor.values[k])
        if event.action == SWITCHES:
            event.side = max(event.side, 0.0)  # a mode that does not last ends at the next look
    monitor.pending_count = 0


def left_side(monitor: EventMonitor, event: MonitoredEvent, value: float) -> float:
    """Return the side of zero of a value that has left zero, else 0; closing loops moves it a little.

    The value of a mode has to become more than rounding, `band`, before it can come to zero.
    """
    event.largest = max(event.largest, abs(value))
    if event.action == SWITCHES:
        if abs(value) <= event.band:
            return 0.0
    elif exists(monitor.closing) and abs(value) <= AWAY * event.largest:
        return 0.0
    return sign(value)


def note_events(e: Function, monitor: EventMonitor, t: float, x: Reals) -> int:
    """Note which events have happened since the side of each was looked at; return how many wait.

    A value that is zero belongs to the side where it comes to.
    """
    compute_values(e, monitor, t, x)
    for k in range(monitor.event_count):
        event = monitor.events[k]
        value = monitor.values[k]
        before = event.side
        side = left_side(monitor, event, value)
        event.peak = max(event.peak, abs(value))
        if before == 0.0:
            event.side = side
        elif before * value <= 0.0:
            event.side = sign(value)
        if event.action == SWITCHES:
            if (before > 0.0 and value <= 0.0) or (before == 0.0 and side < 0.0):
                event.side = -1.0
                add_zero(monitor, t, k, -1.0)
        elif before * value < 0.0 or (before != 0.0 and value == 0.0):
            if event.way != before:
                add_zero(monitor, t, k, -before)
    return monitor.pending_count


def note_start(e: Function, a: Function, monitor: EventMonitor, t: float, x: Reals, longest: float) -> int:
    """Note an event that happens at once because of how its value leaves zero; return 0 if none does."""
    monitor.pending_count = 0
    if not exists(monitor.actions):
        return 0
    return starting_event(e, a, monitor, t, x, longest)


def process_noted(
    e: Function, a: Function, c: Function, monitor: EventMonitor, t: float, x: Reals, longest: float,
    breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """Let what is noted happen at a state, which becomes the one behind; return one of the codes of `look`.

    `breaks` and `pieces` have room for a step; rates decide where values go within the time `longest`.
    """
    if monitor.pending_count == 0:
        return NOTHING_YET
    n = monitor.states
    breaks[0] = t
    breaks[1] = t + longest
    copy(n, x, pieces)
    for k in range(n, monitor.piece_rows * n):
        pieces[k] = 0.0
    for k in range(monitor.pending_count):
        monitor.pending[k].time = t
    monitor.first_step = 0
    monitor.current = 0
    code = settle(e, a, c, monitor, breaks, pieces, H, 1)
    if code == GOES_ON:
        copy(n, monitor.after, x)
    monitor.pending_count = 0
    return code
