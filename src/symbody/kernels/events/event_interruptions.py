"""Values of events where a smooth motion is interrupted: by a sample, a jump, or what a user changes."""

from __future__ import annotations

from symbody.kernels.block import Run
from symbody.kernels.events.event_location import add_zero, compute_values, sign
from symbody.kernels.events.event_monitor import MOST_RECENT, EventMonitor
from symbody.kernels.events.event_starts import ROUNDED_TIMES
from symbody.kernels.events.event_watch import start_stretch
from symbody.kernels.events.zeros_in_order import forget_events
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_bounds import EPSILON


def values_before(e: Function, run: Run, monitor: EventMonitor) -> None:
    """Note on which side of zero the values of events are just before an interruption; zero itself is none.

    Where a motion goes on, the sides are those on which it was interrupted.
    """
    compute_values(e, monitor, run.time, run.state_old)
    for k in range(monitor.event_count):
        side = sign(monitor.values[k])
        event = monitor.events[k]
        if side != 0.0 and (run.counts.steps != 0 or event.side == 0.0):
            event.side = side


def watch_behind(e: Function, run: Run, monitor: EventMonitor, width: float) -> None:
    """Watch the motion behind an interruption: values that jump through zero there have a zero there.

    Times that differ by at most `width` are one instant.
    """
    t = run.time
    start_stretch(monitor, run.counts.steps)
    compute_values(e, monitor, t, run.state_old)
    for k in range(monitor.event_count):
        event = monitor.events[k]
        if run.counts.steps != 0 or monitor.happened != 0:
            event.just_happened = has_just_happened(monitor, k, t, width)
        side = sign(monitor.values[k])
        if event.side * side > 0.0 and event.just_happened == 0.0:
            event.goes_through = side
        if event.side * side < 0.0 and event.just_happened == 0.0:
            add_zero(monitor, t, k, side)


def watch_again(e: Function, run: Run, monitor: EventMonitor) -> None:
    """Watch a motion that goes on anew, its state or its numbers changed."""
    watch_behind(e, run, monitor, ROUNDED_TIMES * EPSILON * abs(run.time))


def has_just_happened(monitor: EventMonitor, place: int, t: float, width: float) -> float:
    """Return 1 if an event has happened at a time, else 0."""
    count = int(monitor.events[place].recent_count)
    if count == 0:
        return 0.0
    if abs(monitor.recent[MOST_RECENT * place + count - 1] - t) <= width:
        return 1.0
    return 0.0


def end_with_state(run: Run, breaks: Reals, pieces: Reals) -> None:
    """Write a step of no length behind the last one: what happens at the end finds its state there."""
    n = run.states
    step = run.counts.steps
    size = run.method.dense_rows * n
    piece = part(pieces, step * size, size)
    copy(n, run.state_old, piece)
    for k in range(n, size):
        piece[k] = 0.0
    breaks[step + 1] = run.time


def forget_steps(run: Run, monitor: EventMonitor, breaks: Reals, pieces: Reals, last: int) -> None:
    """Forget all steps but the last ones, which make room for more.

    A zero is found among the last samples; a step has some.
    """
    gone = run.counts.steps - last
    size = monitor.piece_rows * run.states
    for k in range(last + 1):
        breaks[k] = breaks[gone + k]
    for k in range(last):
        copy(size, part(pieces, (gone + k) * size, size), part(pieces, k * size, size))
    run.counts.steps = last
    monitor.sampled = monitor.sampled - gone
    monitor.current = max(monitor.current - gone, 0)
    monitor.first_step = max(monitor.first_step - gone, 0)


def rewind_events(monitor: EventMonitor, H: Reals, t: float) -> None:
    """Forget what happened behind a time from which a motion goes on anew."""
    forget_events(monitor, H, t)
    for k in range(monitor.event_count):
        monitor.events[k].just_happened = 0.0
    monitor.culprit = 0
    monitor.fault = 0
    monitor.resumed = 0
    monitor.bad_place = 0
    monitor.unmet = 0.0
    monitor.unturned = 0.0
