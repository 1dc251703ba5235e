"""Prescribed rates that jump strike a mechanism: the speeds jump as well.

Of all speeds that fit the new rates, those are taken to which the momenta of the free directions do not
change: ``M u' + b' - (M u + b) = J^T P``, b the momenta that prescribed rates give.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.configurations.strike_problem import StrikeProblem
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.linear.solve_saddle import solve_saddle, work_size
from symbody.kernels.runge_kutta import call, copy

# How a strike ends.
STRUCK: Final = 0
FAULT: Final = 1  # the function has one
TORN: Final = 2  # a constraint on positions jumps
NO_SPEEDS: Final = 3  # that fit the new rates


def strike_room(n: int, m: int) -> int:
    """Return how many numbers of scratch a strike takes, and so many for its result."""
    return work_size(n, m) + n + m + 1


def find_momenta(s: Function, problem: StrikeProblem, before: float, behind: float, x: Reals) -> int:
    """Find what prescribed rates change between two times at a state; return how that ended."""
    n = problem.speeds
    m = problem.rows
    count = problem.positions
    out = problem.out
    momenta = problem.momenta
    residuals = problem.residuals
    first = count + m + m * n
    problem.torn = 0
    if call(s, n, problem.numbers, before, x, out) != 0:
        return FAULT
    problem.energy = out[problem.out_size - 1]
    copy(count, out, residuals)
    copy(n, part(out, first, n), momenta)
    if call(s, n, problem.numbers, behind, x, out) != 0:
        return FAULT
    for k in range(count):
        if abs(out[k] - residuals[k]) > problem.limits[k]:
            problem.torn = k + 1
            return TORN
    for i in range(n):
        momenta[i] = momenta[i] - out[first + i]
    for k in range(m):
        problem.rates[k] = -out[count + k]
    return STRUCK


def change_speeds(problem: StrikeProblem, x: Reals) -> int:
    """Set the speeds to those behind a jump that `find_momenta` has seen; return how that ended."""
    n = problem.speeds
    m = problem.rows
    first = problem.positions + m
    rows = part(problem.out, first, m * n)
    mass = part(problem.out, first + m * n + n, n * n)
    if solve_saddle(n, m, mass, rows, problem.momenta, problem.rates, problem.result, problem.scratch) != 0:
        return NO_SPEEDS
    for i in range(n):
        x[i] = x[i] + problem.result[i]
    return STRUCK


def find_gain(s: Function, problem: StrikeProblem, t: float, x: Reals) -> int:
    """Find by how much the energy has risen at the state behind a jump; return how that ended."""
    if call(s, problem.speeds, problem.numbers, t, x, problem.out) != 0:
        return FAULT
    problem.gained = problem.out[problem.out_size - 1] - problem.energy
    return STRUCK


def strike(s: Function, problem: StrikeProblem, before: float, behind: float, x: Reals) -> int:
    """Set the speeds of a state to those behind a jump of prescribed rates between two times.

    Returns how that ended; `gained` is what the energy rises by.
    """
    result = find_momenta(s, problem, before, behind, x)
    if result == STRUCK:
        result = change_speeds(problem, x)
    if result == STRUCK:
        result = find_gain(s, problem, behind, x)
    return result
