"""`Run`: all that a run of the integrator keeps, and the codes that its functions return."""

from typing import Final

from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, Rows, inline, pointer

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
# What motions return besides along which prescribed rates jump: positions jump, too; no speeds fit the rates.
TORN_MOTION: Final = 16
NO_IMPULSE: Final = 17
# What motions return besides along which joints stick and slip or gaps close.
NO_MODE_ROOM: Final = 18
MODE_FAULT: Final = 19
UNDECIDED: Final = 20  # no modes fit all laws, or more than one
UNMOVABLE: Final = 21  # no speeds keep gaps from closing further
TOO_LONG: Final = 22  # an action leaves parts that overlap, or a rope longer than it can be
# Within a step: the motion is cut, and not begun again yet.
CUT: Final = 23
# What motions on a chart return where other coordinates should be independent: the step is not taken.
CHART_ENDS: Final = 24
# What is returned to who brings an integrator: it has to begin anew from the state that an event has set.
RESTARTED: Final = 25

# What a right-hand side on a chart returns for that, and where it finds no closed state. Positive numbers
# are those of kernels that fail.
CHART_IS_WORN: Final = -1
OUT_OF_REACH: Final = -2

# The code in a verdict that has not been reached.
NOT_ENDED: Final = -1


class Counts(RecordLayout):
    """What a run counts, and what is to blame where it ends early.

    What grows without end is a real: integers of C end at 2^31.
    """

    accepted: float
    rejected: float
    evaluations: float
    samples: int
    steps: int  # whose dense output is kept
    failed_kernel: int  # which one of the right-hand side failed, from 1; 0 for none
    blamed_state: int


class RunGoal(RecordLayout):
    """What is to be reached, and how carefully. It stays the same from step to step."""

    direction: float
    rtol: float
    max_step: float
    max_trials: float
    stop_when_stiff: float


class SampleRoom(RecordLayout):
    """What is stored of a run, and how much room there is. What is asked by *whether* is 1 or 0."""

    every_step: float  # whether each is a sample
    keep_dense: float
    times: int  # how many samples there are to be
    samples: int
    steps: int


class CaseCursor(RecordLayout):
    """Of many motions, the one that is computed."""

    start: float  # when all begin [s]
    current: int  # -1 for none
    begun: float
    ended: int  # how many have
    lane_code: int  # of side by side motions: what `advance` would have returned


class Breakpoint(RecordLayout):
    """When something that depends on time alone changes."""

    time: float
    longest: float  # how long a step before it may be
    jumps: float  # whether something jumps
    margin: float  # within what of its time


class BreakpointTable(RecordLayout):
    """All breakpoints of a motion, the last at an infinite time."""

    next: int
    count: int
    points: Rows[Breakpoint] = pointer("count")


class Method(RecordLayout):
    """An explicit Runge-Kutta method for states of a given number."""

    order: int
    stages: int
    stage_rows: int  # rows of A, those for dense output alone among them
    dense_rows: int  # rows of the dense output
    error_reads_end: float
    exponent: float
    memory: float
    shrink: float
    growth: float
    stiff_bound: float
    split: float
    nodes: Reals = inline(20)
    rows: Reals = inline(32)  # which weight each row begins with, and where the last ends
    weights: Reals = inline(448)  # pairs: where the derivative of a stage begins, and its weight


class FunctionNumbers(RecordLayout):
    """The arguments of a function of generated code: its time, r, p and c, and its scratch."""

    time: float
    input_count: int
    parameter_count: int
    constant_count: int
    work_size: int
    inputs: Reals = pointer("input_count")
    parameters: Reals = pointer("parameter_count")
    constants: Reals = pointer("constant_count")
    work: Reals = pointer("work_size")
    tables: Reals = pointer()  # inputs that are tables, see `tables`; nowhere if there are none


class StateProjection(RecordLayout):
    """What brings states back onto the constraints."""

    coordinates: int
    residuals: int
    out_size: int
    limit: float  # moves above so many tolerated errors reject a step
    rounding: float  # how exactly residuals are known, over what counts as closed
    scales: Reals = pointer("residuals")  # the largest position residuals that count as closed
    sizes: Reals = pointer("coordinates")  # what counts as a large coordinate
    out: Reals = pointer("out_size")  # what the function writes
    numbers: FunctionNumbers = pointer()


class Run(RecordLayout):
    """All of a run: a copy is a copy of the run.

    Its own numbers and `counts` change from step to step; those of its other records do not, but where the
    search for the next breakpoint begins.
    """

    counts: Counts
    time: float
    step: float  # the length to try next
    error: float  # norm of the error of the step before
    length: float  # of the step that is tried, and its end
    t_new: float
    t_end: float
    first_step: float  # 0 where it follows from the first derivatives
    after_rejection: float
    stiff_votes: int
    other_votes: int
    unjudged: int  # steps since the last that was judged for stiffness
    states: int
    speeds: int
    goal: RunGoal
    room: SampleRoom
    cases: CaseCursor
    breaks: BreakpointTable
    method: Method
    state_old: Reals = pointer("states")
    stage: Reals = pointer("states")
    state_new: Reals = pointer("states")
    error_1: Reals = pointer("states")
    error_2: Reals = pointer("states")
    zero_state: Reals = pointer("states")
    tolerances: Reals = pointer("states")  # absolute
    slopes: Reals = pointer()  # derivatives of the stages
    dense: Reals = pointer()  # dense output of one step
    numbers: FunctionNumbers = pointer()  # of the right-hand side
    projection: StateProjection = pointer()  # nowhere if nothing is projected
    gaps: Reals = pointer()  # an `EventMonitor` of those over which no step may pass; nowhere without any


class Verdict(RecordLayout):
    """How a case ended."""

    code: int  # -1 without one
    reached: float  # up to when the motion is known [s]
    counts: Counts
