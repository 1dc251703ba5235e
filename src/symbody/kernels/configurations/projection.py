"""StateProjection of a state onto the constraints."""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import Run, StateProjection
from symbody.kernels.language import INFINITY, Function, Reals, half, is_finite, part, sqrt
from symbody.kernels.runge_kutta import call

MOST_ROUNDS: Final = 8
# How many states stand for a state with other last digits, and by how much these differ: two roundings.
ROUNDED_STATES: Final = 4
ROUNDED: Final = 4.4e-16


def project(g: Function, run: Run, t: float, x: Reals) -> float:
    """Move a state onto the constraints: positions by Newton's method, then velocities.

    Returns the root mean square of the moves over the tolerated errors, infinite if the constraints are out
    of reach.
    """
    projection = run.projection
    n_u = run.speeds
    n_q = projection.coordinates
    count = projection.residuals
    out = projection.out
    numbers = projection.numbers
    scales = projection.scales
    rtol = run.goal.rtol
    atol = run.tolerances
    moved = 0.0
    for turn in range(MOST_ROUNDS + 1):
        if call(g, n_u, numbers, t, x, out) != 0:
            return INFINITY
        worst = worst_residual(count, out, scales)
        if worst <= 1.0:
            break
        if worst == INFINITY:
            return INFINITY
        # Two rounds of Newton's method leave nothing of a drift but rounding, which may be what is left.
        if turn >= 2:
            if worst <= resolution(n_u, n_q, projection, x):
                break
        if turn == MOST_ROUNDS:
            return INFINITY
        for i in range(n_q):
            x[n_u + i] = x[n_u + i] + out[count + i]
        moved = moved + squares(rtol, atol, n_u, n_q, part(x, n_u, n_q), part(out, count, n_q))
    first = projection.out_size - n_u
    for i in range(n_u):
        x[i] = x[i] + out[first + i]
    moved = moved + squares(rtol, atol, 0, n_u, x, part(out, first, n_u))
    return sqrt(moved / max(n_u + n_q, 1))


def worst_residual(count: int, residuals: Reals, scales: Reals) -> float:
    """Return the largest residual over what counts as closed, infinite if one is not finite."""
    worst = 0.0
    for i in range(count):
        size = abs(residuals[i]) / scales[i]
        if not is_finite(size):
            return INFINITY
        worst = max(worst, size)
    return worst


def rounding_move(g: Function, run: Run, t: float, x: Reals, rounded: Reals) -> float:
    """Return how far the constraints would move a state if rounding had it, in the measure of `project`.

    A closed state whose last digits change shows what rounding makes of small parts of large motions, such
    as the velocity across the plane in which a mechanism moves fast. The state itself says little: its moves
    have been taken out of it. `rounded` is scratch.
    """
    projection = run.projection
    n_u = run.speeds
    n_q = projection.coordinates
    count = projection.residuals
    out = projection.out
    first = projection.out_size - n_u
    numbers = projection.numbers
    rtol = run.goal.rtol
    atol = run.tolerances
    most = 0.0
    sign = 1.0
    for _state in range(ROUNDED_STATES):
        for i in range(n_u + n_q):
            # signs without a pattern, the same every time: bits of a linear congruence modulo 65537
            sign = sign * 75.0 + 74.0
            sign = sign - 65537.0 * int(sign / 65537.0)
            bits = int(sign / 1024.0)
            change = -ROUNDED
            if bits != 2 * half(bits):
                change = ROUNDED
            rounded[i] = x[i] * (1.0 + change)
        if call(g, n_u, numbers, t, rounded, out) != 0:
            return 0.0
        moved = squares(rtol, atol, n_u, n_q, part(rounded, n_u, n_q), part(out, count, n_q))
        moved = moved + squares(rtol, atol, 0, n_u, rounded, part(out, first, n_u))
        most = max(most, moved)
    size = sqrt(most / max(n_u + n_q, 1))
    if not is_finite(size):
        return 0.0
    return size


def resolution(n_u: int, n_q: int, projection: StateProjection, x: Reals) -> float:
    """Return how small the residuals can get, over what counts as closed; 1 if that can be resolved."""
    farthest = 1.0
    for i in range(n_q):
        farthest = max(farthest, abs(x[n_u + i]) / projection.sizes[i])
    return max(1.0, projection.rounding * farthest)


def squares(rtol: float, atol: Reals, first: int, size: int, x: Reals, moves: Reals) -> float:
    """Return the sum of squares of moves of the states x from `first` on, over tolerated errors."""
    total = 0.0
    for i in range(size):
        share = moves[i] / (atol[first + i] + rtol * abs(x[i]))
        total = total + share * share
    return total


def project_new_state(g: Function, run: Run, t_new: float) -> float:
    """Project the new state; return how far it moved, negative if that was too far.

    What the state before the step would need if rounded otherwise is not the fault of the step; a shorter one
    mends nothing.
    """
    moved = project(g, run, t_new, run.state_new)
    limit = run.projection.limit
    if not moved <= limit:
        old = run.state_old
        if not moved <= limit * rounding_move(g, run, run.time, old, run.error_2):
            return -1.0
    return moved
