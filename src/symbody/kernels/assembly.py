"""Assembly near a state: the nearest positions and speeds that fulfil the constraints, some of them held.

The block of an assembly holds its sizes, where its arrays begin, and these arrays. Its function writes the
position residuals, their derivatives by the coordinates, the velocity residuals, and J.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Function, Reals, part
from symbody.kernels.projection import worst_residual
from symbody.kernels.runge_kutta import call
from symbody.kernels.solve_saddle import solve_saddle

# Sizes: speeds, coordinates, position residuals, rows of J; then where arrays begin.
SPEEDS: Final = 0
COORDINATES: Final = 1
RESIDUALS: Final = 2
ROWS: Final = 3
HELD: Final = 4  # 1 for each state x = (u, q) that keeps its value, else 0
SIZES: Final = 5  # what counts as a large change of each state
SCALES: Final = 6  # the largest position residuals that count as closed
OUT: Final = 7
OUT_SIZE: Final = 8
MATRICES: Final = 9
NUMBERS: Final = 10  # of the function
HEADER: Final = 12

MOST_ROUNDS: Final = 60
LONGEST: Final = 0.3  # move of a coordinate in one round, over its size
STILL: Final = 1e-13  # a move, over sizes, that changes nothing any more
ROUNDED: Final = 1e3  # a residual over what counts as closed that rounding may leave
CLOSED: Final = 1e-8  # of a velocity residual, over the sum of its terms

# What `assemble` returns.
ASSEMBLED: Final = 0
POSITIONS_FAIL: Final = 1
SPEEDS_FAIL: Final = 2


def least_move(A: Reals, first: int, n: int, m: int, slopes: Reals, residuals: Reals) -> int:
    """Store the least move of n states from the first on that takes away m residuals to first order.

    The move lies behind the matrices; held states do not move. Returns 0 if there is one.
    """
    held = part(A, int(A[HELD]) + first, n)
    sizes = part(A, int(A[SIZES]) + first, n)
    place = int(A[MATRICES])
    result = part(A, place, n + m + 1)
    place = place + n + m + 1
    M = part(A, place, n * n)
    place = place + n * n
    J = part(A, place, m * n)
    place = place + m * n
    F = part(A, place, n)
    gamma = part(A, place + n, m)
    work = part(A, place + n + m, 1)
    for i in range(n):
        for j in range(n):
            M[i * n + j] = 0.0
        M[i * n + i] = 1.0  # moves are counted in sizes
        F[i] = 0.0
    for k in range(m):
        for i in range(n):
            J[k * n + i] = slopes[k * n + i] * sizes[i]
            if held[i] != 0.0:
                J[k * n + i] = 0.0
        gamma[k] = -residuals[k]
    return solve_saddle(n, m, M, J, F, gamma, result, work)


def largest(n: int, values: Reals) -> float:
    """Return the largest magnitude of n values."""
    worst = 0.0
    for i in range(n):
        worst = max(worst, abs(values[i]))
    return worst


def assemble_positions(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move the coordinates of x = (u, q) onto the constraints by Newton's method with bounded moves."""
    n_u = int(A[SPEEDS])
    n = int(A[COORDINATES])
    count = int(A[RESIDUALS])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    scales = part(A, int(A[SCALES]), count)
    sizes = part(A, int(A[SIZES]) + n_u, n)
    moves = part(A, int(A[MATRICES]), n)
    numbers = part(A, int(A[NUMBERS]), 1)
    move = 1.0
    for _round in range(MOST_ROUNDS):
        if call(h, n_u, numbers, t, x, out) != 0:
            return POSITIONS_FAIL
        worst = worst_residual(count, out, scales)
        if worst <= 1.0:
            return ASSEMBLED
        if move < STILL and worst <= ROUNDED:
            return ASSEMBLED
        if least_move(A, n_u, n, count, part(out, count, count * n), out) != 0:
            return POSITIONS_FAIL
        move = largest(n, moves)
        share = min(1.0, LONGEST / max(move, STILL))
        for i in range(n):
            x[n_u + i] = x[n_u + i] + share * moves[i] * sizes[i]
    return POSITIONS_FAIL


def assemble_speeds(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move the speeds of x = (u, q) onto the constraints."""
    n = int(A[SPEEDS])
    m = int(A[ROWS])
    count = int(A[RESIDUALS])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    sizes = part(A, int(A[SIZES]), n)
    moves = part(A, int(A[MATRICES]), n)
    numbers = part(A, int(A[NUMBERS]), 1)
    first = count + count * int(A[COORDINATES])
    if call(h, n, numbers, t, x, out) != 0:
        return SPEEDS_FAIL
    if least_move(A, 0, n, m, part(out, first + m, m * n), part(out, first, m)) != 0:
        return SPEEDS_FAIL
    for i in range(n):
        x[i] = x[i] + moves[i] * sizes[i]
    if call(h, n, numbers, t, x, out) != 0:
        return SPEEDS_FAIL
    for k in range(m):
        terms = 0.0
        for i in range(n):
            terms = terms + abs(out[first + m + k * n + i]) * max(abs(x[i]), sizes[i])
        if not abs(out[first + k]) <= CLOSED * terms:
            return SPEEDS_FAIL
    return ASSEMBLED


def assemble(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move a state x = (u, q) onto the constraints, those that are held aside; return how that ended."""
    result = assemble_positions(h, A, t, x)
    if result != ASSEMBLED:
        return result
    return assemble_speeds(h, A, t, x)


def matrices_size(n: int, m: int) -> int:
    """Return how many numbers the matrices of a move take."""
    return n + m + 1 + n * n + m * n + n + m + 6 * n + 4 * m + n * (m + n)
