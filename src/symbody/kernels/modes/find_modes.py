"""`find_modes`: which elements hold, which are loose, and with which efforts.

The search begins with the modes that the elements have and changes those that are violated: loads first, the
largest first, then accelerations against what is assumed; where that goes around in circles, one element at a
time in a fixed order, which ends wherever the problem is monotone [Murty, Linear Complementarity, Linear and
Nonlinear Programming, 1988, section 4.1]. What is at rest holds if its effort is within its static strength,
else it slips with the kinetic one.

Of more than four undecided elements the search begins again with all loose, and with all that hold.

There is one solution if friction changes its own bounds by a factor below 1 (`friction_gain`). Otherwise all
modes of up to four undecided elements are tried: friction may have no solution or two [Painleve 1895]. Two
are solutions with other accelerations that hold within kinetic strengths; between these and the static ones
an element holds because it did before.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import INFINITY, is_finite, part, sqrt
from symbody.kernels.modes.held_rows import factor_held, solve_held
from symbody.kernels.modes.mode_problem import (
    BACK,
    BOUNDED,
    CONE,
    HOLDS,
    LOOSE,
    UNILATERAL,
    ModeElement,
    ModeProblem,
)
from symbody.kernels.modes.mode_shares import solve_modes
from symbody.kernels.modes.mode_trial import is_held, list_held, row_count

# What `find_modes` returns.
ONE: Final = 0
NONE: Final = 1
TWO: Final = 2
NOT_FOUND: Final = 3  # by the search; there may be some

MOST_UNDECIDED: Final = 4  # elements of which all modes are tried
BALANCED: Final = 1e-9  # loads and accelerations that differ by less of themselves, `symbody.tolerances`
CANCELLED: Final = 1e-12  # of the largest work: rounding
DIFFERENT: Final = 1e-6  # accelerations of two solutions, of what cancels in them


def find_modes(problem: ModeProblem) -> int:
    """Find the modes of all elements from those they have; efforts and accelerations are left with them."""
    undecided = 0
    for k in range(problem.count):
        if problem.elements[k].moves == 0.0:
            undecided = undecided + 1
    gain = friction_gain(problem)
    problem.root = 0
    found = search(problem, undecided)
    if found == 0 and undecided > MOST_UNDECIDED:
        found = search_again(problem, undecided)
    if found == 1 and (gain < 1.0 or undecided > MOST_UNDECIDED):
        return ONE
    if undecided > MOST_UNDECIDED:
        return NOT_FOUND
    return try_all(problem, found)


def search_again(problem: ModeProblem, undecided: int) -> int:
    """Search from where all undecided elements are loose, then from where all hold; return 1 if found."""
    loosen_all(problem)
    if search(problem, undecided) == 1:
        return 1
    hold_all(problem)
    return search(problem, undecided)


def friction_gain(problem: ModeProblem) -> float:
    """Return a number below 1 only if there is one solution, whatever the modes.

    For bounds of fixed size the problem is monotone and has one vector of accelerations, whose change is at
    most that of the efforts that slip, in the norm of kinetic energy. The number bounds by how much the
    bounds that follow from the efforts change for a change of the bounds assumed.
    """
    rows = problem.rows
    list_held(problem)
    problem.held_count = rows
    for i in range(rows):
        problem.held[i] = float(i)
    factor_held(problem)
    total = 0.0
    for k in range(problem.count):
        element = problem.elements[k]
        if element.law != UNILATERAL and element.normals > 0 and element.sliding != 0.0:
            own = 0.0
            for i in range(element.row, element.row + row_count(element)):
                own = own + problem.responses[i * rows + i]
            total = total + element.sliding * sqrt(own) * reaction_gain(problem, element)
    return total


def reaction_gain(problem: ModeProblem, element: ModeElement) -> float:
    """Return by how much a reaction changes with efforts whose accelerations have the kinetic energy 1/2."""
    rows = problem.rows
    x = part(problem.room, 3 * rows, rows)
    y = part(problem.room, rows, 2 * rows)
    square = 0.0
    for i in range(element.normal, element.normal + element.normals):
        moves = 0.0
        for k in range(rows):
            row = int(problem.held[k])
            x[k] = problem.reactions[i * rows + row] / problem.sizes[row]
            moves = max(moves, abs(x[k]))
        if moves > 0.0:
            if problem.rank < rows:
                return INFINITY
            solve_held(problem, x, y)
            for k in range(rows):
                other = int(problem.held[k])
                square = square + x[k] * problem.reactions[i * rows + other] / problem.sizes[other]
    return sqrt(max(square, 0.0))


def search(problem: ModeProblem, undecided: int) -> int:
    """Change modes that are violated until none is; return whether they were found, 1 or 0."""
    for turn in range(40 * undecided + 1):
        if solve_modes(problem) != 0:
            return 0
        if assess(problem) == 0:
            return 1
        if turn < 4 * undecided:
            change_worst(problem)
        else:
            change_first(problem)
    return 0


def assess(problem: ModeProblem) -> int:
    """Note by how much the mode of each element is violated; return how many are."""
    violated = 0
    for k in range(problem.count):
        element = problem.elements[k]
        element.excess = 0.0
        element.reversal = 0.0
        i = element.row
        if not is_finite(problem.accelerations[i]) or not is_finite(element.normal_load):
            element.excess = INFINITY
        elif is_held(element) == 1:
            element.excess = max(overload_of(problem, element), 0.0)
        elif element.moves == 0.0:
            element.reversal = reversal_of(problem, element)
        if element.excess > 0.0 or element.reversal > 0.0:
            violated = violated + 1
    return violated


def overload_of(problem: ModeProblem, element: ModeElement) -> float:
    """Return by how much the effort that holds an element is outside its bound, as a work."""
    i = element.row
    slight = CANCELLED * problem.work
    if element.law == UNILATERAL:
        own = problem.responses[i * problem.rows + i]
        if own > 0.0:
            slight = slight + element.rounding / own * element.scale
        push = -problem.efforts[i] * element.scale
        if push > slight:
            return push
        return 0.0
    effort = effort_size(problem, element)
    bound = element.static * element.normal_load
    slight = slight + BALANCED * bound * element.scale
    if (effort - bound) * element.scale > slight:
        return (effort - bound) * element.scale
    return 0.0


def effort_size(problem: ModeProblem, element: ModeElement) -> float:
    """Return the magnitude of the effort of an element."""
    i = element.row
    square = problem.efforts[i] * problem.efforts[i]
    if element.law == CONE:
        square = square + problem.efforts[i + 1] * problem.efforts[i + 1]
    return sqrt(square)


def reversal_of(problem: ModeProblem, element: ModeElement) -> float:
    """Return by how much a loose element accelerates against its direction, over its size."""
    i = element.row
    along = problem.accelerations[i]
    slight = term_sum(problem, i)
    if element.law == BOUNDED:
        along = along * float(element.mode)
    elif element.law == CONE:
        along = along * element.first + problem.accelerations[i + 1] * element.second
        slight = max(slight, term_sum(problem, i + 1))
    if along < -(element.rounding + BALANCED * slight):
        return -along / element.scale
    return 0.0


def term_sum(problem: ModeProblem, i: int) -> float:
    """Return the sum of the magnitudes of what an acceleration is the sum of."""
    total = abs(problem.offsets[i])
    for j in range(problem.rows):
        total = total + abs(problem.responses[i * problem.rows + j] * problem.efforts[j])
    return total


def change_worst(problem: ModeProblem) -> None:
    """Change the modes that are violated most, loads before accelerations; equal ones together."""
    excess = 0.0
    reversal = 0.0
    for k in range(problem.count):
        excess = max(excess, problem.elements[k].excess)
        reversal = max(reversal, problem.elements[k].reversal)
    for k in range(problem.count):
        element = problem.elements[k]
        if excess > 0.0:
            if element.excess >= (1.0 - BALANCED) * excess:
                change(problem, element)
        elif element.reversal >= (1.0 - BALANCED) * reversal:
            change(problem, element)


def change_first(problem: ModeProblem) -> None:
    """Change the first mode that is violated."""
    for k in range(problem.count):
        element = problem.elements[k]
        if element.excess > 0.0 or element.reversal > 0.0:
            change(problem, element)
            break


def change(problem: ModeProblem, element: ModeElement) -> None:
    """Let an element that holds go against its effort, or hold one that is loose."""
    i = element.row
    if element.mode != HOLDS:
        element.mode = HOLDS
    else:
        element.mode = LOOSE
        if element.law == CONE:
            size = effort_size(problem, element)
            element.first = -problem.efforts[i] / size
            element.second = -problem.efforts[i + 1] / size
        elif element.law == BOUNDED:
            if problem.efforts[i] > 0.0:
                element.mode = BACK
            element.first = float(element.mode)


def try_all(problem: ModeProblem, was_found: int) -> int:
    """Try all modes; keep what the search found, or else the solution in which most elements hold."""
    problem.solutions = was_found
    if was_found == 1:
        keep(problem)
    doubts = 0
    hold_all(problem)
    going = 1
    while going == 1:
        problem.root = 0
        problem.roots = 1
        while problem.root < problem.roots:
            choice = problem.root
            status = solve_modes(problem)
            if problem.certain == 0.0:
                doubts = doubts + 1
            if status == 0 and assess(problem) == 0:
                compare(problem, was_found)
            problem.root = choice + 1
        going = next_modes(problem)
    problem.root = 0
    if problem.solutions > 0:
        restore(problem)
    if problem.solutions == 1:
        return ONE
    if problem.solutions == 2:
        return TWO
    if doubts > 0:
        return NOT_FOUND
    return NONE


def compare(problem: ModeProblem, was_found: int) -> None:
    """Keep a solution if it is the first, or more elements hold than in the others that `try_all` found."""
    if problem.solutions == 0:
        problem.solutions = 1
        keep(problem)
    elif is_apart(problem) == 1:
        problem.solutions = 2
    elif was_found == 0 and count_held(problem) > problem.kept_held:
        keep(problem)


def is_apart(problem: ModeProblem) -> int:
    """Return 1 if a solution contradicts the one that is kept, both within kinetic strengths, else 0.

    Two with one mean differ in shares alone.
    """
    if is_kinetic(problem) == 1 and problem.kept_kinetic == 1.0 and differs(problem) == 1:
        return 1 - has_mean(problem)
    return 0


def has_mean(problem: ModeProblem) -> int:
    """Return 1 if the mean of a solution and the one that is kept is one, too, else 0.

    What may hold or not accelerates alike in both, and friction is linear in reactions along one direction.
    """
    for k in range(problem.count):
        element = problem.elements[k]
        if element.sliding != 0.0 and turns_reaction(problem, element) == 1:
            return 0
        if element.moves == 0.0:
            for i in range(element.row, element.row + row_count(element)):
                if row_differs(problem, i) == 1:
                    return 0
    return 1


def turns_reaction(problem: ModeProblem, element: ModeElement) -> int:
    """Return 1 if the reaction that a bound reads has another direction in the solution that is kept."""
    if element.normals > 1:
        return 1
    for i in range(element.normal, element.normal + element.normals):
        now = problem.loads[i]
        kept = problem.loads[i]
        for j in range(problem.rows):
            now = now + problem.reactions[i * problem.rows + j] * problem.efforts[j]
            kept = kept + problem.reactions[i * problem.rows + j] * problem.saved_rows[2 * j]
        if now * kept < 0.0:
            return 1
    return 0


def hold_all(problem: ModeProblem) -> None:
    """Let all undecided elements hold."""
    for k in range(problem.count):
        element = problem.elements[k]
        if element.moves == 0.0:
            element.mode = HOLDS


def loosen_all(problem: ModeProblem) -> None:
    """Let all undecided elements be loose, each in the direction in which nothing holds it."""
    for k in range(problem.count):
        element = problem.elements[k]
        if element.moves == 0.0:
            element.mode = LOOSE
            loosen(problem, element)
            if element.law == BOUNDED and problem.offsets[element.row] < 0.0:
                element.mode = BACK
                element.first = -1.0


def next_modes(problem: ModeProblem) -> int:
    """Go on to the next modes of the undecided elements; return 0 if these were the last."""
    for k in range(problem.count - 1, -1, -1):
        element = problem.elements[k]
        if element.moves == 0.0:
            if element.mode == HOLDS:
                element.mode = LOOSE
                loosen(problem, element)
                return 1
            if element.law == BOUNDED and element.mode == LOOSE:
                element.mode = BACK
                element.first = -1.0
                return 1
            element.mode = HOLDS
    return 0


def loosen(problem: ModeProblem, element: ModeElement) -> None:
    """Choose a first direction for an element that begins to slip: that in which nothing holds it."""
    i = element.row
    element.first = 1.0
    if element.law == CONE:
        element.second = 0.0
        a = problem.offsets[i]
        b = problem.offsets[i + 1]
        size = sqrt(a * a + b * b)
        if size > 0.0:
            element.first = a / size
            element.second = b / size


def count_held(problem: ModeProblem) -> int:
    """Return how many elements hold."""
    count = 0
    for k in range(problem.count):
        count = count + is_held(problem.elements[k])
    return count


def is_kinetic(problem: ModeProblem) -> int:
    """Return 1 if what holds also would within the kinetic strengths, else 0."""
    for k in range(problem.count):
        element = problem.elements[k]
        if element.law != UNILATERAL and is_held(element) == 1:
            bound = element.sliding * element.normal_load
            slight = CANCELLED * problem.work / element.scale + BALANCED * bound
            if effort_size(problem, element) > bound + slight:
                return 0
    return 1


def keep(problem: ModeProblem) -> None:
    """Keep a solution."""
    problem.kept_held = count_held(problem)
    problem.kept_kinetic = float(is_kinetic(problem))
    for k in range(problem.count):
        element = problem.elements[k]
        problem.saved[4 * k] = float(element.mode)
        problem.saved[4 * k + 1] = element.first
        problem.saved[4 * k + 2] = element.second
        problem.saved[4 * k + 3] = element.normal_load
    for i in range(problem.rows):
        problem.saved_rows[2 * i] = problem.efforts[i]
        problem.saved_rows[2 * i + 1] = problem.accelerations[i]


def restore(problem: ModeProblem) -> None:
    """Return to the solution that was kept."""
    for k in range(problem.count):
        element = problem.elements[k]
        element.mode = int(problem.saved[4 * k])
        element.first = problem.saved[4 * k + 1]
        element.second = problem.saved[4 * k + 2]
        element.normal_load = problem.saved[4 * k + 3]
    for i in range(problem.rows):
        problem.efforts[i] = problem.saved_rows[2 * i]
        problem.accelerations[i] = problem.saved_rows[2 * i + 1]


def differs(problem: ModeProblem) -> int:
    """Return 1 if accelerations differ from those of the solution that was kept, else 0."""
    for i in range(problem.rows):
        if row_differs(problem, i) == 1:
            return 1
    return 0


def row_differs(problem: ModeProblem, i: int) -> int:
    """Return 1 if an acceleration differs from that of the solution that was kept, else 0."""
    difference = abs(problem.accelerations[i] - problem.saved_rows[2 * i + 1])
    if difference > DIFFERENT * term_sum(problem, i):
        return 1
    return 0
