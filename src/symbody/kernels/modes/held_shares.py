"""Shares of efforts that hold dependent rows: of least norm among those within the bounds.

Shares from which friction of what slips follows have no bounds: they are those of least norm, as in the
equations of the motion.

Where rows depend on each other, efforts that hold them are not unique. Of those within their bounds, the ones
of least norm are ``x = P(L y)``, P the projection onto the bounds, with y the minimum of a convex function
whose slope is ``L^T P(L y) - L^T x0``, x0 any efforts that hold; Newton's method with a line search finds it
[Rockafellar, Convex Analysis, 1970, section 31]. Without a minimum no share is within the bounds.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import INFINITY, Reals, part, sqrt
from symbody.kernels.linear.dense_factors import factor_dense, solve_dense
from symbody.kernels.modes.held_rows import multiply_factor, multiply_transposed
from symbody.kernels.modes.mode_problem import CONE, HOLDS, UNILATERAL, ModeElement, ModeProblem

# What `share_efforts` returns.
WITHIN_BOUNDS: Final = 0
MOVED: Final = 1
NONE_WITHIN: Final = 2

MOST_STEPS: Final = 100
MOST_HALVINGS: Final = 30
WITHIN: Final = 1e-9  # of bounds, `symbody.tolerances.BALANCED`
SETTLED: Final = 1e-12  # of the works that hold, which have to stay
RAISED: Final = 1e-12  # what is added to second derivatives, of the largest


def share_efforts(problem: ModeProblem) -> int:
    """Move efforts that hold into their bounds if some are within; to those of least norm if not."""
    n = problem.held_count
    rows = problem.rows
    x = part(problem.room, 3 * rows, rows)
    target = part(problem.room, 4 * rows, rows)
    y = part(problem.room, 5 * rows, rows)
    slope = part(problem.room, 6 * rows, rows)
    for i in range(n):
        x[i] = problem.efforts[int(problem.held[i])] * problem.sizes[int(problem.held[i])]
        target[i] = x[i]
    if overload(problem, x, slope) == 0.0:
        return WITHIN_BOUNDS
    if find_share(problem, x, y, slope) == 0:
        for k in range(rows):
            problem.added[k] = 0.0
        return NONE_WITHIN
    for i in range(n):
        row = int(problem.held[i])
        problem.added[row] = problem.added[row] + (x[i] - target[i]) / problem.sizes[row]
    return MOVED


def held_place(problem: ModeProblem, row: int) -> int:
    """Return the place of a row among those that hold."""
    found = 0
    for i in range(problem.held_count):
        if int(problem.held[i]) == row:
            found = i
    return found


def overload(problem: ModeProblem, x: Reals, projected: Reals) -> float:
    """Set `projected` to works within their bounds that are nearest to x; return 1 if any was not, else 0."""
    outside = 0.0
    for k in range(problem.count):
        element = problem.elements[k]
        if element.mode == HOLDS and element.moves == 0.0:
            i = held_place(problem, element.row)
            bound = bound_of(element)
            if element.law == UNILATERAL:
                projected[i] = max(x[i], -bound)
                if x[i] < -bound:
                    outside = 1.0
            elif element.law == CONE:
                j = held_place(problem, element.row + 1)
                size = sqrt(x[i] * x[i] + x[j] * x[j])
                projected[i] = x[i]
                projected[j] = x[j]
                if size > bound:
                    projected[i] = x[i] * (bound / size)
                    projected[j] = x[j] * (bound / size)
                if size > bound * (1.0 + WITHIN):
                    outside = 1.0
            else:
                projected[i] = min(max(x[i], -bound), bound)
                if abs(x[i]) > bound * (1.0 + WITHIN):
                    outside = 1.0
    return outside


def bound_of(element: ModeElement) -> float:
    """Return how large the work of an element may be: of friction both ways, of a gap below 0."""
    if element.rubs != 0.0:
        return INFINITY
    if element.law == UNILATERAL:
        return 0.0
    return element.static * element.normal_load * element.scale


def find_share(problem: ModeProblem, x: Reals, y: Reals, slope: Reals) -> int:
    """Set x to the works of least norm within bounds that hold as x does; return 0 if there are none."""
    n = problem.held_count
    rows = problem.rows
    rank = problem.rank
    L = problem.factor
    fixed = part(problem.room, 0, rows)
    z = part(problem.room, rows, rows)
    step = problem.vector
    multiply_transposed(n, rank, L, x, fixed)
    largest = 0.0
    for i in range(rank):
        y[i] = 0.0
        largest = max(largest, abs(fixed[i]))
    for _ in range(MOST_STEPS):
        multiply_factor(n, rank, L, y, z)
        overload(problem, z, x)
        multiply_transposed(n, rank, L, x, slope)
        worst = 0.0
        for i in range(rank):
            slope[i] = slope[i] - fixed[i]
            step[i] = -slope[i]
            worst = max(worst, abs(slope[i]))
        if worst <= SETTLED * largest:
            return 1
        put_curvature(problem, z)
        if factor_dense(rank, problem.matrix, problem.pivots) == 0:
            return 0
        solve_dense(rank, problem.matrix, problem.pivots, step)
        if descend(problem, y, step, slope, z, fixed) == 0:
            return 0
    return 0


def put_curvature(problem: ModeProblem, z: Reals) -> None:
    """Store the second derivatives of the function: ``L^T P' L``."""
    n = problem.held_count
    rank = problem.rank
    L = problem.factor
    H = problem.matrix
    clear_curvature(n, rank, L, H)
    for k in range(problem.count):
        element = problem.elements[k]
        if element.mode == HOLDS and element.moves == 0.0:
            i = held_place(problem, element.row)
            bound = bound_of(element)
            if element.law == CONE:
                add_disc(problem, i, held_place(problem, element.row + 1), bound, z, H)
            elif element.law == UNILATERAL:
                if z[i] >= -bound:
                    add_square(n, rank, L, H, i, i, 1.0)
            elif abs(z[i]) <= bound:
                add_square(n, rank, L, H, i, i, 1.0)


def clear_curvature(n: int, rank: int, L: Reals, H: Reals) -> None:
    """Set H (rank, rank) to what keeps it regular where no effort is free."""
    trace = 0.0
    for i in range(n):
        for j in range(min(i + 1, rank)):
            trace = trace + L[i * n + j] * L[i * n + j]
    for k in range(rank * rank):
        H[k] = 0.0
    for c in range(rank):
        H[c * rank + c] = RAISED * trace


def add_disc(problem: ModeProblem, i: int, j: int, bound: float, z: Reals, H: Reals) -> None:
    """Add the second derivatives for two rows whose norm is bounded."""
    n = problem.held_count
    rank = problem.rank
    L = problem.factor
    size = sqrt(z[i] * z[i] + z[j] * z[j])
    if size <= bound:
        add_square(n, rank, L, H, i, i, 1.0)
        add_square(n, rank, L, H, j, j, 1.0)
    else:
        share = bound / (size * size * size)
        add_square(n, rank, L, H, i, i, share * z[j] * z[j])
        add_square(n, rank, L, H, i, j, -share * z[i] * z[j])
        add_square(n, rank, L, H, j, i, -share * z[i] * z[j])
        add_square(n, rank, L, H, j, j, share * z[i] * z[i])


def add_square(n: int, rank: int, L: Reals, H: Reals, i: int, j: int, share: float) -> None:
    """Add a share of the product of two rows of L to H (rank, rank)."""
    for a in range(min(i + 1, rank)):
        for b in range(min(j + 1, rank)):
            H[a * rank + b] = H[a * rank + b] + share * L[i * n + a] * L[j * n + b]


def descend(problem: ModeProblem, y: Reals, step: Reals, slope: Reals, z: Reals, fixed: Reals) -> int:
    """Go along a step, or less, so that the function sinks as its slope says; return 0 if it does not."""
    n = problem.held_count
    rank = problem.rank
    before = height(problem, y, z, fixed)
    fall = 0.0
    for i in range(rank):
        fall = fall + slope[i] * step[i]
    length = 1.0
    for _ in range(MOST_HALVINGS):
        for i in range(rank):
            y[i] = y[i] + length * step[i]
        multiply_factor(n, rank, problem.factor, y, z)
        if height(problem, y, z, fixed) <= before + 1e-4 * length * fall:
            return 1
        for i in range(rank):
            y[i] = y[i] - length * step[i]
        length = 0.5 * length
    return 0


def height(problem: ModeProblem, y: Reals, z: Reals, fixed: Reals) -> float:
    """Return the function of y, for ``z = L y``."""
    total = 0.0
    for c in range(problem.rank):
        total = total - fixed[c] * y[c]
    for k in range(problem.count):
        element = problem.elements[k]
        if element.mode == HOLDS and element.moves == 0.0:
            i = held_place(problem, element.row)
            bound = bound_of(element)
            square = z[i] * z[i]
            if element.law == CONE:
                j = held_place(problem, element.row + 1)
                square = square + z[j] * z[j]
            if element.law == UNILATERAL:
                if z[i] > -bound:
                    total = total + 0.5 * square
            elif square <= bound * bound:
                total = total + 0.5 * square
            else:
                total = total + bound * sqrt(square) - 0.5 * bound * bound
    return total
