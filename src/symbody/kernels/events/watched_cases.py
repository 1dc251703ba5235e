"""Many motions of one mechanism that are searched for events, one after the other.

`cases` and `verdicts` are those of `many_motions`; behind what a row holds there follow, from `first` on, p
and c of the functions of events and of actions, sizes of what is closed, p and c of the
function that closes it. `looks` holds a row for each case: what had happened when it
ended, all cases before it included, which event chattered, and of each event where its value was not a number
or had a pole.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    ACCEPTED,
    CASE,
    CASE_BEGUN,
    CODE,
    FINISHED,
    FIRST_STEP,
    FULL,
    NO_EVENT_ROOM,
    NOT_ENDED,
    REJECTED,
    RUNNING,
    SAMPLES,
    TIMES,
    VERDICT_COUNTS,
    VERDICT_SIZE,
    N,
)
from symbody.kernels.configurations.closing import closing_numbers, set_metric
from symbody.kernels.events.watch_block import (
    ACTIONS,
    CLOSING,
    CULPRIT,
    EVENT_SIZE,
    EVENTS,
    FIRST_LENGTH,
    HAPPENED,
    HAPPENED_ROOM,
    NO_NUMBER,
    NUMBERS,
    TABLE,
    UNTURNED,
)
from symbody.kernels.events.watched_motion import advance_watched
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.many_motions import conclude, prepare, set_numbers
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import begin

# A row of `looks`, then six numbers of each event: `NO_NUMBER` and those behind it.
LOOK_HAPPENED: Final = 0
LOOK_CULPRIT: Final = 1
LOOK_UNTURNED: Final = 2
LOOK_EVENTS: Final = 3
LOOK_SIZE: Final = 6


def prepare_watch(B: Reals, W: Reals, size: int, fresh: Reals, row: Reals) -> None:
    """Set a watch to the beginning of a case."""
    happened = W[HAPPENED]
    room = W[HAPPENED_ROOM]
    copy(size, fresh, W)
    W[HAPPENED] = happened
    W[HAPPENED_ROOM] = room
    B[FIRST_STEP] = W[FIRST_LENGTH]
    place = set_numbers(part(W, int(W[NUMBERS]), 1), row)
    if W[ACTIONS] != 0.0:
        place = place + set_numbers(part(W, int(W[ACTIONS]), 1), part(row, place, 1))
    if W[CLOSING] != 0.0:
        A = part(W, int(W[CLOSING]), 1)
        place = place + set_metric(A, part(row, place, 1))
        place = place + set_numbers(part(A, closing_numbers(A), 1), part(row, place, 1))


def note_looks(W: Reals, look: Reals) -> None:
    """Write down what the search has seen of a case."""
    look[LOOK_HAPPENED] = W[HAPPENED]
    look[LOOK_CULPRIT] = W[CULPRIT]
    look[LOOK_UNTURNED] = W[UNTURNED]
    for k in range(int(W[EVENTS])):
        row = part(W, int(W[TABLE]) + EVENT_SIZE * k + NO_NUMBER, LOOK_SIZE)
        copy(LOOK_SIZE, row, part(look, LOOK_EVENTS + LOOK_SIZE * k, LOOK_SIZE))


def run_watched_cases(
    f: Function, g: Function, e: Function, a: Function, c: Function, B: Reals, W: Reals, watch_size: int,
    fresh: Reals, count: int, size: int, first: int, cases: Reals, times: Reals, t: Reals, x: Reals,
    samples: Reals, verdicts: Reals, breaks: Reals, pieces: Reals, H: Reals, looks: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return a code of `block`.

    `FULL` and `NO_EVENT_ROOM` want more room for steps, or for what happens. `fresh` is a watch that has not
    begun; `t` and `x` are room for the samples of one case and two more, `samples` holds those of all.
    """
    n = int(B[N])
    times_of_case = int(B[TIMES])
    left = trials
    look_size = LOOK_EVENTS + LOOK_SIZE * int(W[EVENTS])
    while int(B[CASE]) < count:
        k = int(B[CASE])
        verdict = part(verdicts, k * VERDICT_SIZE, VERDICT_SIZE)
        if verdict[CODE] == NOT_ENDED:
            code = RUNNING
            if B[CASE_BEGUN] == 0.0:
                row = part(cases, k * size, size)
                prepare(B, row)
                prepare_watch(B, W, watch_size, fresh, part(row, first, 1))
                B[CASE_BEGUN] = 1.0
                code = begin(f, B, times, t, x, breaks)
            before = B[ACCEPTED] + B[REJECTED]
            if code == RUNNING:
                code = advance_watched(f, g, e, a, c, B, W, times, t, x, breaks, pieces, H, left)
            left = left - int(B[ACCEPTED] + B[REJECTED] - before)
            if code == FULL or code == NO_EVENT_ROOM:
                return code
            conclude(B, code, verdict)
            kept = min(int(B[SAMPLES]), times_of_case)  # a motion may stop behind all times that are wanted
            verdict[VERDICT_COUNTS + SAMPLES] = float(kept)
            copy(kept * n, x, part(samples, k * times_of_case * n, times_of_case * n))
            if code == RUNNING:
                return RUNNING
            note_looks(W, part(looks, k * look_size, look_size))
        B[CASE] = float(k + 1)
        B[CASE_BEGUN] = 0.0
    return FINISHED
