"""Projection of a state onto the constraints, as part of the compiled loop.

The cache of the compiled loop does not see a change of this file: touch `native_loop.py` after one.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.simulation.native_interface import Floats, Projector, call, inlined

MOST_ROUNDS: Final = 8


@inlined
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
        if worst <= 1.0:
            break
        if rounds == MOST_ROUNDS:
            return np.inf
        for i in range(n_q):
            move = out[0, count + i]
            x[row, n_u + i] += move
            moved += (move / (atol[n_u + i] + rtol * abs(x[row, n_u + i]))) ** 2
    first = out.shape[1] - n_u
    for i in range(n_u):
        move = out[0, first + i]
        x[row, i] += move
        moved += (move / (atol[i] + rtol * abs(x[row, i]))) ** 2
    size: float = np.sqrt(moved / max(n_u + n_q, 1))
    return size
