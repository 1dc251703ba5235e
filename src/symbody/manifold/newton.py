"""Newton's method for conditions whose solutions need not be isolated: from far away, and from near by.

`descend` starts anywhere and shortens steps until the residual falls. `correct` starts at the predictor of a
continuation and takes whole steps; where these do not shrink, the predictor leads elsewhere. Steps are in
sizes of the unknowns, conditions in sizes of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from symbody.tolerances import EXACT, NEGLIGIBLE, TINY

Floats = NDArray[np.float64]

_STEPS: Final = 80
# A step is halved until it gains a share of what it promises (Nocedal & Wright 2006, equation 3.4). One so
# short that this never happens ends where the residual is least; near rounding few trials show that.
_DECREASE: Final = 1e-3
_HALVINGS: Final = 12
_POLISHED: Final = 1e-12
_POLISHINGS: Final = 2
# Steps that together gain less do not lead to a solution within as many steps as there are.
_CRAWL: Final = 0.1
# Whole steps end where they reach farther than a size, or do not shrink to this share of the step before.
_CORRECTIONS: Final = 15
_SHRINKAGE: Final = 0.6
_GAIN: Final = 4.0  # residuals that fall by less are at their rounding


class Linearized(Protocol):
    """Conditions at a point."""

    @property
    def values(self) -> Floats:
        """The residuals (m,)."""

    @property
    def slopes(self) -> Floats:
        """Their derivatives (m, n) by the unknowns over their sizes."""


P = TypeVar("P", bound=Linearized)
Step = Callable[[Floats, Floats], Floats]


def least_step(values: Floats, slopes: Floats) -> Floats:
    """Return the least step of those that minimize ``|values + slopes step|`` (Gauss-Newton)."""
    return np.asarray(np.linalg.lstsq(slopes, -values, rcond=NEGLIGIBLE)[0])


def square_step(values: Floats, slopes: Floats) -> Floats:
    """Return the step that solves ``values + slopes step = 0``; LinAlgError if there is not exactly one."""
    return np.asarray(np.linalg.solve(slopes, -values), dtype=np.float64)


def damped_step(values: Floats, slopes: Floats) -> Floats:
    """Return the step that minimizes ``|values + slopes step|^2 + |values| |step|^2`` (Levenberg-Marquardt).

    Damped by the residual, steps converge quadratically to sets of solutions as well as to single ones (Fan &
    Yuan, Computing 74 (2005), 23-39). Undamped ones run into the crossing of branches from all about it.
    """
    n = slopes.shape[1]
    rows = np.vstack([slopes, np.sqrt(np.linalg.norm(values)) * np.eye(n)])
    return np.asarray(np.linalg.lstsq(rows, np.concatenate([-values, np.zeros(n)]), rcond=None)[0])


def descend(
    start: P,
    move: Callable[[P, Floats], P],
    step: Step = least_step,
    *,
    patience: int | None = None,
    limited: NDArray[np.bool_] | None = None,
) -> P:
    """Return the point to which steps lead from any start, whether or not the conditions hold there.

    Parameters
    ----------
    move : callable
        From a point and a step (n,), in sizes, to the point there.
    step : callable
        From values and slopes to a step.
    patience : int, optional
        Steps in which the residual has to fall by a tenth; otherwise the search ends.
    limited : (n,) array of bool, optional
        Mask of the unknowns along which a step is a size at most; by default all. Along those in which the
        conditions are linear, whole steps lead there, however far.
    """
    point, norm = start, float(np.linalg.norm(start.values))
    before = norm
    for count in range(_STEPS):
        if patience and count and count % patience == 0:
            if norm > (1.0 - _CRAWL) * before:
                break
            before = norm
        if norm < EXACT or not (norm < np.inf and np.isfinite(point.slopes).all()):
            break
        direction = step(point.values, point.slopes)
        bounded = direction if limited is None else direction[limited]
        share = min(1.0, 1.0 / max(_largest(bounded), TINY))
        for _ in range(_HALVINGS if norm > _POLISHED else _POLISHINGS):
            trial = move(point, share * direction)
            trial_norm = float(np.linalg.norm(trial.values))
            if trial_norm < (1.0 - _DECREASE * share) * norm:
                break
            share /= 2.0
        else:
            break
        point, norm = trial, trial_norm
    return point


def correct(start: P, move: Callable[[P, Floats], P], closed: float, step: Step = least_step) -> P | None:
    """Return the solution beside a predictor; None where whole steps do not converge to one.

    Parameters
    ----------
    move, step : callable
        As for `descend`.
    closed : float
        The largest residual of a solution; steps go on below it as long as they gain.
    """
    point, size, residual = start, 1.0 / _SHRINKAGE, np.inf
    for _ in range(_CORRECTIONS):
        before, residual = residual, _largest(point.values)
        if residual <= EXACT or (residual <= closed and residual > before / _GAIN):
            return point
        if not (residual < np.inf and np.isfinite(point.slopes).all()):
            return None
        direction = step(point.values, point.slopes)
        last, size = size, _largest(direction)
        if not (size <= _SHRINKAGE * last or residual <= closed):
            return None
        point = move(point, direction)
    return point if _largest(point.values) <= closed else None


def _largest(numbers: Floats) -> float:
    """Return the largest absolute value, 0 if there is none."""
    return float(np.abs(numbers).max(initial=0.0))
