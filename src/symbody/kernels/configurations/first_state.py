"""First state of a motion: positions on the constraints, speeds that fit, accelerations, where that is plain.

Plain is a state whose constraints are independent by a wide margin. What is not goes to
`analysis.configurations.assembly`, which judges it and says what is wrong. The function writes, behind what
`assembly` reads, cosines of axes, gamma, accelerations, multipliers, the kinetic energy, and where there are
constraints the mass matrix.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import ASSEMBLED, TINY, assemble_positions
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.configurations.closing import add_free, spread_change, weigh
from symbody.kernels.language import Function, Reals, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

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


def add_constraints(problem: AssemblyProblem, rows: Reals, basis: Reals, lengths: Reals, right: Reals) -> int:
    """Store the rows of the constraints on speeds; return their number, or -1 if some depend on others."""
    n = problem.speeds
    m = problem.rows
    count = problem.residuals
    sizes = problem.sizes
    out = problem.out
    first = count + count * problem.coordinates
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
    problem.zero_rows = m - size
    return size


def add_chosen(
    problem: AssemblyProblem, constraints: int, rows: Reals, basis: Reals, lengths: Reals, right: Reals
) -> int:
    """Store rows of chosen speeds behind those of constraints; count all, or -1 if those to keep do not fit.

    Chosen speeds are pairs of a place in u and a value.
    """
    n = problem.speeds
    chosen = problem.chosen
    size = constraints
    for turn in range(problem.choices):
        length = 0.0
        if size < n:
            speed = int(chosen[2 * turn])
            for i in range(n):
                rows[size * n + i] = 0.0
            rows[size * n + speed] = 1.0
            right[size] = chosen[2 * turn + 1] / problem.sizes[speed]
            length = add_row(n, size, part(rows, size * n, n), basis, RANK)
        if length != 0.0:
            lengths[size] = length
            size = size + 1
        elif turn < problem.kept:
            return -1
    return size


def set_speeds(problem: AssemblyProblem, x: Reals) -> None:
    """Set speeds to what was chosen for them, first choices first."""
    chosen = problem.chosen
    for turn in range(problem.choices - 1, -1, -1):
        x[int(chosen[2 * turn])] = chosen[2 * turn + 1]


def move_others(problem: AssemblyProblem, size: int, basis: Reals, v: Reals, row: Reals) -> None:
    """Change v, which fulfils the rows of a basis, so that speeds left open have the least kinetic energy."""
    n = problem.speeds
    mass = part(problem.out, problem.out_size - n * n, n * n)
    free = add_free(problem, size, row, basis) - size
    images = problem.matrices
    directions = part(basis, size * n, n)
    weigh(problem, mass, directions, free, images)
    spread_change(n, v, directions, free, images, part(problem.matrices, n * n, n))


def find_speeds(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Set the speeds of x = (u, q) to what constraints and chosen values determine, the first of these first.

    The first `KEPT` have to fit. What is not determined has the least kinetic energy: see `closing`.
    """
    n = problem.speeds
    room = problem.row_room
    rows = part(room, 0, n * n + n)
    basis = part(room, n * n + n, n * n)
    lengths = part(room, 2 * n * n + n, n)
    right = part(room, 2 * n * n + 2 * n, n)
    v = part(room, 2 * n * n + 3 * n, n)
    for i in range(n):
        x[i] = 0.0
    _status = call(h, n, problem.numbers, t, x, problem.out)
    size = add_constraints(problem, rows, basis, lengths, right)
    if size < 0:
        return DEPENDENT_ROWS
    if size == 0:
        set_speeds(problem, x)
        return ASSEMBLED
    size = add_chosen(problem, size, rows, basis, lengths, right)
    if size < 0:
        return DEPENDENT_ROWS
    for i in range(n):
        v[i] = 0.0
    for _turn in range(2):  # the second takes away the rounding of the first
        for k in range(size):
            fulfil(n, k, part(rows, k * n, n), basis, lengths[k], right[k], v)
    if size < n and dot(n, v, v) > 0.0:
        move_others(problem, size, basis, v, part(rows, n * n, n))
    for i in range(n):
        x[i] = v[i] * problem.sizes[i]
    return ASSEMBLED


def check_accelerations(problem: AssemblyProblem, u: Reals) -> int:
    """Return whether accelerations fulfil the constraints beyond doubt: to rounding of their terms."""
    n = problem.speeds
    m = problem.rows
    count = problem.residuals
    sizes = problem.sizes
    out = problem.out
    first = count + count * problem.coordinates + m
    gamma = first + m * n + problem.cosines
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


def first_state(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Move x = (u, q) to a first state; return how that ended. The outputs at that state lie in the block."""
    result = ASSEMBLED
    if problem.residuals + problem.quaternion_count > 0:
        result = assemble_positions(h, problem, t, x)
    if result != ASSEMBLED:
        return result
    result = find_speeds(h, problem, t, x)
    if result != ASSEMBLED:
        return result
    out = problem.out
    if call(h, problem.speeds, problem.numbers, t, x, out) != 0:
        return NO_ACCELERATIONS
    m = problem.rows
    count = problem.residuals
    cosines = count + count * problem.coordinates + m + m * problem.speeds
    for k in range(problem.cosines):
        if not out[cosines + k] > ALIGNED:
            return OPPOSITE_AXES
    return check_accelerations(problem, x)


def speeds_size(n: int) -> int:
    """Return how many numbers of scratch the speeds take."""
    return 2 * n * n + 4 * n
