"""Poses that a motion of fixed steps passes faster than its steps resolve.

Beside a flat pose the least singular value of J goes to zero like the distance, and accelerations change as
fast as its inverse. A method of order p is worth its order while the steps are short beside that distance.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints
from symbody.simulation.native.run import RawRun
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

# In so many steps a least singular value must not change by as much as itself: what a step of order 4 is off
# by goes with the fourth power of this.
_STEPS: Final = 4.0
# Places that are looked at first; around so many of the lowest ones every step is.
_PLACES: Final = 200
_LOWEST: Final = 8
# Singular values that stay below this share of the largest belong to constraints that follow from others.
_INDEPENDENT: Final = 1e-6
_NOTE: Final = (
    "near t = {:.6g} s some constraints are almost redundant, and steps of {:.3g} s are too long for how "
    "fast this changes: from there on the motion is much less accurate than the order of the method "
    "suggests; use shorter steps, or omit integrator="
)


def unresolved_pose_notes(problem: SimulationProblem, raw: RawRun, step: float) -> tuple[str, ...]:
    """Return a note where steps of a length [s] do not resolve how dependent the constraints are."""
    dense = raw.dense_output
    if dense is None or dense.breaks.size < 3:
        return ()
    t, loops = dense.breaks, LoopConstraints(problem)

    def singular_values(places: Places) -> Floats:
        return loops.singular_values(t[places], dense(t[places])[loops.places].T)

    coarse = np.arange(0, t.size, -(-t.size // _PLACES))
    values = singular_values(coarse)
    if not np.isfinite(values).all():
        return ()
    rank = int((np.median(values, axis=0) > _INDEPENDENT * values.max(initial=0.0)).sum())
    if rank == 0:
        return ()
    places = _low_places(coarse, values[:, rank - 1], t.size)
    least = [singular_values(some)[:, rank - 1] for some in places]
    unresolved = [some[are_unresolved(sizes)] for some, sizes in zip(places, least, strict=True)]
    times = sorted(float(t[some[0]]) for some in unresolved if some.size)
    return (_NOTE.format(times[0], step),) if times else ()


def _low_places(coarse: Places, least: Floats, count: int) -> list[Places]:
    """Return the steps' ends around the lowest values at some of them, where these may vanish between."""
    stride = int(coarse[1] - coarse[0])
    if stride == 1:
        return [coarse]
    low = coarse[are_unresolved(least)]
    lowest = low[np.argsort(least[low // stride], kind="stable")][:_LOWEST]
    return [np.arange(max(k - stride, 0), min(k + stride + 1, count)) for k in np.sort(lowest)]


def are_unresolved(least: Floats) -> NDArray[np.bool_]:
    """Return a mask of the steps' ends at which a singular value changes too fast for its size."""
    changes = np.abs(np.diff(least))
    beside = np.maximum(np.append(changes, 0.0), np.append(0.0, changes))
    return np.asarray(least < _STEPS * beside, dtype=np.bool_)
