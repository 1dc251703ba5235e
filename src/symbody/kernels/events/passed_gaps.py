"""Steps that pass over a gap: at both of their ends it is open, in between it is closed.

What acts while it is closed would be seen by none of the evaluations of such a step.
"""

from __future__ import annotations

from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import GOES_ON, EventMonitor
from symbody.kernels.events.event_watch import look, start_stretch
from symbody.kernels.language import Function, Reals
from symbody.kernels.runge_kutta import copy


def passes_gap(e: Function, run: Run, piece: Reals) -> int:
    """Return 1 if the step just tried, with a dense output, passes over a gap, else 0; `e` gives the gaps.

    A gap that cannot be computed is not passed: the next evaluation of the motion tells of that.
    """
    monitor = EventMonitor.view(run.gaps, 0)
    copy(monitor.numbers.input_count, run.numbers.inputs, monitor.numbers.inputs)
    ends = monitor.ends
    ends[0] = run.time
    ends[1] = run.t_new
    monitor.fault = 0
    for k in range(monitor.event_count):
        monitor.events[k].largest = 0.0  # what is found depends on this step alone
    start_stretch(monitor, 0)
    if look(e, e, e, monitor, ends, piece, ends, 1, 1) == GOES_ON:
        return 1
    return 0
