"""Shocks of ropes that go taut: the speeds jump, inelastically and without friction.

Of all speeds at which the ends of no taut rope move apart, those are taken to which the change has the
least kinetic energy [Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988]: ropes
pull along themselves, and none pushes. That is the problem of the modes of ropes with rates in the place of
accelerations, so the same kernel solves it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.ropes import rope_rows
from symbody.expr.sequences.saddle import solve_saddle
from symbody.simulation.hybrid.modes import HybridMechanism, HybridState, evaluate_outputs
from symbody.simulation.hybrid.ropes import RATE, TAUT, RopeElements
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]


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


def rope_impact(mechanism: HybridMechanism, ropes: RopeElements, state: HybridState) -> RopeImpact | None:
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
    names = [name for name, is_tight in zip(ropes.names, tight, strict=True) if is_tight]
    rates = dict(zip(names, motion[RATE, tight].tolist(), strict=True))
    struck = mechanism.numbers(t, x).strike(rates)
    if struck is None:
        return RopeImpact(t, x, {}, 0.0, 0.0)
    outputs = ("mass_matrix", "jacobian", "velocity_constraints", "energy")
    mass, rows, residuals, energy = evaluate_outputs(ropes.problem, outputs, t, x)
    formed = ropes.problem.eqs.formed
    loose = set(rope_rows(formed, ropes.names)) - set(rope_rows(formed, list(struck)))
    chosen = [k for k in range(len(residuals)) if k not in loose]
    zeros, gamma = [0.0] * len(mass), (-residuals[chosen]).tolist()
    solution = solve_saddle(mass.ravel().tolist(), rows[chosen].ravel().tolist(), zeros, gamma)
    if not solution.ok:
        return RopeImpact(t, x, {}, 0.0, 0.0)
    du, moved = np.array(solution.udot), x.copy()
    moved[: du.size] += du
    least = BALANCED * max(struck.values(), default=0.0)
    impulses = {name: impulse for name, impulse in struck.items() if impulse > least}
    change = float(evaluate_outputs(ropes.problem, ("energy",), t, moved)[0] - energy)
    return RopeImpact(t, moved, impulses, float(du @ mass @ du) / 2.0, change)
