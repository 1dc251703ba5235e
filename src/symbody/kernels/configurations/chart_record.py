"""`Chart`: which coordinates and speeds of a mechanism follow from the others, and by which constraints."""

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, pointer


class Chart(RecordLayout):
    """Dependent coordinates and speeds, by places, the rows from which they follow, and scratch.

    The function of positions writes constraints, their derivatives by coordinates, velocity residuals and J;
    rows from `conditions` on are norms of quaternions. Moves are measured in sizes, residuals in scales.
    """

    states: int
    speeds: int
    coordinates: int
    conditions: int  # constraints on positions, without norms
    rows: int  # of J
    out_size: int
    dependent_positions: int
    dependent_speeds: int
    quaternion_count: int
    settled: float  # Newton's method ends with a step as small as that
    share: float  # the chart is worn where the least pivot of a matrix is less than this share of its best
    best_position: float
    best_speed: float
    worn: float
    position_rows: Reals = pointer("dependent_positions")
    position_places: Reals = pointer("dependent_positions")  # in q
    speed_rows: Reals = pointer("dependent_speeds")
    speed_places: Reals = pointer("dependent_speeds")  # in u
    quaternion_places: Reals = pointer("quaternion_count", 4)  # in q
    sizes: Reals = pointer("coordinates")
    speed_sizes: Reals = pointer("speeds")
    scales: Reals = pointer("rows")  # those of constraints on positions come first
    state: Reals = pointer("states")  # the closed one
    out: Reals = pointer("out_size")
    norm_row: Reals = pointer("coordinates")
    matrix: Reals = pointer()
    move: Reals = pointer()
    pivots: Reals = pointer()
    numbers: FunctionNumbers = pointer()  # of the function of positions
    rate_numbers: FunctionNumbers = pointer()  # of the right-hand side
