"""How speeds answer to impulses: blocks of the inverse of the mass matrix under the rows that always hold."""

from __future__ import annotations

from symbody.kernels.impulses.impulse_step import ImpulseStep
from symbody.kernels.language import Reals, part
from symbody.kernels.linear.cholesky import factor_positive, solve_lower
from symbody.kernels.linear.solve_saddle import solve_saddle


def forget_responses(step: ImpulseStep) -> None:
    """Forget all answers: those of another state are wanted."""
    for k in range(step.blocks):
        step.has_responses[k] = 0.0
    for k in range(step.points):
        step.has_answers[k] = 0.0


def answer_to_point(step: ImpulseStep, point: int) -> int:
    """Compute how speeds answer to a unit of impulse along each row of a point; return 0 if they cannot.

    Also how the rates of the point itself do.
    """
    if step.has_answers[point] != 0.0:
        return 1
    first = int(step.point_first[point])
    rows = int(step.point_rows[point])
    size = int(step.shared_sizes[point])
    places = part(step.shared_places, int(step.shared_first[point]), size)
    for r in range(rows):
        row = first + r
        answers = part(step.answers, int(step.answer_first[point]) + r * size, size)
        for k in range(size):
            answers[k] = 0.0
        count = int(step.slope_sizes[row])
        slopes = part(step.values, int(step.row_values[row]) + 1, count)
        speeds = part(step.slope_places, int(step.slope_first[row]), count)
        for j in range(count):
            speed = int(speeds[j])
            block = int(step.owners[speed])
            if invert_block(step, block) == 0:
                return 0
            n = int(step.block_sizes[block])
            column = part(
                step.responses, int(step.block_responses[block]) + int(step.local_places[speed]) * n, n
            )
            for k in range(size):
                other = int(places[k])
                if int(step.owners[other]) == block:
                    answers[k] = answers[k] + column[int(step.local_places[other])] * slopes[j]
    for r in range(rows):
        for s in range(rows):
            step.own[9 * point + 3 * r + s] = answer_of_row(step, point, first + r, s)
    step.has_answers[point] = 1.0
    return 1


def answer_of_row(step: ImpulseStep, point: int, row: int, s: int) -> float:
    """Return how the rate along a row of a point answers to a unit of impulse along its row s."""
    size = int(step.shared_sizes[point])
    places = part(step.shared_places, int(step.shared_first[point]), size)
    answers = part(step.answers, int(step.answer_first[point]) + s * size, size)
    count = int(step.slope_sizes[row])
    slopes = part(step.values, int(step.row_values[row]) + 1, count)
    speeds = part(step.slope_places, int(step.slope_first[row]), count)
    total = 0.0
    k = 0
    for j in range(count):  # both are in order
        while places[k] < speeds[j]:
            k = k + 1
        total = total + slopes[j] * answers[k]
    return total


def invert_block(step: ImpulseStep, block: int) -> int:
    """Compute the answers of the speeds of a block to a unit of each force; return 0 if they have none."""
    if step.has_responses[block] != 0.0:
        return 1
    n = int(step.block_sizes[block])
    m = int(step.block_rows[block])
    first = int(step.block_values[block])
    inverse = part(step.responses, int(step.block_responses[block]), n * n)
    M = part(step.values, first, n * n)
    solved = 1
    if m == 0:
        solved = invert_mass(n, M, inverse, step.block)
    else:
        force = part(step.block, 0, n)
        none = part(step.block, n, m)
        result = part(step.block, n + m, n + m + 1)
        work = part(step.block, 2 * n + 2 * m + 1, 6 * n + 4 * m + n * (m + n))
        for i in range(m):
            none[i] = 0.0
        for j in range(n):
            for i in range(n):
                force[i] = 0.0
            force[j] = 1.0
            if solve_saddle(n, m, M, part(step.values, first + n * n, m * n), force, none, result, work) != 0:
                solved = 0
            for i in range(n):
                inverse[j * n + i] = result[i]
    step.has_responses[block] = float(solved)
    return solved


def invert_mass(n: int, M: Reals, inverse: Reals, L: Reals) -> int:
    """Set `inverse` to that of M (n, n); return 0 if M is not positive definite. L is scratch (n, n)."""
    for i in range(n * n):
        L[i] = M[i]
        inverse[i] = 0.0
    if factor_positive(n, L) == 0:
        return 0
    for i in range(n):
        column = part(inverse, i * n, n)
        column[i] = 1.0
        solve_lower(n, n, L, column)
    return 1


def rate_along(step: ImpulseStep, row: int, u: Reals) -> float:
    """Return the rate along a row with some speeds."""
    count = int(step.slope_sizes[row])
    first = int(step.row_values[row])
    slopes = part(step.values, first + 1, count)
    speeds = part(step.slope_places, int(step.slope_first[row]), count)
    total = step.values[first]
    for j in range(count):
        total = total + slopes[j] * u[int(speeds[j])]
    return total


def add_impulse(step: ImpulseStep, point: int, r: int, impulse: float, u: Reals) -> None:
    """Add to speeds how they answer to an impulse along a row of a point."""
    size = int(step.shared_sizes[point])
    places = part(step.shared_places, int(step.shared_first[point]), size)
    answers = part(step.answers, int(step.answer_first[point]) + r * size, size)
    for k in range(size):
        speed = int(places[k])
        u[speed] = u[speed] + answers[k] * impulse


def row_change(step: ImpulseStep, row: int, u: Reals) -> float:
    """Return the rate along a row with some changes of speeds."""
    return rate_along(step, row, u) - step.values[int(step.row_values[row])]
