"""`Passages`: where a motion passes singular configurations, and whether it stays on its branch there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.manifold import count_significant
from symbody.simulation.methods.closed_loops.crossing import Crossing, crossing_of_motion
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR, LoopConstraints, MotionBranch
from symbody.simulation.native.dense_output import DenseOutput

Floats = NDArray[np.float64]

# A least singular value below this share of its largest is worth a closer look; below the last one it is
# asked whether branches meet there, as where a motion breaks off below the second. These only save time: a
# motion through a crossing comes as near to 0 as it is computed, and `find_crossing` decides.
LOW: Final = 0.5
STUCK: Final = 5e-2
_CLOSE: Final = 3e-3
# Share of the prescribed velocities that counts.
_DEMANDED: Final = 1e-2
_REFINEMENTS: Final = 12
_PER_REFINEMENT: Final = 9
# Velocities on both sides of a change point are compared where the singular value is this share: some tenths
# of a radian apart. Extrapolated from one side, with what a parabola leaves, they agree to the cube of that;
# those of two branches differ by their angle, of order one.
_BESIDE_IT: Final = 0.03
_SAME_BRANCH: Final = 0.1
_DOUBLINGS: Final = 48
# Sides of a crossing are told apart by more than the curvature of a motion leaves open: its distance from
# there is some hundredths, see above.
_CLEAR: Final = 0.1


class Leap(NamedTuple):
    """Where a motion goes over to a branch that its own comes close to but does not meet.

    Attributes
    ----------
    before, at : float
        Shortly before, and there [s].
    opening : float
        By what share of the mechanism's size lengths would have to be others for the branches to meet.
    """

    before: float
    at: float
    opening: float


@dataclass(frozen=True, slots=True, eq=False)
class Passages:
    """A motion with the least singular value that counts, over its largest, at the ends of all steps."""

    loops: LoopConstraints
    dense: DenseOutput
    branch: MotionBranch
    rank: int
    largest: float
    least: Floats
    _found: dict[int, tuple[float, Crossing | None] | None] = field(
        default_factory=dict, init=False, repr=False
    )

    def shares(self, t: Floats) -> Floats:
        """Return that value at any times."""
        found: Floats = self.loops.singular_values(t, self.dense(t)[self.loops.places].T)[:, self.rank - 1]
        return found / self.largest

    def times(self) -> Iterator[float]:
        """Yield the times of change points: where branches meet."""
        for at, crossing in self._dips():
            if self._meets(at, crossing):
                yield at

    def leap(self) -> Leap | None:
        """Return where a motion first goes over to a branch that its own does not meet, if it does."""
        first, last = self.dense.breaks[[0, -1]].tolist()
        for at, crossing in self._dips():
            if crossing is None or crossing.meets:
                continue
            before, after = self._time_beside(at, first), self._time_beside(at, last)
            if before is None or after is None:
                continue
            moved = (
                self.dense(np.array([before, after]))[self.loops.places].T - crossing.q
            ) / self.loops.sizes
            sides = moved @ crossing.apart
            if sides[0] * sides[1] < 0.0 and np.abs(sides).min() > _CLEAR * np.abs(moved).max():
                return Leap(before, at, abs(crossing.opening))
        return None

    def sides(self) -> Iterator[tuple[float, float, float]]:
        """Yield times at which branches meet or come close, and on both sides times well beside them."""
        first, last = self.dense.breaks[[0, -1]].tolist()
        for at, _ in self._dips():
            before, after = self._time_beside(at, first), self._time_beside(at, last)
            if before is not None and after is not None:
                yield at, before, after

    def ends_at_crossing(self) -> bool:
        """Return whether branches meet near the end of the motion."""
        end = float(self.dense.breaks[-1])
        return bool(self.least[-1] < STUCK) and self._meets(end, self._find_crossing(end))

    def _dips(self) -> Iterator[tuple[float, Crossing | None]]:
        """Yield times at which constraints are close to dependent, and the singular configuration there."""
        breaks = self.dense.breaks
        for k in _minima(self.least):
            if k not in self._found:
                start, stop = float(breaks[max(k - 1, 0)]), float(breaks[min(k + 1, breaks.size - 1)])
                at = _dip(self.shares, start, stop)
                self._found[k] = None if at is None else (at, self._find_crossing(at))
            found = self._found[k]
            if found is not None:
                yield found

    def _find_crossing(self, at: float) -> Crossing | None:
        return crossing_of_motion(self.loops, self.branch, at, self.dense(at))

    def _meets(self, at: float, crossing: Crossing | None) -> bool:
        """Return whether constraints become dependent; those on speeds alone have no branches."""
        if crossing is not None:
            return crossing.meets
        slopes = self.loops.positions(at, self.dense(at)[self.loops.places])[1]
        return count_significant(np.linalg.svd(slopes, compute_uv=False), NEAR) == self.branch.positions

    def jump(self, at: float, happened: list[float]) -> float | None:
        """Return a time shortly before a change point if velocities are others after it, not by an event."""
        breaks = self.dense.breaks
        before, after = self._time_beside(at, float(breaks[0])), self._time_beside(at, float(breaks[-1]))
        if before is None and after is not None:  # the motion starts there
            return float(breaks[0]) if self._differs(after, float(breaks[0]), happened) else None
        if before is None:
            return None
        if after is None:  # it never came away
            end = float(breaks[-1])
            if locks_up(self.loops, end, self.dense(end)[self.loops.places], self.rank, self.largest):
                return None
            after = min(2.0 * at - before, end, key=lambda t: abs(t - at))
        # Too short a motion before the change point is compared with where velocities beyond it come from.
        sides = (before, after) if self._reaches(before, after) else (after, before)
        return before if self._differs(*sides, happened) else None

    def last_clear(self) -> float | None:
        """Return the last time before the change point at which a motion ends; None if it came to none."""
        start, end = self.dense.breaks[[0, -1]].tolist()
        for at in self.times():
            if self._time_beside(at, end) is None:
                return self._time_beside(at, start)
        return None

    def _differs(self, near: float, far: float, happened: list[float]) -> bool:
        """Return whether velocities at one time are not those to which they lead from beyond another one."""
        if not self._reaches(near, far) or any(min(near, far) <= t <= max(near, far) for t in happened):
            return False
        times = near + (near - far) * np.array([0.5, 0.25, 0.0])
        u = self.dense(np.array([*times, far])).T[:, : self.loops.speed_sizes.size] / self.loops.speed_sizes
        # The parabola through velocities at 0, 1 and 2, at 6.
        apart = np.abs(np.array([10.0, -24.0, 15.0]) @ u[:3] - u[3]).max()
        return bool(apart > _SAME_BRANCH * np.abs(u).max())

    def _reaches(self, near: float, far: float) -> bool:
        """Return whether there is enough motion on the far side of a time to lead to another one."""
        first, last = sorted(map(float, self.dense.breaks[[0, -1]]))
        return first <= near + 0.5 * (near - far) <= last

    def _time_beside(self, at: float, limit: float) -> float | None:
        """Return the nearest time towards a limit at which constraints are independent again."""
        times = at + (limit - at) * np.exp2(-np.arange(_DOUBLINGS - 1.0, -1.0, -1.0))
        times[-1] = limit  # the sum may be rounded to beyond it, where there is no motion
        clear = np.flatnonzero(self.shares(times) > _BESIDE_IT)
        return float(times[clear[0]]) if clear.size else None


def locks_up(loops: LoopConstraints, t: float, q: Floats, rank: int, reference: float) -> bool:
    """Return whether prescribed motions ask for what is lost at a configuration: there their branch ends."""
    rows, drift = loops.speeds(t, q)
    if not loops.is_driven or not np.isfinite(rows).all():
        return False
    left, sizes, _ = np.linalg.svd(rows)
    lost = left[:, :rank][:, sizes[:rank] < STUCK * reference]
    return bool(np.linalg.norm(lost.T @ drift) > _DEMANDED * np.linalg.norm(drift))


def _minima(values: Floats) -> list[int]:
    """Return where low values are no larger than their neighbours."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    low = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]) & (values < LOW)
    return [int(k) for k in np.flatnonzero(low)]


def _dip(shares: Callable[[Floats], Floats], start: float, stop: float) -> float | None:
    """Return where shares fall to `_CLOSE` between two times, by ever closer samples about the least."""
    for _ in range(_REFINEMENTS):
        inside = np.linspace(start, stop, _PER_REFINEMENT)
        found = shares(inside)
        best = int(found.argmin())
        if found[best] < _CLOSE:
            return float(inside[best])
        start, stop = float(inside[max(best - 1, 0)]), float(inside[min(best + 1, inside.size - 1)])
    return None
