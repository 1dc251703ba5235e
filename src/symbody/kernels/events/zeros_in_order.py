"""What happens at zeros: simultaneous ones together, in the order of the events.

H receives a row for each: the place of the event, when, and the state, which is the one before any action.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import ASSEMBLED
from symbody.kernels.configurations.closing import close_state, hold, note_followers
from symbody.kernels.events.acting_events import judge_action
from symbody.kernels.events.event_location import BESIDE, state_at, value_at
from symbody.kernels.events.event_monitor import (
    CHATTERS,
    ENDS,
    GOES_ON,
    MISSES,
    MOST_RECENT,
    NO_ROOM,
    NOTHING_YET,
    RECORDS,
    SETS,
    SHORTENS,
    SPOILS,
    STOPS,
    SWITCHES,
    ZEROS_PER_EVENT,
    EventMonitor,
)
from symbody.kernels.events.event_slopes import (
    compute_action,
    disturb_values,
    find_rates,
    slope_along,
    take_rates,
)
from symbody.kernels.events.event_starts import LOWEST
from symbody.kernels.language import Function, Reals, is_finite, part
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy

SIMULTANEOUS: Final = 1e-12
# By so much a step becomes shorter at most that is taken again.
SHORTEST: Final = 1e-3
# A value that changes by such a share of its largest has jumped.
TORN: Final = 0.25
# So many events of one kind within such a share of the run are chattering.
INSTANT: Final = 1e-7
# Zeros that the next samples may show, of each event.
NEWEST: Final = 4.0


def settle(
    e: Function, a: Function, c: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, H: Reals,
    last: int,
) -> int:  # fmt: skip
    """Let zeros happen before which no other can be found any more, all if these were the last samples."""
    while monitor.pending_count > 0:
        direction = monitor.direction
        t = earliest(monitor)
        within = SIMULTANEOUS * max(monitor.span, abs(breaks[monitor.current + 1]))
        if last == 0 and (monitor.t_before - t) * direction <= within * has_room(monitor):
            return NOTHING_YET
        if monitor.happened + monitor.pending_count > monitor.happened_room:
            return NO_ROOM
        drop_others(e, monitor, breaks, pieces, t, within)
        code = happen(e, a, c, monitor, breaks, pieces, H, t, within)
        if code != NOTHING_YET:
            return code
    return NOTHING_YET


def has_room(monitor: EventMonitor) -> float:
    """Return 1 if the zeros of some more samples may wait, else 0: many fit into a moment far from t = 0."""
    if monitor.pending_count + NEWEST * monitor.event_count > ZEROS_PER_EVENT * monitor.event_count:
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


def earliest(monitor: EventMonitor) -> float:
    """Return the first of the zeros that wait."""
    t = monitor.pending[0].time
    for k in range(1, monitor.pending_count):
        if (monitor.pending[k].time - t) * monitor.direction < 0.0:
            t = monitor.pending[k].time
    return t


def remove_zero(monitor: EventMonitor, number: int) -> None:
    """Remove one of the zeros that wait."""
    count = monitor.pending_count - 1
    for k in range(number, count):
        zero = monitor.pending[k]
        later = monitor.pending[k + 1]
        zero.time = later.time
        zero.event = later.event
        zero.direction = later.direction
    monitor.pending_count = count


def drop_others(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, t: float, within: float
) -> None:
    """Remove the zeros of a moment that are no events: of another direction, or the jump of an angle."""
    for k in range(monitor.pending_count - 1, -1, -1):
        zero = monitor.pending[k]
        if abs(zero.time - t) <= within:
            if counts(e, monitor, breaks, pieces, zero.time, zero.event, zero.direction) == 0:
                remove_zero(monitor, k)


def counts(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, t: float, place: int, direction: float
) -> int:
    """Return 1 if a zero is the event, else 0."""
    event = monitor.events[place]
    if event.way != 0.0 and event.way != direction:
        return 0
    if event.wraps == 0.0:
        return 1
    before = value_at(e, monitor, breaks, pieces, place, t - BESIDE * monitor.span)
    behind = value_at(e, monitor, breaks, pieces, place, t + BESIDE * monitor.span)
    if abs(behind - before) <= TORN * event.largest:
        return 1
    return 0


def next_of_moment(monitor: EventMonitor, t: float, within: float) -> int:
    """Return the number of the first event of a moment, in the order of the events, -1 without one."""
    chosen = -1
    for k in range(monitor.pending_count):
        zero = monitor.pending[k]
        if abs(zero.time - t) <= within:
            if chosen < 0:
                chosen = k
            elif zero.event < monitor.pending[chosen].event:
                chosen = k
    return chosen


def any_acts(monitor: EventMonitor, t: float, within: float) -> int:
    """Return 1 if an event of a moment does more than to be recorded, else 0."""
    for k in range(monitor.pending_count):
        zero = monitor.pending[k]
        event = monitor.events[zero.event]
        if abs(zero.time - t) <= within and event.action != RECORDS:
            return 1
    return 0


def any_shortens(monitor: EventMonitor, t: float, within: float) -> int:
    """Return 1 if a step is to be taken again because of a zero of a moment, else 0."""
    for k in range(monitor.pending_count):
        zero = monitor.pending[k]
        if abs(zero.time - t) <= within and monitor.events[zero.event].action == SHORTENS:
            return 1
    return 0


def take_again(monitor: EventMonitor, breaks: Reals, pieces: Reals, H: Reals, t: float) -> None:
    """Let the motion go on from the start of the step in which a time lies, by shorter steps.

    Inside it what is watched passed zero, and was back at its end. If what acts beyond zero was seen while
    its polynomial was made, that is not the motion, so that the time counts as a guess.
    """
    step = monitor.current
    while step > monitor.first_step and (t - breaks[step]) * monitor.direction <= 0.0:
        step = step - 1
    length = abs(breaks[step + 1] - breaks[step])
    monitor.bound = max(0.5 * abs(t - breaks[step]), SHORTEST * length)
    monitor.cut = breaks[step]
    copy(monitor.states, part(pieces, step * monitor.piece_rows * monitor.states, 1), monitor.before)
    copy(monitor.states, monitor.before, monitor.after)
    forget_events(monitor, H, monitor.cut)


def forget_events(monitor: EventMonitor, H: Reals, t: float) -> None:
    """Forget what happened behind a time."""
    direction = monitor.direction
    row = monitor.states + 2
    while monitor.happened > 0:
        if (H[row * (monitor.happened - 1) + 1] - t) * direction <= 0.0:
            break
        monitor.happened = monitor.happened - 1
    for k in range(monitor.event_count):
        event = monitor.events[k]
        count = event.recent_count
        while count > 0:
            if (monitor.recent[MOST_RECENT * k + count - 1] - t) * direction <= 0.0:
                break
            count = count - 1
            event.just_happened = 0.0
        event.recent_count = count


def happen(
    e: Function, a: Function, c: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, H: Reals,
    t: float, within: float,
) -> int:  # fmt: skip
    """Note the events of a moment and do what they do."""
    n = monitor.states
    before = monitor.before
    number = next_of_moment(monitor, t, within)
    if number < 0:
        return NOTHING_YET
    if any_shortens(monitor, t, within) != 0:
        take_again(monitor, breaks, pieces, H, t)
        return GOES_ON
    acts = any_acts(monitor, t, within)
    monitor.bound = 0.0
    monitor.cut = monitor.pending[number].time
    state_at(monitor, breaks, pieces, monitor.cut, before)
    if acts != 0:
        note_before(c, monitor, monitor.cut, before)
        close_held(c, monitor, monitor.cut, before, 0, before)
        monitor.unmet = 0.0  # what drifts stays as it is where it cannot be closed
        copy(n, before, monitor.after)
        for k in range(monitor.event_count):
            event = monitor.events[k]
            event.repeats = event.just_happened
            event.just_happened = 0.0
        find_slopes_before(e, a, monitor, breaks, t, within)
    while number >= 0:
        zero = monitor.pending[number]
        place = zero.event
        code = let_happen(e, a, c, monitor, breaks, H, place, zero.time, zero.direction)
        if code != NOTHING_YET:
            return code
        remove_zero(monitor, number)
        number = next_of_moment(monitor, t, within)
    if acts == 0:
        return NOTHING_YET
    if monitor.hands_over != 0.0:
        return ENDS
    return GOES_ON


def find_slopes_before(
    e: Function, a: Function, monitor: EventMonitor, breaks: Reals, t: float, within: float
) -> None:
    """Find how fast the values of a moment change before their actions, by the equations of motion."""
    if not exists(monitor.actions):
        return
    before = monitor.before
    find_rates(a, monitor, monitor.cut, before)
    disturb_values(e, monitor, monitor.cut, before)
    step = monitor.current
    for k in range(monitor.pending_count):
        zero = monitor.pending[k]
        event = monitor.events[zero.event]
        if abs(zero.time - t) <= within and event.action == SETS:
            longest = -abs(breaks[step + 1] - breaks[step])
            event.slope_before = slope_along(e, monitor, zero.event, monitor.cut, before, longest)


def let_happen(
    e: Function, a: Function, c: Function, monitor: EventMonitor, breaks: Reals, H: Reals, place: int,
    t: float, direction: float,
) -> int:  # fmt: skip
    """Note one event and do what it does."""
    n = monitor.states
    event = monitor.events[place]
    note = part(H, (n + 2) * monitor.happened, n + 2)
    note[0] = float(place)
    note[1] = t
    copy(n, monitor.before, part(note, 2, n))
    monitor.happened = monitor.happened + 1
    event.just_happened = 1.0
    event.came = direction
    event.waits = 0.0
    if direction != 0.0:
        event.was = -direction
    if chatters(monitor, place, t) != 0 or is_too_low(monitor, place, direction) != 0:
        monitor.culprit = place + 1
        return CHATTERS
    if event.action == STOPS:
        return ENDS
    if event.action == SWITCHES:
        monitor.ended = place + 1
    elif event.action != RECORDS:
        act(a, c, monitor, place, monitor.cut)
        if monitor.bad_place != 0:
            monitor.culprit = place + 1
            return SPOILS
        if monitor.unmet != 0.0:
            monitor.culprit = place + 1
            return MISSES
        take_rates(monitor)
        monitor.rate_known = 1.0
        monitor.has_acted = 1.0
        monitor.actor = place + 1
        step = monitor.current
        longest = abs(breaks[step + 1] - breaks[step])
        after = monitor.after
        if judge_action(e, a, monitor, place, monitor.cut, after, direction, longest) != 0:
            monitor.culprit = place + 1
            monitor.unturned = 1.0
            return CHATTERS
    return NOTHING_YET


def is_too_low(monitor: EventMonitor, place: int, direction: float) -> int:
    """Return 1 if an event acts again after a bounce that is too low, else 0: that is chattering, too.

    Lower than the integrator tolerates, where the value moves the other way by the equations of motion; or no
    more than rounding.
    """
    event = monitor.events[place]
    if event.action != SETS or event.repeats == 0.0:
        return 0
    if event.slope_before * direction < 0.0 or event.peak <= LOWEST * event.rounding:
        return 1
    return 0


def chatters(monitor: EventMonitor, place: int, t: float) -> int:
    """Return 1 if an event happens again and again within an instant, else 0."""
    event = monitor.events[place]
    recent = part(monitor.recent, MOST_RECENT * place, MOST_RECENT)
    most = event.most
    count = event.recent_count
    if count == most:
        for k in range(most - 1):
            recent[k] = recent[k + 1]
        count = most - 1
    recent[count] = t
    event.recent_count = count + 1
    if count + 1 < most or abs(recent[most - 1] - recent[0]) > INSTANT * monitor.span:
        return 0
    return 1


def act(a: Function, c: Function, monitor: EventMonitor, place: int, t: float) -> None:
    """Set the state after an event's action, unless it is not finite; a change of energy counts as work."""
    n = monitor.states
    event = monitor.events[place]
    x = monitor.after
    values = monitor.acted
    release_closing(monitor)
    note_before(c, monitor, t, x)
    compute_action(a, monitor, t, x, values)
    energy = values[0]
    first = event.set_first
    for k in range(event.set_count):
        value = values[1 + first + k]
        if not is_finite(value):
            monitor.bad_value = value
            monitor.bad_place = k + 1
            return
        x[int(monitor.targets[first + k])] = value
    close_held(c, monitor, t, x, event.set_count, part(monitor.targets, first, 1))
    compute_action(a, monitor, t, x, values)
    x[n - 1] = x[n - 1] + (values[0] - energy)


def release_closing(monitor: EventMonitor) -> None:
    """Let no joint stick and no gap be closed where states are closed after an action."""
    if exists(monitor.closing):
        numbers = monitor.closing.numbers
        for k in range(monitor.mode_count):
            numbers.inputs[monitor.first_mode + k] = 1.0


def note_before(c: Function, monitor: EventMonitor, t: float, x: Reals) -> None:
    """Note what a closing has to know of a state before it is changed."""
    if exists(monitor.closing):
        note_followers(c, monitor.closing, t, x)


def close_held(c: Function, monitor: EventMonitor, t: float, x: Reals, count: int, places: Reals) -> None:
    """Close a state with the states at so many places held; note if that cannot be."""
    if not exists(monitor.closing):
        return
    A = monitor.closing
    hold(A, count, places)
    if close_state(c, A, t, x) != ASSEMBLED:
        monitor.unmet = 1.0
