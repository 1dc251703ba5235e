"""`ModeSwitch`: the modes of what sticks and slips and of gaps along a motion, and what decides."""

from typing import Final

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.modes.mode_problem import ModeProblem
from symbody.kernels.record_layout import RecordLayout, Rows, pointer

# What a row of the record of modes holds first.
DECIDED: Final = 0.0  # modes from then on
SHOCK: Final = 1.0  # impulses along gaps


class SwitchingElement(RecordLayout):
    """What sticks and slips, or a gap: of a stop, a contact or a rope. What is asked by *whether* is 1 or 0.

    Its mode is one of `mode_problem`: 0 while it sticks or is closed, 1 or -1 as it slips, 1 for an open gap.
    """

    candidate: int  # its place among all candidates
    rows: int  # how many candidates it has: a contact that slips in two directions has the next one, too
    gap: int  # of the friction of a contact: the element that is its gap, from 1; else 0
    absent: float  # whether that gap is open, so that there is no friction
    is_gap: float
    unit: float  # what counts as a large displacement: 1 rad, or the size of the mechanism
    mode: int
    written: float  # its mode in the record, with the heading of a contact
    before: float  # whether the mode still matters where others are decided
    opens: int  # the mode with which the search begins
    is_decided: float  # whether that is its mode
    ended: float  # whether an event has ended its mode
    rate: float  # of the joint, or of the gap
    across: float  # the rate along the second direction of a contact
    ahead: float  # along both, the heading with which it began to slip
    aside: float
    width: float  # of the gap, below 0 where parts overlap or a rope is too long
    length: float  # what the gap is small against
    restitution: float
    impulse: float  # in the last shock [N s]
    level: float  # what is taken from the value whose fall to zero ends the mode
    shares: float  # whether others that hold can take over some of the effort that holds it


class ModeSwitch(RecordLayout):
    """Modes along a motion. What is asked by *whether* is 1 or 0.

    A function writes what decides: `mode_responses`, then the rates of the joints, the gaps, their rates,
    scales and restitution, and the energy. Another one writes residuals and moves that project a state.
    """

    count: int  # elements: joints, then gaps
    gaps: int
    rates: int  # of what sticks and slips, of contacts two
    candidates: int  # directions of friction that is to be found, then gaps
    components: int  # of reactions that friction reads
    states: int  # the work, which is the last one, among them
    speeds: int
    out_size: int
    moves_size: int
    first_input: int  # place of the modes among the inputs of all functions
    first_event: int  # place of the events that end modes
    length: float  # of the mechanism [m]
    time: float  # in which it moves by its size [s]
    fastest: float  # speeds over displacements as large as the mechanism so far [1/s]
    known: float  # whether modes have been decided
    changed: float  # whether the last decision changed a mode or a speed
    shares: int  # elements that share efforts
    verdict: int  # of `find_modes`
    culprit: int  # the element that is to blame, from 1
    fault: int  # status of a function
    lost: float  # energy in the last shock [J]
    recorded: int
    room: int  # rows of the record

    elements: Rows[SwitchingElement] = pointer("count")
    impulses: Reals = pointer("candidates")  # of an impact, and the loads that they make
    shocks: Reals = pointer("components")
    places: Reals = pointer("candidates")  # the element of each; -1 for friction that does not switch
    normals: Reals = pointer("candidates")  # how many components of its reaction each candidate reads
    units: Reals = pointer("candidates")
    are_lengths: Reals = pointer("candidates")  # whether these are lengths, not angles
    acting: Reals = pointer("candidates")  # the candidates of the mode problem
    sizes: Reals = pointer("speeds")  # displacements that count as large
    kept: Reals = pointer("count")
    fitted: Reals = pointer("states")
    out: Reals = pointer("out_size")
    moves: Reals = pointer("moves_size")
    problem: ModeProblem = pointer()
    numbers: FunctionNumbers = pointer()  # of the function that decides
    projection: FunctionNumbers = pointer()  # of the function that projects
