"""Bodies on a plane, their rows by hand: what decides about contacts, and motions that follow from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeCandidate, ModeSolution, ModeVerdict, Responses, decide
from symbody.kernels.modes.mode_problem import CONE, HOLDS, LOOSE, UNILATERAL

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Plane:
    """Bodies that touch a plane in points.

    Attributes
    ----------
    mass : (n, n) array
    force : callable
        Of coordinates and speeds.
    gaps : (k, n) array
        Rates of the gaps by speeds; all are closed.
    slips : (2 k, n) array
        The same of slips, two a point.
    mu : float
    static : float
        Strength that holds; `mu` by default.
    """

    mass: Floats
    force: Floats
    gaps: Floats
    slips: Callable[[Floats], Floats]
    mu: float
    static: float = field(default=0.0)

    def responses(self, q: Floats) -> Responses:
        """Return responses in the order gap, slip, slip of each point."""
        rows = self.rows(q)
        inverse = np.linalg.inv(self.mass)
        count = len(self.gaps)
        reactions = np.zeros((count, 3 * count))
        reactions[np.arange(count), 3 * np.arange(count)] = 1.0
        return Responses(rows @ inverse @ self.force, rows @ inverse @ rows.T, np.zeros(count), reactions)

    def rows(self, q: Floats) -> Floats:
        slips = self.slips(q)
        return np.vstack([row for k, gap in enumerate(self.gaps) for row in (gap, *slips[2 * k : 2 * k + 2])])

    def decide(self, q: Floats, u: Floats, moving: Sequence[bool]) -> ModeSolution:
        slips = (self.slips(q) @ u).reshape(-1, 2)
        elements = []
        for slip, moves in zip(slips, moving, strict=True):
            size = float(np.hypot(*slip))
            way = (slip[0] / size, slip[1] / size) if moves else (0.0, 0.0)
            elements.append(ModeCandidate(UNILATERAL))
            elements.append(
                ModeCandidate(CONE, normals=1, sliding=self.mu, static=self.static or self.mu, moves=moves,
                          mode=LOOSE if moves else HOLDS, slip=way)
            )  # fmt: skip
        return decide(elements, self.responses(q))

    def slide(self, q: Floats, u: Floats, end: float) -> tuple[float, Floats, Floats]:
        """Return when the first slip ends, or the end, and the state there, from one in which all slip."""
        n = len(u)

        def rates(_t: float, x: Floats) -> Floats:
            solution = self.decide(x[:n], x[n:], [True] * len(self.gaps))
            assert solution.verdict is ModeVerdict.ONE
            forces = self.force + self.rows(x[:n]).T @ solution.efforts
            return np.concatenate([x[n:], np.linalg.solve(self.mass, forces)])

        first = (self.slips(q) @ u).reshape(-1, 2)

        def stops(_t: float, x: Floats) -> float:
            slips = (self.slips(x[:n]) @ x[n:]).reshape(-1, 2)
            return float(np.hypot(*slips.T).min() - 1e-9 * np.hypot(*first.T).max())

        stops.terminal = True  # type: ignore[attr-defined]
        run = scipy.integrate.solve_ivp(
            rates, (0.0, end), np.concatenate([q, u]), rtol=1e-10, atol=1e-12, events=stops
        )
        return float(run.t[-1]), run.y[:n, -1], run.y[n:, -1]
