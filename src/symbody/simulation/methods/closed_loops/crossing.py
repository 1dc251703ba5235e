"""Where branches of configurations cross, and by how much the constraints of a mechanism keep them apart.

Near a singular configuration the constraint that is lost there is a quadratic form of the directions that are
open: branches cross where its level is zero, and turn away from each other like the two parts of a hyperbola
where it is not, however little. A mechanism of nearly equal lengths comes close to a crossing it does not
have. So the singular configuration itself is solved for, with that level as one more unknown:

    Phi(q, t) = opening w,    w . dPhi/d(q, t) = 0,    w . w = 1.

(An imperfect bifurcation with its unfolding parameter: Govaerts, Numerical Methods for Bifurcations of
Dynamical Equilibria, SIAM 2000, chapters 3 and 6.) Lock-ups are not among the solutions: there time goes on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.manifold import count_significant, damped_step, descend, pivot_order
from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints, MotionBranch
from symbody.tolerances import RANK, SAME_POSITION, TRACED

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

# Two configurations on either branch are closed to a tolerance each.
_SIDES: Final = 2.0
# Slopes by central differences are for Newton's method alone: their errors cost it steps, not digits.
_DIFFERENCE: Final = SAME_POSITION
# What is farther than this from where it is looked for, in radians or sizes, is passed at another time.
_NEARBY: Final = 0.3
_PATIENCE: Final = 20


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """A singular configuration near a motion.

    Attributes
    ----------
    q : (n_q,) array
    opening : float
        By what share of its size a constraint would have to be changed for branches to cross there.
    meets : bool
        Whether closed configurations do not tell this from 0.
    apart : (n_q,) array
        By ``q / sizes``: a direction in which each branch stays on one side of the configuration, where they
        do not meet.
    """

    q: Floats
    opening: float
    meets: bool
    apart: Floats


class _Conditions:
    """The conditions above at a point y = (q / sizes, t / unit, w, opening)."""

    def __init__(self, search: _CrossingSearch, y: Floats) -> None:
        self.y, n = y, search.count
        place, weights, opening = y[:n], y[n:-1], y[-1]
        values, slopes = search.constraints(place[np.newaxis])
        beside = place + _DIFFERENCE * np.concatenate([np.eye(n), -np.eye(n)])
        bent = weights @ search.constraints(beside)[1]
        self.hessian = (bent[:n] - bent[n:]) / (2.0 * _DIFFERENCE)
        self.values = np.concatenate(
            [values[0] - opening * weights, weights @ slopes[0], [(weights @ weights - 1.0) / 2.0]]
        )
        m = weights.size
        self.slopes = np.block(
            [
                [slopes[0], -opening * np.eye(m), -weights[:, np.newaxis]],
                [self.hessian, slopes[0].T, np.zeros((n, 1))],
                [np.zeros((1, n)), weights[np.newaxis], np.zeros((1, 1))],
            ]
        )


class _CrossingSearch:
    """Constraints on positions that span all others on a branch, by coordinates and, if driven, time."""

    def __init__(self, loops: LoopConstraints, branch: MotionBranch, t: float, unit: float) -> None:
        self._loops, self._t = loops, t
        self._unit = unit if loops.is_driven else 0.0
        slopes = loops.positions(branch.t, branch.q)[1]
        self._rows = np.sort(pivot_order(slopes.T)[0][: branch.positions])
        self.count = loops.sizes.size + (1 if self._unit else 0)

    def constraints(self, places: Floats) -> tuple[Floats, Floats]:
        """Return values (N, m) and derivatives (N, m, n) at places (N, n)."""
        n_q = self._loops.sizes.size
        q = places[:, :n_q] * self._loops.sizes
        t = self._t + (places[:, n_q] * self._unit if self._unit else np.zeros(len(places)))
        values, slopes = self._loops.positions(t, q)
        if self._unit:
            drift = np.zeros_like(values)
            holonomic = self._loops.speeds(t, q)[1][:, : self._loops.holonomic]
            drift[:, : self._loops.holonomic] = holonomic * self._unit
            slopes = np.concatenate([slopes, drift[..., np.newaxis]], axis=-1)
        return values[:, self._rows], slopes[:, self._rows]


def find_crossing(
    loops: LoopConstraints, branch: MotionBranch, t: float, q: Floats, unit: float
) -> Crossing | None:
    """Return the singular configuration that a motion comes near to at a time; None if there is none.

    Parameters
    ----------
    unit : float
        In what time the motion goes as far as a size [s].
    """
    search = _CrossingSearch(loops, branch, t, unit)
    place = np.zeros(search.count)
    place[: q.size] = q / loops.sizes
    slopes = search.constraints(place[np.newaxis])[1][0]
    if not slopes.size or not np.isfinite(slopes).all():
        return None
    weights = np.linalg.svd(slopes)[0][:, min(slopes.shape) - 1]
    first = _Conditions(search, np.concatenate([place, weights, [0.0]]))
    end = descend(first, lambda at, step: _Conditions(search, at.y + step), damped_step, patience=_PATIENCE)
    n, found = search.count, end.y[: q.size] * loops.sizes
    moved = float(np.abs(end.y[:n] - place).max())
    if not (np.abs(end.values).max() < TRACED and moved < _NEARBY):
        return None
    weights, opening = end.y[n:-1], float(end.y[-1])
    tolerance = loops.manifold(t).tolerance(found)
    meets = abs(opening) <= _SIDES * float(np.abs(weights).sum()) * tolerance
    return Crossing(found, opening, meets, _axis_between(end, slopes.shape[0], n, opening)[: q.size])


def crossing_of_motion(loops: LoopConstraints, branch: MotionBranch, t: float, x: Floats) -> Crossing | None:
    """Return the singular configuration that a motion comes near to in a state x; None if there is none."""
    speed = float(np.abs(loops.rates(t, x)).max(initial=0.0))
    return find_crossing(loops, branch, t, x[loops.places], 1.0 / (speed or 1.0))


def _axis_between(end: _Conditions, m: int, n: int, opening: float) -> Floats:
    """Return the open direction along which no closed configuration is at 0; zeros if it is not one alone."""
    _, sizes, right = np.linalg.svd(end.slopes[:m, :n])
    kernel = right[count_significant(sizes) :]
    curvatures, ways = np.linalg.eigh(kernel @ (end.hessian + end.hessian.T) @ kernel.T)
    curvatures *= -np.sign(opening)
    against = np.flatnonzero(curvatures > RANK * np.abs(curvatures).max(initial=0.0))
    return np.asarray(kernel.T @ ways[:, against[0]]) if against.size == 1 else np.zeros(n)
