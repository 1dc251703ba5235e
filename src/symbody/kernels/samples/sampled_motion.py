"""A motion with values that are held between samples, with events or without."""

from __future__ import annotations

from symbody.kernels.block import (
    DENSE_ROWS,
    EVERY_STEP,
    FINISHED,
    FULL,
    FUNCTION,
    LENGTH,
    METHOD,
    NO_EVENT_ROOM,
    NO_SAMPLE_ROOM,
    RUNNING,
    SAMPLE_FAULT,
    SAMPLE_ROOM,
    SAMPLES,
    STATE_OLD,
    STEP,
    STEP_ROOM,
    STEPS,
    T_END,
    TIME,
    VECTORS,
    N,
)
from symbody.kernels.events.event_location import add_zero, compute_values, sign
from symbody.kernels.events.event_monitor import GOES_ON, MOST_RECENT, NO_ROOM, NOTHING_YET, EventMonitor
from symbody.kernels.events.event_watch import look, start_stretch
from symbody.kernels.events.watched_motion import cut_back, end_at_event, go_on
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy, evaluate
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.kernels.samples.sampling import is_due, is_instant, piece_end, show_values, take_samples
from symbody.kernels.step_bounds import behind_jump
from symbody.kernels.step_machine import advance


def sample(f: Function, h: Function, B: Reals, held: SampleHold, Q: Reals, Y: Reals) -> int:
    """Take the samples that are due, and go on with the derivative behind them; return a code of `block`."""
    if held.recorded == held.room:
        return NO_SAMPLE_ROOM
    t = B[TIME]
    if take_samples(h, Q, held, Y, t, part(B, VECTORS + STATE_OLD * int(B[N]), int(B[N]))) != 0:
        return SAMPLE_FAULT
    show_values(held, part(B, int(B[FUNCTION]), 1))
    if t != B[T_END]:
        B[TIME] = behind_jump(B, t)
        evaluate(f, B, B[TIME], STATE_OLD, 0)
    return RUNNING


def advance_to_sample(
    f: Function, g: Function, B: Reals, held: SampleHold, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals,
) -> int:  # fmt: skip
    """Try one step, which ends at the next sample; return one of the codes of `block`."""
    end = B[T_END]
    stop = piece_end(B, held, end)
    planned = B[STEP]
    B[T_END] = stop
    code = advance(f, g, B, times, t, x, breaks, pieces, 1)
    B[T_END] = end
    if code == FINISHED and stop != end:
        code = RUNNING
    if B[TIME] == stop and abs(B[LENGTH]) < abs(planned) and abs(B[STEP]) < abs(planned):
        B[STEP] = planned  # a step that only the sample cut short says nothing of the next
    return code


def advance_sampled(
    f: Function, g: Function, h: Function, B: Reals, held: SampleHold, Q: Reals, times: Reals, t: Reals,
    x: Reals, breaks: Reals, pieces: Reals, Y: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps and take the samples on the way; return one of the codes of `block`.

    `NO_SAMPLE_ROOM` wants more room for the record of held values.
    """
    for _trial in range(trials):
        if is_due(held, B[TIME]) != 0:
            code = sample(f, h, B, held, Q, Y)
            if code != RUNNING:
                return code
        code = advance_to_sample(f, g, B, held, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING


def values_before(e: Function, B: Reals, monitor: EventMonitor) -> None:
    """Note on which side of zero the values of events are just before a sample; zero itself is none.

    Where a motion goes on, the sides are those on which it was interrupted.
    """
    compute_values(e, monitor, B[TIME], part(B, VECTORS + STATE_OLD * int(B[N]), int(B[N])))
    for k in range(monitor.event_count):
        side = sign(monitor.values[k])
        event = monitor.events[k]
        if side != 0.0 and (B[STEPS] != 0.0 or event.side == 0.0):
            event.side = side


def watch_sample(e: Function, B: Reals, monitor: EventMonitor, held: SampleHold) -> None:
    """Watch the motion behind a sample: values that jump through zero there have a zero there."""
    show_values(held, monitor.numbers)
    if exists(monitor.actions):
        show_values(held, monitor.actions)
    t = B[TIME]
    start_stretch(monitor, int(B[STEPS]))
    compute_values(e, monitor, t, part(B, VECTORS + STATE_OLD * int(B[N]), int(B[N])))
    for k in range(monitor.event_count):
        event = monitor.events[k]
        if B[STEPS] != 0.0 or monitor.happened != 0:
            event.just_happened = has_just_happened(monitor, held, k, t)
        side = sign(monitor.values[k])
        if event.side * side > 0.0 and event.just_happened == 0.0:
            event.goes_through = side
        if event.side * side < 0.0 and event.just_happened == 0.0:
            add_zero(monitor, t, k, side)


def end_with_state(B: Reals, breaks: Reals, pieces: Reals) -> None:
    """Write a step of no length behind the last one: what happens at the end finds its state there."""
    n = int(B[N])
    step = int(B[STEPS])
    size = int(B[METHOD + DENSE_ROWS]) * n
    piece = part(pieces, step * size, size)
    copy(n, part(B, VECTORS + STATE_OLD * n, n), piece)
    for k in range(n, size):
        piece[k] = 0.0
    breaks[step + 1] = B[TIME]


def has_just_happened(monitor: EventMonitor, held: SampleHold, place: int, t: float) -> float:
    """Return 1 if an event has happened at a time, else 0."""
    count = int(monitor.events[place].recent_count)
    if count == 0:
        return 0.0
    return float(is_instant(held, monitor.recent[MOST_RECENT * place + count - 1], t))


def sample_watched(
    f: Function, e: Function, a: Function, c: Function, h: Function, B: Reals, monitor: EventMonitor,
    held: SampleHold, Q: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals,
    Y: Reals,
) -> int:  # fmt: skip
    """Let all happen that comes before the samples that are due, and take these; return a code of `block`."""
    happened = NOTHING_YET
    if B[TIME] == B[T_END] and B[STEPS] == B[STEP_ROOM]:
        return FULL
    if B[STEPS] != 0.0:
        happened = look(e, a, c, monitor, breaks, pieces, H, int(B[STEPS]), 1)
    if happened == NO_ROOM:
        return NO_EVENT_ROOM
    if happened == GOES_ON:
        cut_back(B, monitor, t, x, breaks, pieces, 1)
        code = go_on(f, B, monitor, times, t, x, breaks)
        if code == FINISHED:
            return RUNNING
        return code
    if happened != NOTHING_YET:
        return end_at_event(B, monitor, t, x, breaks, pieces, happened)
    values_before(e, B, monitor)
    code = sample(f, h, B, held, Q, Y)
    if code == RUNNING:
        if B[TIME] == B[T_END]:
            end_with_state(B, breaks, pieces)
        watch_sample(e, B, monitor, held)
    return code


def step_watched(
    f: Function, g: Function, e: Function, a: Function, c: Function, B: Reals, monitor: EventMonitor,
    held: SampleHold, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """Try one step, and let events happen unless samples are due at its end; return a code of `block`."""
    code = FULL
    if B[EVERY_STEP] == 0.0 or B[SAMPLES] + 2.0 <= B[SAMPLE_ROOM]:
        code = advance_to_sample(f, g, B, held, times, t, x, breaks, pieces)
    if B[STEPS] == 0.0 or (code == RUNNING and is_due(held, B[TIME]) != 0):
        return code
    is_over = 1
    if code == RUNNING or code == FULL:
        is_over = 0
    happened = look(e, a, c, monitor, breaks, pieces, H, int(B[STEPS]), is_over)
    if happened == NO_ROOM:
        return NO_EVENT_ROOM
    if happened == GOES_ON:
        cut_back(B, monitor, t, x, breaks, pieces, 1)
        return go_on(f, B, monitor, times, t, x, breaks)
    if happened != NOTHING_YET:
        return end_at_event(B, monitor, t, x, breaks, pieces, happened)
    return code


def advance_sampled_watched(
    f: Function, g: Function, e: Function, a: Function, c: Function, h: Function, B: Reals,
    monitor: EventMonitor, held: SampleHold, Q: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals, H: Reals, Y: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps, take samples and let events happen; return one of the codes of `block`."""
    for _trial in range(trials):
        while is_due(held, B[TIME]) != 0:
            code = sample_watched(f, e, a, c, h, B, monitor, held, Q, times, t, x, breaks, pieces, H, Y)
            if code != RUNNING:
                return code
        code = step_watched(f, g, e, a, c, B, monitor, held, times, t, x, breaks, pieces, H)
        if code != RUNNING:
            return code
    return RUNNING
