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


def position_residual(chart: Chart, row: int) -> float:
    """Return a condition on positions over its scale."""
    if row < chart.conditions:
        return chart.out[row] / chart.scales[row]
    total = 0.0
    places = part(chart.quaternion_places, 4 * (row - chart.conditions), 4)
    for k in range(4):
        component = chart.state[chart.speeds + int(places[k])]
        total = total + component * component
    return (total - 1.0) / 2.0


def position_slope(chart: Chart, row: int, place: int) -> float:
    """Return its derivative by a coordinate over its size."""
    n_q = chart.coordinates
    if row < chart.conditions:
        return chart.out[chart.conditions + row * n_q + place] * chart.sizes[place] / chart.scales[row]
    places = part(chart.quaternion_places, 4 * (row - chart.conditions), 4)
    for k in range(4):
        if int(places[k]) == place:
            return chart.state[chart.speeds + place]
    return 0.0


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
    for a in range(n):
        row = int(chart.position_rows[a])
        chart.move[a] = position_residual(chart, row)
        for b in range(n):
            chart.matrix[a * n + b] = position_slope(chart, row, int(chart.position_places[b]))
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
    for a in range(n):
        row = int(chart.speed_rows[a])
        scale = chart.scales[row]
        chart.move[a] = chart.out[residuals + row] / scale
        for b in range(n):
            place = int(chart.speed_places[b])
            chart.matrix[a * n + b] = chart.out[slopes + row * n_u + place] * chart.speed_sizes[place] / scale
    least = solve_moves(chart, n, chart.best_speed)
    if least == 0.0:
        return 0
    if least < INFINITY:
        chart.best_speed = max(chart.best_speed, least)
    return 1


def close_chart(h: Function, chart: Chart, t: Reals, r: Reals) -> int:
    """Move dependent coordinates and speeds of the state onto the constraints; return 0 if that fails."""
    x = chart.state
    n_u = chart.speeds
    last = 1.0 / SHRINKAGE
    for _round in range(MOST_ROUNDS):
        evaluate_chart(h, chart, t, r)
        if position_moves(chart) == 0:
            return 0
        size = 0.0
        farthest = 0.0
        for a in range(chart.dependent_positions):
            place = int(chart.position_places[a])
            size = max(size, abs(chart.move[a]))
            x[n_u + place] = x[n_u + place] + chart.move[a] * chart.sizes[place]
            farthest = max(farthest, abs(x[n_u + place]) / chart.sizes[place])
        if size <= max(chart.settled, ROUNDED * farthest):
            if speed_moves(chart) == 0:
                return 0
            for a in range(chart.dependent_speeds):
                place = int(chart.speed_places[a])
                x[place] = x[place] + chart.move[a] * chart.speed_sizes[place]
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
    enter_state(chart, q, u)
    evaluate_chart(h, chart, t, r)
    for i in range(n_q + n_u):
        out[count + i] = 0.0
    for a in range(count):
        out[a] = position_residual(chart, int(chart.position_rows[a]))
    if position_moves(chart) == 0:
        return 1
    for a in range(count):
        place = int(chart.position_places[a])
        out[count + place] = chart.move[a] * chart.sizes[place]
    if speed_moves(chart) == 0:
        return 1
    for a in range(chart.dependent_speeds):
        place = int(chart.speed_places[a])
        out[count + n_q + place] = chart.move[a] * chart.speed_sizes[place]
    return 0
