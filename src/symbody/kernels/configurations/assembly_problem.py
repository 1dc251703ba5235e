"""`AssemblyProblem`: what closes a state, and how it is to be closed."""

from symbody.kernels.language import Reals
from symbody.kernels.record import Record, stored


class AssemblyProblem(Record):
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

    held: Reals = stored()  # 1 for each state that keeps its value, else 0
    sizes: Reals = stored()  # what counts as a large change of each state
    scales: Reals = stored("residuals")  # what counts as a large residual of each constraint on positions
    out: Reals = stored("out_size")
    matrices: Reals = stored()  # scratch
    numbers: Reals = stored()  # of the function
    old: Reals = stored("coordinates")  # coordinates before a move
    quaternion_places: Reals = stored("quaternion_count", 4)  # in q
    limited: Reals = stored("coordinates")  # 1 for each coordinate that moves by a size at most in a step

    # Of `closing`: whether the function writes the mass matrix behind J, 1 or 0. Substituted coordinates that
    # count: how many with their rates, how many states they are left out of; flags of held ones of these
    # states, the places of these states and of what is left out among all, and all states.
    weighed: float
    followers: int
    states: int
    asked: Reals = stored()
    places: Reals = stored("states")
    follower_places: Reals = stored("followers")
    whole: Reals = stored()

    # Of `first_state`: how many cosines of axes; how many chosen speeds, and of these such that have to fit;
    # rows of J that are zero; the chosen speeds, each a place in u and a value, and room for rows.
    cosines: int
    choices: int
    kept: int
    zero_rows: int
    chosen: Reals = stored("speeds", 4)
    row_room: Reals = stored()
