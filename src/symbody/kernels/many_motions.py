"""Many motions of one mechanism, one after the other.

`cases` holds a row for each: its first state, its tolerances, its breakpoints, p and c of the right-hand
side, p and c of what projects, scales and sizes as there. `verdicts` holds a row for each, `x` the
samples (cases, times, n); rows of samples that were not reached stay as they were.
"""

from __future__ import annotations

from symbody.kernels.block import (
    FINISHED,
    NOT_ENDED,
    RUNNING,
    Breakpoint,
    Counts,
    FunctionNumbers,
    Run,
    Verdict,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import advance, begin


def set_numbers(numbers: FunctionNumbers, row: Reals) -> int:
    """Set p and c of a function; return how many numbers these are."""
    p = numbers.parameter_count
    c = numbers.constant_count
    copy(p, row, numbers.parameters)
    copy(c, part(row, p, c), numbers.constants)
    return p + c


def set_case(run: Run, row: Reals) -> None:
    """Set the numbers of a case that are not part of its state."""
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


def clear(n: int, x: Reals) -> None:
    """Set an array to zeros."""
    for i in range(n):
        x[i] = 0.0


def prepare(run: Run, row: Reals) -> None:
    """Set a run to the beginning of a case."""
    n = run.states
    set_case(run, row)
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


def conclude(run: Run, code: int, verdict: Verdict) -> None:
    """Write down how far a case came, and how it ended unless it is still running."""
    copy(Counts.size, run.counts, verdict.counts)
    verdict.reached = run.time
    if code != RUNNING:
        verdict.code = code
        run.cases.ended = run.cases.ended + 1


def run_cases(
    f: Function, g: Function, run: Run, count: int, size: int, cases: Reals, times: Reals, t: Reals,
    x: Reals, verdicts: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return `RUNNING` or `FINISHED`.

    `size` is that of a row of `cases`; `t` (times,) is scratch.
    """
    n = run.states
    left = trials
    while run.cases.current < count:
        k = run.cases.current
        verdict = Verdict.view(verdicts, k * Verdict.size)
        if verdict.code == NOT_ENDED:
            samples = part(x, k * run.room.times * n, run.room.times * n)
            code = RUNNING
            if run.cases.begun == 0.0:
                prepare(run, part(cases, k * size, size))
                run.cases.begun = 1.0
                code = begin(f, run, times, t, samples, t)
            before = run.counts.accepted + run.counts.rejected
            if code == RUNNING:
                code = advance(f, g, run, times, t, samples, t, t, left)
            left = left - int(run.counts.accepted + run.counts.rejected - before)
            conclude(run, code, verdict)
            if code == RUNNING:
                return RUNNING
        run.cases.current = k + 1
        run.cases.begun = 0.0
    return FINISHED
