"""`ImplicitStep`: what the generalized-alpha method keeps beside the run of a motion."""

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, pointer


class ImplicitStep(RecordLayout):
    """What the generalized-alpha method keeps.

    With states x = (u, q, s) and the work behind them, v = (u, s) are those whose rates it solves for.
    """

    alpha_m: float  # weights of rates, of velocities and of displacements
    alpha_f: float
    gamma: float
    beta: float
    lag: float  # by what share of a step the algorithmic rates lag behind
    states: int  # with the work
    speeds: int
    coordinates: int
    unknowns: int  # how many there are in v
    rates_size: int  # of u, q and s together
    one_length: float  # whether all steps have one length, but those that end at a jump or at the end

    length_before: float  # how long the last step was [s], 0 at a start
    factored_for: float  # for which length the factors are, 0 without any
    has_derivatives: float
    contraction: float  # how fast corrections shrink
    derivatives_made: float
    factors_made: float
    rounds: float

    rates: Reals = pointer("unknowns")  # algorithmic, at the last step's end
    rates_used: Reals = pointer("unknowns")  # the same for the length of the step that is tried
    rates_new: Reals = pointer("unknowns")  # and at its end
    correction: Reals = pointer("unknowns")
    slopes_used: Reals = pointer("unknowns")  # of v at the start of the step
    slopes_before: Reals = pointer("states")  # one step before
    slopes_change: Reals = pointer("states")  # how slopes change at a start
    middle: Reals = pointer("states")  # a state inside the step
    turn: Reals = pointer("coordinates")  # rates of coordinates there
    derivatives: Reals = pointer("rates_size", "rates_size")  # of all rates by all states
    through_q: Reals = pointer("unknowns", "speeds")  # of v by u through q
    factors: Reals = pointer("unknowns", "unknowns")
    pivots: Reals = pointer("unknowns")  # rows that are exchanged
    rate_numbers: FunctionNumbers = pointer()  # of the function of the rates of coordinates
    derivative_numbers: FunctionNumbers = pointer()  # of the function of the derivatives
