"""The curve on which the positions of a mechanism with one freedom lie, by steps along its tangent.

The length of the curve is its parameter (Keller 1977; Allgower & Georg 1990, chapter 2), so that a coordinate
may turn back on the way. At a bifurcation the tangent is not unique; the curve goes straight on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.kinematics.continuation import Continuation
from symbody.manifold import count_significant
from symbody.tolerances import SINGULAR, TINY

Floats = NDArray[np.float64]

_STEP: Final = 0.05  # rad, or share of the mechanism's size
_TURN: Final = 0.9  # cosine between tangents of neighbours
_SHORTEST: Final = 1e-7
_MOST: Final = 20_000


class PathPoint(NamedTuple):
    """A position, and the direction in which the curve goes on, in scaled coordinates."""

    q: Floats
    tangent: Floats


@dataclass(frozen=True, slots=True, eq=False)
class PositionCurve:
    """The positions of a mechanism whose other freedoms are held."""

    mechanism: Continuation

    def start(self, q: Floats) -> PathPoint | None:
        """Return a point of the curve; None where the curve has no single tangent."""
        directions = self._directions(q)
        if directions.shape[1] != 1:
            return None
        return PathPoint(q, directions[:, 0])

    def trace(self, first: PathPoint, inside: Callable[[Floats], bool]) -> tuple[list[PathPoint], bool]:
        """Return points from the first on, until one lies outside; and whether the curve is closed."""
        points, step = [first], _STEP
        while len(points) < _MOST:
            last = points[-1]
            point = self.advance(last, step)
            if point is None or point.tangent @ last.tangent < _TURN:
                step /= 2.0
                if step < _SHORTEST:
                    return points, False
                continue
            points.append(point)
            if not inside(point.q):
                return points, False
            if len(points) > 3 and self._has_returned(first, last, point):
                return points, True
            step = min(1.5 * step, _STEP)
        return points, False

    def advance(self, point: PathPoint, length: float) -> PathPoint | None:
        """Return the point whose projection on the tangent lies at a length from another point."""
        sizes = self.mechanism.sizes
        place = float(point.tangent @ (point.q / sizes)) + length
        q = self.mechanism.correct(0.0, point.q + length * point.tangent * sizes, (point.tangent, place))
        if q is None:
            return None
        directions = self._directions(q)
        along = directions @ (directions.T @ point.tangent)
        norm = float(np.linalg.norm(along))
        return None if norm < _TURN else PathPoint(q, along / norm)

    def _directions(self, q: Floats) -> Floats:
        """Return orthonormal directions in scaled coordinates in which the mechanism may move."""
        mechanism = self.mechanism
        still = np.zeros(mechanism.speed_sizes.size)
        jacobian = mechanism.rows(0.0, q, still)[0]
        singular, right = np.linalg.svd(mechanism.scaled_rows(jacobian))[1:]
        count = min(count_significant(singular, SINGULAR), len(q) - 1, right.shape[0] - 1)
        basis = right[count:].T * mechanism.speed_sizes[:, np.newaxis]
        still_rates = mechanism.qdot(0.0, q, still)
        moves = [(mechanism.qdot(0.0, q, u) - still_rates) / mechanism.sizes for u in basis.T]
        orthonormal: Floats = np.linalg.qr(np.array(moves).T)[0]
        return orthonormal

    def _has_returned(self, first: PathPoint, last: PathPoint, found: PathPoint) -> bool:
        """Return whether the first point lies between two neighbours."""
        way = (found.q - last.q) / self.mechanism.sizes
        back = self.difference(first.q, last.q)
        length = float(np.linalg.norm(way))
        share = float(back @ way) / max(length, TINY) ** 2
        aside = float(np.linalg.norm(back - share * way))
        return 0.0 < share <= 1.0 and aside < 0.1 * length and float(first.tangent @ found.tangent) > _TURN

    def difference(self, a: Floats, b: Floats) -> Floats:
        """Return the difference of two positions in scaled coordinates, angles within half a turn."""
        apart: Floats = (a - b) / self.mechanism.sizes
        return np.where(self.mechanism.angles, np.arctan2(np.sin(apart), np.cos(apart)), apart)

    def contains(self, points: list[PathPoint], q: Floats) -> bool:
        """Return whether a position lies on the curve through points."""
        apart = self.difference(q, np.array([point.q for point in points]))
        near = points[int(np.abs(apart).max(axis=1).argmin())]
        ahead = float(near.tangent @ self.difference(q, near.q))
        if abs(ahead) > 2.0 * _STEP:
            return False
        end = self.advance(near, ahead)
        return end is not None and bool(np.abs(self.difference(q, end.q)).max() < 1e-6)
