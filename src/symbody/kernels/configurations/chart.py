"""A mechanism on a chart: dependent coordinates and speeds follow from the others.

`chart_rates` and `chart_moves` are called as functions of generated code are: see
`codegen.llvm.kernel_library.load_functions`. The dependent ones that are given are where Newton's method
begins, so that it stays on the branch of the motion.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import CHART_IS_WORN, OUT_OF_REACH
from symbody.kernels.configurations.chart_record import Chart
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part
from symbody.kernels.linear.dense_factors import factor_dense, solve_dense

# As in `manifold.newton`: steps that do not shrink to this share lead elsewhere, so do long ones.
MOST_ROUNDS: Final = 15
SHRINKAGE: Final = 0.6
ROUNDED: Final = 1e-14  # what rounding leaves of a coordinate in Newton's steps


def evaluate_chart(h: Function, chart: Chart, t: Reals, r: Reals) -> None:
    """Evaluate constraints, their derivatives, velocity residuals and J in the state of a chart."""
    x = chart.state
    numbers = chart.numbers
    q = part(x, chart.speeds, chart.coordinates)
    # Accelerations that do not exist do not matter.
    _status = h(t, q, x, r, numbers.parameters, numbers.constants, chart.out, numbers.work)


def norm_condition(chart: Chart, number: int, slopes: Reals) -> float:
    """Return how much longer than 1 a quaternion is, to first order; its slopes go to their coordinates."""
    q = part(chart.state, chart.speeds, chart.coordinates)
    places = part(chart.quaternion_places, 4 * number, 4)
    total = 0.0
    for i in range(chart.coordinates):
        slopes[i] = 0.0
    for k in range(4):
        place = int(places[k])
        slopes[place] = q[place]
        total = total + q[place] * q[place]
    return (total - 1.0) / 2.0


def fill_row(n: int, row: Reals, share: float, places: Reals, sizes: Reals, target: Reals) -> None:
    """Copy the entries of a row that belong to dependent ones, each by its size and the share."""
    for b in range(n):
        place = int(places[b])
        target[b] = row[place] * sizes[place] * share


def solve_moves(chart: Chart, n: int, best: float) -> float:
    """Overwrite n residuals in `move` by the moves that take them away; return the least pivot.

    It is 0 if there are no moves. The chart is worn where it is less than a share of the best so far.
    """
    matrix = chart.matrix
    move = chart.move
    least = INFINITY
    if factor_dense(n, matrix, chart.pivots) == 0:
        least = 0.0
    for i in range(n):
        least = min(least, abs(matrix[i * n + i]))
    if least < chart.share * best:
        chart.worn = 1.0
    if least == 0.0:
        return 0.0
    solve_dense(n, matrix, chart.pivots, move)
    for i in range(n):
        move[i] = -move[i]
        if not is_finite(move[i]):
            return 0.0
    return least


def position_moves(chart: Chart) -> int:
    """Store a step of Newton's method for the dependent coordinates, over sizes; return 0 without one."""
    n = chart.dependent_positions
    n_q = chart.coordinates
    count = chart.conditions
    out = chart.out
    rows = chart.position_rows
    places = chart.position_places
    sizes = chart.sizes
    scales = chart.scales
    matrix = chart.matrix
    move = chart.move
    for a in range(n):
        row = int(rows[a])
        target = part(matrix, a * n, n)
        if row < count:
            share = 1.0 / scales[row]
            move[a] = out[row] * share
            fill_row(n, part(out, count + row * n_q, n_q), share, places, sizes, target)
        else:
            move[a] = norm_condition(chart, row - count, chart.norm_row)
            fill_row(n, chart.norm_row, 1.0, places, sizes, target)
    least = solve_moves(chart, n, chart.best_position)
    if least == 0.0:
        return 0
    if least < INFINITY:
        chart.best_position = max(chart.best_position, least)
    return 1


def speed_moves(chart: Chart) -> int:
    """Store the moves of the dependent speeds, over sizes; return 0 if there are none."""
    n = chart.dependent_speeds
    n_u = chart.speeds
    residuals = chart.conditions + chart.conditions * chart.coordinates
    slopes = residuals + chart.rows
    out = chart.out
    rows = chart.speed_rows
    places = chart.speed_places
    sizes = chart.speed_sizes
    scales = chart.scales
    matrix = chart.matrix
    move = chart.move
    for a in range(n):
        row = int(rows[a])
        share = 1.0 / scales[row]
        move[a] = out[residuals + row] * share
        fill_row(n, part(out, slopes + row * n_u, n_u), share, places, sizes, part(matrix, a * n, n))
    least = solve_moves(chart, n, chart.best_speed)
    if least == 0.0:
        return 0
    if least < INFINITY:
        chart.best_speed = max(chart.best_speed, least)
    return 1


def add_moves(n: int, move: Reals, places: Reals, sizes: Reals, values: Reals) -> None:
    """Change the values at so many places by moves over their sizes."""
    for a in range(n):
        place = int(places[a])
        values[place] = values[place] + move[a] * sizes[place]


def largest_share(n: int, values: Reals) -> float:
    """Return the largest magnitude of so many values."""
    size = 0.0
    for a in range(n):
        size = max(size, abs(values[a]))
    return size


def rounding_of(chart: Chart, q: Reals) -> float:
    """Return what rounding leaves of the dependent coordinates, over their sizes."""
    places = chart.position_places
    sizes = chart.sizes
    farthest = 0.0
    for a in range(chart.dependent_positions):
        place = int(places[a])
        farthest = max(farthest, abs(q[place]) / sizes[place])
    return ROUNDED * farthest


def close_chart(h: Function, chart: Chart, t: Reals, r: Reals) -> int:
    """Move dependent coordinates and speeds of the state onto the constraints; return 0 if that fails."""
    n = chart.dependent_positions
    move = chart.move
    q = part(chart.state, chart.speeds, chart.coordinates)
    settled = max(chart.settled, rounding_of(chart, q))
    last = 1.0 / SHRINKAGE
    for _round in range(MOST_ROUNDS):
        evaluate_chart(h, chart, t, r)
        if position_moves(chart) == 0:
            return 0
        size = largest_share(n, move)
        add_moves(n, move, chart.position_places, chart.sizes, q)
        if size <= settled:
            if speed_moves(chart) == 0:
                return 0
            add_moves(chart.dependent_speeds, move, chart.speed_places, chart.speed_sizes, chart.state)
            return 1
        if not size <= SHRINKAGE * last:
            return 0
        last = size
    return 0


def enter_state(chart: Chart, q: Reals, u: Reals) -> None:
    """Copy a state to that of a chart."""
    n_u = chart.speeds
    for i in range(n_u):
        chart.state[i] = u[i]
    for i in range(chart.states - n_u):
        chart.state[n_u + i] = q[i]


def chart_rates(
    f: Function, h: Function, chart: Chart, t: Reals, q: Reals, u: Reals, r: Reals, out: Reals
) -> int:
    """Set `out` to the slopes of the state that belongs to the independent part of another one.

    Returns `OUT_OF_REACH` where there is none, `CHART_IS_WORN` where others should be independent.
    """
    enter_state(chart, q, u)
    chart.worn = 0.0
    if close_chart(h, chart, t, r) == 0:
        if chart.worn != 0.0:
            return CHART_IS_WORN
        return OUT_OF_REACH
    x = chart.state
    numbers = chart.rate_numbers
    rest = part(x, chart.speeds, chart.states - chart.speeds)
    status = f(t, rest, x, r, numbers.parameters, numbers.constants, out, numbers.work)
    if status == 0 and chart.worn != 0.0:
        return CHART_IS_WORN
    return status


def chart_moves(h: Function, chart: Chart, t: Reals, q: Reals, u: Reals, r: Reals, out: Reals) -> int:
    """Write what `projection` reads: residuals, moves of all coordinates, moves of all speeds."""
    count = chart.dependent_positions
    n_u = chart.speeds
    n_q = chart.coordinates
    places = chart.position_places
    moves = part(out, count, n_q + n_u)
    enter_state(chart, q, u)
    evaluate_chart(h, chart, t, r)
    for i in range(n_q + n_u):
        moves[i] = 0.0
    if position_moves(chart) == 0:
        return 1
    add_moves(count, chart.move, places, chart.sizes, moves)
    for a in range(count):
        row = int(chart.position_rows[a])
        if row < chart.conditions:
            out[a] = chart.out[row] / chart.scales[row]
        else:
            out[a] = norm_condition(chart, row - chart.conditions, chart.norm_row)
    if speed_moves(chart) == 0:
        return 1
    rates = part(moves, n_q, n_u)
    add_moves(chart.dependent_speeds, chart.move, chart.speed_places, chart.speed_sizes, rates)
    return 0
