"""The loop of a motion: steps, and all that happens on the way, in the order of `docs/instants.md`.

It is one text, made for what a motion has; see `features`. The functions are f, slopes of all states; k and
j, rates of coordinates and derivatives of the slopes, of implicit methods; g, which closes the constraints;
e, a and c, those of `event_watch.look`; h, new values at samples; s, that of `strike`; d and w, those of
`mode_switch`. H, Y and Z are what happened, what was sampled, and the record of modes.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    CUT,
    FINISHED,
    FULL,
    NO_EVENT_ROOM,
    NO_MODE_ROOM,
    NO_SAMPLE_ROOM,
    RUNNING,
    SAMPLE_FAULT,
    FunctionNumbers,
    Run,
)
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.configurations.struck_motion import store_behind, strike_state, watch_struck
from symbody.kernels.events.event_interruptions import (
    end_with_state,
    values_before,
    watch_again,
    watch_behind,
)
from symbody.kernels.events.event_monitor import GOES_ON, NO_ROOM, NOTHING_YET, EventMonitor
from symbody.kernels.events.event_watch import look
from symbody.kernels.events.watched_motion import cut_back, end_at_event, look_behind, watch_steps
from symbody.kernels.features import EVENTS, IMPLICIT, JUMPS, MODES, SAMPLES
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.implicit_machine import advance_implicit, set_out
from symbody.kernels.implicit.new_starts import begin_anew, go_on
from symbody.kernels.language import Function, Reals
from symbody.kernels.modes.mode_state import SETTLED, forget_modes, note_rates
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.switch_modes import settle_modes
from symbody.kernels.modes.switching_motion import (
    forget_ends,
    run_code,
    show_all_modes,
    switch_at_cut,
    switch_at_sample,
    watch_shares,
)
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import evaluate
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.kernels.samples.sampling import ONE_INSTANT, is_due, piece_end, show_values, take_samples
from symbody.kernels.step_bounds import behind_jump
from symbody.kernels.step_machine import advance, begin

MOST_ROWS: Final = 4  # of the record of modes that one step may take


def show_held(held: SampleHold, run: Run, implicit: ImplicitStep) -> None:
    """Write the held values among the inputs of the functions of the motion."""
    show_values(held, run.numbers)
    if IMPLICIT != 0:
        show_values(held, implicit.rate_numbers)
        show_values(held, implicit.derivative_numbers)


def show_watch(monitor: EventMonitor, held: SampleHold) -> None:
    """Write the held values among the inputs of the functions of events."""
    show_values(held, monitor.numbers)
    if exists(monitor.actions):
        show_values(held, monitor.actions)


def begin_motion(
    f: Function, h: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, modes: ModeSwitch, times: Reals, t: Reals,
    x: Reals, breaks: Reals, Y: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Take the samples that are due where a motion begins, decide its modes, and begin it; return a code."""
    if SAMPLES != 0:
        if is_due(held, run.time) != 0:
            if take_samples(h, Q, held, Y, run.time, run.state_old) != 0:
                return SAMPLE_FAULT
        show_held(held, run, implicit)
        if EVENTS != 0:
            show_watch(monitor, held)
    if MODES != 0:
        if SAMPLES != 0:
            show_values(held, modes.numbers)
        decided = settle_modes(d, w, modes, Z, run.time, run.state_old)
        if decided != SETTLED:
            return run_code(decided)
        show_all_modes(modes, run, implicit, monitor, Q)
    code = begin(f, run, times, t, x, breaks)
    if IMPLICIT != 0:
        if code == RUNNING:
            set_out(f, run, implicit)
    return code


def watch_anew(e: Function, run: Run, monitor: EventMonitor, held: SampleHold, modes: ModeSwitch) -> None:
    """Watch a motion that goes on anew, its state or its numbers changed."""
    if SAMPLES != 0:
        show_watch(monitor, held)
    watch_again(e, run, monitor)
    if MODES != 0:
        forget_ends(modes, monitor)


def sample(
    f: Function, h: Function, run: Run, implicit: ImplicitStep, held: SampleHold, Q: FunctionNumbers, Y: Reals
) -> int:
    """Take the samples that are due, and go on with the derivative behind them; return a code of `block`."""
    if held.recorded == held.room:
        return NO_SAMPLE_ROOM
    t = run.time
    if take_samples(h, Q, held, Y, t, run.state_old) != 0:
        return SAMPLE_FAULT
    show_held(held, run, implicit)
    if t != run.t_end:
        run.time = behind_jump(run, t)
        evaluate(f, run, run.time, run.state_old, run.slopes)
        if IMPLICIT != 0:
            set_out(f, run, implicit)
    return RUNNING


def sample_watched(
    f: Function, e: Function, a: Function, c: Function, h: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals, H: Reals, Y: Reals,
) -> int:  # fmt: skip
    """Let all happen that comes before the samples that are due, and take these; return a code of `block`."""
    if run.time == run.t_end and run.counts.steps == run.room.steps:
        return FULL
    happened = NOTHING_YET
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
    code = sample(f, h, run, implicit, held, Q, Y)
    if code == RUNNING:
        if run.time == run.t_end:
            end_with_state(run, breaks, pieces)
        show_watch(monitor, held)
        watch_behind(e, run, monitor, ONE_INSTANT * max(abs(run.time), abs(held.start)))
    return code


def step_by_method(
    f: Function, k: Function, j: Function, g: Function, run: Run, implicit: ImplicitStep, times: Reals,
    t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step; return one of the codes of `block`."""
    if IMPLICIT != 0:
        return advance_implicit(f, k, j, g, f, run, implicit, times, t, x, breaks, pieces, 1)
    return advance(f, g, f, run, times, t, x, breaks, pieces, 1)


def step_to_sample(
    f: Function, k: Function, j: Function, g: Function, run: Run, implicit: ImplicitStep, held: SampleHold,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step, which ends at the next sample; return one of the codes of `block`."""
    end = run.t_end
    stop = end
    if SAMPLES != 0:
        stop = piece_end(run, held, end)
    planned = run.step
    run.t_end = stop
    code = step_by_method(f, k, j, g, run, implicit, times, t, x, breaks, pieces)
    run.t_end = end
    if code == FINISHED and stop != end:
        code = RUNNING
    if run.time == stop and abs(run.length) < abs(planned) and abs(run.step) < abs(planned):
        run.step = planned  # a step that only the sample cut short says nothing of the next
    return code


def step_unless_resumed(
    f: Function, k: Function, j: Function, g: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step, unless the search for events in the last one goes on; return a code of `block`."""
    if EVENTS != 0:
        if monitor.resumed != 0:
            return monitor.resumed - 1
        if run.room.every_step != 0.0 and run.counts.samples + 2 > run.room.samples:
            return FULL
    if SAMPLES != 0 or MODES != 0:
        return step_to_sample(f, k, j, g, run, implicit, held, times, t, x, breaks, pieces)
    return step_by_method(f, k, j, g, run, implicit, times, t, x, breaks, pieces)


def look_at_step(
    e: Function, a: Function, c: Function, d: Function, run: Run, monitor: EventMonitor, held: SampleHold,
    modes: ModeSwitch, code: int, t: Reals, x: Reals, breaks: Reals, pieces: Reals, H: Reals,
) -> int:  # fmt: skip
    """Let events happen in a step that ended with a code, unless samples are due; return a code."""
    if MODES != 0:
        if monitor.resumed == 0 and monitor.hands_over == 0.0:
            watch_shares(d, run, monitor, modes, breaks, pieces)
    monitor.resumed = 0
    if SAMPLES != 0:
        if code == RUNNING and is_due(held, run.time) != 0:
            return code
    return watch_steps(e, a, c, run, monitor, t, x, breaks, pieces, H, code)


def go_on_from_cut(
    f: Function, e: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, modes: ModeSwitch, times: Reals, t: Reals,
    x: Reals, breaks: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Go on behind a cut; return a code of `block`."""
    if MODES != 0 and monitor.bound == 0.0:
        if SAMPLES != 0:
            show_values(held, modes.numbers)
        return switch_at_cut(f, e, d, w, run, implicit, monitor, Q, modes, times, t, x, breaks, Z)
    return go_on(f, e, run, implicit, monitor, times, t, x, breaks)


def decide_anew(
    d: Function, w: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor, held: SampleHold,
    Q: FunctionNumbers, modes: ModeSwitch, Z: Reals,
) -> int:  # fmt: skip
    """Decide the modes at a state that was changed, and show them to all functions; return a code."""
    if SAMPLES != 0:
        show_values(held, modes.numbers)
    forget_modes(modes)
    code = settle_modes(d, w, modes, Z, run.time, run.state_old)
    if code == SETTLED:
        show_all_modes(modes, run, implicit, monitor, Q)
    return run_code(code)


def go_on_behind(
    f: Function, e: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor, jumps: RateJumps,
    modes: ModeSwitch, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Begin anew behind a jump of prescribed rates; return a code of `block`."""
    store_behind(run, jumps, times, t, x)
    code = begin_anew(f, run, implicit, times, t, x, breaks)
    if EVENTS != 0:
        if code == RUNNING or code == FINISHED:
            watch_struck(e, run, monitor, jumps, breaks, pieces)
            if MODES != 0:
                forget_ends(modes, monitor)
    if EVENTS != 0 or SAMPLES != 0:
        if code == FINISHED:
            return RUNNING  # more may be due there
    return code


def pass_jump_of_rates(
    f: Function, s: Function, e: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, jumps: RateJumps, modes: ModeSwitch,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Go on behind the jump of prescribed rates to which a motion has come; return a code of `block`.

    Samples at the time of a jump are of the state behind it.
    """
    if run.room.every_step != 0.0 and run.counts.samples == run.room.samples:
        return FULL  # the state behind is a sample
    if EVENTS != 0:
        if run.counts.steps == run.room.steps:
            return FULL  # behind the steps there has to be room for one more
        values_before(e, run, monitor)
    if SAMPLES != 0:
        show_values(held, jumps.problem.numbers)
    code = strike_state(s, run, jumps, times, t, x, breaks)
    if code != RUNNING:
        return code
    if MODES != 0 and monitor.hands_over == 0.0:
        code = decide_anew(d, w, run, implicit, monitor, held, Q, modes, Z)
        if code != RUNNING:
            return code
    return go_on_behind(f, e, run, implicit, monitor, jumps, modes, times, t, x, breaks, pieces)


def sample_or_step(
    f: Function, k: Function, j: Function, g: Function, e: Function, a: Function, c: Function, h: Function,
    d: Function, w: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor, held: SampleHold,
    Q: FunctionNumbers, modes: ModeSwitch, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
    H: Reals, Y: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Take the samples that are due, else try one step; return a code, `CUT` where an event acted."""
    code = RUNNING
    if SAMPLES != 0 and is_due(held, run.time) != 0:
        if EVENTS != 0:
            code = sample_watched(f, e, a, c, h, run, implicit, monitor, held, Q, t, x, breaks, pieces, H, Y)
        else:
            code = sample(f, h, run, implicit, held, Q, Y)
        if MODES != 0:
            note_rates(modes, run.state_old)
            if code == RUNNING:
                show_values(held, modes.numbers)
                return switch_at_sample(
                    f, e, d, w, run, implicit, monitor, Q, modes, times, t, x, breaks, Z
                )  # fmt: skip
        return code
    code = step_unless_resumed(f, k, j, g, run, implicit, monitor, held, times, t, x, breaks, pieces)
    if EVENTS != 0:
        code = look_at_step(e, a, c, d, run, monitor, held, modes, code, t, x, breaks, pieces, H)
    if MODES != 0:
        note_rates(modes, run.state_old)
    return code


def go_on_from_end(
    f: Function, s: Function, e: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, held: SampleHold, Q: FunctionNumbers, jumps: RateJumps, modes: ModeSwitch,
    times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals, Z: Reals, code: int,
) -> int:  # fmt: skip
    """Go on behind a cut or a jump of rates at which steps have ended with a code; return one."""
    ending = code
    if EVENTS != 0 and code == CUT:
        ending = go_on_from_cut(f, e, d, w, run, implicit, monitor, held, Q, modes, times, t, x, breaks, Z)
        if SAMPLES != 0 and ending == FINISHED:
            if is_due(held, run.time) != 0:
                return RUNNING
    if JUMPS != 0 and ending == FINISHED:
        if jumps.next < jumps.count:
            return pass_jump_of_rates(
                f, s, e, d, w, run, implicit, monitor, held, Q, jumps, modes, times, t, x, breaks, pieces, Z
            )  # fmt: skip
    return ending


def advance_motion(
    f: Function, k: Function, j: Function, g: Function, e: Function, a: Function, c: Function, h: Function,
    s: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor,
    held: SampleHold, Q: FunctionNumbers, jumps: RateJumps, modes: ModeSwitch, times: Reals, t: Reals,
    x: Reals, breaks: Reals, pieces: Reals, H: Reals, Y: Reals, Z: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps, and let all happen on the way; return one of the codes of `block`.

    `FULL`, `NO_EVENT_ROOM`, `NO_SAMPLE_ROOM` and `NO_MODE_ROOM` want more room.
    """
    for _trial in range(trials):
        if MODES != 0:
            if modes.recorded + MOST_ROWS > modes.room:
                return NO_MODE_ROOM
        code = sample_or_step(
            f, k, j, g, e, a, c, h, d, w, run, implicit, monitor, held, Q, modes, times, t, x, breaks, pieces,
            H, Y, Z,
        )  # fmt: skip
        if EVENTS != 0 or JUMPS != 0:
            code = go_on_from_end(
                f, s, e, d, w, run, implicit, monitor, held, Q, jumps, modes, times, t, x, breaks, pieces, Z,
                code,
            )  # fmt: skip
        if code != RUNNING:
            return code
    return RUNNING
