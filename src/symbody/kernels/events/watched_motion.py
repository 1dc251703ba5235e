"""A motion that is searched for events step by step: cut where one acts, it goes on from there."""

from __future__ import annotations

from symbody.kernels.block import (
    CHART_ENDS,
    CHATTERING,
    CUT,
    EVENT_FAULT,
    FINISHED,
    FULL,
    NO_EVENT_ROOM,
    RUNNING,
    SPOILED,
    STOPPED,
    UNMET,
    Run,
)
from symbody.kernels.dense_output import interpolate
from symbody.kernels.events.event_interruptions import end_with_state, watch_again
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
from symbody.kernels.events.zeros_in_order import SIMULTANEOUS, steps_before
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy


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
    run: Run, monitor: EventMonitor, t: Reals, x: Reals, breaks: Reals, pieces: Reals, goes_on: int
) -> None:
    """Forget what lies beyond the cut; its state is a sample if every step is one, or if it is the end.

    A step that is taken again begins with a sample.
    """
    n = run.states
    rows = run.method.dense_rows
    cut = monitor.cut
    way = run.goal.direction
    end = steps_before(breaks, run.counts.steps, cut, way)
    first = cut
    if (breaks[end] - cut) * way < 0.0:
        first = breaks[end]  # just behind a jump, where steps meet
    else:
        if end > 0 and breaks[end] != cut:
            share = (cut - breaks[end - 1]) / (breaks[end] - breaks[end - 1])
            shorten(n, rows, monitor.cut_fit, part(pieces, (end - 1) * rows * n, rows * n), share)
        breaks[end] = cut
        if end > 0 and run.room.every_step == 0.0:
            if abs(cut - breaks[end - 1]) <= SIMULTANEOUS * max(monitor.span, abs(cut)):
                first = breaks[end - 1]  # both are one instant
    run.counts.steps = end
    sample = run.counts.samples
    while sample > 0:
        if (t[sample - 1] - first) * way < 0.0:
            break
        sample = sample - 1
    if (run.room.every_step != 0.0 and monitor.bound == 0.0) or goes_on == 0:
        t[sample] = cut
        copy(n, monitor.before, part(x, sample * n, n))
        sample = sample + 1
    run.counts.samples = sample
    run.time = cut
    copy(n, monitor.before, run.state_old)


def look_behind(
    e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor, breaks: Reals, pieces: Reals,
    H: Reals,
) -> int:  # fmt: skip
    """Let events happen first whose values have jumped through zero where a motion goes on."""
    watch_again(e, run, monitor)
    end_with_state(run, breaks, pieces)
    return look(e, a, c, monitor, breaks, pieces, H, run.counts.steps, 1)


def watch_steps(
    e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals, code: int,
) -> int:  # fmt: skip
    """Let events happen in the steps so far, the last of which ended with a code; return one.

    It is `CUT` where the motion goes on from the state `after`.
    """
    is_over = 1
    if code == RUNNING or code == FULL or code == CHART_ENDS:
        is_over = 0
    happened = NOTHING_YET
    if run.counts.steps != 0:
        happened = look(e, a, c, monitor, breaks, pieces, H, run.counts.steps, is_over)
    elif code == FINISHED:
        happened = look_behind(e, a, c, run, monitor, breaks, pieces, H)
    if happened == NO_ROOM:
        monitor.resumed = code + 1
        return NO_EVENT_ROOM
    if happened == GOES_ON:
        cut_back(run, monitor, t, x, breaks, pieces, 1)
        return CUT
    if happened != NOTHING_YET:
        return end_at_event(run, monitor, t, x, breaks, pieces, happened)
    return code


def end_at_event(
    run: Run, monitor: EventMonitor, t: Reals, x: Reals, breaks: Reals, pieces: Reals, happened: int
) -> int:
    """End a motion at an event, or at the fault of a function; return the code."""
    if happened == FAILS:
        return EVENT_FAULT
    cut_back(run, monitor, t, x, breaks, pieces, 0)
    if happened == CHATTERS:
        return CHATTERING
    if happened == SPOILS:
        return SPOILED
    if happened == MISSES:
        return UNMET
    return STOPPED


def break_off(
    e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """End a motion that is interrupted at an event beyond which it was computed, if there is one."""
    happened = look(e, a, c, monitor, breaks, pieces, H, run.counts.steps, 1)
    if happened == GOES_ON or happened == ENDS or happened == CHATTERS:
        cut_back(run, monitor, t, x, breaks, pieces, 0)
    return happened
