"""How values that are zero where a smooth motion begins leave zero.

An event that sets values happens there if its value goes in the event's direction: the first rate that is not
zero decides, of the first and second. Events that record or stop happen if the value comes back.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import TOUCHING, add_root, add_zero, find_extremum, sign, value_at
from symbody.kernels.events.event_monitor import (
    LEAF_VALUES,
    MOST_RECENT,
    NO_SIDE,
    RESTS,
    SETS,
    STEP_NODES,
    EventMonitor,
)
from symbody.kernels.events.event_slopes import (
    ROUNDED,
    bend_along,
    disturb_values,
    find_rates,
    slope_along,
    take_rates_of_step,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.record_layout import exists
from symbody.kernels.step_bounds import EPSILON

AWAY: Final = 1e-6  # of the largest value so far, and of time and states
SLIGHT: Final = 3e-13  # a slope that is rounding of the one before an action
LOWEST: Final = 2.0  # so many roundings of a value are not a bounce
BOUNCES: Final = 1e4  # a slope so many times the least that shows is not lost in a bounce
ROUNDED_TIMES: Final = 8.0  # so many roundings of a time
BESIDE_ZERO: Final = 2.2250738585072014e-308  # a value that stands on one side of zero alone


def settle_start(e: Function, monitor: EventMonitor) -> None:
    """Mark the events whose value is zero at the start of a smooth motion, up to rounding.

    A value whose motion was interrupted just before its zero, by a sample or the end of a step, is on its way
    there.
    """
    m = monitor.event_count
    n = monitor.states
    leaf = monitor.leaf
    state = part(monitor.scratch, 2 * n, n)
    doubtful = 0
    for i in range(m):
        event = monitor.events[i]
        event.hit = 0.0
        event.at_zero = 0.0
        event.peak = 0.0
        event.rounding = 0.0
        if may_be_zero(monitor, i) != 0:
            doubtful = 1
    if doubtful == 0:
        return
    disturb_values(e, monitor, leaf[0], state)
    for i in range(m):
        settle_value(monitor, i, leaf[0], leaf[LEAF_VALUES + i * STEP_NODES])


def settle_value(monitor: EventMonitor, place: int, t: float, first: float) -> None:
    """Mark an event whose value is zero at the start of a smooth motion, up to rounding."""
    event = monitor.events[place]
    error = event.blur
    if event.just_happened != 0.0:
        largest = max(largest_sample(monitor, place), event.largest)
        event.rounding = ROUNDED * error
        event.band = max(ROUNDED * error, 2.0 * abs(first))
        event.at_zero = 1.0 - was_moved_away(first, largest, error)
    elif event.goes_through != 0.0:
        if event.goes_through * first < 0.0:
            settle_side(monitor, place, t, first)
    elif abs(first) <= error and may_be_zero(monitor, place) != 0:
        event.band = 2.0 * abs(first)
        if first == 0.0 or event.action == SETS:  # steps may be so short that only rounding changes it
            event.band = max(ROUNDED * error, event.band)
        event.at_zero = 1.0


def largest_sample(monitor: EventMonitor, place: int) -> float:
    """Return the largest value of an event in the leaf."""
    samples = part(monitor.leaf, LEAF_VALUES + place * STEP_NODES, STEP_NODES)
    largest = 0.0
    for k in range(STEP_NODES):
        largest = max(largest, abs(samples[k]))
    return largest


def may_be_zero(monitor: EventMonitor, place: int) -> int:
    """Return 1 if rounding decides whether a value is zero at a start, else 0.

    Of values that rest there all samples are rounding. Only actions make it worth to look at those.
    """
    event = monitor.events[place]
    first = monitor.leaf[LEAF_VALUES + place * STEP_NODES]
    if event.just_happened != 0.0:
        return 1
    if event.goes_through != 0.0:
        if event.goes_through * first < 0.0:
            return 1
        return 0
    if event.action == SETS or abs(first) <= TOUCHING * largest_sample(monitor, place):
        return 1
    return 0


def settle_side(monitor: EventMonitor, place: int, t: float, first: float) -> None:
    """Keep a value on the side of zero where it was, unless it has jumped through: then it has a zero there.

    A value that differs by rounding alone has not jumped. Angles jump by whole turns.
    """
    event = monitor.events[place]
    if abs(first) > event.blur:
        event.goes_through = 0.0
        if event.wraps == 0.0:
            add_zero(monitor, t, place, sign(first))


def was_moved_away(first: float, largest: float, error: float) -> float:
    """Return 1 if an action moved the value of its own event off zero, such as one that resets, else 0.

    What is left of a zero that was located, or of loops that were closed again, is smaller.
    """
    if abs(first) <= AWAY * largest or abs(first) <= AWAY / TOUCHING * error:
        return 0.0
    return 1.0


def begin_samples(e: Function, a: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals) -> None:
    """Take the first sample of a smooth motion, and judge the values that are zero there."""
    m = monitor.event_count
    n = monitor.states
    leaf = monitor.leaf
    state = part(monitor.scratch, 2 * n, n)
    longest = abs(breaks[monitor.current + 1] - leaf[0])
    monitor.t_last = leaf[0]
    monitor.t_before = leaf[0]
    monitor.seen = 1.0
    if monitor.rate_known == 0.0 and any_at_zero(monitor) != 0:
        if exists(monitor.actions):
            find_rates(a, monitor, leaf[0], state)
        else:
            take_rates_of_step(monitor, breaks, pieces)
    for i in range(m):
        event = monitor.events[i]
        event.g_last = leaf[LEAF_VALUES + i * STEP_NODES]
        note_value(monitor, i, leaf[0], event.g_last)
        if event.goes_through != 0.0 and event.goes_through * event.g_last <= 0.0:
            event.g_last = event.goes_through * BESIDE_ZERO
        if event.at_zero != 0.0:
            event.g_last = 0.0
            event.leaves = find_way_out(e, monitor, i, leaf[0], state, longest)
            if event.action == SETS:
                start_event(e, a, monitor, i, leaf[0], state, longest)
        else:
            leave_side(monitor, i, event.g_last)
        event.largest = max(event.largest, abs(event.g_last))
    monitor.rate_known = 0.0


def any_at_zero(monitor: EventMonitor) -> int:
    """Return 1 if some value is zero where the smooth motion begins, else 0."""
    for i in range(monitor.event_count):
        if monitor.events[i].at_zero != 0.0:
            return 1
    return 0


def leave_side(monitor: EventMonitor, place: int, value: float) -> None:
    """Note on which side of zero a value is, where no event has happened yet."""
    event = monitor.events[place]
    event.done = 0.0
    if sign(value) != 0.0:
        event.was = sign(value)
        if event.way * value < 0.0:  # it comes back from the side from which the event happens
            event.waits = 0.0


def start_event(
    e: Function, a: Function, monitor: EventMonitor, place: int, t: float, state: Reals, longest: float
) -> None:
    """Let an event that sets values happen at a start where its value leaves zero in the event's direction.

    It happens once for each time that the value goes through zero: after its own action only if something has
    turned the value back in between. If the event has no direction, the side on which its value was decides.
    """
    event = monitor.events[place]
    way = event.leaves
    if way == 0.0:
        way = bend_along(e, a, monitor, place, t, state, longest)
    wanted = wanted_way(monitor, place)
    if way != event.done:
        event.done = 0.0
    if way != 0.0 and way == wanted and event.done == 0.0:
        event.at_start = 1.0
        add_zero(monitor, t, place, way)
    elif event.waits == 0.0 and happened_at(monitor, place, t) == 0:
        if way == 0.0:
            event.waits = RESTS
        elif wanted == 0.0:
            event.waits = NO_SIDE
        event.waits_time = t


def wanted_way(monitor: EventMonitor, place: int) -> float:
    """Return the direction in which a value passes zero at its event, 0 if that is not known."""
    event = monitor.events[place]
    if event.way == 0.0:
        return -event.was
    return event.way


def happened_at(monitor: EventMonitor, place: int, t: float) -> int:
    """Return 1 if an event that sets values happened last where the smooth motion begins, else 0."""
    event = monitor.events[place]
    count = event.recent_count
    if event.just_happened != 0.0:
        return 1
    if count == 0:
        return 0
    if monitor.recent[MOST_RECENT * place + count - 1] == t:
        return 1
    return 0


def note_value(monitor: EventMonitor, place: int, t: float, value: float) -> None:
    """Note when a value is first no number."""
    event = monitor.events[place]
    if value != value and event.no_number == 0.0:
        event.no_number = 1.0
        event.no_number_time = t


def find_way_out(
    e: Function, monitor: EventMonitor, place: int, t: float, state: Reals, longest: float
) -> float:
    """Return the direction in which a value leaves zero at a state, 0 if it has none of first order.

    Before it has left, it may change by what times are rounded.
    A slope that an action has made zero may be rounding of the one before. Where bounces are so low that
    slopes do not show any more, the value is to go back where it came from.
    """
    event = monitor.events[place]
    slope = slope_along(e, monitor, place, t, state, longest)
    event.band = max(event.band, ROUNDED_TIMES * EPSILON * abs(t) * abs(slope))
    if event.just_happened == 0.0 or monitor.rate_known == 0.0:
        return sign(slope)
    before = abs(event.slope_before)
    if slope != 0.0 and abs(slope) <= SLIGHT * before:
        return 0.0
    if slope == 0.0 and event.repeats != 0.0 and before <= BOUNCES * monitor.resolution:
        return -event.came
    return sign(slope)


def leave_zero(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, t: float, value: float
) -> float:
    """Return the value of a sample, 0 as long as it has not left the zero where its smooth motion began.

    A value that leaves zero upwards and then stands below has come back in between.
    """
    event = monitor.events[place]
    if abs(value) <= event.band:
        return 0.0
    if value != value:
        return value
    event.at_zero = 0.0
    if event.leaves == 0.0:
        leave_side(monitor, place, value)
    else:
        leave_side(monitor, place, event.leaves)
    if event.leaves * value < 0.0:
        find_missed_return(e, monitor, breaks, pieces, place, t)
    return value


def find_missed_return(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, end: float
) -> None:
    """Add the zero at which a value came back between the start of a smooth motion and a sample.

    Where that return is rounding, or less than the integrator tolerates, it counts if the event has just
    happened: its action leads back at once, which is chattering already.
    """
    event = monitor.events[place]
    begin = breaks[monitor.first_step]
    side = event.leaves
    samples = part(monitor.leaf, LEAF_VALUES + place * STEP_NODES, STEP_NODES)
    largest = 0.0
    for k in range(STEP_NODES):
        largest = max(largest, abs(samples[k]))
    top = find_extremum(e, monitor, breaks, pieces, place, begin, end, -side)
    value = value_at(e, monitor, breaks, pieces, place, top)
    if top != begin and top != end and value * side > max(1e-15 * largest, LOWEST * event.rounding):
        add_root(e, monitor, breaks, pieces, place, top, end, -side)
    elif event.just_happened != 0.0:
        recent = part(monitor.recent, MOST_RECENT * place, MOST_RECENT)
        for k in range(event.most):
            recent[k] = begin
        event.recent_count = event.most
        add_zero(monitor, begin, place, -side)
