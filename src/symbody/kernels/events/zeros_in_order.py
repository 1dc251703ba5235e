"""What happens at zeros: simultaneous ones together, in the order of the events.

H receives a row for each: the place of the event, when, and the state, which is the one before any action.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import ASSEMBLED
from symbody.kernels.configurations.closing import close_state, hold, note_followers
from symbody.kernels.events.acting_events import judge_action
from symbody.kernels.events.event_location import BESIDE, state_at, value_at
from symbody.kernels.events.event_slopes import (
    compute_action,
    disturb_values,
    find_rates,
    slope_along,
    take_rates,
)
from symbody.kernels.events.event_starts import LOWEST
from symbody.kernels.events.watch_block import (
    ACTED,
    ACTION,
    ACTION_VALUES,
    ACTIONS,
    AFTER,
    BAD_PLACE,
    BAD_VALUE,
    BEFORE,
    CAME,
    CHATTERS,
    CLOSING,
    CULPRIT,
    CURRENT,
    CUT,
    DIRECTION,
    ENDS,
    EVENT_SIZE,
    EVENTS,
    GOES_ON,
    HAPPENED,
    HAPPENED_ROOM,
    JUST_HAPPENED,
    LARGEST,
    MISSES,
    MOST,
    MOST_RECENT,
    NO_ROOM,
    NOTHING_YET,
    PEAK,
    PENDING,
    PENDING_COUNT,
    RATE_KNOWN,
    RECENT,
    RECENT_COUNT,
    RECORDS,
    REPEATS,
    ROUNDING,
    SET_COUNT,
    SET_FIRST,
    SETS,
    SLOPE_BEFORE,
    SPAN,
    SPOILS,
    STATES,
    STOPS,
    T_BEFORE,
    TABLE,
    TARGETS,
    UNMET,
    UNTURNED,
    WAITS,
    WAS,
    WAY,
    WRAPS,
    ZERO_SIZE,
    ZEROS_PER_EVENT,
)
from symbody.kernels.language import Function, Reals, is_finite, part
from symbody.kernels.runge_kutta import copy

SIMULTANEOUS: Final = 1e-12
# A value that changes by such a share of its largest has jumped.
TORN: Final = 0.25
# So many events of one kind within such a share of the run are chattering.
INSTANT: Final = 1e-7
# Zeros that the next samples may show, of each event.
NEWEST: Final = 4.0


def settle(
    e: Function, a: Function, c: Function, W: Reals, breaks: Reals, pieces: Reals, H: Reals, last: int
) -> int:
    """Let zeros happen before which no other can be found any more, all if these were the last samples."""
    while W[PENDING_COUNT] > 0.0:
        direction = W[DIRECTION]
        t = earliest(W)
        within = SIMULTANEOUS * max(W[SPAN], abs(breaks[int(W[CURRENT]) + 1]))
        if last == 0 and (W[T_BEFORE] - t) * direction <= within * has_room(W):
            return NOTHING_YET
        if W[HAPPENED] + W[PENDING_COUNT] > W[HAPPENED_ROOM]:
            return NO_ROOM
        drop_others(e, W, breaks, pieces, t, within)
        code = happen(e, a, c, W, breaks, pieces, H, t, within)
        if code != NOTHING_YET:
            return code
    return NOTHING_YET


def has_room(W: Reals) -> float:
    """Return 1 if the zeros of some more samples may wait, else 0: many fit into a moment far from t = 0."""
    if W[PENDING_COUNT] + NEWEST * W[EVENTS] > ZEROS_PER_EVENT * W[EVENTS]:
        return 0.0
    return 1.0


def steps_before(breaks: Reals, steps: int, t: float, direction: float) -> int:
    """Return how many of the first `steps` steps begin before a time."""
    count = steps
    while count > 0:
        if (breaks[count - 1] - t) * direction < 0.0:
            break
        count = count - 1
    return count


def earliest(W: Reals) -> float:
    """Return the first of the zeros that wait."""
    zeros = part(W, int(W[PENDING]), ZERO_SIZE * int(W[PENDING_COUNT]))
    t = zeros[0]
    for k in range(1, int(W[PENDING_COUNT])):
        if (zeros[ZERO_SIZE * k] - t) * W[DIRECTION] < 0.0:
            t = zeros[ZERO_SIZE * k]
    return t


def remove_zero(W: Reals, number: int) -> None:
    """Remove one of the zeros that wait."""
    count = int(W[PENDING_COUNT]) - 1
    zeros = part(W, int(W[PENDING]), ZERO_SIZE * (count + 1))
    for k in range(ZERO_SIZE * number, ZERO_SIZE * count):
        zeros[k] = zeros[k + ZERO_SIZE]
    W[PENDING_COUNT] = float(count)


def drop_others(e: Function, W: Reals, breaks: Reals, pieces: Reals, t: float, within: float) -> None:
    """Remove the zeros of a moment that are no events: of another direction, or the jump of an angle."""
    for k in range(int(W[PENDING_COUNT]) - 1, -1, -1):
        zero = part(W, int(W[PENDING]) + ZERO_SIZE * k, ZERO_SIZE)
        if abs(zero[0] - t) <= within:
            if counts(e, W, breaks, pieces, zero[0], int(zero[1]), zero[2]) == 0:
                remove_zero(W, k)


def counts(
    e: Function, W: Reals, breaks: Reals, pieces: Reals, t: float, place: int, direction: float
) -> int:
    """Return 1 if a zero is the event, else 0."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    if W[row + WAY] != 0.0 and W[row + WAY] != direction:
        return 0
    if W[row + WRAPS] == 0.0:
        return 1
    before = value_at(e, W, breaks, pieces, place, t - BESIDE * W[SPAN])
    behind = value_at(e, W, breaks, pieces, place, t + BESIDE * W[SPAN])
    if abs(behind - before) <= TORN * W[row + LARGEST]:
        return 1
    return 0


def next_of_moment(W: Reals, t: float, within: float) -> int:
    """Return the number of the first event of a moment, in the order of the events, -1 without one."""
    chosen = -1
    for k in range(int(W[PENDING_COUNT])):
        zero = part(W, int(W[PENDING]) + ZERO_SIZE * k, ZERO_SIZE)
        if abs(zero[0] - t) <= within:
            if chosen < 0:
                chosen = k
            elif zero[1] < W[int(W[PENDING]) + ZERO_SIZE * chosen + 1]:
                chosen = k
    return chosen


def any_acts(W: Reals, t: float, within: float) -> int:
    """Return 1 if an event of a moment does more than to be recorded, else 0."""
    for k in range(int(W[PENDING_COUNT])):
        zero = part(W, int(W[PENDING]) + ZERO_SIZE * k, ZERO_SIZE)
        row = int(W[TABLE]) + EVENT_SIZE * int(zero[1])
        if abs(zero[0] - t) <= within and W[row + ACTION] != RECORDS:
            return 1
    return 0


def happen(
    e: Function, a: Function, c: Function, W: Reals, breaks: Reals, pieces: Reals, H: Reals, t: float,
    within: float,
) -> int:  # fmt: skip
    """Note the events of a moment and do what they do."""
    n = int(W[STATES])
    before = part(W, int(W[BEFORE]), n)
    number = next_of_moment(W, t, within)
    if number < 0:
        return NOTHING_YET
    acts = any_acts(W, t, within)
    W[CUT] = W[int(W[PENDING]) + ZERO_SIZE * number]
    state_at(W, breaks, pieces, W[CUT], before)
    if acts != 0:
        note_before(c, W, W[CUT], before)
        close_held(c, W, W[CUT], before, 0, before)
        W[UNMET] = 0.0  # what drifts stays as it is where it cannot be closed
        copy(n, before, part(W, int(W[AFTER]), n))
        for k in range(int(W[EVENTS])):
            row = int(W[TABLE]) + EVENT_SIZE * k
            W[row + REPEATS] = W[row + JUST_HAPPENED]
            W[row + JUST_HAPPENED] = 0.0
        find_slopes_before(e, a, W, breaks, t, within)
    while number >= 0:
        zero = part(W, int(W[PENDING]) + ZERO_SIZE * number, ZERO_SIZE)
        place = int(zero[1])
        code = let_happen(e, a, c, W, breaks, H, place, zero[0], zero[2])
        if code != NOTHING_YET:
            return code
        remove_zero(W, number)
        number = next_of_moment(W, t, within)
    if acts != 0:
        return GOES_ON
    return NOTHING_YET


def find_slopes_before(e: Function, a: Function, W: Reals, breaks: Reals, t: float, within: float) -> None:
    """Find how fast the values of a moment change before their actions, by the equations of motion."""
    if W[ACTIONS] == 0.0:
        return
    n = int(W[STATES])
    before = part(W, int(W[BEFORE]), n)
    find_rates(a, W, W[CUT], before)
    disturb_values(e, W, W[CUT], before)
    step = int(W[CURRENT])
    for k in range(int(W[PENDING_COUNT])):
        zero = part(W, int(W[PENDING]) + ZERO_SIZE * k, ZERO_SIZE)
        row = int(W[TABLE]) + EVENT_SIZE * int(zero[1])
        if abs(zero[0] - t) <= within and W[row + ACTION] == SETS:
            longest = -abs(breaks[step + 1] - breaks[step])
            W[row + SLOPE_BEFORE] = slope_along(e, W, int(zero[1]), W[CUT], before, longest)


def let_happen(
    e: Function, a: Function, c: Function, W: Reals, breaks: Reals, H: Reals, place: int, t: float,
    direction: float,
) -> int:  # fmt: skip
    """Note one event and do what it does."""
    n = int(W[STATES])
    row = int(W[TABLE]) + EVENT_SIZE * place
    note = part(H, (n + 2) * int(W[HAPPENED]), n + 2)
    note[0] = float(place)
    note[1] = t
    copy(n, part(W, int(W[BEFORE]), n), part(note, 2, n))
    W[HAPPENED] = W[HAPPENED] + 1.0
    W[row + JUST_HAPPENED] = 1.0
    W[row + CAME] = direction
    W[row + WAITS] = 0.0
    if direction != 0.0:
        W[row + WAS] = -direction
    if chatters(W, place, t) != 0 or is_too_low(W, place, direction) != 0:
        W[CULPRIT] = float(place + 1)
        return CHATTERS
    if W[row + ACTION] == STOPS:
        return ENDS
    if W[row + ACTION] != RECORDS:
        act(a, c, W, place, W[CUT])
        if W[BAD_PLACE] != 0.0:
            W[CULPRIT] = float(place + 1)
            return SPOILS
        if W[UNMET] != 0.0:
            W[CULPRIT] = float(place + 1)
            return MISSES
        take_rates(W)
        W[RATE_KNOWN] = 1.0
        step = int(W[CURRENT])
        longest = abs(breaks[step + 1] - breaks[step])
        after = part(W, int(W[AFTER]), n)
        if judge_action(e, a, W, place, W[CUT], after, direction, longest) != 0:
            W[CULPRIT] = float(place + 1)
            W[UNTURNED] = 1.0
            return CHATTERS
    return NOTHING_YET


def is_too_low(W: Reals, place: int, direction: float) -> int:
    """Return 1 if an event acts again after a bounce that is too low, else 0: that is chattering, too.

    Lower than the integrator tolerates, where the value moves the other way by the equations of motion; or no
    more than rounding.
    """
    row = part(W, int(W[TABLE]) + EVENT_SIZE * place, EVENT_SIZE)
    if row[ACTION] != SETS or row[REPEATS] == 0.0:
        return 0
    if row[SLOPE_BEFORE] * direction < 0.0 or row[PEAK] <= LOWEST * row[ROUNDING]:
        return 1
    return 0


def chatters(W: Reals, place: int, t: float) -> int:
    """Return 1 if an event happens again and again within an instant, else 0."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    recent = part(W, int(W[RECENT]) + MOST_RECENT * place, MOST_RECENT)
    most = int(W[row + MOST])
    count = int(W[row + RECENT_COUNT])
    if count == most:
        for k in range(most - 1):
            recent[k] = recent[k + 1]
        count = most - 1
    recent[count] = t
    W[row + RECENT_COUNT] = float(count + 1)
    if count + 1 < most or abs(recent[most - 1] - recent[0]) > INSTANT * W[SPAN]:
        return 0
    return 1


def act(a: Function, c: Function, W: Reals, place: int, t: float) -> None:
    """Set the state after an event's action, unless it is not finite; a change of energy counts as work."""
    n = int(W[STATES])
    row = int(W[TABLE]) + EVENT_SIZE * place
    x = part(W, int(W[AFTER]), n)
    values = part(W, int(W[ACTED]), int(W[ACTION_VALUES]))
    note_before(c, W, t, x)
    compute_action(a, W, t, x, values)
    energy = values[0]
    first = int(W[row + SET_FIRST])
    for k in range(int(W[row + SET_COUNT])):
        value = values[1 + first + k]
        if not is_finite(value):
            W[BAD_VALUE] = value
            W[BAD_PLACE] = float(k + 1)
            return
        x[int(W[int(W[TARGETS]) + first + k])] = value
    close_held(c, W, t, x, int(W[row + SET_COUNT]), part(W, int(W[TARGETS]) + first, 1))
    compute_action(a, W, t, x, values)
    x[n - 1] = x[n - 1] + (values[0] - energy)


def note_before(c: Function, W: Reals, t: float, x: Reals) -> None:
    """Note what a closing has to know of a state before it is changed."""
    if W[CLOSING] != 0.0:
        note_followers(c, part(W, int(W[CLOSING]), 1), t, x)


def close_held(c: Function, W: Reals, t: float, x: Reals, count: int, places: Reals) -> None:
    """Close a state with the states at so many places held; note if that cannot be."""
    if W[CLOSING] == 0.0:
        return
    A = part(W, int(W[CLOSING]), 1)
    hold(A, count, places)
    if close_state(c, A, t, x) != ASSEMBLED:
        W[UNMET] = 1.0
