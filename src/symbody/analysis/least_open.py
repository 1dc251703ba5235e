"""`least_open`: the configuration with the smallest residual of loops that cannot close."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from symbody.analysis.closure import Closure

Floats = NDArray[np.float64]

# Messages give three digits; a sum of squares is this flat about its least value.
_EXACT = 1e-12
_EVALUATIONS = 400


def least_open(evaluator: Closure, q: Floats, fixed: Mapping[str, float]) -> tuple[Floats, float]:
    """Return coordinates near `q` with the least sum of squares of all conditions, and this sum.

    Quaternions are units throughout: with another norm, a rotation matrix in them stretches the body.
    Lengths count over the size of the mechanism, angles in radians, so that what is missing is shared
    among all loops that it can be shared among.
    """
    sphere = _Spheres(evaluator, q, fixed)
    found = least_squares(
        sphere.values, q[sphere.free], sphere.slopes, x_scale=evaluator.sizes[sphere.free],
        ftol=_EXACT, xtol=_EXACT, gtol=_EXACT, max_nfev=_EVALUATIONS,
    )  # fmt: skip
    return sphere.project(found.x)[0], 2.0 * float(found.cost)


class _Spheres:
    """The conditions as functions of free coordinates, of which quaternions are put on their sphere first.

    Rows that hold each quaternion's length before that make its four numbers unique; they change nothing.
    """

    def __init__(self, evaluator: Closure, q: Floats, fixed: Mapping[str, float]) -> None:
        self._manifold, self._q = replace(evaluator.manifold(fixed), free=None), q
        self.free = evaluator.free(fixed)
        self._fours = []
        for places in evaluator.quaternions():
            held = sum(float(q[k]) ** 2 for k in places if not self.free[k])
            rest = [k for k in places if self.free[k]]
            if rest and held < 1.0:
                self._fours.append((rest, float(np.sqrt(1.0 - held))))

    def project(self, x: Floats) -> tuple[Floats, Floats]:
        """Return all coordinates, and as they are before quaternions are put on their spheres."""
        before = self._q.copy()
        before[self.free] = x
        q = before.copy()
        for places, radius in self._fours:
            q[places] *= radius / np.linalg.norm(q[places])
        return q, before

    def values(self, x: Floats) -> Floats:
        """Return the conditions."""
        q, before = self.project(x)
        lengths = [(before[places] @ before[places] - radius**2) / 2.0 for places, radius in self._fours]
        return np.concatenate([self._manifold.constraints(q).values, lengths])

    def slopes(self, x: Floats) -> Floats:
        """Return their derivatives by the free coordinates."""
        q, before = self.project(x)
        rows = self._manifold.jacobian(q) / self._manifold.sizes
        lengths = np.zeros((len(self._fours), q.size))
        for k, (places, radius) in enumerate(self._fours):
            norm = float(np.linalg.norm(before[places]))
            along = before[places] / norm
            tangent = (np.eye(len(places)) - np.outer(along, along)) * (radius / norm)
            rows[:, places] = rows[:, places] @ tangent
            lengths[k, places] = before[places]
        return np.vstack([rows, lengths])[:, self.free]
