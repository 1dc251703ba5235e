"""One trial of modes: the efforts with which rows that hold keep still and what slips is rubbed.

Elements whose bound reads a reaction and that slip are *sliders*. All efforts are affine in the norms N of
the sliders' reactions, so N solves ``N_j = |a_j + sum of d_jk N_k|``: a quadratic equation for one, Newton's
method for several, as in `equations.solving.friction_solution`. There is one solution where all pivots of
``1 - |d_jk|`` are positive. Elsewhere `root` chooses one: of one slider, and of several whose reactions have
one component each, all are found.

An element with a cone that begins to slip does so along its acceleration a, against friction of size f along
-d. With r at least the largest response of the cone, ``d <- (a + r f d) / |a + r f d|`` never expands, and is
exact at once where responses are equal in all directions.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Reals, half, is_finite, part, sqrt
from symbody.kernels.linear.dense_factors import factor_dense, solve_dense
from symbody.kernels.modes.held_rows import solve_held
from symbody.kernels.modes.mode_problem import CONE, HOLDS, LOOSE, UNILATERAL, ModeElement, ModeProblem

# What `solve_modes` returns.
SOLVED: Final = 0
UNSOLVED: Final = 1

TINY: Final = 1e-200  # squares of reactions below which these have no direction
SLIGHT: Final = 1e-90  # reactions that are none
MOST_STEPS: Final = 40  # of Newton's method
MOST_SIGNS: Final = 4  # sliders of whose reactions all signs are tried
MOST_TURNS: Final = 1000  # of directions of cones that begin to slip
SETTLED: Final = 1e-14  # changes of directions, of 1
FOUND: Final = 1e-9  # residuals of reactions over them, `symbody.tolerances.UNSOLVED`; changes of directions


def list_held(problem: ModeProblem) -> None:
    """List the rows that hold and the elements whose friction depends on reactions."""
    held = problem.held
    sliders = problem.sliders
    count = 0
    sliding = 0
    for k in range(problem.count):
        element = problem.elements[k]
        element.rubs = 0.0
        for i in range(element.row, element.row + row_count(element)):
            problem.added[i] = 0.0
            problem.sizes[i] = element.scale
            problem.room[7 * problem.rows + i] = element.rounding / element.scale
            if is_held(element) == 1:
                held[count] = float(i)
                count = count + 1
        if is_slider(element) == 1:
            sliders[sliding] = float(k)
            sliding = sliding + 1
    problem.held_count = count
    problem.slider_count = sliding


def row_count(element: ModeElement) -> int:
    """Return how many rows an element has."""
    if element.law == CONE:
        return 2
    return 1


def is_held(element: ModeElement) -> int:
    """Return 1 if the rows of an element hold, else 0."""
    if element.mode == HOLDS and element.moves == 0.0:
        return 1
    return 0


def is_slider(element: ModeElement) -> int:
    """Return 1 if an element slips with friction that depends on a reaction, else 0."""
    if element.law == UNILATERAL or is_held(element) == 1:
        return 0
    if element.normals > 0 and element.sliding != 0.0 and (element.first != 0.0 or element.second != 0.0):
        return 1
    return 0


def solve_directions(problem: ModeProblem) -> int:
    """Find efforts and accelerations, and the directions in which cones begin to slip."""
    status = SOLVED
    change = 0.0
    for _ in range(MOST_TURNS):
        status = solve_norms(problem)
        if status != SOLVED:
            break
        combine_efforts(problem)
        change = turn_cones(problem)
        if not change > SETTLED:
            break
    if not change <= FOUND:
        return UNSOLVED
    return status


def solve_norms(problem: ModeProblem) -> int:
    """Find the norms of the sliders' reactions."""
    n = problem.slider_count
    rows = problem.rows
    status = SOLVED
    for c in range(n + 1):
        column = part(problem.combination, c * rows, rows)
        for i in range(rows):
            column[i] = 0.0
        if c == 0:
            for k in range(problem.count):
                element = problem.elements[k]
                if element.law != UNILATERAL and is_held(element) == 0 and element.normals == 0:
                    put_friction(element, element.sliding, column)
        else:
            slider = problem.elements[int(problem.sliders[c - 1])]
            put_friction(slider, slider.sliding, column)
        if hold_rows(problem, c, column) != 0:
            status = UNSOLVED
        put_parts(problem, c, column)
    if status != SOLVED:
        return status
    problem.roots = 1
    problem.certain = 1.0
    if n == 1:
        return solve_quadratic(problem)
    if n > 1:
        return solve_newton(problem)
    return SOLVED


def put_friction(element: ModeElement, strength: float, column: Reals) -> None:
    """Store the friction of an element that slips, for a strength."""
    column[element.row] = -(element.first * strength)
    if element.law == CONE:
        column[element.row + 1] = -(element.second * strength)


def hold_rows(problem: ModeProblem, c: int, column: Reals) -> int:
    """Store the efforts of the rows that hold beside those of the others; return 1 if none hold them."""
    rows = problem.rows
    n = problem.held_count
    held = problem.held
    sizes = problem.sizes
    x = part(problem.room, 3 * rows, rows)
    y = part(problem.room, rows, 2 * rows)
    for i in range(n):
        row = int(held[i])
        total = 0.0
        if c == 0:
            total = -problem.offsets[row]
        for j in range(rows):
            total = total - problem.responses[row * rows + j] * column[j]
        x[i] = total / sizes[row]
    status = solve_held(problem, x, y)
    for i in range(n):
        other = int(held[i])
        column[other] = x[i] / sizes[other]
        if c == 0:
            column[other] = column[other] + problem.added[other]
    return status


def put_parts(problem: ModeProblem, c: int, column: Reals) -> None:
    """Store the components of all reactions for efforts."""
    rows = problem.rows
    for i in range(problem.components):
        total = 0.0
        if c == 0:
            total = problem.loads[i]
        for j in range(rows):
            total = total + problem.reactions[i * rows + j] * column[j]
        problem.parts[c * problem.components + i] = total


def product(problem: ModeProblem, element: ModeElement, a: int, b: int) -> float:
    """Return the inner product of two columns of the reaction of an element."""
    total = 0.0
    for i in range(element.normal, element.normal + element.normals):
        total = total + problem.parts[a * problem.components + i] * problem.parts[b * problem.components + i]
    return total


def solve_quadratic(problem: ModeProblem) -> int:
    """Find the norm of the reaction of one slider: ``N = |a + d N|``."""
    slider = problem.elements[int(problem.sliders[0])]
    s = product(problem, slider, 0, 0)
    p = product(problem, slider, 0, 1)
    q = product(problem, slider, 1, 1)
    norm = -1.0
    if q < 1.0:
        root = sqrt(p * p + (1.0 - q) * s)
        if p > 0.0:
            norm = (p + root) / (1.0 - q)
        elif root - p > 0.0:
            norm = s / (root - p)
        else:
            norm = 0.0
    elif not s > 0.0:
        norm = 0.0
    else:
        rest = p * p - (q - 1.0) * s
        if p < 0.0 and rest >= 0.0:
            problem.roots = 2
            norm = s / (sqrt(rest) - p)
            if problem.root == 1:
                norm = (sqrt(rest) - p) / max(q - 1.0, TINY)
    problem.norms[0] = norm
    if norm >= 0.0 and is_finite(norm):
        return SOLVED
    return UNSOLVED


def solve_newton(problem: ModeProblem) -> int:
    """Find the norms of the reactions of several sliders by Newton's method."""
    n = problem.slider_count
    A = problem.matrix
    y = problem.vector
    for j in range(n):
        for k in range(n):
            slider = problem.elements[int(problem.sliders[j])]
            A[j * n + k] = -sqrt(product(problem, slider, k + 1, k + 1))
        A[j * n + j] = A[j * n + j] + 1.0
        problem.norms[j] = sqrt(product(problem, problem.elements[int(problem.sliders[j])], 0, 0))
    problem.certain = positive_pivots(n, A)
    if problem.certain == 0.0:
        expect_roots(problem)
    residual = 0.0
    for step in range(MOST_STEPS):
        pattern = 0
        if step == 0:
            pattern = problem.root
        residual = put_newton(problem, pattern, A, y)
        if not residual > SETTLED or factor_dense(n, A, problem.pivots) == 0:
            break
        solve_dense(n, A, problem.pivots, y)
        for k in range(n):
            problem.norms[k] = y[k]
    if residual <= FOUND:
        return SOLVED
    return UNSOLVED


def expect_roots(problem: ModeProblem) -> None:
    """Let Newton's method begin with all signs of reactions: all solutions, where each has one component."""
    problem.certain = 1.0
    signs = 1
    for j in range(problem.slider_count):
        signs = signs * 2
        if problem.elements[int(problem.sliders[j])].normals > 1 or j >= MOST_SIGNS:
            problem.certain = 0.0
    if problem.slider_count <= MOST_SIGNS:
        problem.roots = signs + 1


def positive_pivots(n: int, A: Reals) -> float:
    """Return 1 if all pivots of A are positive, which is overwritten, else 0."""
    for k in range(n):
        if not A[k * n + k] > 0.0:
            return 0.0
        for i in range(k + 1, n):
            factor = A[i * n + k] / A[k * n + k]
            for j in range(k + 1, n):
                A[i * n + j] = A[i * n + j] - factor * A[k * n + j]
    return 1.0


def put_newton(problem: ModeProblem, pattern: int, A: Reals, y: Reals) -> float:
    """Store the linear system of a step; return the largest residual of a norm, over it.

    A pattern above 0 stands for signs: reactions then have the directions, or the opposite ones, that they
    have without sliders.
    """
    signs = pattern - 1
    n = problem.slider_count
    size = problem.components
    worst = 0.0
    for j in range(n):
        slider = problem.elements[int(problem.sliders[j])]
        square = TINY
        sign = 1.0
        if pattern > 0:
            if signs - 2 * half(signs) == 1:
                sign = -1.0
            signs = half(signs)
        for k in range(n + 1):
            A[j * n + max(k - 1, 0)] = 0.0
        y[j] = 0.0
        for i in range(slider.normal, slider.normal + slider.normals):
            total = reaction_part(problem, i, pattern)
            square = square + total * total
        length = sqrt(square)
        for i in range(slider.normal, slider.normal + slider.normals):
            unit = sign * reaction_part(problem, i, pattern) / length
            if pattern > 0 and slider.normals == 1:
                unit = sign
            y[j] = y[j] + unit * problem.parts[i]
            for k in range(n):
                A[j * n + k] = A[j * n + k] - unit * problem.parts[(k + 1) * size + i]
        A[j * n + j] = A[j * n + j] + 1.0
        worst = max(worst, abs(problem.norms[j] - length) / (abs(problem.norms[j]) + length + SLIGHT))
    if pattern > 0:
        return 1.0
    return worst


def reaction_part(problem: ModeProblem, i: int, pattern: int) -> float:
    """Return a component of the reactions for the norms; without sliders for a pattern above 0."""
    total = problem.parts[i]
    if pattern > 0:
        return total
    for k in range(problem.slider_count):
        total = total + problem.parts[(k + 1) * problem.components + i] * problem.norms[k]
    return total


def combine_efforts(problem: ModeProblem) -> None:
    """Set efforts, accelerations and the norms of all reactions."""
    rows = problem.rows
    work = 0.0
    for i in range(rows):
        total = problem.combination[i]
        for k in range(problem.slider_count):
            total = total + problem.combination[(k + 1) * rows + i] * problem.norms[k]
        problem.efforts[i] = total
        work = max(work, abs(total) * problem.sizes[i])
    for i in range(rows):
        rate = problem.offsets[i]
        for j in range(rows):
            rate = rate + problem.responses[i * rows + j] * problem.efforts[j]
        problem.accelerations[i] = rate
        own = problem.responses[i * rows + i]
        if own > 0.0:
            work = max(work, abs(problem.offsets[i]) / own * problem.sizes[i])
    problem.work = work
    for k in range(problem.count):
        element = problem.elements[k]
        element.normal_load = 1.0
        if element.normals > 0:
            square = 0.0
            for i in range(element.normal, element.normal + element.normals):
                component = reaction_part(problem, i, 0)
                square = square + component * component
            element.normal_load = sqrt(square)


def turn_cones(problem: ModeProblem) -> float:
    """Turn the directions in which cones begin to slip towards their accelerations; return the change."""
    rows = problem.rows
    change = 0.0
    for k in range(problem.count):
        element = problem.elements[k]
        if element.law == CONE and element.mode == LOOSE and element.moves == 0.0:
            i = element.row
            a = problem.responses[i * rows + i]
            b = problem.responses[i * rows + i + 1]
            c = problem.responses[i * rows + rows + i + 1]
            largest = 0.5 * (a + c) + sqrt(0.25 * (a - c) * (a - c) + b * b)
            friction = largest * element.sliding * element.normal_load
            x = problem.accelerations[i] + friction * element.first
            y = problem.accelerations[i + 1] + friction * element.second
            length = sqrt(x * x + y * y)
            if length > 0.0:
                change = max(change, max(abs(x / length - element.first), abs(y / length - element.second)))
                element.first = x / length
                element.second = y / length
    return change
