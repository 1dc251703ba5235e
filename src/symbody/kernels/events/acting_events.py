"""What follows where an event acts: whether its value goes on as before, and which events act at once.

Programs whose steps others take, as FMUs do in model exchange, judge starts by `starting_event`.
"""

from __future__ import annotations

from symbody.kernels.events.event_location import sign
from symbody.kernels.events.event_monitor import SETS, EventMonitor
from symbody.kernels.events.event_slopes import bend_along, disturb_values, find_rates
from symbody.kernels.events.event_starts import find_way_out, leave_side, start_event, was_moved_away
from symbody.kernels.language import Function, Reals


def goes_on(
    e: Function, a: Function, monitor: EventMonitor, place: int, t: float, state: Reals, direction: float,
    longest: float,
) -> int:  # fmt: skip
    """Return 1 if a value is still zero in the state after its event's action and goes on as before, else 0.

    `RATE` holds the rates there.
    """
    event = monitor.events[place]
    disturb_values(e, monitor, t, state)
    if was_moved_away(event.here, event.largest, event.blur) != 0.0:
        return 0
    way = find_way_out(e, monitor, place, t, state, longest)
    if way == 0.0:
        way = bend_along(e, a, monitor, place, t, state, longest)
    if way * direction > 0.0:
        return 1
    return 0


def judge_action(
    e: Function, a: Function, monitor: EventMonitor, place: int, t: float, state: Reals, direction: float,
    longest: float,
) -> int:  # fmt: skip
    """Note whether a value goes on as before in the state after its event's action; return 1 if it chatters.

    It does where the event happened at a start, and its action turned nothing that it could have turned.
    """
    event = monitor.events[place]
    event.done = 0.0
    if goes_on(e, a, monitor, place, t, state, direction, longest) == 0:
        return 0
    event.done = direction
    if event.at_start != 0.0 and event.of_time == 0.0:
        return 1
    return 0


def starting_event(
    e: Function, a: Function, monitor: EventMonitor, t: float, x: Reals, longest: float
) -> int:
    """Return which event happens at once because of how its value leaves zero, from 1; 0 if none does.

    For motions whose steps another program takes: the monitor has functions, events and room, but sees no
    steps.
    """
    disturb_values(e, monitor, t, x)
    find_rates(a, monitor, t, x)
    monitor.rate_known = 1.0
    monitor.pending_count = 0
    for i in range(monitor.event_count):
        event = monitor.events[i]
        event.at_start = 0.0
        event.largest = max(event.largest, abs(event.here))
        if event.action == SETS:
            if is_zero(monitor, i) == 0:
                event.just_happened = 0.0
                leave_side(monitor, i, event.here)
            else:
                event.leaves = find_way_out(e, monitor, i, t, x, longest)
                start_event(e, a, monitor, i, t, x, longest)
                if event.at_start != 0.0:
                    event.came = sign(event.way)
                    if event.came == 0.0:
                        event.came = -event.was
                    return i + 1
    return 0


def is_zero(monitor: EventMonitor, place: int) -> int:
    """Return 1 if a value is zero in the state that `disturb_values` has seen, else 0."""
    event = monitor.events[place]
    if event.just_happened != 0.0:
        return int(1.0 - was_moved_away(event.here, event.largest, event.blur))
    if abs(event.here) <= event.blur:
        return 1
    return 0
