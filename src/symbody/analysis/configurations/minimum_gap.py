"""`minimum_gap`: the configuration with the smallest residual of loops that cannot close."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.analysis.constraint_evaluator import ConstraintEvaluator

Floats = NDArray[np.float64]

# Messages give three digits; a sum of squares is this flat about its least value.
_EXACT = 1e-12
_EVALUATIONS = 400


def minimum_gap(
    evaluator: ConstraintEvaluator, q: Floats, fixed: Mapping[str, float]
) -> tuple[Floats, float]:
    """Return coordinates near `q` with the least sum of squares of all conditions, and this sum.

    Quaternions are units throughout: with another norm, a rotation matrix in them stretches the body.
    Lengths count over the size of the mechanism, angles in radians, so that what is missing is shared
    among all loops that it can be shared among.
    """
    manifold, free = replace(evaluator.manifold(fixed), free=None), evaluator.free_coordinates(fixed)
    spheres = []  # of the free components of each quaternion, with their radius
    for places in map(np.array, evaluator.quaternions()):
        square = 1.0 - float((q[places[~free[places]]] ** 2).sum())
        if free[places].any() and square > 0.0:
            spheres.append((places[free[places]], np.sqrt(square)))

    def coordinates(x: Floats) -> Floats:
        result = q.copy()
        result[free] = x
        for places, radius in spheres:
            result[places] *= radius / np.linalg.norm(result[places])
        return result

    def slopes(x: Floats) -> Floats:
        result, before = coordinates(x), q.copy()
        before[free] = x
        rows = manifold.jacobian(result) / manifold.sizes
        for places, radius in spheres:
            along = result[places] / radius
            tangent = rows[:, places] - np.outer(rows[:, places] @ along, along)
            rows[:, places] = tangent * radius / np.linalg.norm(before[places])
        return rows[:, free]

    least = scipy.optimize.least_squares(
        lambda x: manifold.constraints(coordinates(x)).values, q[free], slopes,
        x_scale=evaluator.sizes[free], ftol=_EXACT, xtol=_EXACT, gtol=_EXACT, max_nfev=_EVALUATIONS,
    )  # fmt: skip
    return coordinates(least.x), 2.0 * float(least.cost)
