"""Many motions of one mechanism along which joints stick and slip and ropes go taut, one after the other.

Rows of `cases` and `looks` are those of `watched_cases`. Behind what a row of `cases` holds there follow p
and c of the function that decides about modes and of the one that projects speeds, and what counts as large;
a row of `looks` ends with how many rows of the record of modes there were when its case ended.
"""

from __future__ import annotations

from symbody.kernels.block import (
    FINISHED,
    FULL,
    NO_EVENT_ROOM,
    NO_MODE_ROOM,
    NOT_ENDED,
    RUNNING,
    FunctionNumbers,
    Run,
    Verdict,
)
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.events.watched_cases import (
    LOOK_EVENTS,
    LOOK_SIZE,
    keep_samples,
    note_looks,
    prepare_watch,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.many_motions import conclude, prepare, set_numbers
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.switching_motion import advance_switching, begin_switching
from symbody.kernels.runge_kutta import copy
from symbody.kernels.samples.sample_hold import SampleHold


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


def run_switching_cases(
    f: Function, g: Function, e: Function, a: Function, c: Function, d: Function, w: Function, run: Run,
    monitor: EventMonitor, watch_size: int, fresh: Reals, held: SampleHold, Q: FunctionNumbers,
    modes: ModeSwitch, modes_size: int, fresh_modes: Reals, count: int, size: int, first: int, behind: int,
    cases: Reals, times: Reals, t: Reals, x: Reals, samples: Reals, verdicts: Reals, breaks: Reals,
    pieces: Reals, H: Reals, looks: Reals, Z: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return a code of `block`.

    As `run_watched_cases`; numbers of modes begin at `behind` in a row, `NO_MODE_ROOM` wants more room in Z.
    """
    left = trials
    look_size = LOOK_EVENTS + LOOK_SIZE * monitor.event_count + 1
    while run.cases.current < count:
        k = run.cases.current
        verdict = Verdict.view(verdicts, k * Verdict.size)
        if verdict.code == NOT_ENDED:
            code = RUNNING
            if run.cases.begun == 0.0:
                if modes.recorded + 4 > modes.room:
                    return NO_MODE_ROOM
                row = part(cases, k * size, size)
                prepare(run, row)
                prepare_watch(run, monitor, watch_size, fresh, part(row, first, 1))
                prepare_modes(modes, modes_size, fresh_modes, part(row, behind, 1))
                run.cases.begun = 1.0
                code = begin_switching(f, e, d, w, run, monitor, held, Q, modes, times, t, x, breaks, H, Z)
            before = run.counts.accepted + run.counts.rejected
            if code == RUNNING:
                code = advance_switching(
                    f, g, e, a, c, e, d, w, run, monitor, held, Q, modes, times, t, x, breaks, pieces, H, H,
                    Z, left,
                )  # fmt: skip
            left = left - int(run.counts.accepted + run.counts.rejected - before)
            if code == FULL or code == NO_EVENT_ROOM or code == NO_MODE_ROOM:
                return code
            conclude(run, code, verdict)
            keep_samples(run, verdict, x, samples)
            if code == RUNNING:
                return RUNNING
            look = part(looks, k * look_size, look_size)
            note_looks(monitor, look)
            look[look_size - 1] = float(modes.recorded)
        run.cases.current = k + 1
        run.cases.begun = 0.0
    return FINISHED
