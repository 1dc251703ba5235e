"""When efforts that several elements share can no longer hold them, whatever the shares are.

That is no zero of a value: of the shares within bounds there may be many, and then there is none. It is
looked for at some places of each step, and then by bisection.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.dense_output import interpolate
from symbody.kernels.language import INFINITY, Function, Reals
from symbody.kernels.modes.fill_problem import fill_problem
from symbody.kernels.modes.find_modes import overload_of
from symbody.kernels.modes.mode_problem import HOLDS
from symbody.kernels.modes.mode_shares import solve_modes
from symbody.kernels.modes.mode_state import measure
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.mode_trial import SOLVED

SHARE_NODES: Final = 8  # places of a step at which shares are looked for
SHARE_HALVINGS: Final = 50
ROUNDED_END: Final = 1e-12  # of times: by so much later, rounding does not let it seem to hold


def find_end_of_shares(
    d: Function, modes: ModeSwitch, rows: int, breaks: Reals, piece: Reals, x: Reals
) -> float:
    """Return when in one step no shares of efforts within their bounds hold any more; infinite if they do.

    The step is from the first to the second of `breaks`; x (states) is scratch.
    """
    if modes.shares == 0:
        return INFINITY
    start = breaks[0]
    length = breaks[1] - start
    good = 0.0
    bad = 2.0
    for node in range(1, SHARE_NODES + 1):
        share = float(node) / float(SHARE_NODES)
        if bad > 1.0:
            interpolate(modes.states, rows, piece, share, x)
            if shares_hold(d, modes, start + share * length, x) == 1:
                good = share
            else:
                bad = share
    if bad > 1.0:
        return INFINITY
    for _ in range(SHARE_HALVINGS):
        middle = 0.5 * (good + bad)
        interpolate(modes.states, rows, piece, middle, x)
        if shares_hold(d, modes, start + middle * length, x) == 1:
            good = middle
        else:
            bad = middle
    end = start + bad * length
    behind = ROUNDED_END * (abs(end) + abs(length))
    if length < 0.0:
        behind = -behind
    if abs(end + behind - start) > abs(length):
        return breaks[1]
    return end + behind


def shares_hold(d: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Return 1 if efforts within their bounds hold what shares them in the present modes, else 0."""
    if measure(d, modes, t, x) != 0:
        return 1
    for k in range(modes.count):
        element = modes.elements[k]
        element.opens = element.mode
        element.is_decided = 0.0
        if element.mode != HOLDS:
            element.is_decided = 1.0
    fill_problem(modes, 0)
    problem = modes.problem
    if solve_modes(problem) != SOLVED:
        return 0  # rows that hold contradict each other
    for k in range(problem.count):
        place = int(modes.places[int(modes.acting[problem.elements[k].row])])
        if place >= 0 and modes.elements[place].shares != 0.0:
            if overload_of(problem, problem.elements[k]) > 0.0:
                return 0
    return 1
