"""A motion with values that are held between samples, with events or without."""

from __future__ import annotations

from symbody.kernels.block import (
    CUT,
    FINISHED,
    FULL,
    NO_EVENT_ROOM,
    NO_SAMPLE_ROOM,
    RUNNING,
    SAMPLE_FAULT,
    FunctionNumbers,
    Run,
)
from symbody.kernels.events.event_interruptions import end_with_state, values_before, watch_behind
from symbody.kernels.events.event_monitor import GOES_ON, NO_ROOM, NOTHING_YET, EventMonitor
from symbody.kernels.events.event_watch import look
from symbody.kernels.events.watched_motion import cut_back, end_at_event, go_on, look_behind, watch_steps
from symbody.kernels.language import Function, Reals
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import evaluate
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.kernels.samples.sampling import ONE_INSTANT, is_due, piece_end, show_values, take_samples
from symbody.kernels.step_bounds import behind_jump
from symbody.kernels.step_machine import advance, begin


def begin_sampled(
    f: Function, h: Function, run: Run, held: SampleHold, Q: FunctionNumbers, times: Reals, t: Reals,
    x: Reals, breaks: Reals, Y: Reals,
) -> int:  # fmt: skip
    """Take the samples that are due where a motion begins, and begin it; return a code of `block`."""
    if is_due(held, run.time) != 0:
        if take_samples(h, Q, held, Y, run.time, run.state_old) != 0:
            return SAMPLE_FAULT
    show_values(held, run.numbers)
    return begin(f, run, times, t, x, breaks)


def sample(f: Function, h: Function, run: Run, held: SampleHold, Q: FunctionNumbers, Y: Reals) -> int:
    """Take the samples that are due, and go on with the derivative behind them; return a code of `block`."""
    if held.recorded == held.room:
        return NO_SAMPLE_ROOM
    t = run.time
    if take_samples(h, Q, held, Y, t, run.state_old) != 0:
        return SAMPLE_FAULT
    show_values(held, run.numbers)
    if t != run.t_end:
        run.time = behind_jump(run, t)
        evaluate(f, run, run.time, run.state_old, run.slopes)
    return RUNNING


def advance_to_sample(
    f: Function, g: Function, run: Run, held: SampleHold, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals,
) -> int:  # fmt: skip
    """Try one step, which ends at the next sample; return one of the codes of `block`."""
    end = run.t_end
    stop = piece_end(run, held, end)
    planned = run.step
    run.t_end = stop
    code = advance(f, g, run, times, t, x, breaks, pieces, 1)
    run.t_end = end
    if code == FINISHED and stop != end:
        code = RUNNING
    if run.time == stop and abs(run.length) < abs(planned) and abs(run.step) < abs(planned):
        run.step = planned  # a step that only the sample cut short says nothing of the next
    return code


def advance_sampled(
    f: Function, g: Function, h: Function, run: Run, held: SampleHold, Q: FunctionNumbers, times: Reals,
    t: Reals, x: Reals, breaks: Reals, pieces: Reals, Y: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps and take the samples on the way; return one of the codes of `block`.

    `NO_SAMPLE_ROOM` wants more room for the record of held values.
    """
    for _trial in range(trials):
        if is_due(held, run.time) != 0:
            code = sample(f, h, run, held, Q, Y)
            if code != RUNNING:
                return code
        code = advance_to_sample(f, g, run, held, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING


def show_watch(monitor: EventMonitor, held: SampleHold) -> None:
    """Write the held values among the inputs of the functions of events."""
    show_values(held, monitor.numbers)
    if exists(monitor.actions):
        show_values(held, monitor.actions)


def watch_sample(e: Function, run: Run, monitor: EventMonitor, held: SampleHold) -> None:
    """Watch the motion behind a sample."""
    show_watch(monitor, held)
    watch_behind(e, run, monitor, ONE_INSTANT * max(abs(run.time), abs(held.start)))


def sample_watched(
    f: Function, e: Function, a: Function, c: Function, h: Function, run: Run, monitor: EventMonitor,
    held: SampleHold, Q: FunctionNumbers, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
    H: Reals, Y: Reals,
) -> int:  # fmt: skip
    """Let all happen that comes before the samples that are due, and take these; return a code of `block`."""
    if run.time == run.t_end and run.counts.steps == run.room.steps:
        return FULL
    if run.counts.steps == 0:
        happened = look_behind(e, a, c, run, monitor, breaks, pieces, H)
    else:
        happened = look(e, a, c, monitor, breaks, pieces, H, run.counts.steps, 1)
    if happened == NO_ROOM:
        return NO_EVENT_ROOM
    if happened == GOES_ON:
        cut_back(run, monitor, t, x, breaks, pieces, 1)
        return CUT
    if happened != NOTHING_YET:
        return end_at_event(run, monitor, t, x, breaks, pieces, happened)
    values_before(e, run, monitor)
    code = sample(f, h, run, held, Q, Y)
    if code == RUNNING:
        if run.time == run.t_end:
            end_with_state(run, breaks, pieces)
        watch_sample(e, run, monitor, held)
    return code


def advance_unless_resumed(
    f: Function, g: Function, run: Run, monitor: EventMonitor, held: SampleHold, times: Reals, t: Reals,
    x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step, unless the search in the last one goes on; return a code of `block`."""
    if monitor.resumed != 0:
        return monitor.resumed - 1
    if run.room.every_step == 0.0 or run.counts.samples + 2 <= run.room.samples:
        return advance_to_sample(f, g, run, held, times, t, x, breaks, pieces)
    return FULL


def watch_unless_due(
    e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor, held: SampleHold, code: int,
    t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """Let events happen in a step that ended with a code, unless samples are due; return a code."""
    if code == RUNNING and is_due(held, run.time) != 0:
        return code
    return watch_steps(e, a, c, run, monitor, t, x, breaks, pieces, H, code)


def step_watched(
    f: Function, g: Function, e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor,
    held: SampleHold, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """Try one step, and let events happen unless samples are due at its end; return a code of `block`."""
    code = advance_unless_resumed(f, g, run, monitor, held, times, t, x, breaks, pieces)
    monitor.resumed = 0
    return watch_unless_due(e, a, c, run, monitor, held, code, t, x, breaks, pieces, H)


def happen_or_step(
    f: Function, g: Function, e: Function, a: Function, c: Function, h: Function, run: Run,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, times: Reals, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals, Y: Reals,
) -> int:  # fmt: skip
    """Take samples that are due, or try one step; return a code of `block`, `CUT` where an event acted."""
    if is_due(held, run.time) != 0:
        return sample_watched(f, e, a, c, h, run, monitor, held, Q, times, t, x, breaks, pieces, H, Y)
    return step_watched(f, g, e, a, c, run, monitor, held, times, t, x, breaks, pieces, H)


def advance_sampled_watched(
    f: Function, g: Function, e: Function, a: Function, c: Function, h: Function, run: Run,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, times: Reals, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, H: Reals, Y: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps, take samples and let events happen; return one of the codes of `block`."""
    for _trial in range(trials):
        code = happen_or_step(f, g, e, a, c, h, run, monitor, held, Q, times, t, x, breaks, pieces, H, Y)
        if code == CUT:
            code = go_on(f, e, run, monitor, times, t, x, breaks)
            if code == FINISHED and is_due(held, run.time) != 0:
                code = RUNNING
        if code != RUNNING:
            return code
    return RUNNING
