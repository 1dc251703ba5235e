"""The constraints of a mechanism at one state, and those of a tree, which has none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class ConstraintValues(NamedTuple):
    """Constraints on positions (n_h,), on velocities at rest (n_c,), their Jacobians, and cosines of axes."""

    constraints: Floats
    position_jacobian: Floats
    jacobian: Floats
    velocity_constraints: Floats
    alignment: Floats


@dataclass(frozen=True, slots=True)
class Unconstrained:
    """The constraints of a tree, for which nothing has to be compiled."""

    coordinates: int
    speeds: int

    def __call__(self, t: float, q: Floats, u: Floats) -> ConstraintValues:
        """Return no values, with as many columns as there are coordinates (n_q,) and speeds (n_u,)."""
        none = np.zeros(0)
        return ConstraintValues(none, np.zeros((0, self.coordinates)), np.zeros((0, self.speeds)), none, none)
