"""How a motion begins anew in the middle of a run, whatever its steps are."""

from __future__ import annotations

from symbody.kernels.block import FINISHED, RUNNING, Run
from symbody.kernels.events.event_interruptions import values_before
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.features import IMPLICIT
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.implicit_machine import set_out
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import begin_again


def begin_anew(
    f: Function, run: Run, implicit: ImplicitStep, times: Reals, t: Reals, x: Reals, breaks: Reals
) -> int:
    """Begin anew from the time and state at present; return a code of `block`."""
    code = begin_again(f, run, times, t, x, breaks)
    if IMPLICIT != 0:
        if code == RUNNING:
            if implicit.one_length != 0.0:
                run.step = run.goal.direction * run.goal.max_step
            set_out(f, run, implicit)
    return code


def go_on(
    f: Function, e: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor, times: Reals, t: Reals,
    x: Reals, breaks: Reals,
) -> int:  # fmt: skip
    """Begin anew from the state after a cut; at the end note on which side of zero values have come there."""
    n = run.states
    after = monitor.after
    copy(n, after, run.state_old)
    code = begin_anew(f, run, implicit, times, t, x, breaks)
    if monitor.bound != 0.0:
        run.step = run.goal.direction * min(abs(run.step), monitor.bound)
    sample = run.counts.samples
    if code == FINISHED and run.counts.samples < run.room.times:
        t[sample] = monitor.cut
        copy(n, after, part(x, sample * n, n))
        run.counts.samples = run.counts.samples + 1
    if code == FINISHED:
        values_before(e, run, monitor)
    return code
