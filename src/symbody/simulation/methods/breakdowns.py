"""Why a smooth motion ended where the mechanism leaves its accelerations or speeds open.

Friction and the reaction it comes from may have no solution, or two (Painleve); speeds that were eliminated
may cease to follow from the others.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.velocities import CURE, pivot_groups
from symbody.simulation.events.events import Event, LevelEvent
from symbody.simulation.methods.integration import Integration
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import UNSOLVED

Floats = NDArray[np.float64]

# Errors of the independent speeds come back divided by the pivot: three digits are given away, no more.
_NEAR: Final = 1e-3
_SHARE: Final = 0.1  # of the first pivot, where that is small already
_LABEL: Final = "dependent speeds "
# Steps end where accelerations grow like 1 / margin; what is left there is far less, elsewhere far more.
_LEAST_MARGIN: Final = 1e-3
_BROKEN: Final = frozenset({Status.NOT_FINITE, Status.STEP_COLLAPSE, Status.SINGULAR, Status.TOO_MANY_STEPS})


def pivot_events(problem: SimulationProblem, t: float, x: Floats) -> tuple[Event, ...]:
    """Return what ends a motion from a state x = (u, q) before a pivot vanishes, on either side of zero."""
    groups = pivot_groups(problem.eqs)
    if not groups:
        return ()
    n_u = len(problem.eqs.speed_names)
    state = np.array([t]), x[n_u:, np.newaxis], x[:n_u, np.newaxis]
    pivots = problem.evaluate(problem.compile_outputs([f"{names[0]}_pivot" for names in groups]), *state)
    events = []
    for names, value in zip(groups, np.ravel(pivots), strict=True):
        limit = min(_NEAR, _SHARE * abs(float(value)))
        for sign in "-+":
            level = limit if sign == "-" else -limit
            label = f"{_LABEL}{', '.join(names)} {sign}"
            events.append(LevelEvent(f"{names[0]}_pivot", 0, "stop", label, level))
    return tuple(events)


def judge_pivots(run: Integration, events: tuple[Event, ...]) -> Integration:
    """Return a run with the verdict that one of the `pivot_events` ended it, if one did, and a note."""
    watch = run.watch
    last = watch.occurrences[-1] if watch is not None and watch.occurrences else None
    if watch is None or last is None or run.raw.status is not Status.STOPPED:
        return run
    if last.name not in {event.label for event in events}:
        return run
    watch.forget_last()
    names = last.name.removeprefix(_LABEL).rpartition(" ")[0]
    return _blame(
        run,
        Status.DEPENDENT_SPEEDS,
        f"at t = {last.t:.9g} s the dependent speeds {names} are hardly determined by the others any "
        f"longer; {CURE}",
    )


def judge_friction(problem: SimulationProblem, run: Integration) -> Integration:
    """Return a run with the verdict that friction is to blame, if it is, and a note that names the joint."""
    raw = run.raw
    friction = problem.eqs.formed.friction
    if raw.status not in _BROKEN or not friction:
        return run
    n_u, n = len(problem.eqs.speed_names), len(problem.eqs.state_names)
    x = raw.x[:, -1] if raw.dense_output is None else raw.dense_output(raw.reached)
    t = np.array([raw.reached])
    state = t, x[n_u:n, np.newaxis], x[:n_u, np.newaxis]
    margins = np.nan_to_num(problem.evaluate(problem.compile_outputs("friction_margin"), *state)[0], nan=-1.0)
    residuals = problem.evaluate(problem.compile_outputs("friction_residual"), *state)[0]
    unsolved = np.nan_to_num(residuals, nan=1.0) > UNSOLVED
    if margins.min() > _LEAST_MARGIN and not unsolved.any():
        return run
    k = int(margins.argmin() if margins.min() <= _LEAST_MARGIN else residuals.argmax())
    joint = friction[k].owner
    note = (
        f"at t = {raw.reached:.9g} s friction in joint {joint} increases its own normal force without "
        f"bound: the reaction is undetermined (margin {margins[k]:.3g})"
    )
    return _blame(run, Status.FRICTION, note)


def _blame(run: Integration, status: Status, note: str) -> Integration:
    """Return a run with another verdict and a note."""
    raw = replace(run.raw, status=status, state=None, kernel=None)
    return run._replace(raw=raw, notes=(*run.notes, note))
