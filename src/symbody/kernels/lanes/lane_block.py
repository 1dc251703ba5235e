"""`LaneGroup`: motions side by side, one in each lane of a register.

Every lane has a run of its own. What is computed in all lanes at once lies beside: entry k of each array
begins at k times `LANES`.
"""

from typing import Final

from symbody.kernels.block import Method
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, inline, pointer

# Registers have at most so many lanes.
WIDEST: Final = 8


class LaneNumbers(RecordLayout):
    """The arguments of a function in lanes: times, r, p and c, and its scratch."""

    alignment = WIDEST  # what begins at a multiple of it is loaded by one access

    times: Reals = inline(WIDEST)
    inputs: Reals = pointer()
    parameters: Reals = pointer()
    constants: Reals = pointer()
    work: Reals = pointer()
    tables: Reals = pointer()  # the same in all lanes; nowhere if there are none


class LaneGroup(RecordLayout):
    """Motions side by side."""

    alignment = WIDEST

    # The steps that are tried: beginning, length and error, the evaluations they took, numbers on the way,
    # which lanes are meant, ones.
    start: Reals = inline(WIDEST)
    length: Reals = inline(WIDEST)
    error: Reals = inline(WIDEST)
    calls: Reals = inline(WIDEST)
    first: Reals = inline(WIDEST)
    second: Reals = inline(WIDEST)
    mask: Reals = inline(WIDEST)
    ones: Reals = inline(WIDEST)

    states: int
    speeds: int
    rtol: float
    projects: float  # whether states are projected
    next_case: int
    cases_ended: int
    run_size: int  # of the run of each lane
    method: Method  # for registers of states

    # As in a run.
    state_old: Reals = pointer()
    stage: Reals = pointer()
    state_new: Reals = pointer()
    error_1: Reals = pointer()
    error_2: Reals = pointer()
    zero_state: Reals = pointer()
    tolerances: Reals = pointer()
    slopes: Reals = pointer()
    dense: Reals = pointer()

    scratch: Reals = pointer()  # a state, and its derivative
    scratch_slope: Reals = pointer()
    numbers: LaneNumbers = pointer()
    runs: Reals = pointer()  # of the lanes, one behind the other
