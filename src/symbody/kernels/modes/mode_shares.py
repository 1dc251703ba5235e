"""Which elements share the efforts with which they hold: rigid bodies do not say how much each one bears."""

from __future__ import annotations

from symbody.kernels.modes.held_rows import factor_held, shares_effort
from symbody.kernels.modes.held_shares import held_place
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.mode_trial import is_held, list_held


def note_shares(modes: ModeSwitch) -> None:
    """Note which elements share the efforts with which they hold, once modes have been decided."""
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
    for k in range(problem.count):
        element = problem.elements[k]
        place = int(modes.places[int(modes.acting[problem.elements[k].row])])
        if is_held(element) == 1 and place >= 0:
            i = held_place(problem, element.row)
            if shares_effort(problem, i, problem.vector) == 1:
                modes.elements[place].shares = 1.0
                modes.shares = modes.shares + 1
