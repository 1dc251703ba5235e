"""`StrikeProblem` and `RateJumps`: what prescribed rates that jump do to the speeds, and when."""

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, Rows, pointer


class StrikeProblem(RecordLayout):
    """A jump of prescribed rates: sizes, and what was found.

    The function writes the constraints on positions, the velocity residuals, the rows of J, then the momenta
    of the speeds, the mass matrix and the energy.
    """

    speeds: int
    positions: int  # constraints on positions
    rows: int  # of J
    out_size: int
    room: int  # of scratch
    torn: int  # the constraint that no state fulfils on both sides, from 1; 0 for none
    energy: float  # before the jump, and by how much it rises there [J]
    gained: float

    numbers: FunctionNumbers = pointer()  # of the function
    limits: Reals = pointer("positions")  # by how much a constraint may change
    out: Reals = pointer("out_size")
    residuals: Reals = pointer("positions")
    momenta: Reals = pointer("speeds")  # by how much prescribed rates change them, less than before
    rates: Reals = pointer("rows")  # by how much the rates of constraints have to change
    result: Reals = pointer("room")
    scratch: Reals = pointer("room")


class RateJump(RecordLayout):
    """One jump of prescribed rates: when, and what it has done."""

    before: float  # where the motion before it ends [s]
    meets: float  # where that meets the motion behind it
    behind: float  # where that begins
    gained: float  # by how much the energy has risen [J]
    change: float  # the largest change of a state


class RateJumps(RecordLayout):
    """When prescribed rates jump along a motion."""

    next: int
    count: int
    t_end: float  # of the motion [s]
    ends_behind: float  # whether the motion ends just behind each, 1 or 0: it goes on outside
    jumps: Rows[RateJump] = pointer("count")
    problem: StrikeProblem = pointer()
