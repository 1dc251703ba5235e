"""Where a run keeps what it needs: places in its block, and the codes that its functions return.

All of a run lies in one array of reals: what it is to reach, the method, the state, counters as whole
numbers. A copy of the block is a copy of the run. Behind the `HEADER` follow the method, vectors of the n
states x = (u, q), the derivatives of the stages, the dense output of one step; then, where the header says,
breakpoints and the numbers of both functions.
"""

from __future__ import annotations

from typing import Final

# What `begin` and `advance` return.
RUNNING: Final = 0
FULL: Final = 1
FINISHED: Final = 2
COLLAPSED: Final = 3
NOT_FINITE: Final = 4
SINGULAR: Final = 5
TOO_MANY: Final = 6
STIFF: Final = 7
# What motions that are searched for events return besides.
NO_EVENT_ROOM: Final = 8
STOPPED: Final = 9
CHATTERING: Final = 10
EVENT_FAULT: Final = 11
# What motions with held values return besides.
NO_SAMPLE_ROOM: Final = 12
SAMPLE_FAULT: Final = 13
# What motions that are searched for events return where an action sets what is not finite.
SPOILED: Final = 14
# The same where the constraints do not admit what an action sets.
UNMET: Final = 15

# Counters, first in the block.
ACCEPTED: Final = 0
REJECTED: Final = 1
EVALUATIONS: Final = 2
SAMPLES: Final = 3
STEPS: Final = 4  # whose dense output is kept
KERNEL: Final = 5  # which one of the right-hand side failed, from 1; 0 for none
STATE: Final = 6  # which state is to blame
AFTER_REJECTION: Final = 7
STIFF_VOTES: Final = 8
OTHER_VOTES: Final = 9
NEXT_BREAK: Final = 10
FIRST_BREAK: Final = 11  # of this motion
UNJUDGED: Final = 12  # steps since the last that was judged for stiffness
COUNTS: Final = 13

# The step under way.
TIME: Final = 13
STEP: Final = 14  # the length to try next
ERROR: Final = 15  # norm of the error of the step before
LENGTH: Final = 16  # of the step that is tried, and its end
T_NEW: Final = 17

# What is to be reached, how carefully, and what is kept.
T_END: Final = 18
DIRECTION: Final = 19
RTOL: Final = 20
MAX_STEP: Final = 21
MAX_TRIALS: Final = 22
STOP_WHEN_STIFF: Final = 23
FIRST_STEP: Final = 24  # 0 where it follows from the first derivatives
EVERY_STEP: Final = 25  # whether each is a sample
KEEP_DENSE: Final = 26
TIMES: Final = 27  # how many samples there are to be
SAMPLE_ROOM: Final = 28
STEP_ROOM: Final = 29

# Sizes, and where things lie.
N: Final = 30
N_U: Final = 31
BREAKS: Final = 32
FUNCTION: Final = 33
PROJECTOR: Final = 34  # 0 where nothing is projected
T_START: Final = 35
CASE: Final = 36  # of many, the one that is computed, whether it has begun, and how many have ended
CASE_BEGUN: Final = 37
CASES_ENDED: Final = 38
LANE_CODE: Final = 39  # of side by side motions: what `advance` would have returned
HEADER: Final = 40

# The method, behind the header: places in it, then nodes c, where each row begins, and its entries.
METHOD: Final = HEADER
ORDER: Final = 0
STAGES: Final = 1
STAGE_ROWS: Final = 2  # rows of A, those for dense output alone among them
DENSE_ROWS: Final = 3  # rows of the dense output
ERROR_READS_END: Final = 4
EXPONENT: Final = 5
MEMORY: Final = 6
SHRINK: Final = 7
GROWTH: Final = 8
STIFF_BOUND: Final = 9
SPLIT: Final = 10
NODES: Final = 12
ROWS: Final = 32
# Pairs: where the derivative of a stage begins, and its weight.
ENTRIES: Final = 64
METHOD_SIZE: Final = 512

# Vectors behind the method; K, the derivatives, follow them.
VECTORS: Final = METHOD + METHOD_SIZE
STATE_OLD: Final = 0
STAGE: Final = 1
STATE_NEW: Final = 2
ERROR_1: Final = 3
ERROR_2: Final = 4
NOTHING: Final = 5  # zeros
TOLERANCES: Final = 6  # absolute, of each state
VECTOR_ROWS: Final = 7

# A breakpoint: when, how long a step before it may be, whether something jumps, and within what of its time.
BREAK_SIZE: Final = 4
BREAK_TIME: Final = 0
BREAK_LONGEST: Final = 1
BREAK_JUMPS: Final = 2
BREAK_MARGIN: Final = 3

# The numbers of a function: its time, where p, c, its scratch and its tables begin (0: it has none), then r
# and these.
CLOCK: Final = 0
P_PLACE: Final = 1
C_PLACE: Final = 2
WORK_PLACE: Final = 3
TABLES_PLACE: Final = 4
R_PLACE: Final = 8

# What projects: sizes and limits, where the numbers of its function begin; then the scales of the position
# residuals, the sizes of the coordinates, and what the function writes.
P_COORDINATES: Final = 0
P_RESIDUALS: Final = 1
P_OUT: Final = 2
P_OUT_SIZE: Final = 3
P_FUNCTION: Final = 4
P_LIMIT: Final = 5
P_ROUNDING: Final = 6
P_SCALES: Final = 8

# A row of a table of verdicts: the code, -1 without one, up to when the motion is known, the counters.
NOT_ENDED: Final = -1.0
CODE: Final = 0
REACHED: Final = 1
VERDICT_COUNTS: Final = 2
VERDICT_SIZE: Final = VERDICT_COUNTS + COUNTS
