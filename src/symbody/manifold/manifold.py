"""`ConstraintManifold`: the configurations on which constraints ``Phi(q) = 0`` hold.

Coordinates are measured in sizes (1 for angles, a length of the mechanism for lengths) and constraints
likewise, so that all numbers here are of order one and without units. The norms of quaternions are among the
constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.manifold.ranks import null_space
from symbody.manifold.tolerances import CLOSED, EXACT

Floats = NDArray[np.float64]

_ITERATIONS: Final = 80
# A step is halved until it gains a share of what it promises (Nocedal & Wright 2006, equation 3.4).
_HALVINGS: Final = 12
_DECREASE: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Configuration:
    """A configuration near a guess, on the constraints or as near to them as steps lead.

    Attributes
    ----------
    q : (n,) array
    residual : float
        The largest constraint that is left, in sizes.
    is_closed : bool
        Whether all constraints hold there.
    """

    q: Floats
    residual: float
    is_closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class ConstraintManifold:
    """Constraints on positions.

    Attributes
    ----------
    evaluate : callable
        From q (n,) to the values (m,) of the constraints and their derivatives (m, n), row by row.
    sizes : (n,) array
        What counts as one for each coordinate.
    scales : (m,) array
        What counts as one for each constraint.
    quaternions : sequence of four places
        Coordinates that are components of unit quaternions.
    admits : callable
        Whether a configuration on which all constraints hold is one of the mechanism: the equations of a
        hinge hold with opposite axes, too.
    """

    evaluate: Callable[[Floats], Sequence[ArrayLike]]
    sizes: Floats
    scales: Floats
    quaternions: Sequence[Sequence[int]] = ()
    admits: Callable[[Floats], bool] = lambda q: True

    def constraints(self, q: Floats) -> tuple[Floats, Floats]:
        """Return values (m',) and derivatives (m', n) by ``q / sizes``, norms of quaternions included."""
        values, slopes = (np.asarray(part, dtype=np.float64) for part in self.evaluate(q))
        slopes = slopes.reshape(self.scales.size, self.sizes.size)
        parts, rows = [values / self.scales], [slopes * self.sizes / self.scales[:, np.newaxis]]
        for places in self.quaternions:
            row = np.zeros((1, q.size))
            row[0, list(places)] = q[list(places)]
            parts.append(np.array([(q[list(places)] @ q[list(places)] - 1.0) / 2.0]))
            rows.append(row)
        return np.concatenate(parts), np.vstack(rows)

    def jacobian(self, q: Floats) -> Floats:
        """Return the derivatives (m', n) of the constraints by ``q / sizes``."""
        return self.constraints(q)[1]

    def tangent(self, q: Floats) -> Floats:
        """Return an orthonormal basis (n, d) of the directions that the constraints admit to first order."""
        return null_space(self.jacobian(q))

    def project(self, guess: ArrayLike) -> Configuration:
        """Return a configuration on the constraints near a guess.

        Levenberg-Marquardt steps damped by the residual: they converge quadratically to sets of solutions as
        well as to single ones (Fan & Yuan, Computing 74 (2005), 23-39). Newton's method, undamped, runs into
        the crossing of branches from all about it.
        """
        q = np.array(guess, dtype=np.float64)
        values, slopes = self.constraints(q)
        norm = float(np.linalg.norm(values))
        for _ in range(_ITERATIONS):
            if not (np.isfinite(norm) and np.isfinite(slopes).all()) or norm < EXACT:
                break
            step = _damped_step(values, slopes, norm)
            share = min(1.0, 1.0 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
            for _ in range(_HALVINGS):
                trial = q + share * step * self.sizes
                new_values, new_slopes = self.constraints(trial)
                new_norm = float(np.linalg.norm(new_values))
                if new_norm < (1.0 - _DECREASE * share) * norm:
                    break
                share /= 2.0
            else:
                break
            q, values, slopes, norm = trial, new_values, new_slopes, new_norm
        residual = float(np.abs(values).max(initial=0.0))
        is_closed = residual <= CLOSED and bool(np.isfinite(slopes).all()) and self.admits(q)
        return Configuration(q, residual, is_closed)


def constraint_manifold(
    evaluate: Callable[[Floats], Sequence[ArrayLike]],
    sizes: Sequence[float],
    scales: Sequence[float],
    quaternions: Sequence[Sequence[int]] = (),
    admits: Callable[[Floats], bool] = lambda q: True,
) -> ConstraintManifold:
    """Return the manifold of constraints whose sizes and scales are lists of numbers."""
    return ConstraintManifold(
        evaluate, np.array(sizes, dtype=np.float64), np.array(scales, dtype=np.float64), quaternions, admits
    )


def _damped_step(values: Floats, slopes: Floats, damping: float) -> Floats:
    """Return the step s that minimizes ``|values + slopes s|^2 + damping |s|^2``."""
    n = slopes.shape[1]
    rows = np.vstack([slopes, np.sqrt(damping) * np.eye(n)])
    return np.asarray(np.linalg.lstsq(rows, np.concatenate([-values, np.zeros(n)]), rcond=None)[0])
