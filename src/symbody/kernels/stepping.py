"""A motion in steps of the caller's own length, with inputs that keep their values until others are given.

The block is that of one motion. `S`, the numbers of the caller, holds behind those named here the state
x = (u, q) and the inputs r.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FINISHED, RUNNING, Run
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


def renew_inputs(run: Run, S: Reals) -> None:
    """Set the inputs of the right-hand side to those of the caller."""
    given = part(S, STATE_AT + run.states, int(S[INPUTS]))
    r = run.numbers.inputs
    for i in range(int(S[INPUTS])):
        if r[i] != given[i]:
            r[i] = given[i]
            S[DERIVED] = 0.0


def set_off(f: Function, run: Run, S: Reals) -> int:
    """Begin a step: set its end, and the derivative at its beginning unless it is known."""
    n = run.states
    S[UNDER_WAY] = 1.0
    S[COUNT] = S[COUNT] + 1.0
    run.t_end = S[START] + S[COUNT] * S[DURATION]
    run.counts.accepted = 0.0
    run.counts.rejected = 0.0
    run.after_rejection = 0.0
    run.counts.failed_kernel = 0
    renew_inputs(run, S)
    begin = behind_jump(run, run.time)
    if begin != run.time:
        run.time = begin
        S[DERIVED] = 0.0
    if S[DERIVED] == 0.0:
        evaluate(f, run, begin, run.state_old, run.slopes)
        if run.counts.failed_kernel != 0 or all_finite(n, run.slopes) == 0:
            return failure(run)
        S[DERIVED] = 1.0
    if run.method.growth == 1.0:
        run.step = run.goal.direction * run.goal.max_step
    elif run.step == 0.0:
        copy(n, run.state_old, run.state_new)
        run.error = 1e-4
        length = run.first_step
        if not length > 0.0:
            length = first_step(f, run)
        run.step = run.goal.direction * min(length, run.goal.max_step)
    return RUNNING


def conclude_step(run: Run, S: Reals, code: int) -> None:
    """Go on from the end of a step, or from where it broke off."""
    S[UNDER_WAY] = 0.0
    if code != FINISHED:
        S[START] = run.time
        S[COUNT] = 0.0
        S[DERIVED] = 0.0
        run.step = 0.0
    elif abs(run.length) < abs(S[PLANNED]) and abs(run.step) < abs(S[PLANNED]):
        run.step = S[PLANNED]  # a step that only the end cut short says nothing of the next


def step(f: Function, g: Function, e: Function, run: Run, S: Reals, trials: int) -> int:
    """Go on with a step by at most so many of the integrator's; return one of the codes of `block`.

    `e` gives the gaps over which none of these may pass, if there are any.
    """
    n = run.states
    code = RUNNING
    if S[UNDER_WAY] == 0.0:
        code = set_off(f, run, S)
    nothing = part(S, 0, 1)
    left = trials
    while code == RUNNING and left > 0:
        left = left - 1
        if run.time != run.t_end:
            S[PLANNED] = run.step
        code = advance(f, g, e, run, nothing, nothing, nothing, nothing, nothing, 1)
    if code != RUNNING:
        conclude_step(run, S, code)
    S[NOW] = run.time
    copy(n, run.state_old, part(S, STATE_AT, n))
    return code
