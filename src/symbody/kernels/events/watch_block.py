"""Where a watch for events keeps what it needs: places in its block, and the codes that `look` returns.

Like a run, a watch is one array of reals. Behind the `HEADER` lie, where the header says, constants, tables
of m events, what the search remembers, and the numbers of three functions.
"""

from __future__ import annotations

from typing import Final

# What `look` returns.
NOTHING_YET: Final = 0
GOES_ON: Final = 1  # from the state `AFTER`
ENDS: Final = 2
CHATTERS: Final = 3
NO_ROOM: Final = 4  # for what happened
FAILS: Final = 5  # a function has a fault, `FAULT`
SPOILS: Final = 6  # an action sets a state to what is not finite, `BAD_VALUE`
MISSES: Final = 7  # the constraints do not admit what an action sets

# Sizes.
STATES: Final = 0
SPEEDS: Final = 1
PIECE_ROWS: Final = 2
EVENTS: Final = 3
ACTION_VALUES: Final = 6
HAPPENED_ROOM: Final = 8

# What counts.
DIRECTION: Final = 9
SPAN: Final = 10  # length of the run [s]

# Where things lie.
EXTREMUM_FIT: Final = 11
STEP_FIT: Final = 12
TABLE: Final = 13  # a row of `EVENT_SIZE` an event
TARGETS: Final = 14  # places of the states that actions set
PENDING: Final = 15  # zeros that wait until all before them are known
LEAF: Final = 16  # samples of the part of a step that is looked at
STACK: Final = 17  # where later parts of the step end, and how often it was halved for them
RECENT: Final = 18
NUMBERS: Final = 19  # of the values of events
VALUES: Final = 20
ACTIONS: Final = 21  # numbers of the function of actions; 0 where no event acts
ACTED: Final = 22  # what it writes
CLOSING: Final = 23  # what closes states, see `closing`; 0 where there is nothing to close
BEFORE: Final = 26  # states
AFTER: Final = 27
SCRATCH: Final = 28

# What the search remembers.
FIRST_STEP: Final = 29  # of the smooth motion
SAMPLED: Final = 30  # steps
CURRENT: Final = 31  # step that is looked at
SEEN: Final = 32  # samples of the smooth motion
NODE: Final = 33  # the next sample of the leaf
LEAF_END: Final = 34
STACKED: Final = 36
PENDING_COUNT: Final = 37
T_LAST: Final = 38  # the newest sample
T_BEFORE: Final = 39  # the two before it
T_OLDER: Final = 40
HAPPENED: Final = 41  # how often something has happened
CUT: Final = 42  # when the motion is cut [s]
CULPRIT: Final = 43  # the event that happens again and again, or spoils a state, from 1; see `UNTURNED`
FAULT: Final = 44
RESUMED: Final = 45  # one more than what the run returned before there was no room for what happened
CUT_FIT: Final = 46
RATE: Final = 47  # rates of the states, the work left out
RATE_KNOWN: Final = 48  # whether those after an action are
RESOLUTION: Final = 49  # the least slope that shows above rounding
FIRST_LENGTH: Final = 50  # of many motions: what the first step of each is to be, 0 where that follows
BAD_VALUE: Final = 51  # that an action sets, and which of its values, from 1; 0 if all are finite
BAD_PLACE: Final = 52
UNMET: Final = 53  # whether the constraints do not admit what an action sets
UNTURNED: Final = 54  # whether the culprit's value goes on as before its action at a start
HEADER: Final = 55

# The fit of a cut: for each row of a piece a share of a step, the matrix from states there to the rows, and
# these states.

# A fit: the shares of an interval at which it samples, and the matrix from samples to coefficients;
# behind that of an extremum samples, scratch and the slope's coefficients.
STEP_NODES: Final = 9
EXTREMUM_NODES: Final = 13
LEAF_VALUES: Final = STEP_NODES  # the times come first

# A row of the table of events.
WAY: Final = 0  # direction of the zeros that count
ACTION: Final = 1
WRAPS: Final = 2  # whether the value reads an angle that jumps by a turn
SET_COUNT: Final = 3  # how many states its action sets, and where their values and places begin
SET_FIRST: Final = 4
MOST: Final = 5  # so many at one instant are one too many
JUST_HAPPENED: Final = 6
LARGEST: Final = 7
G_LAST: Final = 8  # values at the newest sample, and at the two before it
G_BEFORE: Final = 9
G_OLDER: Final = 10
HIT: Final = 11  # the sign before a sample that is zero, 0 if there is none
HIT_TIME: Final = 12
RECENT_COUNT: Final = 13
LEVEL: Final = 14  # what is taken from the value
AT_ZERO: Final = 15  # whether the value has not left zero yet since the smooth motion began
BAND: Final = 16  # how far from zero that is
LEAVES: Final = 17  # the direction in which it leaves, 0 if that is not known
SLOPE_BEFORE: Final = 18  # of the value, before the last action
REPEATS: Final = 19  # whether the event acted when the smooth motion began
CAME: Final = 20  # direction of the last zero that was the event
NO_NUMBER: Final = 21  # whether the value was not a number, and when first
NO_NUMBER_TIME: Final = 22
POLE: Final = 23  # whether it passed a pole, and where first
POLE_TIME: Final = 24
WAITS: Final = 25  # why an event that acts did not happen where its value was zero, and where first
WAITS_TIME: Final = 26
PEAK: Final = 27  # the largest value since the smooth motion began, and what is rounding there
ROUNDING: Final = 28
SIDE: Final = 29  # the sign of the value before the last sample of held values, 0 before it had one
GOES_THROUGH: Final = 30  # the side of zero on which the value was where a motion goes on, 0 if it begins
HERE: Final = 31  # the value at the state that was last disturbed, and by how much that changed it
BLUR: Final = 32
OF_TIME: Final = 33  # whether the value reads no state
WAS: Final = 34  # the side of zero on which the value was last, 0 if it never was on one
DONE: Final = 35  # the direction of a zero at which the event has happened, while the value goes on there
AT_START: Final = 36  # whether the event happens because of how its value leaves zero at a start
EVENT_SIZE: Final = 37

# Why an event waits.
RESTS: Final = 1.0  # its value has no first and no second rate
NO_SIDE: Final = 2.0  # it has no direction, and its value has not been on a side of zero yet

# What an event does.
RECORDS: Final = 0.0
STOPS: Final = 1.0
SETS: Final = 2.0

# A zero: when, of which event, in which direction.
ZERO_SIZE: Final = 3
DEEPEST: Final = 12  # halvings of a step
MOST_RECENT: Final = 100
# Zeros that may wait: two of each of the last samples, and one of a start.
ZEROS_PER_EVENT: Final = 8
