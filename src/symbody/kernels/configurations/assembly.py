"""Assembly near a state: the nearest positions that fulfil the constraints, some of them held.

The function writes what `AssemblyProblem` says.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

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


def least_move(problem: AssemblyProblem, first: int, n: int, m: int, slopes: Reals, residuals: Reals) -> int:
    """Store the least move of n states from the first on that takes away m residuals to first order.

    The move, in sizes, lies at the beginning of the matrices; held states do not move. Rows that follow from
    those before them count for nothing. Returns how many count.
    """
    room = problem.matrices
    move = part(room, 0, n)
    row = part(room, n, n)
    size = 0
    for i in range(n):
        move[i] = 0.0
    for k in range(m):
        for i in range(n):
            row[i] = slopes[k * n + i]
        size = fulfil_row(problem, first, n, size, residuals[k])
    return size


def fulfil_row(problem: AssemblyProblem, first: int, n: int, size: int, residual: float) -> int:
    """Change a move that fulfils `size` conditions so that it takes away one more residual; count it.

    The slopes of the residual by n states from the first on lie behind the move.
    """
    held = part(problem.held, first, n)
    sizes = part(problem.sizes, first, n)
    room = problem.matrices
    row = part(room, n, n)
    basis = part(room, 2 * n, n * n)
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
    fulfil(n, size, row, basis, length, -residual / scale, part(room, 0, n))
    return size + 1


def excess(problem: AssemblyProblem, q: Reals, number: int) -> float:
    """Return by how much a quaternion is longer than 1, to first order."""
    total = 0.0
    for k in range(4):
        x = q[int(problem.quaternion_places[4 * number + k])]
        total = total + x * x
    return (total - 1.0) / 2.0


def coordinate_move(problem: AssemblyProblem, q: Reals) -> None:
    """Store the least move of the coordinates that closes loops and keeps quaternions of norm 1."""
    n = problem.coordinates
    count = problem.residuals
    out = problem.out
    row = part(problem.matrices, n, n)
    size = least_move(problem, problem.speeds, n, count, part(out, count, count * n), out)
    for number in range(problem.quaternion_count):
        for i in range(n):
            row[i] = 0.0
        for k in range(4):
            place = int(problem.quaternion_places[4 * number + k])
            row[place] = q[place]
        size = fulfil_row(problem, problem.speeds, n, size, excess(problem, q, number))


def largest(n: int, values: Reals, counts: Reals) -> float:
    """Return the largest magnitude of those of n values that count."""
    worst = 0.0
    for i in range(n):
        if counts[i] != 0.0:
            worst = max(worst, abs(values[i]))
    return worst


def openness(problem: AssemblyProblem, q: Reals) -> float:
    """Return the root of the sum of squares of all residuals over their sizes; infinite if one is."""
    out = problem.out
    total = 0.0
    for k in range(problem.residuals):
        share = out[k] / problem.scales[k]
        total = total + share * share
    for number in range(problem.quaternion_count):
        share = excess(problem, q, number)
        total = total + share * share
    if not is_finite(total):
        return INFINITY
    return sqrt(total)


def try_move(h: Function, problem: AssemblyProblem, t: float, x: Reals, norm: float) -> float:
    """Move the coordinates as far as the residuals fall; return their norm there, negative if they do not."""
    n_u = problem.speeds
    n = problem.coordinates
    out = problem.out
    numbers = problem.numbers
    sizes = part(problem.sizes, n_u, n)
    moves = problem.matrices
    old = problem.old
    for i in range(n):
        old[i] = x[n_u + i]
    limited = problem.limited
    share = min(1.0, 1.0 / max(largest(n, moves, limited), TINY))
    halvings = HALVINGS
    if norm <= POLISHED:
        halvings = POLISHINGS
    for _halving in range(halvings):
        for i in range(n):
            x[n_u + i] = old[i] + share * moves[i] * sizes[i]
        # Accelerations that do not exist on the way do not matter.
        _status = call(h, n_u, numbers, t, x, out)
        trial = openness(problem, part(x, n_u, n))
        if trial < (1.0 - DECREASE * share) * norm:
            return trial
        share = share / 2.0
    for i in range(n):
        x[n_u + i] = old[i]
    return -1.0


def assemble_positions(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Move the coordinates of x = (u, q) onto the constraints by Newton's method with steps that descend."""
    n_u = problem.speeds
    n = problem.coordinates
    out = problem.out
    _status = call(h, n_u, problem.numbers, t, x, out)
    norm = openness(problem, part(x, n_u, n))
    for _round in range(MOST_ROUNDS):
        if norm <= problem.enough or norm == INFINITY:
            break
        coordinate_move(problem, part(x, n_u, n))
        trial = try_move(h, problem, t, x, norm)
        if trial < 0.0:
            break
        norm = trial
    farthest = 0.0
    for i in range(n):
        farthest = max(farthest, abs(x[n_u + i]) / problem.sizes[n_u + i])
    if norm <= max(problem.share, FAR * farthest):
        return ASSEMBLED
    return POSITIONS_FAIL
