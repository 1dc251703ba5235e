"""A motion in steps of the caller's own length, with inputs that keep their values until others are given.

The block is that of one motion. `S`, the numbers of the caller, holds behind those named here the state
x = (u, q) and the inputs r.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    ACCEPTED,
    AFTER_REJECTION,
    DIRECTION,
    ERROR,
    FINISHED,
    FIRST_STEP,
    FUNCTION,
    GROWTH,
    KERNEL,
    LENGTH,
    MAX_STEP,
    METHOD,
    R_PLACE,
    REJECTED,
    RUNNING,
    STATE_NEW,
    STATE_OLD,
    STEP,
    T_END,
    TIME,
    VECTOR_ROWS,
    VECTORS,
    N,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import all_finite, copy, evaluate
from symbody.kernels.step_bounds import behind_jump
from symbody.kernels.step_machine import advance, failure, first_step

DURATION: Final = 0  # of each step [s]
START: Final = 1  # when steps were counted from, so that their ends do not drift [s]
COUNT: Final = 2
NOW: Final = 3  # time that has been reached [s]
DERIVED: Final = 4  # whether the derivative at the beginning is known
UNDER_WAY: Final = 5  # whether a step has begun and not ended
PLANNED: Final = 6  # how long the integrator's last step was to be, before the end cut it [s]
INPUTS: Final = 7  # how many
STATE_AT: Final = 8


def renew_inputs(B: Reals, S: Reals) -> None:
    """Set the inputs of the right-hand side to those of the caller."""
    given = part(S, STATE_AT + int(B[N]), int(S[INPUTS]))
    r = part(B, int(B[FUNCTION]) + R_PLACE, int(S[INPUTS]))
    for i in range(int(S[INPUTS])):
        if r[i] != given[i]:
            r[i] = given[i]
            S[DERIVED] = 0.0


def set_off(f: Function, B: Reals, S: Reals) -> int:
    """Begin a step: set its end, and the derivative at its beginning unless it is known."""
    n = int(B[N])
    S[UNDER_WAY] = 1.0
    S[COUNT] = S[COUNT] + 1.0
    B[T_END] = S[START] + S[COUNT] * S[DURATION]
    B[ACCEPTED] = 0.0
    B[REJECTED] = 0.0
    B[AFTER_REJECTION] = 0.0
    B[KERNEL] = 0.0
    renew_inputs(B, S)
    begin = behind_jump(B, B[TIME])
    if begin != B[TIME]:
        B[TIME] = begin
        S[DERIVED] = 0.0
    if S[DERIVED] == 0.0:
        evaluate(f, B, begin, STATE_OLD, 0)
        if B[KERNEL] != 0.0 or all_finite(n, part(B, VECTORS + VECTOR_ROWS * n, n)) == 0:
            return failure(B)
        S[DERIVED] = 1.0
    if B[METHOD + GROWTH] == 1.0:
        B[STEP] = B[DIRECTION] * B[MAX_STEP]
    elif B[STEP] == 0.0:
        copy(n, part(B, VECTORS + STATE_OLD * n, n), part(B, VECTORS + STATE_NEW * n, n))
        B[ERROR] = 1e-4
        length = B[FIRST_STEP]
        if not length > 0.0:
            length = first_step(f, B)
        B[STEP] = B[DIRECTION] * min(length, B[MAX_STEP])
    return RUNNING


def conclude_step(B: Reals, S: Reals, code: int) -> None:
    """Go on from the end of a step, or from where it broke off."""
    S[UNDER_WAY] = 0.0
    if code != FINISHED:
        S[START] = B[TIME]
        S[COUNT] = 0.0
        S[DERIVED] = 0.0
        B[STEP] = 0.0
    elif abs(B[LENGTH]) < abs(S[PLANNED]) and abs(B[STEP]) < abs(S[PLANNED]):
        B[STEP] = S[PLANNED]  # a step that only the end cut short says nothing of the next


def step(f: Function, g: Function, B: Reals, S: Reals, trials: int) -> int:
    """Go on with a step by at most so many of the integrator's; return one of the codes of `block`."""
    n = int(B[N])
    code = RUNNING
    if S[UNDER_WAY] == 0.0:
        code = set_off(f, B, S)
    nothing = part(S, 0, 1)
    left = trials
    while code == RUNNING and left > 0:
        left = left - 1
        if B[TIME] != B[T_END]:
            S[PLANNED] = B[STEP]
        code = advance(f, g, B, nothing, nothing, nothing, nothing, nothing, 1)
    if code != RUNNING:
        conclude_step(B, S, code)
    S[NOW] = B[TIME]
    copy(n, part(B, VECTORS + STATE_OLD * n, n), part(S, STATE_AT, n))
    return code
