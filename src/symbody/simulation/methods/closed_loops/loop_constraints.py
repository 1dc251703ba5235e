"""`LoopConstraints`: the constraints of a motion as numbers, and the branch of configurations it follows.

Lengths are measured by the mechanism's size, so that coordinates, speeds and constraints are numbers of order
one. Where constraints are dependent, their number means little: in linkages that only just fit, rows of J
follow from others on the configurations that close all loops, and nowhere else; at change points they do so
for an instant. What stays the same along a motion is the rank of J at its regular configurations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.manifold import ConstraintManifold, count_significant, explore_branch
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import SHARP_RANK

Floats = NDArray[np.float64]

# Beside a change point by an angle d its least singular value is about d. Coordinates are solved to eps / d,
# speeds to eps / d^2 and accelerations to eps / d^3: of some 30 speeds [m] to 1e-9 of what they are at this
# share of the value elsewhere.
NEAR: Final = 2e-2
# How far a configuration is moved along its motion, in radians or sizes, to learn what is regular there.
_BESIDE: Final = (0.03, 0.011)
_MOST_POINTS: Final = 4
_ROUNDS: Final = 4


@dataclass(frozen=True, slots=True)
class MotionBranch:
    """What holds along the branch of configurations that a motion follows.

    Attributes
    ----------
    positions, speeds : int
        Ranks of the conditions on positions, norms of quaternions among them, and of J.
    reference : float
        The least singular value of J that counts, where the branch is regular.
    t, q : float, (n_q,) array
        A time and coordinates where it is regular.
    """

    positions: int
    speeds: int
    reference: float
    t: float
    q: Floats


class LoopConstraints:
    """Constraints with values of parameters, at one state or many (leading axes of q and u)."""

    def __init__(self, problem: SimulationProblem) -> None:
        self.problem, eqs = problem, problem.eqs
        self.sizes, self.speed_sizes = problem.scales.coordinates(eqs), problem.scales.displacements(eqs)
        n_u = len(eqs.speed_names)
        self.places = slice(n_u, n_u + len(eqs.coordinate_names))  # of the coordinates in a state
        self._scales = problem.scales.constraints(eqs)

    @property
    def is_driven(self) -> bool:
        """Whether time moves the mechanism."""
        return any(not row.drift.is_zero for row in self.problem.eqs.formed.rows)

    @property
    def holonomic(self) -> int:
        """How many constraints are on positions; they come first."""
        return len(self.problem.eqs.formed.holonomic)

    @property
    def quaternions(self) -> list[list[int]]:
        """Places of quaternions among the coordinates."""
        names = self.problem.eqs.coordinate_names
        return [[names.index(name) for name in four] for four in self.problem.eqs.quaternions]

    def positions(self, t: float | Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return the conditions (.., m) on positions and their derivatives (.., m, n_q) by ``q / sizes``."""
        _, values, slopes = self.manifold(t).constraints(q)
        return values, slopes

    def speeds(self, t: float | Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return J (.., m, n_u) by ``u / speed_sizes`` and b (.., m) of ``J u + b = 0``."""
        found = self._values(("jacobian", "velocity_constraints"), t, q)
        return self._scale(found[0]), found[1] / self._scales

    def singular_values(self, t: float | Floats, q: Floats) -> Floats:
        """Return those of J, the largest first; NaN where it is not finite."""
        rows = self._scale(self._values("jacobian", t, q))
        if not np.isfinite(rows).all():
            return np.full((*rows.shape[:-2], min(rows.shape[-2:])), np.nan)
        return np.asarray(np.linalg.svd(rows, compute_uv=False), dtype=np.float64)

    def depends(self, t: float, q: Floats) -> bool:
        """Return whether some constraints follow from others at a configuration.

        Those that hold whatever moves, for these parameters, are left aside.
        """
        elsewhere = q + np.linspace(0.1, 0.2, q.size) * self.sizes
        rows, others = (self._scale(self._values("jacobian", t, place)) for place in (q, elsewhere))
        rows = rows[rows.any(axis=1) | others.any(axis=1)]
        return len(rows) > count_significant(np.linalg.svd(rows, compute_uv=False), SHARP_RANK)

    def rates(self, t: float, x: Floats) -> Floats:
        """Return q' of a state, in sizes."""
        n_u = self.speed_sizes.size
        found = self._call(self.problem.compile_outputs("qdot"), t, x[self.places], x[:n_u])
        return np.asarray(found / self.sizes, dtype=np.float64)

    def manifold(self, t: float | Floats) -> ConstraintManifold:
        """Return the configurations that fulfil the constraints at a time, or at the time of each."""

        def evaluate(q: Floats) -> tuple[Floats, Floats]:
            found = self._values(("constraints", "position_jacobian"), t, q)
            return found[0], found[1]

        return ConstraintManifold(evaluate, self.sizes, self._scales[: self.holonomic], self.quaternions)

    def project(self, branch: MotionBranch, t: Floats, x: Floats) -> Floats:
        """Return states (N, n) at times (N,) on the constraints, by the least moves.

        Conditions that follow from others on the branch are left out, and near change points what is about
        to follow from others there.
        """
        if not t.size:
            return x
        n_u = self.speed_sizes.size
        u, q = x[:, :n_u].copy(), x[:, self.places].copy()
        for _ in range(_ROUNDS):
            values, slopes = self.positions(t, q)
            q -= _least_moves(slopes, values, branch.positions, branch.reference) * self.sizes
        rows, drift = self.speeds(t, q)
        violation = (rows @ (u / self.speed_sizes)[..., np.newaxis])[..., 0] + drift
        u -= _least_moves(rows, violation, branch.speeds, branch.reference) * self.speed_sizes
        result = np.concatenate([u, q, x[:, self.places.stop :]], axis=1)
        return np.where(np.isfinite(result).all(axis=1, keepdims=True), result, x)

    def _scale(self, rows: Floats) -> Floats:
        return np.asarray(rows / self._scales[:, np.newaxis] * self.speed_sizes, dtype=np.float64)

    def _values(self, outputs: str | tuple[str, ...], t: float | Floats, q: Floats) -> Any:
        still = np.zeros((*q.shape[:-1], self.speed_sizes.size))
        return self._call(self.problem.compile_outputs(outputs), t, q, still)

    def _call(self, function: Any, t: float | Floats, q: Floats, u: Floats) -> Any:
        if q.ndim > 1:
            return self.problem.evaluate(function, np.asarray(t), q.T, u.T)
        inputs = self.problem.laws.evaluate(float(t), q, u) if self.problem.laws.callbacks else np.zeros(0)
        return function(t, q, u, inputs)


def motion_branch(loops: LoopConstraints, t: float, x: Floats) -> MotionBranch:
    """Return the branch on which a motion starts at a state that fulfils the constraints.

    It is looked at beside the start: along the velocity, by which motions pass change points, and where this
    shows no more independent constraints, along all directions that the constraints admit.
    """
    q = x[loops.places]
    here = _regular(loops, [(t, q)])
    found = _regular(loops, [(t, q), *_neighbours_along_motion(loops, t, x)])
    if found.speeds > here.speeds or not loops.depends(t, q):
        return found
    points = explore_branch(loops.manifold(t), q).points[:_MOST_POINTS]
    return _regular(loops, [(t, q), *((t, point) for point in points)])


def _regular(loops: LoopConstraints, places: Iterable[tuple[float, Floats]]) -> MotionBranch:
    """Return the branch with the ranks of the most regular of some configurations at their times."""
    best = MotionBranch(0, 0, 0.0, np.nan, np.zeros(0))
    for time, place in places:
        slopes, rows = loops.positions(time, place)[1], loops.speeds(time, place)[0]
        if not (np.isfinite(slopes).all() and np.isfinite(rows).all()):
            continue
        sizes = np.linalg.svd(rows, compute_uv=False)
        by_position = count_significant(np.linalg.svd(slopes, compute_uv=False), SHARP_RANK)
        count = count_significant(sizes, SHARP_RANK)
        least = float(sizes[count - 1]) if count else 0.0
        if (by_position, count, least) > (best.positions, best.speeds, best.reference):
            best = MotionBranch(by_position, count, least, time, place)
    return best


def _neighbours_along_motion(loops: LoopConstraints, t: float, x: Floats) -> Iterator[tuple[float, Floats]]:
    """Yield times and closed configurations shortly before and after a state, if it moves."""
    rate = loops.rates(t, x)
    speed = float(np.abs(rate).max(initial=0.0))
    if not (0.0 < speed < np.inf):
        return
    for length in _BESIDE:
        for time in (-length / speed, length / speed):
            at = t + time if loops.is_driven else t
            found = loops.manifold(at).project(x[loops.places] + time * rate * loops.sizes)
            if found.is_closed:
                yield at, found.q


def _least_moves(slopes: Floats, values: Floats, rank: int, reference: float) -> Floats:
    """Return least moves (N, n) that change values (N, m) of this rank by their amount."""
    left, sizes, right = np.linalg.svd(slopes, full_matrices=False)
    left, sizes, right = left[..., :rank], sizes[..., :rank], right[..., :rank, :]
    shares = (np.swapaxes(left, -1, -2) @ values[..., np.newaxis])[..., 0]
    counts = sizes > NEAR * reference
    shares = np.where(counts, shares, 0.0) / np.where(counts, sizes, 1.0)
    return np.asarray((shares[..., np.newaxis, :] @ right)[..., 0, :])
