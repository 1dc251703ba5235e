"""The end of a motion where friction and the reactions it comes from are not determined (Painleve)."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status
from symbody.simulation.task import Task
from symbody.tolerances import UNSOLVED

# Steps end where accelerations grow like 1 / margin; what is left there is far less, elsewhere far more.
_NEAR: Final = 1e-3
_BROKEN: Final = frozenset({Status.NOT_FINITE, Status.STEP_COLLAPSE, Status.SINGULAR, Status.TOO_MANY_STEPS})


def judged(task: Task, raw: RawRun) -> tuple[RawRun, tuple[str, ...]]:
    """Return a run with the verdict that friction is to blame, if it is, and a note that names the joint."""
    friction = task.eqs.formed.friction
    if raw.status not in _BROKEN or not friction:
        return raw, ()
    n_u, n = len(task.eqs.speed_names), len(task.eqs.state_names)
    x = raw.x[:, -1] if raw.dense_output is None else raw.dense_output(raw.reached)
    t = np.array([raw.reached])
    state = t, x[n_u:n, np.newaxis], x[:n_u, np.newaxis]
    margins = np.nan_to_num(task.evaluated(task.compiled("friction_margin"), *state)[0], nan=-1.0)
    residuals = task.evaluated(task.compiled("friction_residual"), *state)[0]
    unsolved = np.nan_to_num(residuals, nan=1.0) > UNSOLVED
    if margins.min() > _NEAR and not unsolved.any():
        return raw, ()
    k = int(margins.argmin() if margins.min() <= _NEAR else residuals.argmax())
    joint = friction[k].joint.name
    note = (
        f"at t = {raw.reached:.9g} s friction in joint {joint} loads it as much as it holds it back: "
        f"its reaction is not determined (margin {margins[k]:.3g})"
    )
    return replace(raw, status=Status.FRICTION, state=None, kernel=None), (note,)
