"""Assembly near a state: the nearest positions that fulfil the constraints, some of them held.

The block of an assembly holds its sizes, where its arrays begin, and these arrays. Its function writes the
constraints on positions, their derivatives by the coordinates, the velocity residuals, and J.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

# Sizes: speeds, coordinates, constraints on positions, rows of J; then where arrays begin.
SPEEDS: Final = 0
COORDINATES: Final = 1
RESIDUALS: Final = 2
ROWS: Final = 3
HELD: Final = 4  # 1 for each state x = (u, q) that keeps its value, else 0
SIZES: Final = 5  # what counts as a large change of each state
SCALES: Final = 6  # what counts as a large residual of each constraint on positions
OUT: Final = 7
OUT_SIZE: Final = 8
MATRICES: Final = 9
NUMBERS: Final = 10  # of the function
OLD: Final = 11  # states before a move
SHARE: Final = 12  # the residual, over sizes, of constraints that count as closed
QUATERNIONS: Final = 13  # how many; their places in q
QUATERNION_PLACES: Final = 14
ENOUGH: Final = 21  # the residual from which on nothing is moved
WEIGHED: Final = 22  # whether the function writes the mass matrix behind J: see `closing`
LIMITED: Final = 23  # 1 for each coordinate that moves by a size at most in a step, 0 for linear ones
# Substituted coordinates that a closing counts in, see `closing`: how many with their rates, how many states
# they are left out of; where flags of held ones of these states begin, the places of these states and of
# what is left out among all, and all states.
FOLLOWERS: Final = 24
STATES: Final = 25
ASKED: Final = 26
PLACES: Final = 27
FOLLOWER_PLACES: Final = 28
WHOLE: Final = 29
HEADER: Final = 30

# As in `symbody.manifold.newton`, which says why: residuals over their sizes, moves over those of states.
MOST_ROUNDS: Final = 80
DECREASE: Final = 1e-3
HALVINGS: Final = 12
POLISHED: Final = 1e-12
POLISHINGS: Final = 2
FAR: Final = 1e-14
TINY: Final = 1e-300
NEGLIGIBLE: Final = 1e-10  # of a row beside others
CLOSED: Final = 1e-8  # of a velocity residual, over the sum of its terms

# What `assemble` returns.
ASSEMBLED: Final = 0
POSITIONS_FAIL: Final = 1
SPEEDS_FAIL: Final = 2


def least_move(A: Reals, first: int, n: int, m: int, slopes: Reals, residuals: Reals) -> int:
    """Store the least move of n states from the first on that takes away m residuals to first order.

    The move, in sizes, lies at the beginning of the matrices; held states do not move. Rows that follow from
    those before them count for nothing. Returns how many count.
    """
    place = int(A[MATRICES])
    move = part(A, place, n)
    row = part(A, place + n, n)
    size = 0
    for i in range(n):
        move[i] = 0.0
    for k in range(m):
        for i in range(n):
            row[i] = slopes[k * n + i]
        size = fulfil_row(A, first, n, size, residuals[k])
    return size


def fulfil_row(A: Reals, first: int, n: int, size: int, residual: float) -> int:
    """Change a move that fulfils `size` conditions so that it takes away one more residual; count it.

    The slopes of the residual by n states from the first on lie behind the move.
    """
    held = part(A, int(A[HELD]) + first, n)
    sizes = part(A, int(A[SIZES]) + first, n)
    place = int(A[MATRICES])
    row = part(A, place + n, n)
    basis = part(A, place + 2 * n, n * n)
    for i in range(n):
        row[i] = row[i] * sizes[i]
        if held[i] != 0.0:
            row[i] = 0.0
    scale = sqrt(dot(n, row, row))
    if size == n or not scale > 0.0:
        return size
    for i in range(n):
        row[i] = row[i] / scale
    length = add_row(n, size, row, basis, NEGLIGIBLE)
    if length == 0.0:
        return size
    fulfil(n, size, row, basis, length, -residual / scale, part(A, place, n))
    return size + 1


def excess(A: Reals, q: Reals, number: int) -> float:
    """Return by how much a quaternion is longer than 1, to first order."""
    total = 0.0
    for k in range(4):
        x = q[int(A[int(A[QUATERNION_PLACES]) + 4 * number + k])]
        total = total + x * x
    return (total - 1.0) / 2.0


def coordinate_move(A: Reals, q: Reals) -> None:
    """Store the least move of the coordinates that closes loops and keeps quaternions of norm 1."""
    n = int(A[COORDINATES])
    count = int(A[RESIDUALS])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    row = part(A, int(A[MATRICES]) + n, n)
    size = least_move(A, int(A[SPEEDS]), n, count, part(out, count, count * n), out)
    for number in range(int(A[QUATERNIONS])):
        for i in range(n):
            row[i] = 0.0
        for k in range(4):
            place = int(A[int(A[QUATERNION_PLACES]) + 4 * number + k])
            row[place] = q[place]
        size = fulfil_row(A, int(A[SPEEDS]), n, size, excess(A, q, number))


def largest(n: int, values: Reals, counts: Reals) -> float:
    """Return the largest magnitude of those of n values that count."""
    worst = 0.0
    for i in range(n):
        if counts[i] != 0.0:
            worst = max(worst, abs(values[i]))
    return worst


def openness(A: Reals, q: Reals) -> float:
    """Return the root of the sum of squares of all residuals over their sizes; infinite if one is."""
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    total = 0.0
    for k in range(int(A[RESIDUALS])):
        share = out[k] / A[int(A[SCALES]) + k]
        total = total + share * share
    for number in range(int(A[QUATERNIONS])):
        share = excess(A, q, number)
        total = total + share * share
    if not is_finite(total):
        return INFINITY
    return sqrt(total)


def try_move(h: Function, A: Reals, t: float, x: Reals, norm: float) -> float:
    """Move the coordinates as far as the residuals fall; return their norm there, negative if they do not."""
    n_u = int(A[SPEEDS])
    n = int(A[COORDINATES])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    numbers = part(A, int(A[NUMBERS]), 1)
    sizes = part(A, int(A[SIZES]) + n_u, n)
    moves = part(A, int(A[MATRICES]), n)
    old = part(A, int(A[OLD]), n)
    for i in range(n):
        old[i] = x[n_u + i]
    limited = part(A, int(A[LIMITED]), n)
    share = min(1.0, 1.0 / max(largest(n, moves, limited), TINY))
    halvings = HALVINGS
    if norm <= POLISHED:
        halvings = POLISHINGS
    for _halving in range(halvings):
        for i in range(n):
            x[n_u + i] = old[i] + share * moves[i] * sizes[i]
        # Accelerations that do not exist on the way do not matter.
        _status = call(h, n_u, numbers, t, x, out)
        trial = openness(A, part(x, n_u, n))
        if trial < (1.0 - DECREASE * share) * norm:
            return trial
        share = share / 2.0
    for i in range(n):
        x[n_u + i] = old[i]
    return -1.0


def assemble_positions(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move the coordinates of x = (u, q) onto the constraints by Newton's method with steps that descend."""
    n_u = int(A[SPEEDS])
    n = int(A[COORDINATES])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    _status = call(h, n_u, part(A, int(A[NUMBERS]), 1), t, x, out)
    norm = openness(A, part(x, n_u, n))
    for _round in range(MOST_ROUNDS):
        if norm <= A[ENOUGH] or norm == INFINITY:
            break
        coordinate_move(A, part(x, n_u, n))
        trial = try_move(h, A, t, x, norm)
        if trial < 0.0:
            break
        norm = trial
    farthest = 0.0
    for i in range(n):
        farthest = max(farthest, abs(x[n_u + i]) / A[int(A[SIZES]) + n_u + i])
    if norm <= max(A[SHARE], FAR * farthest):
        return ASSEMBLED
    return POSITIONS_FAIL
