"""Impacts: the speeds jump where ropes go taut, and where prescribed rates jump.

Of all speeds that fit the constraints and at which the ends of no taut rope move apart, those are taken to
which the change has the least kinetic energy [Moreau, Unilateral contact and dry friction in finite freedom
dynamics, 1988]: ropes pull along themselves, and none pushes. Friction is finite and transmits nothing in an
instant. Where prescribed rates jump, the momenta that they give change as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.ropes import rope_rows
from symbody.expr.sequences.saddle import solve_saddle
from symbody.simulation.hybrid.modes import HybridState, evaluate_outputs
from symbody.simulation.hybrid.ropes import RATE, TAUT, RopeElements
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

_MOST_TRIED: Final = 4096


@dataclass(frozen=True, slots=True)
class Impact:
    """What an impact did.

    Attributes
    ----------
    t : float
        When [s].
    x : array
        State afterwards.
    impulses : mapping of rope to float
        With which each rope pulled [N s].
    lost : float or None
        Energy that is gone [J]; None where prescribed rates have jumped, which give some.
    change : float
        By how much the energy changed [J]; more than was lost, where what moves by itself gave some.
    """

    t: float
    x: Floats
    impulses: Mapping[str, float]
    lost: float | None
    change: float

    @property
    def note(self) -> str:
        """The shock of ropes in words."""
        each = " and ".join(f"{name} by {impulse:.6g} N s" for name, impulse in self.impulses.items())
        lost = "" if self.lost is None else f"; {self.lost:.6g} J are lost"
        return f"at t = {self.t:.9g} s ropes go taut with an impact: {each}{lost}"


def separating_ropes(ropes: RopeElements, state: HybridState) -> bool:
    """Return whether ends of ropes at their length move apart, of ropes that were not taut."""
    motion = ropes.motion_values(state.t, state.x)
    were = np.array([state.before.get(name) == TAUT for name in ropes.names], dtype=np.bool_)
    tight = ropes.tight(state.before, motion)
    return bool((tight & ~were & (motion[RATE] < -state.small * state.length)).any())


def impact(
    problem: SimulationProblem, t: float, x: Floats, momenta: Floats | None = None,
    ropes: RopeElements | None = None, before: Mapping[str, int] = MappingProxyType({}), slow: float = 0.0,
) -> Impact | None:  # fmt: skip
    """Return what happens where speeds jump; None if no speeds were found.

    Parameters
    ----------
    momenta : (n_u,) array, optional
        By how much those that prescribed rates give have changed.
    ropes : RopeElements, optional
        Those of the mechanism, with their modes `before`.
    slow : float
        Ends of ropes that move apart more slowly do not move apart [m/s].
    """
    names = ("jacobian", "velocity_constraints") if problem.eqs.multiplier_names else ()
    energy, mass, *closed = evaluate_outputs(problem, ("energy", "mass_matrix", *names), t, x)
    rows, rates = closed if closed else (np.zeros((0, len(mass))), np.zeros(0))
    places, tight = _tight_rows(ropes, t, x, before)
    always = [k for k in range(len(rates)) if k not in places]
    given = np.zeros(len(mass)) if momenta is None else -momenta
    for some in _subsets(tight):
        chosen = [*always, *some]
        solution = solve_saddle(
            mass.ravel().tolist(), rows[chosen].ravel().tolist(), given.tolist(), (-rates[chosen]).tolist()
        )
        du, pulls = np.array(solution.udot), -np.array(solution.multipliers[len(always) :])
        after = rates + rows @ du
        left = [place for place in tight if place not in some]
        # A rope along which nothing was struck pulls by rounding of what was.
        struck = 0.0 if momenta is None else float(np.abs(mass @ du).max(initial=0.0))
        if solution.ok and _is_inelastic(pulls, after[left], rates, struck, slow):
            moved = x.copy()
            moved[: du.size] += du
            least = BALANCED * float(pulls.max(initial=struck))
            pairs = zip(some, pulls, strict=True)
            by_row = {} if ropes is None else dict(zip(places, ropes.names, strict=True))
            impulses = {by_row[k]: float(pull) for k, pull in pairs if pull > least}
            change = float(evaluate_outputs(problem, ("energy",), t, moved)[0] - energy)
            lost = float(du @ mass @ du) / 2.0 if momenta is None else None
            return Impact(t, moved, impulses, lost, change)
    return None


def _tight_rows(
    ropes: RopeElements | None, t: float, x: Floats, before: Mapping[str, int]
) -> tuple[list[int], list[int]]:
    """Return the rows of all ropes, and of those at their length."""
    if ropes is None:
        return [], []
    places = rope_rows(ropes.problem.eqs.formed, ropes.names)
    tight = ropes.tight(before, ropes.motion_values(t, x))
    return places, [place for place, is_tight in zip(places, tight, strict=True) if is_tight]


def _subsets(places: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Return the ropes that may pull: all, and then fewer and fewer."""
    tried = 0
    for size in range(len(places), -1, -1):
        for some in combinations(places, size):
            yield some
            tried += 1
            if tried == _MOST_TRIED:
                return


def _is_inelastic(pulls: Floats, left: Floats, rates: Floats, struck: float, slow: float) -> bool:
    """Return whether no rope pushes, and the ends of those that do not pull do not move apart."""
    least = -BALANCED * float(np.abs(pulls).max(initial=struck))
    most = max(BALANCED * float(np.abs(rates).max(initial=0.0)), slow)
    return bool((pulls >= least).all() and (left <= most).all())
