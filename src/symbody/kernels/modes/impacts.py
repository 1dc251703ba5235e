"""Impacts: gaps that close change the speeds at once.

Where gaps at zero close, impulses keep them from it, those of the mode problem with rates in the place of
accelerations: the change has the least kinetic energy [Moreau, Unilateral contact and dry friction in finite
freedom dynamics, 1988]. By Poisson's hypothesis gaps open again; ropes do not. All gaps at zero are struck at
once. Friction of joints is finite and transmits nothing in an instant; that of contacts does.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Function, Reals, part
from symbody.kernels.modes.fill_problem import candidate_block, fill_problem, rate_behind, row_rate
from symbody.kernels.modes.find_modes import BALANCED, ONE, TWO, find_modes
from symbody.kernels.modes.mode_problem import HOLDS, LOOSE
from symbody.kernels.modes.mode_state import (
    FUNCTION_FAULT,
    NO_SPEEDS,
    SETTLED,
    UNWRITTEN,
    energy_of,
    is_closed,
    measure,
    record,
    slow_rate,
    was_closed,
)
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch
from symbody.kernels.runge_kutta import copy

LEAST_SHARE: Final = 1e-3  # of restitution


def are_struck(modes: ModeSwitch) -> int:
    """Return 1 if a gap at zero closes further that was not closed, else 0."""
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_gap != 0.0 and was_closed(element) == 0 and is_closed(element) == 1:
            if element.rate < -slow_rate(modes, element):
                return 1
    return 0


def strike_gaps(d: Function, modes: ModeSwitch, Z: Reals, t: float, x: Reals) -> int:
    """Change the speeds to those behind the impact of gaps that close."""
    energy = energy_of(modes)
    if find_impulses(modes) != ONE:
        return NO_SPEEDS
    copy(modes.states, x, modes.fitted)
    add_impulses(modes, x)
    if measure(d, modes, t, x) != 0:
        return FUNCTION_FAULT
    n = modes.states
    x[n - 1] = x[n - 1] + (energy_of(modes) - energy)
    record(modes, Z, SHOCK, t, modes.fitted, modes.lost)
    modes.changed = 1.0
    return SETTLED


def find_impulses(modes: ModeSwitch) -> int:
    """Find with which impulses gaps at zero keep from closing; return the verdict of `find_modes`.

    Poisson's hypothesis with friction: impulses that end the approach, then their share of restitution, then
    those that end what approaches still; those across are within friction of those along the normals, in
    both phases [Glocker & Pfeiffer, Multiple impacts with friction in rigid multibody systems, Nonlinear
    Dynamics 7, 1995]. If the energy would rise the shares are lowered [Glocker, Energetic consistency
    conditions for standard impacts, Multibody Syst. Dyn. 29, 2013].
    """
    for k in range(modes.count):
        element = modes.elements[k]
        element.impulse = 0.0
        element.opens = HOLDS
        element.is_decided = 0.0
        if element.is_gap != 0.0 and is_closed(element) == 0:
            element.opens = LOOSE
            element.is_decided = 1.0
    for k in range(modes.count):
        rubbing = modes.elements[k]
        if rubbing.gap > 0:
            rubbing.absent = modes.elements[rubbing.gap - 1].is_decided
    verdict = compress(modes)
    share = 1.0
    while verdict == ONE and share > LEAST_SHARE:
        verdict = expand(modes, share)
        share = 0.5 * share
        if verdict == ONE and not modes.lost < 0.0:
            share = 0.0
        if share > LEAST_SHARE and verdict == ONE:
            verdict = compress(modes)
    settle_impulses(modes)
    return verdict


def compress(modes: ModeSwitch) -> int:
    """Find the impulses that end the approach of gaps."""
    for k in range(modes.candidates):
        modes.impulses[k] = 0.0
    for k in range(modes.components):
        modes.shocks[k] = 0.0
    return solve_impact(modes)


def solve_impact(modes: ModeSwitch) -> int:
    """Add the impulses that keep gaps from closing further; return the verdict of `find_modes`.

    Friction may let there be several, of which any will do: what holds most is taken.
    """
    fill_problem(modes, 1)
    verdict = find_modes(modes.problem)
    add_efforts(modes)
    if verdict == TWO:
        return ONE
    return verdict


def add_efforts(modes: ModeSwitch) -> None:
    """Add the efforts that were found to the impulses."""
    problem = modes.problem
    for i in range(problem.rows):
        candidate = int(modes.acting[i])
        modes.impulses[candidate] = modes.impulses[candidate] + problem.efforts[i]


def expand(modes: ModeSwitch, share: float) -> int:
    """Let gaps open with a share of their restitution, and end what approaches still."""
    problem = modes.problem
    shares = part(problem.room, 0, problem.rows)
    most = 0.0
    for i in range(problem.rows):
        candidate = int(modes.acting[i])
        place = int(modes.places[candidate])
        struck = modes.elements[place]
        shares[i] = 0.0
        if struck.is_gap != 0.0:
            shares[i] = share * struck.restitution * modes.impulses[candidate]
        most = max(most, shares[i])
    verdict = ONE
    if most > 0.0:
        for k in range(modes.components):
            for i in range(problem.rows):
                modes.shocks[k] = modes.shocks[k] + problem.reactions[k * problem.rows + i] * shares[i]
        for i in range(problem.rows):
            candidate = int(modes.acting[i])
            modes.impulses[candidate] = modes.impulses[candidate] + shares[i]
        verdict = solve_impact(modes)
    modes.lost = lost_energy(modes)
    return verdict


def lost_energy(modes: ModeSwitch) -> float:
    """Return the energy that the impulses so far lose: work at the mean of the rates before and behind."""
    lost = 0.0
    size = 0.0
    for i in range(modes.problem.rows):
        impulse = modes.impulses[int(modes.acting[i])]
        work = 0.5 * impulse * (row_rate(modes, i) + rate_behind(modes, i))
        lost = lost - work
        size = size + abs(0.5 * impulse * row_rate(modes, i))
    if abs(lost) < BALANCED * size:
        return 0.0
    return lost


def settle_impulses(modes: ModeSwitch) -> None:
    """Note which gaps an impact strikes; others keep their modes."""
    largest = 0.0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_gap != 0.0:
            element.impulse = modes.impulses[element.candidate]
            largest = max(largest, element.impulse)
    for k in range(modes.count):
        struck = modes.elements[k]
        if struck.is_gap != 0.0:
            if struck.impulse > BALANCED * largest:
                struck.mode = HOLDS
                struck.written = UNWRITTEN
            else:
                struck.impulse = 0.0


def add_impulses(modes: ModeSwitch, x: Reals) -> None:
    """Add to speeds what the impulses change them by."""
    first = 3 * (modes.candidates - modes.gaps) + candidate_block(modes) + modes.candidates
    for k in range(modes.candidates):
        column = part(modes.out, first + k * modes.speeds, modes.speeds)
        for i in range(modes.speeds):
            x[i] = x[i] + column[i] * modes.impulses[k]


def rest_of_impacts(modes: ModeSwitch) -> float:
    """Return how long gaps that close at an impact would go on to bounce, too low to be seen [s].

    Flights last ``2 v/a`` with speeds v that fall by the restitution, a geometric series.
    """
    problem = modes.problem
    longest = 0.0
    for k in range(problem.count):
        i = problem.elements[k].row
        place = int(modes.places[int(modes.acting[i])])
        if place >= 0 and problem.elements[k].mode == HOLDS:
            element = modes.elements[place]
            back = problem.responses[i * problem.rows + i] * problem.efforts[i]
            left = 1.0 - element.restitution
            if element.is_gap != 0.0 and element.impulse > 0.0 and element.rate > 0.0 and back * left > 0.0:
                longest = max(longest, 2.0 * element.rate / (back * left))
    return longest
