"""First state of a motion: positions on the constraints, speeds that fit, accelerations, where that is plain.

Plain is a state whose constraints are independent by a wide margin. What is not goes to
`analysis.configurations.assembly`, which judges it and says what is wrong. The function writes, behind what
`assembly` reads, cosines of axes, gamma, accelerations, multipliers, the kinetic energy, and where there are
constraints the mass matrix.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import (
    ASSEMBLED,
    COORDINATES,
    MATRICES,
    NUMBERS,
    OUT,
    OUT_SIZE,
    QUATERNIONS,
    RESIDUALS,
    ROWS,
    SIZES,
    SPEEDS,
    TINY,
    assemble_positions,
)
from symbody.kernels.configurations.closing import add_free, spread_change, weigh
from symbody.kernels.language import Function, Reals, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

# Behind the places of `assembly`: how many cosines of axes; how many chosen speeds, and of these such that
# have to fit; rows of J that are zero; where chosen speeds and rows begin.
COSINES: Final = 15
CHOICES: Final = 16
KEPT: Final = 17
ZERO_ROWS: Final = 18
CHOSEN: Final = 19
ROW_PLACE: Final = 20

# Other ends than those of `assembly`.
OPPOSITE_AXES: Final = 3
DEPENDENT_ROWS: Final = 4
NO_ACCELERATIONS: Final = 5

ALIGNED: Final = 0.5
# What is left of a row of J beside those before it, over its length, if constraints are plainly independent.
WIDE: Final = 1e-3
# The same of a speed that is still free. As `symbody.tolerances.RANK`.
RANK: Final = 1e-6
# Of accelerations on the constraints, over the sum of terms.
CONSISTENT: Final = 1e-9
# The same of a row times the largest acceleration.
ROUNDED: Final = 1e-13


def unit_row(n: int, slopes: Reals, sizes: Reals, row: Reals) -> float:
    """Set a row to slopes by states over their sizes, divided by its length, and return that."""
    for i in range(n):
        row[i] = slopes[i] * sizes[i]
    scale = sqrt(dot(n, row, row))
    for i in range(n):
        row[i] = row[i] / max(scale, TINY)
    return scale


def add_constraints(A: Reals, rows: Reals, basis: Reals, lengths: Reals, right: Reals) -> int:
    """Store the rows of the constraints on speeds; return their number, or -1 if some depend on others."""
    n = int(A[SPEEDS])
    m = int(A[ROWS])
    count = int(A[RESIDUALS])
    sizes = part(A, int(A[SIZES]), n)
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    first = count + count * int(A[COORDINATES])
    row = part(rows, n * n, n)
    size = 0
    for k in range(m):
        scale = unit_row(n, part(out, first + m + k * n, n), sizes, row)
        if scale == 0.0:
            if out[first + k] != 0.0:
                return -1
        else:
            if size == n:
                return -1
            for i in range(n):
                rows[size * n + i] = row[i]
            right[size] = -out[first + k] / scale
            lengths[size] = add_row(n, size, row, basis, WIDE)
            if lengths[size] == 0.0:
                return -1
            size = size + 1
    A[ZERO_ROWS] = float(m - size)
    return size


def add_chosen(A: Reals, constraints: int, rows: Reals, basis: Reals, lengths: Reals, right: Reals) -> int:
    """Store rows of chosen speeds behind those of constraints; count all, or -1 if those to keep do not fit.

    Chosen speeds are pairs of a place in u and a value.
    """
    n = int(A[SPEEDS])
    chosen = part(A, int(A[CHOSEN]), 4 * n)
    size = constraints
    for turn in range(int(A[CHOICES])):
        length = 0.0
        if size < n:
            speed = int(chosen[2 * turn])
            for i in range(n):
                rows[size * n + i] = 0.0
            rows[size * n + speed] = 1.0
            right[size] = chosen[2 * turn + 1] / A[int(A[SIZES]) + speed]
            length = add_row(n, size, part(rows, size * n, n), basis, RANK)
        if length != 0.0:
            lengths[size] = length
            size = size + 1
        elif turn < int(A[KEPT]):
            return -1
    return size


def set_speeds(A: Reals, x: Reals) -> None:
    """Set speeds to what was chosen for them, first choices first."""
    chosen = part(A, int(A[CHOSEN]), 4 * int(A[SPEEDS]))
    for turn in range(int(A[CHOICES]) - 1, -1, -1):
        x[int(chosen[2 * turn])] = chosen[2 * turn + 1]


def move_others(A: Reals, size: int, basis: Reals, v: Reals, row: Reals) -> None:
    """Change v, which fulfils the rows of a basis, so that speeds left open have the least kinetic energy."""
    n = int(A[SPEEDS])
    mass = part(A, int(A[OUT]) + int(A[OUT_SIZE]) - n * n, n * n)
    free = add_free(A, size, row, basis) - size
    images = part(A, int(A[MATRICES]), n * n)
    directions = part(basis, size * n, n)
    weigh(A, mass, directions, free, images)
    spread_change(n, v, directions, free, images, part(A, int(A[MATRICES]) + n * n, n))


def find_speeds(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Set the speeds of x = (u, q) to what constraints and chosen values determine, the first of these first.

    The first `KEPT` have to fit. What is not determined has the least kinetic energy: see `closing`.
    """
    n = int(A[SPEEDS])
    place = int(A[ROW_PLACE])
    rows = part(A, place, n * n + n)
    basis = part(A, place + n * n + n, n * n)
    lengths = part(A, place + 2 * n * n + n, n)
    right = part(A, place + 2 * n * n + 2 * n, n)
    v = part(A, place + 2 * n * n + 3 * n, n)
    for i in range(n):
        x[i] = 0.0
    _status = call(h, n, part(A, int(A[NUMBERS]), 1), t, x, part(A, int(A[OUT]), int(A[OUT_SIZE])))
    size = add_constraints(A, rows, basis, lengths, right)
    if size < 0:
        return DEPENDENT_ROWS
    if size == 0:
        set_speeds(A, x)
        return ASSEMBLED
    size = add_chosen(A, size, rows, basis, lengths, right)
    if size < 0:
        return DEPENDENT_ROWS
    for i in range(n):
        v[i] = 0.0
    for _turn in range(2):  # the second takes away the rounding of the first
        for k in range(size):
            fulfil(n, k, part(rows, k * n, n), basis, lengths[k], right[k], v)
    if size < n and dot(n, v, v) > 0.0:
        move_others(A, size, basis, v, part(rows, n * n, n))
    for i in range(n):
        x[i] = v[i] * A[int(A[SIZES]) + i]
    return ASSEMBLED


def check_accelerations(A: Reals, u: Reals) -> int:
    """Return whether accelerations fulfil the constraints beyond doubt: to rounding of their terms."""
    n = int(A[SPEEDS])
    m = int(A[ROWS])
    count = int(A[RESIDUALS])
    sizes = part(A, int(A[SIZES]), n)
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    first = count + count * int(A[COORDINATES]) + m
    gamma = first + m * n + int(A[COSINES])
    largest = 0.0
    fastest = 0.0
    for i in range(n):
        largest = max(largest, abs(out[gamma + m + i]) / sizes[i])
        fastest = max(fastest, abs(u[i]) / sizes[i])
    for k in range(m):
        left = -out[gamma + k]
        terms = abs(left)
        steepest = 0.0
        for i in range(n):
            term = out[first + k * n + i] * out[gamma + m + i]
            left = left + term
            terms = terms + abs(term)
            steepest = max(steepest, abs(out[first + k * n + i]) * sizes[i])
        rounding = ROUNDED * steepest * (largest + fastest * fastest)
        if not abs(left) <= CONSISTENT * terms + rounding + TINY:
            return NO_ACCELERATIONS
    return ASSEMBLED


def first_state(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move x = (u, q) to a first state; return how that ended. The outputs at that state lie in the block."""
    result = ASSEMBLED
    if int(A[RESIDUALS]) + int(A[QUATERNIONS]) > 0:
        result = assemble_positions(h, A, t, x)
    if result != ASSEMBLED:
        return result
    result = find_speeds(h, A, t, x)
    if result != ASSEMBLED:
        return result
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    if call(h, int(A[SPEEDS]), part(A, int(A[NUMBERS]), 1), t, x, out) != 0:
        return NO_ACCELERATIONS
    m = int(A[ROWS])
    count = int(A[RESIDUALS])
    cosines = count + count * int(A[COORDINATES]) + m + m * int(A[SPEEDS])
    for k in range(int(A[COSINES])):
        if not out[cosines + k] > ALIGNED:
            return OPPOSITE_AXES
    return check_accelerations(A, x)


def speeds_size(n: int) -> int:
    """Return how many numbers of scratch the speeds take."""
    return 2 * n * n + 4 * n
