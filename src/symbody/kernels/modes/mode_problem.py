"""`ModeProblem`: the elements that may hold or not, reduced to the rows along which they do.

A unit of effort along a row changes the accelerations of all rows by a column of `responses`, and the
reactions that bounds read by a column of `reactions`; without efforts they are `offsets` and `loads`.
"""

from typing import Final

from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, Rows, pointer

# What elements are.
UNILATERAL: Final = 0  # one row, the gap: its effort opens the gap and is never negative
BOUNDED: Final = 1  # one row: its effort is within a bound
CONE: Final = 2  # two rows: the norm of the effort is within a bound

# Their modes. What is loose slips, or its gap opens.
HOLDS: Final = 0
LOOSE: Final = 1
BACK: Final = -1  # slips backward: elements with one row and a bound


class ModeElement(RecordLayout):
    """One element that may hold or not. What is asked by *whether* is 1 or 0."""

    law: int
    row: int  # the first
    normal: int  # the first component of the reaction that its bound reads
    normals: int  # how many components; 0: the strengths are the bounds
    sliding: float  # strengths, which multiply the norm of the reaction
    static: float
    scale: float  # of displacements along the rows: an effort times it is a work
    rounding: float  # accelerations that are rounding
    moves: float  # whether it is loose whatever the efforts are, since it moves
    first: float  # the direction of slip
    second: float
    mode: int
    normal_load: float  # norm of the reaction, 1 if the bound does not read one
    excess: float  # by how much its mode is violated, as a work
    reversal: float  # the same as an acceleration over the size
    rubs: float  # whether friction of what slips follows from its share of the efforts that hold


class ModeProblem(RecordLayout):
    """What decides about modes, the solution, and scratch. What is asked by *whether* is 1 or 0."""

    count: int
    rows: int
    components: int  # of all reactions
    columns: int  # rows + 1
    root: int  # which of the solutions of a trial is taken
    roots: int  # how many have to be asked for
    certain: float  # whether it has no others
    held_count: int
    rank: int  # of the responses of the rows that hold
    slider_count: int
    solutions: int  # of all modes: 2 stands for more
    kept_held: int  # how many elements hold in the solution that is kept
    kept_kinetic: float  # whether they do within kinetic strengths
    work: float  # the largest that efforts do, for tolerances

    elements: Rows[ModeElement] = pointer("count")
    responses: Reals = pointer("rows", "rows")
    offsets: Reals = pointer("rows")
    reactions: Reals = pointer("components", "rows")
    loads: Reals = pointer("components")
    efforts: Reals = pointer("rows")
    accelerations: Reals = pointer("rows")

    sizes: Reals = pointer("rows")
    held: Reals = pointer("rows")  # rows that hold
    factor: Reals = pointer("rows", "rows")  # of their responses
    gram: Reals = pointer("rows", "rows")
    pivots: Reals = pointer("columns")
    added: Reals = pointer("rows")  # what efforts differ by from those of least norm
    sliders: Reals = pointer("count")  # elements whose friction depends on reactions
    combination: Reals = pointer(
        "columns", "rows"
    )  # efforts without sliders, and for a unit of each reaction
    parts: Reals = pointer("columns", "components")  # reactions of these
    norms: Reals = pointer("count")  # of the reactions of sliders
    matrix: Reals = pointer("columns", "columns")
    vector: Reals = pointer("columns")
    room: Reals = pointer("rows", 8)
    saved: Reals = pointer("columns", 4)  # modes and directions of the solution that is kept
    saved_rows: Reals = pointer("rows", 2)  # its efforts and accelerations
