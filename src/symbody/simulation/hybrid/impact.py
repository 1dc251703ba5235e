"""Impacts: the speeds jump where ropes go taut, and where prescribed rates jump.

Of all speeds that fit the constraints and at which the ends of no taut rope move apart, those are taken to
which the change has the least kinetic energy [Moreau, Unilateral contact and dry friction in finite freedom
dynamics, 1988]: ropes pull along themselves, and none pushes. That is the problem of the modes of ropes with
rates in the place of accelerations, so the same kernel solves it. Friction is finite and transmits nothing in
an instant. Where prescribed rates jump, the momenta that they give change as well.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.ropes import rope_rows
from symbody.expr.sequences.saddle import solve_saddle
from symbody.simulation.hybrid.modes import HybridMechanism, HybridState, evaluate_outputs
from symbody.simulation.hybrid.ropes import RATE, TAUT, RopeElements
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]


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


def shock(mechanism: HybridMechanism, ropes: RopeElements, state: HybridState) -> Impact | None:
    """Return what the shock of ropes whose ends move apart does; None if no speeds were found."""
    t, x, problem = state.t, state.x, ropes.problem
    pulls = _pulls(mechanism, ropes, state)
    if pulls is None:
        return None
    found = change_speeds(problem, t, x, None, _loose_rows(ropes, pulls))
    if found is None:
        return None
    moved, lost = found
    least = BALANCED * max(pulls.values(), default=0.0)
    impulses = {name: impulse for name, impulse in pulls.items() if impulse > least}
    energies = [float(evaluate_outputs(problem, ("energy",), t, y)[0]) for y in (x, moved)]
    return Impact(t, moved, impulses, lost, energies[1] - energies[0])


def strike(
    mechanism: HybridMechanism, ropes: RopeElements | None, state: HybridState, momenta: Floats
) -> Impact | None:
    """Return what a jump of the momenta that prescribed rates give does; None if no speeds were found.

    First as if all ropes were slack; where their ends move apart then, these strike.
    """
    t, x, problem = state.t, state.x, mechanism.problem
    found = change_speeds(problem, t, x, momenta, [] if ropes is None else _loose_rows(ropes, {}))
    if found is None or ropes is None:
        return None if found is None else Impact(t, found[0], {}, None, 0.0)
    free = replace(state, x=found[0])
    motion = ropes.motion_values(t, free.x)
    if not (ropes.tight(state.before, motion) & (motion[RATE] < -state.small * state.length)).any():
        return Impact(t, free.x, {}, None, 0.0)
    pulls = _pulls(mechanism, ropes, free)
    found = None if pulls is None else change_speeds(problem, t, x, momenta, _loose_rows(ropes, pulls))
    return None if found is None or pulls is None else Impact(t, found[0], pulls, None, 0.0)


def _pulls(mechanism: HybridMechanism, ropes: RopeElements, state: HybridState) -> dict[str, float] | None:
    """Return the ropes that pull where ends move apart, and their impulses [N s]; None if none were found."""
    motion = ropes.motion_values(state.t, state.x)
    tight = ropes.tight(state.before, motion)
    names = [name for name, is_tight in zip(ropes.names, tight, strict=True) if is_tight]
    rates = dict(zip(names, motion[RATE, tight].tolist(), strict=True))
    found: dict[str, float] | None = mechanism.numbers(state.t, state.x).strike(rates)
    return found


def _loose_rows(ropes: RopeElements, pulling: Collection[str]) -> list[int]:
    """Return the rows of the ropes that do not pull."""
    formed = ropes.problem.eqs.formed
    return [*set(rope_rows(formed, ropes.names)).difference(rope_rows(formed, list(pulling)))]


def change_speeds(
    problem: SimulationProblem, t: float, x: Floats, momenta: Floats | None, loose: Collection[int] = ()
) -> tuple[Floats, float] | None:
    """Return the state whose speeds fit the constraints, and the energy of the change [J].

    Of all such speeds those to which the momenta change by no more than constraints and `momenta` say.

    Parameters
    ----------
    momenta : (n_u,) array or None
        By how much those that prescribed rates give have changed.
    loose : collection of int
        Rows that do not hold.
    """
    names = ("jacobian", "velocity_constraints") if problem.eqs.multiplier_names else ()
    values = evaluate_outputs(problem, ("mass_matrix", *names), t, x)
    mass, rows, rates = values if names else (values[0], np.zeros((0, len(values[0]))), np.zeros(0))
    chosen = [k for k in range(len(rates)) if k not in loose]
    given = np.zeros(len(mass)) if momenta is None else -momenta
    solution = solve_saddle(
        mass.ravel().tolist(), rows[chosen].ravel().tolist(), given.tolist(), (-rates[chosen]).tolist()
    )
    if not solution.ok:
        return None
    du, moved = np.array(solution.udot), x.copy()
    moved[: du.size] += du
    return moved, float(du @ mass @ du) / 2.0
