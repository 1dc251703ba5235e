"""Closing of a state: positions by the least move, then rates by the least kinetic energy of the change.

What is held keeps its value, or the state cannot be closed. Held rates and the constraints determine others;
of all else the change has the least kinetic energy, and where no inertia resists it the least sum of squares
of rates over their sizes. The function writes what `assembly` reads, then the mass matrix.

Where coordinates are substituted that follow from several others, the function is that of the equations with
these couplings as constraints, and writes last what follows: a state is closed with all coordinates in it.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.assembly import (
    ASKED,
    ASSEMBLED,
    CLOSED,
    COORDINATES,
    FOLLOWER_PLACES,
    FOLLOWERS,
    HELD,
    MATRICES,
    NUMBERS,
    OUT,
    OUT_SIZE,
    PLACES,
    QUATERNION_PLACES,
    QUATERNIONS,
    RESIDUALS,
    ROWS,
    SCALES,
    SIZES,
    SPEEDS,
    SPEEDS_FAIL,
    STATES,
    WEIGHED,
    WHOLE,
    assemble_positions,
)
from symbody.kernels.language import Function, Reals, part, sqrt
from symbody.kernels.linear.row_space import add_row, dot, fulfil
from symbody.kernels.runge_kutta import call

# What is left of a row beside those before it, over its length, if it counts: `symbody.tolerances.RANK`.
RANK: Final = 1e-6
# The same of rows of kinetic energies; less is rounding of sums of some ten terms.
RESISTED: Final = 1e-12


def add_conditions(A: Reals, first: int, v: Reals, row: Reals, basis: Reals) -> int:
    """Change v, speeds over their sizes, by what constraints ask of those that are not held.

    Their residuals lie in the output from `first` on, J behind them. Returns how many count.
    """
    n = int(A[SPEEDS])
    m = int(A[ROWS])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    held = part(A, int(A[HELD]), n)
    sizes = part(A, int(A[SIZES]), n)
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


def add_free(A: Reals, size: int, row: Reals, basis: Reals) -> int:
    """Complete a basis of `size` rows by directions in which constraints let the others move; count all."""
    n = int(A[SPEEDS])
    held = part(A, int(A[HELD]), n)
    count = size
    for k in range(n):
        if count < n and held[k] == 0.0:
            for i in range(n):
                row[i] = 0.0
            row[k] = 1.0
            if add_row(n, count, row, basis, RANK) != 0.0:
                count = count + 1
    return count


def weigh(A: Reals, mass: Reals, free: Reals, count: int, images: Reals) -> None:
    """Store the momenta of so many directions; those of speeds that follow from what is held are left out."""
    n = int(A[SPEEDS])
    sizes = part(A, int(A[SIZES]), n)
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


def close_speeds(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move the speeds of x = (u, q) onto the constraints, those that are held aside."""
    n = int(A[SPEEDS])
    m = int(A[ROWS])
    count = int(A[RESIDUALS])
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    sizes = part(A, int(A[SIZES]), n)
    numbers = part(A, int(A[NUMBERS]), 1)
    place = int(A[MATRICES])
    v = part(A, place, n)
    row = part(A, place + n, n)
    basis = part(A, place + 2 * n, n * n)
    images = part(A, place + 2 * n + n * n, n * n)
    first = count + count * int(A[COORDINATES])
    if call(h, n, numbers, t, x, out) != 0:
        return SPEEDS_FAIL
    for i in range(n):
        v[i] = 0.0
    size = add_conditions(A, first, v, row, basis)
    free = add_free(A, size, row, basis) - size
    if free > 0 and A[WEIGHED] != 0.0 and dot(n, v, v) > 0.0:
        directions = part(basis, size * n, free * n)
        weigh(A, part(out, first + m + m * n, n * n), directions, free, images)
        spread_change(n, v, directions, free, images, part(A, place + 2 * n + 2 * n * n, 2 * n + n * n))
    for i in range(n):
        if A[int(A[HELD]) + i] == 0.0:
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


def hold(A: Reals, count: int, places: Reals) -> None:
    """Hold the states at so many places, and no others."""
    n = int(A[SPEEDS]) + int(A[COORDINATES]) - int(A[FOLLOWERS])
    held = part(A, int(A[ASKED]), n)
    for i in range(n):
        held[i] = 0.0
    for k in range(count):
        if places[k] < float(n):  # behind them lie states of signals
            held[int(places[k])] = 1.0


def set_metric(A: Reals, row: Reals) -> int:
    """Take sizes of states and of constraints from a row; return how many these are."""
    n = int(A[SPEEDS]) + int(A[COORDINATES])
    count = int(A[RESIDUALS])
    for i in range(n):
        A[int(A[SIZES]) + i] = row[i]
    for k in range(count):
        A[int(A[SCALES]) + k] = row[n + k]
    return n + count


def closing_numbers(A: Reals) -> int:
    """Return where the numbers of the function begin."""
    return int(A[NUMBERS])


def normalize_held(A: Reals, q: Reals) -> None:
    """Divide quaternions that are held as a whole by their norm: what is held of them is the orientation."""
    held = part(A, int(A[HELD]) + int(A[SPEEDS]), int(A[COORDINATES]))
    for number in range(int(A[QUATERNIONS])):
        total = 0.0
        is_held = 1
        for k in range(4):
            place = int(A[int(A[QUATERNION_PLACES]) + 4 * number + k])
            total = total + q[place] * q[place]
            if held[place] == 0.0:
                is_held = 0
        if is_held != 0 and total > 0.0:
            for k in range(4):
                place = int(A[int(A[QUATERNION_PLACES]) + 4 * number + k])
                q[place] = q[place] / sqrt(total)


def close_all(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move a state x = (u, q) of the function onto the constraints; return how that ended."""
    normalize_held(A, part(x, int(A[SPEEDS]), int(A[COORDINATES])))
    result = assemble_positions(h, A, t, x)
    if result != ASSEMBLED:
        return result
    return close_speeds(h, A, t, x)


def enter_states(A: Reals, x: Reals) -> None:
    """Copy states to their places among all."""
    for i in range(int(A[STATES])):
        A[int(A[WHOLE]) + int(A[int(A[PLACES]) + i])] = x[i]


def note_followers(h: Function, A: Reals, t: float, x: Reals) -> None:
    """Store the coordinates that are substituted, and their rates, as they are before states x change."""
    count = int(A[FOLLOWERS])
    if count == 0:
        return
    enter_states(A, x)
    out = part(A, int(A[OUT]), int(A[OUT_SIZE]))
    # The function may say that accelerations do not exist, which does not matter.
    _status = call(h, int(A[SPEEDS]), part(A, int(A[NUMBERS]), 1), t, part(A, int(A[WHOLE]), 1), out)
    for k in range(count):
        place = int(A[WHOLE]) + int(A[int(A[FOLLOWER_PLACES]) + k])
        A[place] = out[int(A[OUT_SIZE]) - count + k]


def close_state(h: Function, A: Reals, t: float, x: Reals) -> int:
    """Move a state x = (u, q) onto the constraints, those that are held aside; return how that ended.

    Where coordinates are substituted `note_followers` has seen the state before it changed.
    """
    if A[FOLLOWERS] == 0.0:
        return close_all(h, A, t, x)
    enter_states(A, x)
    for k in range(int(A[FOLLOWERS])):
        A[int(A[HELD]) + int(A[int(A[FOLLOWER_PLACES]) + k])] = 0.0
    count = int(A[SPEEDS]) + int(A[COORDINATES]) - int(A[FOLLOWERS])
    for i in range(count):
        A[int(A[HELD]) + int(A[int(A[PLACES]) + i])] = A[int(A[ASKED]) + i]
    result = close_all(h, A, t, part(A, int(A[WHOLE]), 1))
    for i in range(count):
        x[i] = A[int(A[WHOLE]) + int(A[int(A[PLACES]) + i])]
    return result


def closing_size(n: int) -> int:
    """Return how many numbers the matrices take that close n states."""
    return 4 * n + 3 * n * n
