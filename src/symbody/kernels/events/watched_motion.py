"""A motion that is searched for events step by step: cut where one acts, it goes on from there."""

from __future__ import annotations

from symbody.kernels.block import (
    AFTER_REJECTION,
    CHATTERING,
    DENSE_ROWS,
    DIRECTION,
    EVENT_FAULT,
    EVERY_STEP,
    FINISHED,
    FIRST_STEP,
    FULL,
    GROWTH,
    KERNEL,
    MAX_STEP,
    METHOD,
    NO_EVENT_ROOM,
    OTHER_VOTES,
    RUNNING,
    SAMPLE_ROOM,
    SAMPLES,
    SPOILED,
    STATE_OLD,
    STEPS,
    STIFF_VOTES,
    STOPPED,
    TIME,
    TIMES,
    UNMET,
    VECTORS,
    N,
)
from symbody.kernels.dense_output import interpolate
from symbody.kernels.events.event_monitor import (
    CHATTERS,
    ENDS,
    FAILS,
    GOES_ON,
    MISSES,
    NO_ROOM,
    NOTHING_YET,
    SPOILS,
    EventMonitor,
)
from symbody.kernels.events.event_watch import look
from symbody.kernels.events.zeros_in_order import steps_before
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import advance, begin


def shorten(n: int, rows: int, fit: Reals, piece: Reals, share: float) -> None:
    """Make the first `share` of a step's polynomial that of a step of its own."""
    inverse = part(fit, rows, rows * rows)
    states = part(fit, rows + rows * rows, rows * n)
    for k in range(rows):
        interpolate(n, rows, piece, share * fit[k], part(states, k * n, n))
    for row in range(1, rows):
        for i in range(n):
            total = 0.0
            for k in range(rows):
                total = total + inverse[row * rows + k] * states[k * n + i]
            piece[row * n + i] = total


def cut_back(
    B: Reals, monitor: EventMonitor, t: Reals, x: Reals, breaks: Reals, pieces: Reals, goes_on: int
) -> None:
    """Forget what lies beyond the cut; its state is a sample if every step is one, or if it is the end."""
    n = int(B[N])
    rows = int(B[METHOD + DENSE_ROWS])
    cut = monitor.cut
    end = steps_before(breaks, int(B[STEPS]), cut, B[DIRECTION])
    if end > 0 and breaks[end] != cut:
        share = (cut - breaks[end - 1]) / (breaks[end] - breaks[end - 1])
        shorten(n, rows, monitor.cut_fit, part(pieces, (end - 1) * rows * n, rows * n), share)
    breaks[end] = cut
    B[STEPS] = float(end)
    sample = int(B[SAMPLES])
    while sample > 0:
        if (t[sample - 1] - cut) * B[DIRECTION] < 0.0:
            break
        sample = sample - 1
    if B[EVERY_STEP] != 0.0 or goes_on == 0:
        t[sample] = cut
        copy(n, monitor.before, part(x, sample * n, n))
        sample = sample + 1
    B[SAMPLES] = float(sample)
    B[TIME] = cut
    copy(n, monitor.before, part(B, VECTORS + STATE_OLD * n, n))


def go_on(
    f: Function, B: Reals, monitor: EventMonitor, times: Reals, t: Reals, x: Reals, breaks: Reals
) -> int:
    """Begin anew from the state after a cut."""
    n = int(B[N])
    after = monitor.after
    copy(n, after, part(B, VECTORS + STATE_OLD * n, n))
    B[KERNEL] = 0.0
    B[AFTER_REJECTION] = 0.0
    B[STIFF_VOTES] = 0.0
    B[OTHER_VOTES] = 0.0
    B[FIRST_STEP] = 0.0  # steps begin with a short one, as at the start, but those of one length
    if B[METHOD + GROWTH] == 1.0:
        B[FIRST_STEP] = B[MAX_STEP]
    first = breaks[0]
    code = begin(f, B, times, t, x, breaks)
    breaks[0] = first  # it belongs to the first stretch
    sample = int(B[SAMPLES])
    if code == FINISHED and B[SAMPLES] < B[TIMES]:
        t[sample] = monitor.cut
        copy(n, after, part(x, sample * n, n))
        B[SAMPLES] = B[SAMPLES] + 1.0
    return code


def advance_watched(
    f: Function, g: Function, e: Function, a: Function, c: Function, B: Reals, monitor: EventMonitor,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps, and let events happen; return one of the codes of `block`.

    The last functions are those of `event_watch.look`; `FULL` and `NO_EVENT_ROOM` want more room.
    """
    code = monitor.resumed - 1
    monitor.resumed = 0
    for _trial in range(trials):
        if code < 0:
            code = FULL
            if B[EVERY_STEP] == 0.0 or B[SAMPLES] + 2.0 <= B[SAMPLE_ROOM]:
                code = advance(f, g, B, times, t, x, breaks, pieces, 1)
        is_over = 1
        if code == RUNNING or code == FULL:
            is_over = 0
        happened = look(e, a, c, monitor, breaks, pieces, H, int(B[STEPS]), is_over)
        if happened == NO_ROOM:
            monitor.resumed = code + 1
            return NO_EVENT_ROOM
        if happened == GOES_ON:
            cut_back(B, monitor, t, x, breaks, pieces, 1)
            code = go_on(f, B, monitor, times, t, x, breaks)
        elif happened != NOTHING_YET:
            return end_at_event(B, monitor, t, x, breaks, pieces, happened)
        if code != RUNNING:
            return code
        code = -1
    return RUNNING


def end_at_event(
    B: Reals, monitor: EventMonitor, t: Reals, x: Reals, breaks: Reals, pieces: Reals, happened: int
) -> int:
    """End a motion at an event, or at the fault of a function; return the code."""
    if happened == FAILS:
        return EVENT_FAULT
    cut_back(B, monitor, t, x, breaks, pieces, 0)
    if happened == CHATTERS:
        return CHATTERING
    if happened == SPOILS:
        return SPOILED
    if happened == MISSES:
        return UNMET
    return STOPPED


def break_off(
    e: Function, a: Function, c: Function, B: Reals, monitor: EventMonitor, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """End a motion that is interrupted at an event beyond which it was computed, if there is one."""
    happened = look(e, a, c, monitor, breaks, pieces, H, int(B[STEPS]), 1)
    if happened == GOES_ON or happened == ENDS or happened == CHATTERS:
        cut_back(B, monitor, t, x, breaks, pieces, 0)
    return happened
