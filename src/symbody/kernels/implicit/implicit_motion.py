"""A motion by the generalized-alpha method that is cut at events and at jumps of prescribed rates."""

from __future__ import annotations

from symbody.kernels.block import CUT, FULL, RUNNING, Run
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.configurations.struck_motion import pass_jump_of_rates, pass_watched_jump
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.events.watched_motion import go_on, watch_steps
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.implicit_machine import advance_implicit, set_out
from symbody.kernels.language import Function, Reals


def set_out_again(f: Function, run: Run, implicit: ImplicitStep, code: int) -> int:
    """Set out from the state at which an explicit method would begin anew; return the code."""
    if code == RUNNING:
        if implicit.one_length != 0.0:
            run.step = run.goal.direction * run.goal.max_step
        set_out(f, run, implicit)
    return code


def advance_implicit_watched(
    f: Function, k: Function, d: Function, g: Function, e: Function, a: Function, c: Function, run: Run,
    implicit: ImplicitStep, monitor: EventMonitor, times: Reals, t: Reals, x: Reals, breaks: Reals,
    pieces: Reals, H: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps, and let events happen; return one of the codes of `block`.

    As `advance_watched`, by the functions of `advance_implicit`.
    """
    code = monitor.resumed - 1
    monitor.resumed = 0
    for _trial in range(trials):
        if code < 0:
            code = FULL
            if run.room.every_step == 0.0 or run.counts.samples + 2 <= run.room.samples:
                code = advance_implicit(f, k, d, g, run, implicit, times, t, x, breaks, pieces, 1)
        code = watch_steps(e, a, c, run, monitor, t, x, breaks, pieces, H, code)
        if code == CUT:
            code = set_out_again(f, run, implicit, go_on(f, e, run, monitor, times, t, x, breaks))
        if code != RUNNING:
            return code
        code = -1
    return RUNNING


def pass_implicit_jump(
    f: Function, s: Function, run: Run, implicit: ImplicitStep, jumps: RateJumps, times: Reals, t: Reals,
    x: Reals, breaks: Reals,
) -> int:  # fmt: skip
    """Go on behind a jump of prescribed rates as `pass_jump_of_rates`."""
    return set_out_again(f, run, implicit, pass_jump_of_rates(f, s, run, jumps, times, t, x, breaks))


def pass_implicit_watched_jump(
    f: Function, s: Function, e: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor,
    jumps: RateJumps, times: Reals, t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Go on behind a jump of prescribed rates as `pass_watched_jump`."""
    code = pass_watched_jump(f, s, e, run, monitor, jumps, times, t, x, breaks, pieces)
    return set_out_again(f, run, implicit, code)
