"""Many motions of one mechanism, one after the other, with all that happens along them.

`cases` holds a row for each: its first state, its tolerances, its breakpoints, p and c of the right-hand
side; then, of what there is, the numbers of what projects: p, c, scales and sizes; of the search for events:
p and c of the functions of values and of actions, sizes of what is closed, p and c of the function that
closes it; of the modes: p and c of the functions that decide and that project, and what counts as large.

`verdicts` holds a row for each, `samples` the samples (cases, times, n); rows of samples that were not
reached stay as they were. `looks` holds a row for each that is searched for events: what had happened when it
ended, all cases before it included, and how many rows the record of modes had; which event chattered; and of
each event where its value was not a number or had a pole.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    FINISHED,
    FULL,
    NO_EVENT_ROOM,
    NO_MODE_ROOM,
    NOT_ENDED,
    RUNNING,
    Breakpoint,
    Counts,
    FunctionNumbers,
    Run,
    Verdict,
)
from symbody.kernels.configurations.closing import set_metric
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.features import EVENTS, MODES
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.motion_loop import MOST_ROWS, advance_motion, begin_motion
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy
from symbody.kernels.samples.sample_hold import SampleHold

# A row of `looks`, then six numbers of each event: whether and when its value was no number,
# had a pole, or why and since when it waits.
LOOK_HAPPENED: Final = 0
LOOK_MODES: Final = 1
LOOK_CULPRIT: Final = 2
LOOK_UNTURNED: Final = 3
LOOK_EVENTS: Final = 4
LOOK_SIZE: Final = 6


def set_numbers(numbers: FunctionNumbers, row: Reals) -> int:
    """Set p and c of a function; return how many numbers these are."""
    p = numbers.parameter_count
    c = numbers.constant_count
    copy(p, row, numbers.parameters)
    copy(c, part(row, p, c), numbers.constants)
    return p + c


def set_case(run: Run, row: Reals) -> int:
    """Set the numbers of a case that are not part of its state; return where those of events begin."""
    n = run.states
    copy(n, part(row, n, n), run.tolerances)
    place = 2 * n
    breaks = Breakpoint.size * run.breaks.count
    copy(breaks, part(row, place, breaks), run.breaks.points[0])
    place = place + breaks
    place = place + set_numbers(run.numbers, part(row, place, 1))
    if exists(run.projection):
        projection = run.projection
        place = place + set_numbers(projection.numbers, part(row, place, 1))
        copy(projection.residuals, part(row, place, projection.residuals), projection.scales)
        place = place + projection.residuals
        copy(projection.coordinates, part(row, place, projection.coordinates), projection.sizes)
        place = place + projection.coordinates
    return place


def clear(n: int, x: Reals) -> None:
    """Set an array to zeros."""
    for i in range(n):
        x[i] = 0.0


def prepare(run: Run, row: Reals) -> int:
    """Set a run to the beginning of a case; return where the numbers of events begin in its row."""
    n = run.states
    place = set_case(run, row)
    copy(n, row, run.state_old)
    # What a case before left there would decide whose fault a failure is.
    clear(run.method.stage_rows * n, run.slopes)
    clear(run.method.dense_rows * n, run.dense)
    clear(Counts.size, run.counts)
    run.time = run.cases.start
    run.step = 0.0
    run.error = 0.0
    run.after_rejection = 0.0
    run.stiff_votes = 0
    run.other_votes = 0
    run.unjudged = 0
    run.breaks.next = 0
    return place


def prepare_watch(run: Run, monitor: EventMonitor, size: int, fresh: Reals, row: Reals) -> int:
    """Set a watch to the beginning of a case; return how many numbers of the row it has taken."""
    happened = monitor.happened
    room = monitor.happened_room
    copy(size, fresh, monitor)
    monitor.happened = happened
    monitor.happened_room = room
    run.first_step = monitor.first_length
    place = set_numbers(monitor.numbers, row)
    if exists(monitor.actions):
        place = place + set_numbers(monitor.actions, part(row, place, 1))
    if exists(monitor.closing):
        place = place + set_metric(monitor.closing, part(row, place, 1))
        place = place + set_numbers(monitor.closing.numbers, part(row, place, 1))
    return place


def prepare_modes(modes: ModeSwitch, size: int, fresh: Reals, row: Reals) -> None:
    """Set modes to the beginning of a case."""
    recorded = modes.recorded
    room = modes.room
    copy(size, fresh, modes)
    modes.recorded = recorded
    modes.room = room
    place = set_numbers(modes.numbers, row)
    place = place + set_numbers(modes.projection, part(row, place, 1))
    modes.length = row[place]
    modes.time = row[place + 1]
    modes.fastest = 1.0 / modes.time
    for k in range(modes.candidates):
        if modes.are_lengths[k] != 0.0:
            modes.units[k] = modes.length
    for k in range(modes.count):
        element = modes.elements[k]
        element.unit = modes.units[element.candidate]
    copy(modes.speeds, part(row, place + 2, modes.speeds), modes.sizes)


def conclude(run: Run, code: int, verdict: Verdict) -> None:
    """Write down how far a case came, and how it ended unless it is still running."""
    copy(Counts.size, run.counts, verdict.counts)
    verdict.reached = run.time
    if code != RUNNING:
        verdict.code = code
        run.cases.ended = run.cases.ended + 1


def keep_samples(run: Run, verdict: Verdict, x: Reals, samples: Reals) -> None:
    """Keep the samples of a case; a motion may stop behind all times that are wanted."""
    size = run.room.times * run.states
    kept = min(run.counts.samples, run.room.times)
    verdict.counts.samples = kept
    copy(kept * run.states, x, part(samples, run.cases.current * size, size))


def note_looks(monitor: EventMonitor, modes: ModeSwitch, look: Reals) -> None:
    """Write down what the search has seen of a case."""
    if EVENTS != 0:
        look[LOOK_HAPPENED] = monitor.happened
        if MODES != 0:
            look[LOOK_MODES] = modes.recorded
        look[LOOK_CULPRIT] = monitor.culprit
        look[LOOK_UNTURNED] = monitor.unturned
        for k in range(monitor.event_count):
            event = monitor.events[k]
            seen = part(look, LOOK_EVENTS + LOOK_SIZE * k, LOOK_SIZE)
            seen[0] = event.no_number
            seen[1] = event.no_number_time
            seen[2] = event.pole
            seen[3] = event.pole_time
            seen[4] = event.waits
            seen[5] = event.waits_time


def begin_case(
    f: Function, e: Function, d: Function, w: Function, run: Run, monitor: EventMonitor, watch_size: int,
    fresh: Reals, modes: ModeSwitch, modes_size: int, fresh_modes: Reals, row: Reals, times: Reals, t: Reals,
    x: Reals, breaks: Reals, H: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Set everything to the beginning of a case, and begin it; return a code of `block`."""
    place = prepare(run, row)
    if EVENTS != 0:
        place = place + prepare_watch(run, monitor, watch_size, fresh, part(row, place, 1))
    run.cases.begun = 1.0
    if MODES != 0:
        prepare_modes(modes, modes_size, fresh_modes, part(row, place, 1))
    return begin_motion(
        f, e, d, w, run, ImplicitStep.view(H, 0), monitor, SampleHold.view(H, 0), FunctionNumbers.view(H, 0),
        modes, times, t, x, breaks, H, Z,
    )  # fmt: skip


def run_cases(
    f: Function, g: Function, e: Function, a: Function, c: Function, d: Function, w: Function, run: Run,
    monitor: EventMonitor, watch_size: int, fresh: Reals, modes: ModeSwitch, modes_size: int,
    fresh_modes: Reals, count: int, size: int, cases: Reals, times: Reals, t: Reals, x: Reals, samples: Reals,
    verdicts: Reals, breaks: Reals, pieces: Reals, H: Reals, looks: Reals, Z: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return a code of `block`.

    `FULL`, `NO_EVENT_ROOM` and `NO_MODE_ROOM` want more room for steps, for what happens, in Z; `size` is
    that of a row of `cases`. `fresh` and
    `fresh_modes` are those of motions that have not begun. `t` and `x` are room for the samples of one case
    and two more, `samples` holds those of all.
    """
    left = trials
    look_size = LOOK_EVENTS + LOOK_SIZE * monitor.event_count
    while run.cases.current < count:
        k = run.cases.current
        verdict = Verdict.view(verdicts, k * Verdict.size)
        if verdict.code == NOT_ENDED:
            code = RUNNING
            if run.cases.begun == 0.0:
                if MODES != 0:
                    if modes.recorded + MOST_ROWS > modes.room:
                        return NO_MODE_ROOM
                code = begin_case(
                    f, e, d, w, run, monitor, watch_size, fresh, modes, modes_size, fresh_modes,
                    part(cases, k * size, size), times, t, x, breaks, H, Z,
                )  # fmt: skip
            before = run.counts.accepted + run.counts.rejected
            if code == RUNNING:
                code = advance_motion(
                    f, f, f, g, e, a, c, e, e, d, w, run, ImplicitStep.view(H, 0), monitor,
                    SampleHold.view(H, 0), FunctionNumbers.view(H, 0), RateJumps.view(H, 0), modes, times, t,
                    x, breaks, pieces, H, H, Z, left,
                )  # fmt: skip
            left = left - int(run.counts.accepted + run.counts.rejected - before)
            if code == FULL or code == NO_EVENT_ROOM or code == NO_MODE_ROOM:
                return code
            conclude(run, code, verdict)
            keep_samples(run, verdict, x, samples)
            if code == RUNNING:
                return RUNNING
            note_looks(monitor, modes, part(looks, k * look_size, look_size))
        run.cases.current = k + 1
        run.cases.begun = 0.0
    return FINISHED
