"""Shocks of ropes that go taut: the speeds jump, inelastically and without friction.

Of all speeds at which the ends of no taut rope move apart, those are taken to which the change has the
least kinetic energy [Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988]: ropes
pull along themselves, and none pushes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.ropes import rope_rows
from symbody.expr.sequences.saddle import solve_saddle
from symbody.simulation.hybrid.modes import HybridState, evaluate_outputs
from symbody.simulation.hybrid.ropes import RATE, TAUT, RopeElements
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

_MOST_TRIED: Final = 4096


@dataclass(frozen=True, slots=True)
class RopeImpact:
    """What a shock did.

    Attributes
    ----------
    t : float
        When [s].
    x : array
        State afterwards.
    impulses : mapping of rope to float
        With which each rope pulled [N s].
    lost : float
        Energy that is gone [J].
    change : float
        By how much the energy changed [J]; more than was lost, where what moves by itself gave some.
    """

    t: float
    x: Floats
    impulses: Mapping[str, float]
    lost: float
    change: float

    @property
    def note(self) -> str:
        """The shock in words."""
        each = " and ".join(f"{name} by {impulse:.6g} N s" for name, impulse in self.impulses.items())
        return f"at t = {self.t:.9g} s ropes go taut with an impact: {each}; {self.lost:.6g} J are lost"


def rope_impact(ropes: RopeElements, state: HybridState) -> RopeImpact | None:
    """Return what happens where ends of ropes at their length move apart; None where none do.

    Returns
    -------
    RopeImpact or None
        Its impulses are empty if no speeds were found.
    """
    t, x = state.t, state.x
    motion = ropes.motion_values(t, x)
    tight = ropes.tight(state.before, motion)
    were = np.array([state.before.get(name) == TAUT for name in ropes.names], dtype=np.bool_)
    if not (tight & ~were & (motion[RATE] < -state.small * state.length)).any():
        return None
    problem = ropes.problem
    names = ("mass_matrix", "jacobian", "velocity_constraints", "energy")
    mass, rows, rates, energy = evaluate_outputs(problem, names, t, x)
    places = rope_rows(problem.eqs.formed, ropes.names)
    always = [k for k in range(len(rates)) if k not in places]
    for some in _subsets([place for place, is_tight in zip(places, tight, strict=True) if is_tight]):
        chosen = [*always, *some]
        solution = solve_saddle(
            mass.ravel().tolist(), rows[chosen].ravel().tolist(), [0.0] * len(mass), (-rates[chosen]).tolist()
        )
        du, pulls = np.array(solution.udot), -np.array(solution.multipliers[len(always) :])
        after = rates + rows @ du
        left = [
            place for place, is_tight in zip(places, tight, strict=True) if is_tight and place not in some
        ]
        if solution.ok and _is_inelastic(pulls, after[left], rates):
            moved = x.copy()
            moved[: du.size] += du
            least = BALANCED * float(pulls.max())
            pairs = zip(some, pulls, strict=True)
            impulses = {ropes.names[places.index(k)]: float(pull) for k, pull in pairs if pull > least}
            change = float(evaluate_outputs(problem, ("energy",), t, moved)[0] - energy)
            return RopeImpact(t, moved, impulses, float(du @ mass @ du) / 2.0, change)
    return RopeImpact(t, x, {}, 0.0, 0.0)


def _subsets(places: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Return the ropes that may pull: all, and then fewer and fewer."""
    tried = 0
    for size in range(len(places), 0, -1):
        for some in combinations(places, size):
            yield some
            tried += 1
            if tried == _MOST_TRIED:
                return


def _is_inelastic(pulls: Floats, left: Floats, rates: Floats) -> bool:
    """Return whether no rope pushes, and the ends of those that do not pull do not move apart."""
    least = -BALANCED * float(np.abs(pulls).max(initial=0.0))
    most = BALANCED * float(np.abs(rates).max(initial=0.0))
    return bool((pulls >= least).all() and (left <= most).all())
