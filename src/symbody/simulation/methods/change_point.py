"""Motions for which `Projection` in the compiled loop is not enough, and `Partition` takes over.

Two kinds: constraints that follow from others only where all loops are closed, as in Bennett's linkage, so
that beside such states the mechanism seems locked; and positions where constraints become dependent (change
points, such as a flat parallelogram), at which accelerations leave the branch of the motion open.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.redundancy import redundancy
from symbody.analysis.state import State
from symbody.simulation.events.watching import EventWatch
from symbody.simulation.methods.choice import Constraints, Integrator
from symbody.simulation.methods.constraints import Projection
from symbody.simulation.methods.partition import Partition
from symbody.simulation.methods.stiff import Stiff
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status
from symbody.simulation.task import Task

Floats = NDArray[np.float64]

# Relative singular values: of rows that follow from others in a state closed to 1e-9, and of rows that no
# longer do so a step beside it.
_FOLLOWS: Final = 1e-8
_STANDS: Final = 1e-7
_BESIDE: Final = 1e-2  # rad, or share of the mechanism's size
# A change point is passed where the smallest singular value falls to this share of its largest, or a motion
# breaks off below the larger one. A minimum worth a closer look is below the third.
_PASSED: Final = 3e-3
_STUCK: Final = 5e-2
_LOW: Final = 0.5
_REFINEMENTS: Final = 12
_PER_REFINEMENT: Final = 9
_INDEPENDENT: Final = 1e-6
_CHANGED: Final = (
    "at t = {:.6g} s constraints become dependent (change point), where sb.Projection() may take another "
    "branch: sb.Partition() integrates the motion"
)
_OVERCONSTRAINED: Final = (
    "some constraints follow from others only where all loops are closed, see sb.redundancy(): "
    "sb.Partition() integrates the motion"
)
# Ends after which another way is tried: what ran out of steps or was interrupted is not begun again.
_RETRIED: Final = (Status.SUCCESS, Status.STOPPED, Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE)
_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE)


Moved = tuple[RawRun, tuple[str, ...], EventWatch | None]


def run_held(
    task: Task,
    first: State,
    t: float,
    integrator: Integrator | None,
    constraints: Constraints | None,
    run: Callable[[Constraints], Moved],
) -> Moved:
    """Return the run under the constraints asked for; None is `Projection` where that is safe.

    Parameters
    ----------
    first, t : State, float
        Where and when the motion starts.
    run : callable
        Runs the whole motion, anew at each call; returns its notes and what looked for events, too.
    """
    if constraints is not None or isinstance(integrator, Stiff):
        return run(constraints or Projection())
    if is_overconstrained(task, first, t):
        raw, notes, watch = run(Partition())
        return raw, (_OVERCONSTRAINED, *notes), watch
    moved = run(Projection())
    at = change_point(task, moved[0]) if moved[0].status in _RETRIED else None
    if at is None:
        return moved
    raw, notes, watch = run(Partition())
    return (raw, (_CHANGED.format(at), *notes), watch) if raw.status.success else moved


def is_overconstrained(task: Task, first: State, t: float) -> bool:
    """Return whether constraints follow from others only where all loops are closed."""
    eqs = task.eqs
    if not eqs.multiplier_names or not eqs.speed_names:
        return False
    rows = _Rows(task)
    q = np.array(list(first.q.values()))
    here = rows.scaled(np.array([t]), q[:, np.newaxis])[0]
    sizes, right = np.linalg.svd(here)[1:]
    rank = int((sizes > _FOLLOWS * sizes.max(initial=0.0)).sum())
    if rank == min(here.shape):
        return False
    motion = (right[rank:].sum(axis=0) * rows.speeds)[:, np.newaxis]
    rate = task.evaluated(task.compiled("qdot"), np.array([t]), q[:, np.newaxis], motion)[0]
    beside = q + _BESIDE * rate / max(1.0, float(np.abs(motion / rows.speeds[:, np.newaxis]).max()))
    there = rows.sizes(np.array([t]), beside[:, np.newaxis])[0]
    raised = int((there > _STANDS * there.max(initial=0.0)).sum())
    if raised <= rank:
        return False
    # A start at a change point looks alike, but there the rank is lower than elsewhere on the motion.
    return len(redundancy(eqs, task.parameters, dict(first.q)).kept) < raised


def change_point(task: Task, raw: RawRun) -> float | None:
    """Return the time of the first change point of a motion, or None."""
    eqs = task.eqs
    if not eqs.multiplier_names or not eqs.speed_names or raw.dense_output is None:
        return None
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    rows, dense, t = _Rows(task), raw.dense_output, raw.dense_output.breaks
    sizes = rows.sizes(t, dense(t)[n_u:n])
    if not np.isfinite(sizes).all():
        return None
    rank = int((sizes > _INDEPENDENT * sizes.max()).sum(axis=1).max())
    if rank == 0:
        return None
    largest = float(sizes[:, rank - 1].max())

    def shares(at: Floats) -> Floats:
        """Return the smallest singular value that counts, over its largest on the motion."""
        found: Floats = rows.sizes(at, dense(at)[n_u:n])[:, rank - 1] / largest
        return found

    least = sizes[:, rank - 1] / largest
    for k in _minima(least):
        at = _dip(shares, float(t[max(k - 1, 0)]), float(t[min(k + 1, t.size - 1)]))
        if at is not None:
            return at
    return float(t[-1]) if raw.status in _COLLAPSES and least[-1] < _STUCK else None


def _minima(values: Floats) -> list[int]:
    """Return where low values are no larger than their neighbours."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    low = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]) & (values < _LOW)
    return [int(k) for k in np.flatnonzero(low)]


def _dip(shares: Callable[[Floats], Floats], start: float, stop: float) -> float | None:
    """Return where shares fall to `_PASSED` between two times, by ever closer samples about the least."""
    for _ in range(_REFINEMENTS):
        inside = np.linspace(start, stop, _PER_REFINEMENT)
        found = shares(inside)
        best = int(found.argmin())
        if found[best] < _PASSED:
            return float(inside[best])
        start, stop = float(inside[max(best - 1, 0)]), float(inside[min(best + 1, inside.size - 1)])
    return None


class _Rows:
    """J of a motion with lengths measured by the mechanism's size."""

    def __init__(self, task: Task) -> None:
        eqs = task.eqs
        self._task, self._function = task, task.compiled("jacobian")
        self._scales, self.speeds = task.scales.constraints(eqs), task.scales.displacements(eqs)

    def scaled(self, t: Floats, q: Floats) -> Floats:
        """Return J at times (N,) with coordinates (n_q, N)."""
        found = self._task.evaluated(self._function, t, q, np.zeros((self.speeds.size, t.size)))
        rows: Floats = found / self._scales[:, np.newaxis] * self.speeds
        return rows

    def sizes(self, t: Floats, q: Floats) -> Floats:
        """Return the singular values of J, the largest first."""
        rows = self.scaled(t, q)
        if not np.isfinite(rows).all():
            return np.full((t.size, min(rows.shape[1:])), np.nan)
        found: Floats = np.asarray(np.linalg.svd(rows, compute_uv=False), dtype=np.float64)
        return found
