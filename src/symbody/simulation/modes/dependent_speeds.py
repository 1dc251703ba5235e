"""The end of a motion where speeds that were eliminated do not follow from the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from symbody.analysis.state import State
from symbody.analysis.velocities import CURE, pivot_groups
from symbody.simulation.events.events import Event
from symbody.simulation.events.watching import EventWatch
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status
from symbody.simulation.task import Task

# Errors of the independent speeds come back divided by the pivot: three digits are given away, no more.
_NEAR: Final = 1e-3
_SHARE: Final = 0.1  # of the first pivot, where that is small already
_LABEL: Final = "dependent speeds "


def pivot_events(task: Task, first: State, t: float) -> tuple[Event, ...]:
    """Return what ends a motion before a pivot vanishes, on either side of zero."""
    groups = pivot_groups(task.eqs)
    if not groups:
        return ()
    q, u = np.array([*first.q.values()]), np.array([*first.u.values()])
    state = np.array([t]), q[:, np.newaxis], u[:, np.newaxis]
    found = task.evaluated(task.compiled([f"{names[0]}_pivot" for names in groups]), *state)
    events = []
    for names, value in zip(groups, np.ravel(found), strict=True):
        limit = min(_NEAR, _SHARE * abs(float(value)))
        for sign in "-+":
            formula = f"{names[0]}_pivot {sign} {limit:.17g}"
            events.append(Event(formula, 0, "stop", f"{_LABEL}{', '.join(names)} {sign}"))
    return tuple(events)


def pivots_judged(
    raw: RawRun, watch: EventWatch | None, events: Sequence[Event]
) -> tuple[RawRun, tuple[str, ...]]:
    """Return a run with the verdict that a pivot ended it, if one did, and a note that names the speeds.

    Parameters
    ----------
    events : sequence of Event
        What `pivot_events` returned.
    """
    labels = {event.label for event in events}
    last = watch.occurrences[-1] if watch is not None and watch.occurrences else None
    if watch is None or last is None or raw.status is not Status.STOPPED or last.name not in labels:
        return raw, ()
    watch.occurrences.pop()
    names = last.name.removeprefix(_LABEL).rpartition(" ")[0]
    note = (
        f"at t = {last.t:.9g} s the dependent speeds {names} hardly follow from the others any more; {CURE}"
    )
    return replace(raw, status=Status.DEPENDENT_SPEEDS, state=None, kernel=None), (note,)
