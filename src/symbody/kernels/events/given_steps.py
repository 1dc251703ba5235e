"""Steps that an integrator outside the kernels has taken: their samples, and the events in them.

The polynomial of a step lies in `pieces`, behind those of the steps before it.
"""

from __future__ import annotations

from symbody.kernels.block import NO_EVENT_ROOM, RESTARTED, RUNNING, Run
from symbody.kernels.dense_output import interpolate
from symbody.kernels.events.event_interruptions import values_before
from symbody.kernels.events.event_monitor import GOES_ON, NO_ROOM, NOTHING_YET, EventMonitor
from symbody.kernels.events.event_watch import look
from symbody.kernels.events.watched_motion import cut_back, end_at_event, look_behind
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import begin_record, store_sample, store_samples


def begin_given(run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Store the first sample; return a code of `block`."""
    return begin_record(run, times, t, x, breaks)


def keep_given(
    g: Function, run: Run, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, end: float
) -> None:
    """Store a step that leads to a time, and go on to its end."""
    n = run.states
    rows = run.method.dense_rows
    steps = run.counts.steps
    piece = part(pieces, steps * rows * n, rows * n)
    run.t_new = end
    run.length = end - run.time
    interpolate(n, rows, piece, 1.0, run.state_new)
    breaks[steps + 1] = end
    run.counts.steps = steps + 1
    if run.room.every_step == 0.0:
        store_samples(g, run, piece, times, t, x)
    else:
        store_sample(run, end, run.state_new, t, x)
    run.counts.accepted = run.counts.accepted + 1
    run.time = end
    copy(n, run.state_new, run.state_old)


def process_given(
    e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals, is_over: int,
) -> int:  # fmt: skip
    """Let events happen in the steps so far; return one of the codes of `block`.

    The last functions are those of `event_watch.look`. The motion goes on from `state_old` after `RESTARTED`.
    """
    happened = NOTHING_YET
    if run.counts.steps != 0:
        happened = look(e, a, c, monitor, breaks, pieces, H, run.counts.steps, is_over)
    elif is_over != 0 and run.time == run.t_end:
        happened = look_behind(e, a, c, run, monitor, breaks, pieces, H)
    if happened == NOTHING_YET:
        return RUNNING
    if happened == NO_ROOM:
        return NO_EVENT_ROOM
    if happened != GOES_ON:
        return end_at_event(run, monitor, t, x, breaks, pieces, happened)
    cut_back(run, monitor, t, x, breaks, pieces, 1)
    copy(run.states, monitor.after, run.state_old)
    if run.time == run.t_end:
        values_before(e, run, monitor)
    return RESTARTED
