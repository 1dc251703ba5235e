"""What follows where an event acts: whether its value goes on as before, and which events act at once.

Programs that take their own steps, as FMUs do, judge starts by `starting_event` and `end_action`.
"""

from __future__ import annotations

from symbody.kernels.events.event_location import sign
from symbody.kernels.events.event_slopes import bend_along, disturb_values, find_rates
from symbody.kernels.events.event_starts import find_way_out, leave_side, start_event, was_moved_away
from symbody.kernels.events.watch_block import (
    ACTION,
    AT_START,
    BLUR,
    CAME,
    DONE,
    EVENT_SIZE,
    EVENTS,
    HERE,
    JUST_HAPPENED,
    LARGEST,
    LEAVES,
    OF_TIME,
    PENDING_COUNT,
    RATE_KNOWN,
    SETS,
    TABLE,
    WAS,
    WAY,
)
from symbody.kernels.language import Function, Reals


def goes_on(
    e: Function, a: Function, W: Reals, place: int, t: float, state: Reals, direction: float, longest: float
) -> int:
    """Return 1 if a value is still zero in the state after its event's action and goes on as before, else 0.

    `RATE` holds the rates there.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    disturb_values(e, W, t, state)
    if was_moved_away(W[row + HERE], W[row + LARGEST], W[row + BLUR]) != 0.0:
        return 0
    way = find_way_out(e, W, place, t, state, longest)
    if way == 0.0:
        way = bend_along(e, a, W, place, t, state, longest)
    if way * direction > 0.0:
        return 1
    return 0


def judge_action(
    e: Function, a: Function, W: Reals, place: int, t: float, state: Reals, direction: float, longest: float
) -> int:
    """Note whether a value goes on as before in the state after its event's action; return 1 if it chatters.

    It does where the event happened at a start, and its action turned nothing that it could have turned.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    W[row + DONE] = 0.0
    if goes_on(e, a, W, place, t, state, direction, longest) == 0:
        return 0
    W[row + DONE] = direction
    if W[row + AT_START] != 0.0 and W[row + OF_TIME] == 0.0:
        return 1
    return 0


def starting_event(e: Function, a: Function, W: Reals, t: float, x: Reals, longest: float) -> int:
    """Return which event happens at once because of how its value leaves zero, from 1; 0 if none does.

    For motions whose steps another program takes: W has functions, the table and room, but sees no steps.
    """
    disturb_values(e, W, t, x)
    find_rates(a, W, t, x)
    W[RATE_KNOWN] = 1.0
    W[PENDING_COUNT] = 0.0
    for i in range(int(W[EVENTS])):
        row = int(W[TABLE]) + EVENT_SIZE * i
        W[row + AT_START] = 0.0
        W[row + LARGEST] = max(W[row + LARGEST], abs(W[row + HERE]))
        if W[row + ACTION] == SETS:
            if is_zero(W, i) == 0:
                W[row + JUST_HAPPENED] = 0.0
                leave_side(W, i, W[row + HERE])
            else:
                W[row + LEAVES] = find_way_out(e, W, i, t, x, longest)
                start_event(e, a, W, i, t, x, longest)
                if W[row + AT_START] != 0.0:
                    W[row + CAME] = sign(W[row + WAY])
                    if W[row + CAME] == 0.0:
                        W[row + CAME] = -W[row + WAS]
                    return i + 1
    return 0


def is_zero(W: Reals, place: int) -> int:
    """Return 1 if a value is zero in the state that `disturb_values` has seen, else 0."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    if W[row + JUST_HAPPENED] != 0.0:
        return int(1.0 - was_moved_away(W[row + HERE], W[row + LARGEST], W[row + BLUR]))
    if abs(W[row + HERE]) <= W[row + BLUR]:
        return 1
    return 0


def end_action(e: Function, a: Function, W: Reals, place: int, t: float, x: Reals, longest: float) -> int:
    """Note that an event has acted, beside `starting_event`; return 1 if it chatters."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    W[row + JUST_HAPPENED] = 1.0
    W[row + WAS] = -W[row + CAME]
    find_rates(a, W, t, x)
    return judge_action(e, a, W, place, t, x, W[row + CAME], longest)
