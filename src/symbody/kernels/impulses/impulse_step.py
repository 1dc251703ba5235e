"""`ImpulseStep`: what the method of Moreau and Jean keeps beside the run of a motion.

Impulses act at points, along rows: first the gap, then up to two directions of friction. Points with a gap
stand before those with friction alone. What is asked by *whether* is 1 or 0.
"""

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, pointer


class ImpulseStep(RecordLayout):
    """What the method keeps: a pattern, what one step computes, and what is to be told of all steps."""

    states: int  # with the work
    speeds: int
    coordinates: int
    points: int
    gaps: int  # how many of the points have one
    rows: int
    blocks: int  # of speeds that the mass matrix, or rows that always hold, connect
    slopes: int  # of all rows
    shared: int  # speeds that answer to impulses at a point, of all points
    answers_size: int
    values_size: int
    responses_size: int
    block_room: int  # for the solution of one block
    tolerance: float
    sweeps: int  # at most

    # The pattern
    block_sizes: Reals = pointer("blocks")
    block_rows: Reals = pointer("blocks")  # rows that always hold
    block_values: Reals = pointer("blocks")  # where M stands in `values`, and these rows behind it
    block_responses: Reals = pointer("blocks")  # where the inverse stands in `responses`
    owners: Reals = pointer("speeds")  # the block of each
    local_places: Reals = pointer("speeds")  # its place there
    point_first: Reals = pointer("points")  # the first row
    point_rows: Reals = pointer("points")
    point_values: Reals = pointer("points")  # where restitution and friction stand in `values`
    shared_first: Reals = pointer("points")
    shared_sizes: Reals = pointer("points")
    shared_places: Reals = pointer("shared")  # speeds
    answer_first: Reals = pointer("points")  # where the answers to a unit of each row stand in `answers`
    slope_first: Reals = pointer("rows")
    slope_sizes: Reals = pointer("rows")
    slope_places: Reals = pointer("slopes")  # speeds
    row_values: Reals = pointer("rows")  # where the rate without speeds stands in `values`; slopes behind it
    closed: Reals = pointer("gaps")  # how large a gap is that counts as closed

    # One step
    widths: Reals = pointer("gaps")
    widths_before: Reals = pointer("gaps")  # where the step begins
    values: Reals = pointer("values_size")
    responses: Reals = pointer("responses_size")  # changes of the speeds of a block by a unit of each force
    has_responses: Reals = pointer("blocks")
    answers: Reals = pointer("answers_size")
    has_answers: Reals = pointer("points")
    acts: Reals = pointer("points")
    active: Reals = pointer("points")  # the points that act
    count: int
    acting_rows: Reals = pointer("rows")  # their rows
    acting: int
    own: Reals = pointer("points", 9)  # how rates of a point answer to its own impulses
    impulses: Reals = pointer("rows")
    kept: Reals = pointer("rows")  # those of the last step
    before: Reals = pointer("rows")  # rates with the speeds at the begin
    without: Reals = pointer("rows")  # rates without impulses
    multipliers: Reals = pointer("points")  # where a search for slip ended last
    free: Reals = pointer("speeds")  # speeds without impulses
    moving: Reals = pointer("speeds")
    turn: Reals = pointer("states")  # rates of coordinates
    middle: Reals = pointer("states")
    slopes_end: Reals = pointer("states")
    pushes: Reals = pointer("points")  # displacements that bring gaps back
    shifts: Reals = pointer("speeds")  # and what they make of coordinates
    nudge: Reals = pointer("speeds")
    local: Reals = pointer(32)
    start: Reals = pointer("rows")  # impulses before sweeps, and where these have led
    last_start: Reals = pointer("rows")
    last_change: Reals = pointer("rows")
    way: Reals = pointer("rows")
    history: Reals = pointer("rows", 10)  # by pairs: how changes, and ends of sweeps, have differed
    best_impulses: Reals = pointer("rows")
    best: float  # their residual
    normal_matrix: Reals = pointer(25)
    weights: Reals = pointer(5)
    known: int
    slot: int
    turn_count: int
    has_last: float
    residual_before: float
    block: Reals = pointer("block_room")
    share: float  # of restitution
    scale: float  # rates in this step, of which the tolerance is a share
    residual: float

    # All steps
    begins: float  # whether impulses of the last step are known
    worst: float  # greatest residual, as a share
    worst_time: float
    missed: float  # steps that did not reach the tolerance
    missed_time: float  # the first of them
    deepest: float  # overlap, over what counts as closed
    deepest_time: float
    swept: float
    most: float  # points that acted at once
    lowered: float  # steps with lower restitution
    steps: int  # recorded
    step_room: int
    recorded: int
    entry_room: int

    gap_numbers: FunctionNumbers = pointer()
    response_numbers: FunctionNumbers = pointer()
    rate_numbers: FunctionNumbers = pointer()
