"""`AssemblyProblem`: what closes a state, and how it is to be closed."""

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, pointer


class AssemblyProblem(RecordLayout):
    """The state of a mechanism that is to be closed: sizes, what is held, scratch.

    States are x = (u, q), and `rows` those of J. The function writes the constraints on positions, their
    derivatives by the coordinates, the velocity residuals and J, then what `closing` or `first_state` reads.
    """

    speeds: int
    coordinates: int
    residuals: int  # constraints on positions
    rows: int
    out_size: int
    quaternion_count: int
    share: float  # the residual, over sizes, of constraints that count as closed
    enough: float  # the residual from which on nothing is moved

    held: Reals = pointer()  # 1 for each state that keeps its value, else 0
    sizes: Reals = pointer()  # what counts as a large change of each state
    scales: Reals = pointer("residuals")  # what counts as a large residual of each constraint on positions
    out: Reals = pointer("out_size")
    matrices: Reals = pointer()  # scratch
    numbers: FunctionNumbers = pointer()  # of the function
    old: Reals = pointer("coordinates")  # coordinates before a move
    quaternion_places: Reals = pointer("quaternion_count", 4)  # in q
    limited: Reals = pointer("coordinates")  # 1 for each coordinate that moves by a size at most in a step

    # Of `closing`: whether the function writes the mass matrix behind J, 1 or 0. Substituted coordinates that
    # count: how many with their rates, how many states they are left out of; flags of held ones of these
    # states, the places of these states and of what is left out among all, and all states.
    weighed: float
    followers: int
    states: int
    asked: Reals = pointer()
    places: Reals = pointer("states")
    follower_places: Reals = pointer("followers")
    whole: Reals = pointer()

    # Of `first_state`: how many cosines of axes; how many chosen speeds, and of these such that have to fit;
    # rows of J that are zero; the chosen speeds, each a place in u and a value, and room for rows.
    cosines: int
    choices: int
    kept: int
    zero_rows: int
    chosen: Reals = pointer("speeds", 4)
    row_room: Reals = pointer()
