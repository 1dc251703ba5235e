"""Many motions of one mechanism, one after the other.

`cases` holds a row for each: its first state, its tolerances, its breakpoints, p and c of the right-hand
side, p and c of what projects, scales and sizes as there. `verdicts` holds a row for each, `x` the
samples (cases, times, n); rows of samples that were not reached stay as they were.
"""

from __future__ import annotations

from symbody.kernels.block import (
    ACCEPTED,
    BREAKS,
    CASE,
    CASE_BEGUN,
    CASES_ENDED,
    CODE,
    COUNTS,
    ERROR,
    FINISHED,
    FIRST_BREAK,
    FUNCTION,
    NEXT_BREAK,
    NOT_ENDED,
    P_COORDINATES,
    P_FUNCTION,
    P_PLACE,
    P_RESIDUALS,
    P_SCALES,
    PROJECTOR,
    REACHED,
    REJECTED,
    RUNNING,
    STATE_OLD,
    STEP,
    T_START,
    TIME,
    TIMES,
    TOLERANCES,
    VECTOR_ROWS,
    VECTORS,
    VERDICT_COUNTS,
    VERDICT_SIZE,
    WORK_PLACE,
    N,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import advance, begin


def set_numbers(numbers: Reals, row: Reals) -> int:
    """Set p and c of a function; return how many numbers these are."""
    first = int(numbers[P_PLACE])
    size = int(numbers[WORK_PLACE]) - first
    copy(size, row, part(numbers, first, size))
    return size


def set_case(B: Reals, row: Reals) -> None:
    """Set the numbers of a case that are not part of its state."""
    n = int(B[N])
    copy(n, part(row, n, n), part(B, VECTORS + TOLERANCES * n, n))
    place = 2 * n
    breaks = int(B[FUNCTION]) - int(B[BREAKS])
    copy(breaks, part(row, place, breaks), part(B, int(B[BREAKS]), breaks))
    place = place + breaks
    place = place + set_numbers(part(B, int(B[FUNCTION]), 1), part(row, place, 1))
    if B[PROJECTOR] != 0.0:
        P = part(B, int(B[PROJECTOR]), 1)
        place = place + set_numbers(part(P, int(P[P_FUNCTION]), 1), part(row, place, 1))
        size = int(P[P_RESIDUALS]) + int(P[P_COORDINATES])
        copy(size, part(row, place, size), part(P, P_SCALES, size))


def prepare(B: Reals, row: Reals) -> None:
    """Set the block to the beginning of a case."""
    n = int(B[N])
    set_case(B, row)
    copy(n, row, part(B, VECTORS + STATE_OLD * n, n))
    # What a case before left there would decide whose fault a failure is.
    for i in range(int(B[BREAKS]) - VECTORS - VECTOR_ROWS * n):
        B[VECTORS + VECTOR_ROWS * n + i] = 0.0
    for k in range(COUNTS):
        B[k] = 0.0
    B[TIME] = B[T_START]
    B[STEP] = 0.0
    B[ERROR] = 0.0
    B[FIRST_BREAK] = B[BREAKS]
    B[NEXT_BREAK] = B[BREAKS]


def conclude(B: Reals, code: int, verdict: Reals) -> None:
    """Write down how far a case came, and how it ended unless it is still running."""
    copy(COUNTS, B, part(verdict, VERDICT_COUNTS, COUNTS))
    verdict[REACHED] = B[TIME]
    if code != RUNNING:
        verdict[CODE] = float(code)
        B[CASES_ENDED] = B[CASES_ENDED] + 1.0


def run_cases(
    f: Function, g: Function, B: Reals, count: int, size: int, cases: Reals, times: Reals, t: Reals, x: Reals,
    verdicts: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps of the cases without a verdict; return `RUNNING` or `FINISHED`.

    `size` is that of a row of `cases`; `t` (times,) is scratch.
    """
    n = int(B[N])
    left = trials
    while int(B[CASE]) < count:
        k = int(B[CASE])
        verdict = part(verdicts, k * VERDICT_SIZE, VERDICT_SIZE)
        if verdict[CODE] == NOT_ENDED:
            samples = part(x, k * int(B[TIMES]) * n, int(B[TIMES]) * n)
            code = RUNNING
            if B[CASE_BEGUN] == 0.0:
                prepare(B, part(cases, k * size, size))
                B[CASE_BEGUN] = 1.0
                code = begin(f, B, times, t, samples, t)
            before = B[ACCEPTED] + B[REJECTED]
            if code == RUNNING:
                code = advance(f, g, B, times, t, samples, t, t, left)
            left = left - int(B[ACCEPTED] + B[REJECTED] - before)
            conclude(B, code, verdict)
            if code == RUNNING:
                return RUNNING
        B[CASE] = float(k + 1)
        B[CASE_BEGUN] = 0.0
    return FINISHED
