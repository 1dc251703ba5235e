"""How values that are zero where a smooth motion begins leave zero.

An event that sets values happens there if its value goes in the event's direction: the first rate that is not
zero decides, of the first and second. Events that record or stop happen if the value comes back.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import TOUCHING, add_root, add_zero, find_extremum, sign, value_at
from symbody.kernels.events.event_slopes import (
    ROUNDED,
    bend_along,
    disturb_values,
    find_rates,
    slope_along,
    take_rates_of_step,
)
from symbody.kernels.events.watch_block import (
    ACTION,
    ACTIONS,
    AT_START,
    AT_ZERO,
    BAND,
    BLUR,
    CAME,
    CURRENT,
    DONE,
    EVENT_SIZE,
    EVENTS,
    FIRST_STEP,
    G_LAST,
    GOES_THROUGH,
    HIT,
    JUST_HAPPENED,
    LARGEST,
    LEAF,
    LEAF_VALUES,
    LEAVES,
    MOST,
    MOST_RECENT,
    NO_NUMBER,
    NO_NUMBER_TIME,
    NO_SIDE,
    PEAK,
    RATE_KNOWN,
    RECENT,
    RECENT_COUNT,
    REPEATS,
    RESOLUTION,
    RESTS,
    ROUNDING,
    SCRATCH,
    SEEN,
    SETS,
    SLOPE_BEFORE,
    STATES,
    STEP_NODES,
    T_BEFORE,
    T_LAST,
    TABLE,
    WAITS,
    WAITS_TIME,
    WAS,
    WAY,
    WRAPS,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.step_bounds import EPSILON

AWAY: Final = 1e-6  # of the largest value so far, and of time and states
SLIGHT: Final = 3e-13  # a slope that is rounding of the one before an action
LOWEST: Final = 2.0  # so many roundings of a value are not a bounce
BOUNCES: Final = 1e4  # a slope so many times the least that shows is not lost in a bounce
ROUNDED_TIMES: Final = 8.0  # so many roundings of a time
BESIDE_ZERO: Final = 2.2250738585072014e-308  # a value that stands on one side of zero alone


def settle_start(e: Function, W: Reals) -> None:
    """Mark the events whose value is zero at the start of a smooth motion, up to rounding.

    A value whose motion was interrupted just before its zero, by a sample or the end of a step, is on its way
    there.
    """
    m = int(W[EVENTS])
    n = int(W[STATES])
    leaf = part(W, int(W[LEAF]), LEAF_VALUES + m * STEP_NODES)
    state = part(W, int(W[SCRATCH]) + 2 * n, n)
    doubtful = 0
    for i in range(m):
        row = int(W[TABLE]) + EVENT_SIZE * i
        W[row + HIT] = 0.0
        W[row + AT_ZERO] = 0.0
        W[row + PEAK] = 0.0
        W[row + ROUNDING] = 0.0
        if may_be_zero(W, i) != 0:
            doubtful = 1
    if doubtful == 0:
        return
    disturb_values(e, W, leaf[0], state)
    for i in range(m):
        settle_value(W, i, leaf[0], leaf[LEAF_VALUES + i * STEP_NODES])


def settle_value(W: Reals, place: int, t: float, first: float) -> None:
    """Mark an event whose value is zero at the start of a smooth motion, up to rounding."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    error = W[row + BLUR]
    if W[row + JUST_HAPPENED] != 0.0:
        largest = max(largest_sample(W, place), W[row + LARGEST])
        W[row + ROUNDING] = ROUNDED * error
        W[row + BAND] = max(ROUNDED * error, 2.0 * abs(first))
        W[row + AT_ZERO] = 1.0 - was_moved_away(first, largest, error)
    elif W[row + GOES_THROUGH] != 0.0:
        if W[row + GOES_THROUGH] * first < 0.0:
            settle_side(W, place, t, first)
    elif abs(first) <= error and may_be_zero(W, place) != 0:
        W[row + BAND] = 2.0 * abs(first)
        if first == 0.0 or W[row + ACTION] == SETS:  # steps may be so short that only rounding changes it
            W[row + BAND] = max(ROUNDED * error, W[row + BAND])
        W[row + AT_ZERO] = 1.0


def largest_sample(W: Reals, place: int) -> float:
    """Return the largest value of an event in the leaf."""
    samples = part(W, int(W[LEAF]) + LEAF_VALUES + place * STEP_NODES, STEP_NODES)
    largest = 0.0
    for k in range(STEP_NODES):
        largest = max(largest, abs(samples[k]))
    return largest


def may_be_zero(W: Reals, place: int) -> int:
    """Return 1 if rounding decides whether a value is zero at a start, else 0.

    Of values that rest there all samples are rounding. Only actions make it worth to look at those.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    first = W[int(W[LEAF]) + LEAF_VALUES + place * STEP_NODES]
    if W[row + JUST_HAPPENED] != 0.0:
        return 1
    if W[row + GOES_THROUGH] != 0.0:
        if W[row + GOES_THROUGH] * first < 0.0:
            return 1
        return 0
    if W[row + ACTION] == SETS or abs(first) <= TOUCHING * largest_sample(W, place):
        return 1
    return 0


def settle_side(W: Reals, place: int, t: float, first: float) -> None:
    """Keep a value on the side of zero where it was, unless it has jumped through: then it has a zero there.

    A value that differs by rounding alone has not jumped. Angles jump by whole turns.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    if abs(first) > W[row + BLUR]:
        W[row + GOES_THROUGH] = 0.0
        if W[row + WRAPS] == 0.0:
            add_zero(W, t, place, sign(first))


def was_moved_away(first: float, largest: float, error: float) -> float:
    """Return 1 if an action moved the value of its own event off zero, such as one that resets, else 0.

    What is left of a zero that was located, or of loops that were closed again, is smaller.
    """
    if abs(first) <= AWAY * largest or abs(first) <= AWAY / TOUCHING * error:
        return 0.0
    return 1.0


def begin_samples(e: Function, a: Function, W: Reals, breaks: Reals, pieces: Reals) -> None:
    """Take the first sample of a smooth motion, and judge the values that are zero there."""
    m = int(W[EVENTS])
    n = int(W[STATES])
    leaf = part(W, int(W[LEAF]), LEAF_VALUES + m * STEP_NODES)
    state = part(W, int(W[SCRATCH]) + 2 * n, n)
    longest = abs(breaks[int(W[CURRENT]) + 1] - leaf[0])
    W[T_LAST] = leaf[0]
    W[T_BEFORE] = leaf[0]
    W[SEEN] = 1.0
    if W[RATE_KNOWN] == 0.0 and any_at_zero(W) != 0:
        if W[ACTIONS] != 0.0:
            find_rates(a, W, leaf[0], state)
        else:
            take_rates_of_step(W, breaks, pieces)
    for i in range(m):
        row = int(W[TABLE]) + EVENT_SIZE * i
        W[row + G_LAST] = leaf[LEAF_VALUES + i * STEP_NODES]
        note_value(W, i, leaf[0], W[row + G_LAST])
        if W[row + GOES_THROUGH] != 0.0 and W[row + GOES_THROUGH] * W[row + G_LAST] <= 0.0:
            W[row + G_LAST] = W[row + GOES_THROUGH] * BESIDE_ZERO
        if W[row + AT_ZERO] != 0.0:
            W[row + G_LAST] = 0.0
            W[row + LEAVES] = find_way_out(e, W, i, leaf[0], state, longest)
            if W[row + ACTION] == SETS:
                start_event(e, a, W, i, leaf[0], state, longest)
        else:
            leave_side(W, i, W[row + G_LAST])
        W[row + LARGEST] = max(W[row + LARGEST], abs(W[row + G_LAST]))
    W[RATE_KNOWN] = 0.0


def any_at_zero(W: Reals) -> int:
    """Return 1 if some value is zero where the smooth motion begins, else 0."""
    for i in range(int(W[EVENTS])):
        if W[int(W[TABLE]) + EVENT_SIZE * i + AT_ZERO] != 0.0:
            return 1
    return 0


def leave_side(W: Reals, place: int, value: float) -> None:
    """Note on which side of zero a value is, where no event has happened yet."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    W[row + DONE] = 0.0
    if sign(value) != 0.0:
        W[row + WAS] = sign(value)
        if W[row + WAY] * value < 0.0:  # it comes back from the side from which the event happens
            W[row + WAITS] = 0.0


def start_event(
    e: Function, a: Function, W: Reals, place: int, t: float, state: Reals, longest: float
) -> None:
    """Let an event that sets values happen at a start where its value leaves zero in the event's direction.

    It happens once for each time that the value goes through zero: after its own action only if something has
    turned the value back in between. If the event has no direction, the side on which its value was decides.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    way = W[row + LEAVES]
    if way == 0.0:
        way = bend_along(e, a, W, place, t, state, longest)
    wanted = wanted_way(W, place)
    if way != W[row + DONE]:
        W[row + DONE] = 0.0
    if way != 0.0 and way == wanted and W[row + DONE] == 0.0:
        W[row + AT_START] = 1.0
        add_zero(W, t, place, way)
    elif W[row + WAITS] == 0.0 and happened_at(W, place, t) == 0:
        if way == 0.0:
            W[row + WAITS] = RESTS
        elif wanted == 0.0:
            W[row + WAITS] = NO_SIDE
        W[row + WAITS_TIME] = t


def wanted_way(W: Reals, place: int) -> float:
    """Return the direction in which a value passes zero at its event, 0 if that is not known."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    if W[row + WAY] == 0.0:
        return -W[row + WAS]
    return W[row + WAY]


def happened_at(W: Reals, place: int, t: float) -> int:
    """Return 1 if an event that sets values happened last where the smooth motion begins, else 0."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    count = int(W[row + RECENT_COUNT])
    if W[row + JUST_HAPPENED] != 0.0:
        return 1
    if count == 0:
        return 0
    if W[int(W[RECENT]) + MOST_RECENT * place + count - 1] == t:
        return 1
    return 0


def note_value(W: Reals, place: int, t: float, value: float) -> None:
    """Note when a value is first no number."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    if value != value and W[row + NO_NUMBER] == 0.0:
        W[row + NO_NUMBER] = 1.0
        W[row + NO_NUMBER_TIME] = t


def find_way_out(e: Function, W: Reals, place: int, t: float, state: Reals, longest: float) -> float:
    """Return the direction in which a value leaves zero at a state, 0 if it has none of first order.

    Before it has left, it may change by what times are rounded.
    A slope that an action has made zero may be rounding of the one before. Where bounces are so low that
    slopes do not show any more, the value is to go back where it came from.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    slope = slope_along(e, W, place, t, state, longest)
    W[row + BAND] = max(W[row + BAND], ROUNDED_TIMES * EPSILON * abs(t) * abs(slope))
    if W[row + JUST_HAPPENED] == 0.0 or W[RATE_KNOWN] == 0.0:
        return sign(slope)
    before = abs(W[row + SLOPE_BEFORE])
    if slope != 0.0 and abs(slope) <= SLIGHT * before:
        return 0.0
    if slope == 0.0 and W[row + REPEATS] != 0.0 and before <= BOUNCES * W[RESOLUTION]:
        return -W[row + CAME]
    return sign(slope)


def leave_zero(
    e: Function, W: Reals, breaks: Reals, pieces: Reals, place: int, t: float, value: float
) -> float:
    """Return the value of a sample, 0 as long as it has not left the zero where its smooth motion began.

    A value that leaves zero upwards and then stands below has come back in between.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    if abs(value) <= W[row + BAND]:
        return 0.0
    if value != value:
        return value
    W[row + AT_ZERO] = 0.0
    if W[row + LEAVES] == 0.0:
        leave_side(W, place, value)
    else:
        leave_side(W, place, W[row + LEAVES])
    if W[row + LEAVES] * value < 0.0:
        find_missed_return(e, W, breaks, pieces, place, t)
    return value


def find_missed_return(e: Function, W: Reals, breaks: Reals, pieces: Reals, place: int, end: float) -> None:
    """Add the zero at which a value came back between the start of a smooth motion and a sample.

    Where that return is rounding, or less than the integrator tolerates, it counts if the event has just
    happened: its action leads back at once, which is chattering already.
    """
    row = int(W[TABLE]) + EVENT_SIZE * place
    begin = breaks[int(W[FIRST_STEP])]
    side = W[row + LEAVES]
    samples = part(W, int(W[LEAF]) + LEAF_VALUES + place * STEP_NODES, STEP_NODES)
    largest = 0.0
    for k in range(STEP_NODES):
        largest = max(largest, abs(samples[k]))
    top = find_extremum(e, W, breaks, pieces, place, begin, end, -side)
    value = value_at(e, W, breaks, pieces, place, top)
    if top != begin and top != end and value * side > max(1e-15 * largest, LOWEST * W[row + ROUNDING]):
        add_root(e, W, breaks, pieces, place, top, end, -side)
    elif W[row + JUST_HAPPENED] != 0.0:
        recent = part(W, int(W[RECENT]) + MOST_RECENT * place, MOST_RECENT)
        for k in range(int(W[row + MOST])):
            recent[k] = begin
        W[row + RECENT_COUNT] = W[row + MOST]
        add_zero(W, begin, place, -side)
