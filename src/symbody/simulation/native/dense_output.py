"""A motion between its stored samples: one polynomial per step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.errors import Problem, UsageError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class DenseOutput:
    """Piecewise polynomial in time, in the nested form of Hairer, Norsett and Wanner, section II.6.

    With s the share of the step that has passed and F its rows, the state is
    ``F0 + s (F1 + (1 - s) (F2 + s (F3 + (1 - s) (F4 + ...))))``; four rows alone are the cubic of Hermite.

    Attributes
    ----------
    breaks : (steps + 1,) array
        Ends of the steps, rising or falling [s].
    pieces : (steps, rows, n) array
        F of each step.
    """

    breaks: Floats
    pieces: Floats

    def __call__(self, t: ArrayLike) -> Floats:
        """Return the states at times of any shape: (n, *shape).

        Raises
        ------
        UsageError
            Times outside the motion.
        """
        times = np.asarray(t, dtype=np.float64)
        self._check_range(times)
        direction = 1.0 if self.breaks[-1] >= self.breaks[0] else -1.0
        step = np.searchsorted(direction * self.breaks, direction * times, side="right") - 1
        step = np.clip(step, 0, self.pieces.shape[0] - 1)
        length = self.breaks[step + 1] - self.breaks[step]
        passed = times - self.breaks[step]
        share = np.divide(passed, length, out=np.zeros_like(passed), where=length != 0.0)[..., np.newaxis]
        value: Floats = np.zeros((*times.shape, self.pieces.shape[2]))
        for row in range(self.pieces.shape[1] - 1, 0, -1):
            value = (value + self.pieces[step, row]) * (share if row % 2 == 1 else 1.0 - share)
        return np.moveaxis(self.pieces[step, 0] + value, -1, 0)

    def at_breaks(self) -> Floats:
        """Return the states at the ends of all steps (n, steps + 1)."""
        starts, end = self.pieces[:, 0], self.pieces[-1:, 0] + self.pieces[-1:, 1]
        return np.concatenate([starts, end]).T

    def at_end(self) -> Floats:
        """Return the state at the end of the last step (n,)."""
        end: Floats = self.pieces[-1, 0] + self.pieces[-1, 1]
        return end

    def _check_range(self, times: Floats) -> None:
        first, last = sorted((float(self.breaks[0]), float(self.breaks[-1])))
        outside = times[~((times >= first) & (times <= last))]
        if outside.size:
            raise UsageError(
                Problem(
                    "simulation.time_outside",
                    "at",
                    f"t = {outside.flat[0]:g} lies outside the motion, which runs from {first:g} to {last:g}",
                    fix="ask for times in that range, or simulate for longer",
                )
            )


def shorten(piece: Floats, share: float) -> Floats:
    """Return the first `share` of a step's polynomial as the polynomial of a step of its own."""
    nodes, to_rows = cut_matrix(piece.shape[0])
    result = to_rows @ (_basis(share * nodes, piece.shape[0]) @ piece)
    result[0] = piece[0]
    return np.asarray(result, dtype=np.float64)


@cache
def cut_matrix(rows: int) -> tuple[Floats, Floats]:
    """Return shares of a step (rows,), and the matrix from the states there to its piece."""
    nodes = (1.0 - np.cos(np.pi * np.arange(rows) / (rows - 1))) / 2.0
    return nodes, np.asarray(np.linalg.inv(_basis(nodes, rows)), dtype=np.float64)


def _basis(s: Floats, rows: int) -> Floats:
    """Return what multiplies each row of a piece at shares of the step, (places, rows)."""
    factors = [np.ones_like(s), *(s if row % 2 == 1 else 1.0 - s for row in range(1, rows))]
    return np.asarray(np.cumprod(np.array(factors), axis=0).T, dtype=np.float64)
