"""Efforts in given modes, where several elements may share those that hold.

Rigid bodies do not say how much each one bears. It matters under a box that slides and spins on four corners:
friction in each follows from its share, and the motion from friction.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Reals, part
from symbody.kernels.modes.held_rows import factor_held, shares_effort
from symbody.kernels.modes.held_shares import NONE_WITHIN, WITHIN_BOUNDS, held_place, share_efforts
from symbody.kernels.modes.mode_problem import ModeElement, ModeProblem
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.mode_trial import (
    SOLVED,
    hold_rows,
    is_held,
    is_slider,
    list_held,
    put_friction,
    row_count,
    solve_directions,
)

MATTERS: Final = 1e-6  # accelerations by another share, of what cancels in them
SLIGHT_SHARE: Final = 1e-9  # works in other shares, of that of the dependent row
MOST_SHARES: Final = 20


def solve_modes(problem: ModeProblem) -> int:
    """Find efforts and accelerations in the modes of the elements."""
    list_held(problem)
    factor_held(problem)
    status = SOLVED
    for turn in range(MOST_SHARES):
        status = solve_directions(problem)
        if status != SOLVED or problem.rank == problem.held_count:
            break
        if turn == 0:
            note_rubbing(problem)
        shared = share_efforts(problem)
        if shared == NONE_WITHIN:
            return solve_directions(problem)
        if shared == WITHIN_BOUNDS:
            break
    return status


def note_shares(modes: ModeSwitch) -> None:
    """Note which elements share the efforts with which they hold, once modes have been decided.

    Where friction of what slips follows from a share, it is that of least norm, and ends the mode as
    an effort that is not shared does.
    """
    problem = modes.problem
    modes.shares = 0
    for k in range(modes.count):
        modes.elements[k].shares = 0.0
    list_held(problem)
    if problem.held_count <= 1:
        return
    factor_held(problem)
    if problem.rank == problem.held_count:
        return
    note_rubbing(problem)
    for k in range(problem.count):
        element = problem.elements[k]
        place = int(modes.places[int(modes.acting[problem.elements[k].row])])
        if is_held(element) == 1 and element.rubs == 0.0 and place >= 0:
            i = held_place(problem, element.row)
            if shares_effort(problem, i, problem.vector) == 1:
                modes.elements[place].shares = 1.0
                modes.shares = modes.shares + 1


def note_rubbing(problem: ModeProblem) -> None:
    """Note from whose shares friction of what slips follows; efforts that hold have to be factored."""
    rows = problem.rows
    column = problem.combination
    for extra in range(problem.rank, problem.held_count):
        put_other_share(problem, extra, problem.vector, column)
        friction = part(problem.room, 6 * rows, rows)
        put_share_of_friction(problem, column, friction)
        if hold_rows(problem, 1, friction) == 0 and moves_rows(problem, friction) == 1:
            for k in range(problem.count):
                element = problem.elements[k]
                for i in range(element.row, element.row + row_count(element)):
                    if abs(column[i]) * problem.sizes[i] > SLIGHT_SHARE:
                        element.rubs = 1.0


def put_other_share(problem: ModeProblem, extra: int, y: Reals, column: Reals) -> None:
    """Set a column of efforts to some that hold nothing, with a unit of the dependent row at a place."""
    n = problem.held_count
    L = problem.factor
    for i in range(problem.rows):
        column[i] = 0.0
    for k in range(problem.rank - 1, -1, -1):
        y[k] = L[extra * n + k]
        for c in range(k + 1, problem.rank):
            y[k] = y[k] - L[c * n + k] * y[c]
        y[k] = y[k] / L[k * n + k]
        row = int(problem.held[k])
        column[row] = -y[k] / problem.sizes[row]
    row = int(problem.held[extra])
    column[row] = 1.0 / problem.sizes[row]


def put_share_of_friction(problem: ModeProblem, column: Reals, friction: Reals) -> None:
    """Set `friction` to that of sliders whose reactions change by those of a column of efforts."""
    for i in range(problem.rows):
        friction[i] = 0.0
    for k in range(problem.count):
        element = problem.elements[k]
        if is_slider(element) == 1:
            put_friction(element, element.sliding * change_of_load(problem, element, column), friction)


def change_of_load(problem: ModeProblem, element: ModeElement, column: Reals) -> float:
    """Return by how much the norm of the reaction of an element changes, to first order."""
    total = 0.0
    for i in range(element.normal, element.normal + element.normals):
        load = problem.loads[i]
        change = 0.0
        for j in range(problem.rows):
            load = load + problem.reactions[i * problem.rows + j] * problem.efforts[j]
            change = change + problem.reactions[i * problem.rows + j] * column[j]
        if element.normal_load > 0.0:
            total = total + change * load / element.normal_load
    return total


def moves_rows(problem: ModeProblem, efforts: Reals) -> int:
    """Return 1 if efforts accelerate a row by more than rounding, else 0."""
    for i in range(problem.rows):
        total = 0.0
        size = 0.0
        for j in range(problem.rows):
            term = problem.responses[i * problem.rows + j] * efforts[j]
            total = total + term
            size = size + abs(term)
        if abs(total) > MATTERS * size:
            return 1
    return 0
