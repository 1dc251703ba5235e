"""`ConstraintManifold`: the configurations on which constraints ``Phi(q) = 0`` hold.

Coordinates are measured in sizes (1 for angles, a length of the mechanism for lengths) and constraints
likewise, so that all numbers here are of order one and without units. The norms of quaternions are among the
constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.manifold.newton import Step, correct, damped_step, descend
from symbody.manifold.ranks import null_space, unit_rows
from symbody.tolerances import CLOSED, FAR, NEGLIGIBLE

Floats = NDArray[np.float64]


class LinearConstraints(NamedTuple):
    """Constraints at a configuration, or at several (leading axes), to first order.

    Attributes
    ----------
    q : (.., n) array
    values : (.., m) array
        In their scales.
    slopes : (.., m, f) array
        Derivatives by those of ``q / sizes`` that may move.
    """

    q: Floats
    values: Floats
    slopes: Floats


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
        From q (.., n) to the values (.., m) of the constraints and their derivatives (.., m, n), row by row.
    sizes : (n,) array
        Size of each coordinate.
    scales : (m,) array
        Size of each constraint.
    quaternions : sequence of four places
        Coordinates that are components of unit quaternions.
    admits : callable
        Whether a configuration on which all constraints hold is one of the mechanism: the equations of a
        hinge hold with opposite axes, too.
    free : (n,) array of bool or None
        Mask of the coordinates that may move; None: all.
    closed : float
        The largest residual of constraints that hold.
    curved : (n,) array of bool or None
        Mask of the coordinates in which constraints are not linear: steps are limited along these; None: all.
    linear : (m,) array of bool or None
        Mask of the constraints that are linear in what may move; None: none is.
    """

    evaluate: Callable[[Floats], Sequence[ArrayLike]]
    sizes: Floats
    scales: Floats
    quaternions: Sequence[Sequence[int]] = ()
    admits: Callable[[Floats], bool] = lambda q: True
    free: NDArray[np.bool_] | None = None
    closed: float = CLOSED
    curved: NDArray[np.bool_] | None = None
    linear: NDArray[np.bool_] | None = None

    def constraints(self, q: Floats) -> LinearConstraints:
        """Return values and derivatives of the constraints, norms of quaternions included."""
        evaluated, derivatives = self.evaluate(q)
        shape = (*q.shape[:-1], self.scales.size, self.sizes.size)
        values: Floats = np.asarray(evaluated, dtype=np.float64) / self.scales
        slopes: Floats = np.asarray(derivatives, dtype=np.float64).reshape(shape)
        slopes = slopes * self.sizes / self.scales[:, np.newaxis]
        if len(self.quaternions):
            places = np.array(self.quaternions, dtype=np.intp)
            parts = q[..., places]
            rows = np.zeros((*q.shape[:-1], len(places), q.shape[-1]))
            rows[..., np.arange(len(places))[:, np.newaxis], places] = parts
            norms = ((parts**2).sum(axis=-1) - 1.0) / 2.0
            values, slopes = np.concatenate([values, norms], -1), np.concatenate([slopes, rows], -2)
        return LinearConstraints(q, values, slopes if self.free is None else slopes[..., self.free])

    def jacobian(self, q: Floats) -> Floats:
        """Return the derivatives (m', f) of the constraints by what may move of ``q / sizes``."""
        return self.constraints(q).slopes

    def tangent(self, q: Floats) -> Floats:
        """Return an orthonormal basis (f, d) of the directions that the constraints admit to first order."""
        return null_space(unit_rows(self.jacobian(q)))

    def tolerance(self, q: Floats) -> float:
        """Return the largest residual of constraints that hold at coordinates as large as these."""
        return max(self.closed, FAR * float(np.abs(q / self.sizes).max(initial=0.0)))

    def project(self, guess: ArrayLike, step: Step = damped_step) -> Configuration:
        """Return a configuration on the constraints near a guess, by steps of a kind.

        Where linear constraints demand a long way along coordinates in which others are not linear, they are
        met first, by one step.
        """
        start = self.constraints(np.array(guess, dtype=np.float64))
        limited = self.curved if self.curved is None or self.free is None else self.curved[self.free]
        if self.linear is not None and limited is not None and self.linear.any():
            move = self._linear_move(start)
            if np.abs(move[limited]).max(initial=0.0) > 1.0:
                start = self.constraints(self._step_from(start.q, move))
        q, values, slopes = descend(
            start, lambda point, move: self.constraints(self._step_from(point.q, move)), step, limited=limited
        )
        return self._judge(q, values, slopes)

    def contradicts(self, q: Floats) -> bool:
        """Return whether linear constraints alone exclude every configuration with what is held as in `q`."""
        if self.linear is None or not self.linear.any():
            return False
        start = self.constraints(q)
        for cut in (NEGLIGIBLE, None):  # one loses directions of long chains, the other rests on rounding
            point = start
            for _ in range(2):  # the second takes away the rounding of the first
                point = self.constraints(self._step_from(point.q, self._linear_move(point, cut)))
            values = np.abs(point.values[: self.linear.size][self.linear])
            if values.max(initial=0.0) <= self.tolerance(point.q):
                return False
        return True

    def _linear_move(self, point: LinearConstraints, cut: float | None = NEGLIGIBLE) -> Floats:
        """Return the least step, in sizes, that meets the linear constraints as well as they can be met."""
        rows = np.flatnonzero(() if self.linear is None else self.linear)
        return np.asarray(np.linalg.lstsq(point.slopes[rows], -point.values[rows], rcond=cut)[0])

    def judge(self, q: Floats) -> Configuration:
        """Return a configuration as it is, with how far it is from the constraints."""
        point = self.constraints(q)
        return self._judge(q, point.values, point.slopes)

    def _judge(self, q: Floats, values: Floats, slopes: Floats) -> Configuration:
        residual = float(np.abs(values).max(initial=0.0))
        is_closed = residual <= self.tolerance(q) and bool(np.isfinite(slopes).all()) and self.admits(q)
        return Configuration(q, residual, is_closed)

    def correct(self, guess: Floats, plane: tuple[Floats, float] | None = None) -> Floats | None:
        """Return the configuration on the constraints beside a guess, by whole steps, or None.

        Parameters
        ----------
        plane : (n,) array and number, optional
            One more condition, ``normal @ q / sizes = number``.
        """

        def evaluate(q: Floats) -> LinearConstraints:
            point = self.constraints(q)
            if plane is None:
                return point
            values = np.append(point.values, plane[0] @ (q / self.sizes) - plane[1])
            return LinearConstraints(q, values, np.vstack([point.slopes, plane[0]]))

        end = correct(
            evaluate(guess),
            lambda point, move: evaluate(self._step_from(point.q, move)),
            self.tolerance(guess),
        )
        return None if end is None else end.q

    def _step_from(self, q: Floats, move: Floats) -> Floats:
        """Return coordinates after a step of those that may move, in sizes."""
        if self.free is None:
            return np.asarray(q + move * self.sizes)
        result = q.copy()
        result[self.free] += move * self.sizes[self.free]
        return result


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
