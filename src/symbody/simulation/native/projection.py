"""Projection of a state onto the constraints, as part of the compiled loop.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.simulation.native.interface import Floats, Projector, call, inline

MOST_ROUNDS: Final = 8
# How many states stand for a state with other last digits, and by how much these differ: two roundings.
ROUNDED_STATES: Final = 4
ROUNDED: Final = 4.4e-16


@inline
def project(projector: Projector, rtol: float, atol: Floats, t: float, x: Floats, row: int) -> float:
    """Move x[row] onto the constraints: positions by Newton's method, then velocities.

    Returns the root mean square of the moves over the tolerated errors, infinite if the constraints are out
    of reach.
    """
    n, n_u, n_q, count = x.shape[1], projector.n_u, projector.n_q, projector.scales.size
    out = projector.out
    moved = 0.0
    for rounds in range(MOST_ROUNDS + 1):
        projector.clock[0] = t
        if call(projector, x, row * n, out, 0) != 0:
            return np.inf
        worst = 0.0
        for i in range(count):
            worst = max(worst, abs(out[0, i]) / projector.scales[i])
        if not np.isfinite(worst):
            return np.inf
        # Two rounds of Newton's method leave nothing of a drift but rounding, which may be what is left.
        if worst <= 1.0 or (rounds >= 2 and worst <= _resolution(projector, x, row)):
            break
        if rounds == MOST_ROUNDS:
            return np.inf
        for i in range(n_q):
            x[row, n_u + i] += out[0, count + i]
        moved += _squares(rtol, atol, x, row, n_u, n_q, out, count)
    first = out.shape[1] - n_u
    for i in range(n_u):
        x[row, i] += out[0, first + i]
    moved += _squares(rtol, atol, x, row, 0, n_u, out, first)
    size: float = np.sqrt(moved / max(n_u + n_q, 1))
    return size


@inline
def asked_move(
    projector: Projector, rtol: float, atol: Floats, t: float, x: Floats, row: int, scratch: int
) -> float:
    """Return how far the constraints would move x[row] if rounding had it, in the measure of `project`.

    A closed state whose last digits change asks for what rounding makes of small parts of large motions, such
    as the velocity across the plane in which a mechanism moves fast. The state itself says little: its moves
    have been taken out of it. x[scratch] is overwritten.
    """
    out, n_u, n_q, n = projector.out, projector.n_u, projector.n_q, x.shape[1]
    most = 0.0
    sign = 1
    for _ in range(ROUNDED_STATES):
        for i in range(n):
            sign = (sign * 75 + 74) % 65537  # signs without a pattern, the same every time
            x[scratch, i] = x[row, i] * (1.0 + (ROUNDED if sign & 1024 else -ROUNDED))
        projector.clock[0] = t
        if call(projector, x, scratch * n, out, 0) != 0:
            return 0.0
        moved = _squares(rtol, atol, x, scratch, n_u, n_q, out, projector.scales.size)
        moved += _squares(rtol, atol, x, scratch, 0, n_u, out, out.shape[1] - n_u)
        most = max(most, moved)
    size: float = np.sqrt(most / max(n_u + n_q, 1))
    return size if np.isfinite(size) else 0.0


@inline
def _resolution(projector: Projector, x: Floats, row: int) -> float:
    """Return how small the residuals can get, over what counts as closed; 1 if that can be resolved."""
    farthest = 1.0
    for i in range(projector.n_q):
        farthest = max(farthest, abs(x[row, projector.n_u + i]) / projector.sizes[i])
    return max(1.0, projector.rounding * farthest)


@inline
def _squares(
    rtol: float, atol: Floats, x: Floats, row: int, first: int, size: int, out: Floats, place: int
) -> float:
    """Return the sum of squares of moves out[place:] of the states from `first` on, over tolerated errors."""
    total = 0.0
    for i in range(size):
        state = first + i
        total += (out[0, place + i] / (atol[state] + rtol * abs(x[row, state]))) ** 2
    return total
