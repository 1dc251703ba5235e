"""Many motions of one mechanism that are searched for events, one after the other.

`cases` and `verdicts` are those of `many_motions`; behind what a row holds there follow, from `first` on, p
and c of the functions of events and of actions, sizes of what is closed, p and c of the
function that closes it. `looks` holds a row for each case: what had happened when it
ended, all cases before it included, which event chattered, and of each event where its value was not a number
or had a pole.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FINISHED, FULL, NO_EVENT_ROOM, NOT_ENDED, RUNNING, Run, Verdict
from symbody.kernels.configurations.closing import set_metric
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.events.watched_motion import advance_watched
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.many_motions import conclude, prepare, set_numbers
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import begin

# A row of `looks`, then six numbers of each event: whether and when its value was no number,
# had a pole, or why and since when it waits.
LOOK_HAPPENED: Final = 0
LOOK_CULPRIT: Final = 1
LOOK_UNTURNED: Final = 2
LOOK_EVENTS: Final = 3
LOOK_SIZE: Final = 6


def prepare_watch(run: Run, monitor: EventMonitor, size: int, fresh: Reals, row: Reals) -> None:
    """Set a watch to the beginning of a case."""
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


def note_looks(monitor: EventMonitor, look: Reals) -> None:
    """Write down what the search has seen of a case."""
    look[LOOK_HAPPENED] = monitor.happened
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


def keep_samples(run: Run, verdict: Verdict, x: Reals, samples: Reals) -> None:
    """Keep the samples of a case; a motion may stop behind all times that are wanted."""
    size = run.room.times * run.states
    kept = min(run.counts.samples, run.room.times)
    verdict.counts.samples = kept
    copy(kept * run.states, x, part(samples, run.cases.current * size, size))


def run_watched_cases(
    f: Function, g: Function, e: Function, a: Function, c: Function, run: Run, monitor: EventMonitor,
    watch_size: int, fresh: Reals, count: int, size: int, first: int, cases: Reals, times: Reals, t: Reals,
    x: Reals, samples: Reals, verdicts: Reals, breaks: Reals, pieces: Reals, H: Reals, looks: Reals,
    trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return a code of `block`.

    `FULL` and `NO_EVENT_ROOM` want more room for steps, or for what happens. `fresh` is a watch that has not
    begun; `t` and `x` are room for the samples of one case and two more, `samples` holds those of all.
    """
    left = trials
    look_size = LOOK_EVENTS + LOOK_SIZE * monitor.event_count
    while run.cases.current < count:
        k = run.cases.current
        verdict = Verdict.view(verdicts, k * Verdict.size)
        if verdict.code == NOT_ENDED:
            code = RUNNING
            if run.cases.begun == 0.0:
                row = part(cases, k * size, size)
                prepare(run, row)
                prepare_watch(run, monitor, watch_size, fresh, part(row, first, 1))
                run.cases.begun = 1.0
                code = begin(f, run, times, t, x, breaks)
            before = run.counts.accepted + run.counts.rejected
            if code == RUNNING:
                code = advance_watched(f, g, e, a, c, run, monitor, times, t, x, breaks, pieces, H, left)
            left = left - int(run.counts.accepted + run.counts.rejected - before)
            if code == FULL or code == NO_EVENT_ROOM:
                return code
            conclude(run, code, verdict)
            keep_samples(run, verdict, x, samples)
            if code == RUNNING:
                return RUNNING
            note_looks(monitor, part(looks, k * look_size, look_size))
        run.cases.current = k + 1
        run.cases.begun = 0.0
    return FINISHED
