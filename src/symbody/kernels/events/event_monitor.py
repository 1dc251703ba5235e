"""`EventMonitor`: what a search for events keeps, and the codes that `look` returns."""

from typing import Final

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, Rows, pointer

# What `look` returns.
NOTHING_YET: Final = 0
GOES_ON: Final = 1  # from the state `after`
ENDS: Final = 2
CHATTERS: Final = 3
NO_ROOM: Final = 4  # for what happened
FAILS: Final = 5  # a function has a fault, `fault`
SPOILS: Final = 6  # an action sets a state to what is not finite, `bad_value`
MISSES: Final = 7  # the constraints do not admit what an action sets

# Samples of a part of a step, and of an interval in which an extremum lies.
STEP_NODES: Final = 9
EXTREMUM_NODES: Final = 13
LEAF_VALUES: Final = STEP_NODES  # the times come first
DEEPEST: Final = 12  # halvings of a step
MOST_RECENT: Final = 100
# Zeros that may wait: two of each of the last samples, and one of a start.
ZEROS_PER_EVENT: Final = 8

# Why an event waits.
RESTS: Final = 1.0  # its value has no first and no second rate
NO_SIDE: Final = 2.0  # it has no direction, and its value has not been on a side of zero yet

# What an event does.
RECORDS: Final = 0.0
STOPS: Final = 1.0
SETS: Final = 2.0
SWITCHES: Final = 3.0  # ends a mode
SHORTENS: Final = 4.0  # lets its step be taken again, shorter, without being written down


class MonitoredEvent(RecordLayout):
    """One event, and what the search remembers of its value. What is asked by *whether* is 1 or 0."""

    way: float  # direction of the zeros that count
    action: float
    wraps: float  # whether the value reads an angle that jumps by a turn
    set_count: int  # how many states its action sets, and where their values and places begin
    set_first: int
    most: int  # so many at one instant are one too many
    just_happened: float
    largest: float
    g_last: float  # values at the newest sample, and at the two before it
    g_before: float
    g_older: float
    hit: float  # the sign before a sample that is zero, 0 if there is none
    hit_time: float
    recent_count: int
    level: float  # what is taken from the value
    at_zero: float  # whether the value has not left zero yet since the smooth motion began
    band: float  # how far from zero that is
    leaves: float  # the direction in which it leaves, 0 if that is not known
    slope_before: float  # of the value, before the last action
    repeats: float  # whether the event acted when the smooth motion began
    came: float  # direction of the last zero that was the event
    no_number: float  # whether the value was not a number, and when first
    no_number_time: float
    pole: float  # whether it passed a pole, and where first
    pole_time: float
    waits: float  # why an event that acts did not happen where its value was zero, and where first
    waits_time: float
    peak: float  # the largest value since the smooth motion began, and what is rounding there
    rounding: float
    side: float  # the sign of the value before the last sample of held values, 0 before it had one
    goes_through: float  # the side of zero on which the value was where a motion goes on, 0 if it begins
    here: float  # the value at the state that was last disturbed, and by how much that changed it
    blur: float
    of_time: float  # whether the value reads no state
    was: float  # the side of zero on which the value was last, 0 if it never was on one
    done: float  # the direction of a zero at which the event has happened, while the value goes on there
    at_start: float  # whether the event happens because of how its value leaves zero at a start


class Zero(RecordLayout):
    """A zero of a value: when, of which event, in which direction."""

    time: float
    event: int
    direction: float


class EventMonitor(RecordLayout):
    """A search for events along a motion. What is asked by *whether* is 1 or 0."""

    states: int
    speeds: int
    piece_rows: int
    event_count: int
    action_values: int  # how many numbers the function of actions writes
    happened_room: int
    direction: float
    span: float  # length of the run [s]

    # The shares of an interval at which it is sampled, and the matrix from samples to coefficients; behind
    # that of an extremum samples, scratch and the slope's coefficients.
    extremum_fit: Reals = pointer(EXTREMUM_NODES, EXTREMUM_NODES + 3)
    step_fit: Reals = pointer(STEP_NODES, STEP_NODES + 1)
    events: Rows[MonitoredEvent] = pointer("event_count")
    targets: Reals = pointer()  # places of the states that actions set
    pending: Rows[Zero] = pointer(
        "event_count", ZEROS_PER_EVENT
    )  # zeros that wait until all before them are known
    leaf: Reals = pointer(STEP_NODES)  # samples of the part of a step that is looked at: times, then values
    stack: Reals = pointer(
        2 * (DEEPEST + 2)
    )  # where later parts end, and how often the step was halved for them
    recent: Reals = pointer("event_count", MOST_RECENT)  # when each event happened last
    numbers: FunctionNumbers = pointer()  # of the function of the values
    values: Reals = pointer("event_count")
    actions: FunctionNumbers = pointer()  # numbers of the function of actions; nowhere if no event acts
    acted: Reals = pointer("action_values")  # what it writes
    closing: AssemblyProblem = (
        pointer()
    )  # what closes states, see `closing`; nowhere if there is nothing to close
    before: Reals = pointer("states")
    after: Reals = pointer("states")
    scratch: Reals = pointer("states", 3)
    rate: Reals = pointer("states")  # rates of the states, the work left out
    ends: Reals = pointer(2)  # of a step that is looked at by itself
    # The fit of a cut: for each row of a piece a share of a step, the matrix from states there to the rows,
    # and these states.
    cut_fit: Reals = pointer()

    first_step: int  # of the smooth motion
    sampled: int  # steps
    current: int  # step that is looked at
    seen: float  # samples of the smooth motion, which grow without end
    node: int  # the next sample of the leaf
    leaf_end: float
    stacked: int
    pending_count: int
    t_last: float  # the newest sample
    t_before: float  # the two before it
    t_older: float
    happened: int  # how often something has happened
    cut: float  # when the motion is cut [s]
    culprit: int  # the event that happens again and again, or spoils a state, from 1; see `unturned`
    fault: int
    resumed: int  # one more than what the run returned before there was no room for what happened
    rate_known: float  # whether the rates after an action are
    resolution: float  # the least slope that shows above rounding
    first_length: float  # of many motions: what the first step of each is to be, 0 where that follows
    bad_value: float  # that an action sets, and which of its values, from 1; 0 if all are finite
    bad_place: int
    unmet: float  # whether the constraints do not admit what an action sets
    unturned: float  # whether the culprit's value goes on as before its action at a start
    hands_over: float  # whether a motion ends at an action, and goes on outside from the state `after`
    has_acted: float  # whether it ended so
    actor: int  # the event that has acted last, from 1
    ended: int  # the event that has ended a mode, from 1
    bound: float  # how long a step from the cut may be that is taken again [s]; 0 where none is
    mode_count: int  # modes among the inputs of the functions, and the place of the first one
    first_mode: int
