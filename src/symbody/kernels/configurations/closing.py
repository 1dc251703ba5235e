"""Closing of a state: positions by the least move, then rates by the least kinetic energy of the change.

What is held keeps its value, or the state cannot be closed. Held rates and the constraints determine others;
of all else the change has the least kinetic energy, and where no inertia resists it the least sum of squares
of rates over their sizes. The function writes what `assembly` reads, then the mass matrix.

Where coordinates are substituted that follow from several others, the function is that of the equations with
these couplings as constraints, and writes last what follows: a state is closed with all coordinates in it.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import ASSEMBLED, CLOSED, SPEEDS_FAIL, assemble_positions
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.language import Function, Reals, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

# What is left of a row beside those before it, over its length, if it counts: `symbody.tolerances.RANK`.
RANK: Final = 1e-6
# The same of rows of kinetic energies; less is rounding of sums of some ten terms.
RESISTED: Final = 1e-12


def add_conditions(problem: AssemblyProblem, first: int, v: Reals, row: Reals, basis: Reals) -> int:
    """Change v, speeds over their sizes, by what constraints ask of those that are not held.

    Their residuals lie in the output from `first` on, J behind them. Returns how many count.
    """
    n = problem.speeds
    m = problem.rows
    out = problem.out
    held = problem.held
    sizes = problem.sizes
    size = 0
    for k in range(m):
        whole = 0.0
        for i in range(n):
            row[i] = out[first + m + k * n + i] * sizes[i]
            whole = whole + row[i] * row[i]
            if held[i] != 0.0:
                row[i] = 0.0
        scale = sqrt(dot(n, row, row))
        if size < n and scale > RANK * sqrt(whole):
            for i in range(n):
                row[i] = row[i] / scale
            length = add_row(n, size, row, basis, RANK)
            if length != 0.0:
                fulfil(n, size, row, basis, length, -out[first + k] / scale, v)
                size = size + 1
    return size


def add_free(problem: AssemblyProblem, size: int, row: Reals, basis: Reals) -> int:
    """Complete a basis of `size` rows by directions in which constraints let the others move; count all."""
    n = problem.speeds
    held = problem.held
    count = size
    for k in range(n):
        if count < n and held[k] == 0.0:
            for i in range(n):
                row[i] = 0.0
            row[k] = 1.0
            if add_row(n, count, row, basis, RANK) != 0.0:
                count = count + 1
    return count


def weigh(problem: AssemblyProblem, mass: Reals, free: Reals, count: int, images: Reals) -> None:
    """Store the momenta of so many directions; those of speeds that follow from what is held are left out."""
    n = problem.speeds
    sizes = problem.sizes
    for i in range(n):
        moves = 0.0
        for k in range(count):
            moves = max(moves, abs(free[k * n + i]))
        for k in range(count):
            total = 0.0
            if moves > RANK:
                for j in range(n):
                    total = total + mass[i * n + j] * sizes[j] * free[k * n + j]
            images[k * n + i] = total * sizes[i]


def spread_change(n: int, v: Reals, free: Reals, count: int, images: Reals, scratch: Reals) -> None:
    """Change v along free directions so that its momentum along each vanishes; by least, if several do."""
    share = part(scratch, 0, n)
    row = part(scratch, n, n)
    basis = part(scratch, 2 * n, n * n)
    heaviest = 0.0
    for k in range(count):
        share[k] = 0.0
        heaviest = max(heaviest, dot(n, part(images, k * n, n), part(free, k * n, n)))
    size = 0
    for k in range(count):
        for i in range(count):
            row[i] = dot(n, part(images, k * n, n), part(free, i * n, n))
        scale = sqrt(dot(count, row, row))
        if scale > RESISTED * heaviest:
            for i in range(count):
                row[i] = row[i] / scale
            length = add_row(count, size, row, basis, RESISTED)
            if length != 0.0:
                value = -dot(n, part(images, k * n, n), v) / scale
                fulfil(count, size, row, basis, length, value, share)
                size = size + 1
    for k in range(count):
        for i in range(n):
            v[i] = v[i] + share[k] * free[k * n + i]


def close_speeds(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Move the speeds of x = (u, q) onto the constraints, those that are held aside."""
    n = problem.speeds
    m = problem.rows
    count = problem.residuals
    out = problem.out
    sizes = problem.sizes
    numbers = problem.numbers
    room = problem.matrices
    v = part(room, 0, n)
    row = part(room, n, n)
    basis = part(room, 2 * n, n * n)
    images = part(room, 2 * n + n * n, n * n)
    first = count + count * problem.coordinates
    if call(h, n, numbers, t, x, out) != 0:
        return SPEEDS_FAIL
    for i in range(n):
        v[i] = 0.0
    size = add_conditions(problem, first, v, row, basis)
    free = add_free(problem, size, row, basis) - size
    if free > 0 and problem.weighed != 0.0 and dot(n, v, v) > 0.0:
        directions = part(basis, size * n, free * n)
        weigh(problem, part(out, first + m + m * n, n * n), directions, free, images)
        spread_change(n, v, directions, free, images, part(room, 2 * n + 2 * n * n, 2 * n + n * n))
    for i in range(n):
        if problem.held[i] == 0.0:
            x[i] = x[i] + v[i] * sizes[i]
    if call(h, n, numbers, t, x, out) != 0:
        return SPEEDS_FAIL
    for k in range(m):
        terms = 0.0
        for i in range(n):
            terms = terms + abs(out[first + m + k * n + i]) * max(abs(x[i]), sizes[i])
        if not abs(out[first + k]) <= CLOSED * terms:
            return SPEEDS_FAIL
    return ASSEMBLED


def hold(problem: AssemblyProblem, count: int, places: Reals) -> None:
    """Hold the states at so many places, and no others."""
    n = problem.speeds + problem.coordinates - problem.followers
    held = problem.asked
    for i in range(n):
        held[i] = 0.0
    for k in range(count):
        if places[k] < float(n):  # behind them lie states of signals
            held[int(places[k])] = 1.0


def set_metric(problem: AssemblyProblem, row: Reals) -> int:
    """Take sizes of states and of constraints from a row; return how many these are."""
    n = problem.speeds + problem.coordinates
    count = problem.residuals
    for i in range(n):
        problem.sizes[i] = row[i]
    for k in range(count):
        problem.scales[k] = row[n + k]
    return n + count


def normalize_held(problem: AssemblyProblem, q: Reals) -> None:
    """Divide quaternions that are held as a whole by their norm: what is held of them is the orientation."""
    held = part(problem.held, problem.speeds, problem.coordinates)
    for number in range(problem.quaternion_count):
        total = 0.0
        is_held = 1
        for k in range(4):
            place = int(problem.quaternion_places[4 * number + k])
            total = total + q[place] * q[place]
            if held[place] == 0.0:
                is_held = 0
        if is_held != 0 and total > 0.0:
            for k in range(4):
                place = int(problem.quaternion_places[4 * number + k])
                q[place] = q[place] / sqrt(total)


def close_all(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Move a state x = (u, q) of the function onto the constraints; return how that ended."""
    normalize_held(problem, part(x, problem.speeds, problem.coordinates))
    result = assemble_positions(h, problem, t, x)
    if result != ASSEMBLED:
        return result
    return close_speeds(h, problem, t, x)


def enter_states(problem: AssemblyProblem, x: Reals) -> None:
    """Copy states to their places among all."""
    for i in range(problem.states):
        problem.whole[int(problem.places[i])] = x[i]


def note_followers(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> None:
    """Store the coordinates that are substituted, and their rates, as they are before states x change."""
    count = problem.followers
    if count == 0:
        return
    enter_states(problem, x)
    out = problem.out
    # The function may say that accelerations do not exist, which does not matter.
    _status = call(h, problem.speeds, problem.numbers, t, problem.whole, out)
    for k in range(count):
        problem.whole[int(problem.follower_places[k])] = out[problem.out_size - count + k]


def close_state(h: Function, problem: AssemblyProblem, t: float, x: Reals) -> int:
    """Move a state x = (u, q) onto the constraints, those that are held aside; return how that ended.

    Where coordinates are substituted `note_followers` has seen the state before it changed.
    """
    if problem.followers == 0:
        return close_all(h, problem, t, x)
    enter_states(problem, x)
    for k in range(problem.followers):
        problem.held[int(problem.follower_places[k])] = 0.0
    count = problem.speeds + problem.coordinates - problem.followers
    for i in range(count):
        problem.held[int(problem.places[i])] = problem.asked[i]
    result = close_all(h, problem, t, problem.whole)
    for i in range(count):
        x[i] = problem.whole[int(problem.places[i])]
    return result


def closing_size(n: int) -> int:
    """Return how many numbers the matrices take that close n states."""
    return 4 * n + 3 * n * n
