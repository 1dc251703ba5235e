"""Ropes of a configuration or a state: which of them are constraints, and which are slack.

Kinematic analyses take ropes at their length as constraints (`equations_with_ropes`); assembly takes those
that pull.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.state import State
from symbody.analysis.velocities import solve_speeds
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import open_gaps, unilateral_elements
from symbody.errors import AssemblyError, Problem
from symbody.tolerances import AT_REST, TINY

Floats = NDArray[np.float64]
# From equations and fixed positions to a state in which their constraints hold.
Attempt = Callable[[EquationSet, Mapping[str, float]], State]

AT_LENGTH: Final = 2e-9  # of its length: a rope that is closer to it is taut
LOOSE: Final = 1e-7  # of its length: what assembly and continuation leave of a rope that is taut
_MEASURES: Final = ("row_gap", "gap_scale")


def assemble_with_ropes(
    eqs: EquationSet,
    fixed: Mapping[str, float],
    guess: Mapping[str, float],
    attempt: Attempt,
    closed: Callable[[EquationSet], ConstraintEvaluator],
) -> State:
    """Return a state in which no rope is longer than it is, and no taut one gets longer.

    Fixed speeds may have the ends of a taut rope move apart: a shock begins the motion.

    Parameters
    ----------
    attempt : callable
        Assembles equations from the guess, with some coordinates fixed.
    closed : callable
        Returns the constraints of equations as numbers.

    Raises
    ------
    AssemblyError
        If the mechanism does not close, or a rope is too short for the positions fixed.
    """
    positions, rates = closed(eqs).split_values(fixed)
    loose = closed(with_taut(eqs, ()))
    state = _place(loose, eqs, positions, attempt)
    search = _Speeds(eqs, np.array([*state.q.values()]), rates, guess, closed)
    complete = search.solve(state)
    places = {name: change for name, change in state.moved.items() if name in complete.q}
    return replace(complete, moved=places | dict(complete.moved))


def with_taut(eqs: EquationSet, names: Collection[str]) -> EquationSet:
    """Return equations in which only the ropes named are constraints; the others are slack."""
    slack = tuple(name for name in unilateral_elements(eqs.formed) if name not in names)
    if not slack:
        return eqs
    # Kept with the equations, as their code is: the next state has the same ropes to look at.
    loosened: EquationSet = eqs.plans.get(
        ("slack ropes", slack), lambda: EquationSet(eqs.model, open_gaps(eqs.formed, slack), eqs.notes)
    )
    return loosened


def slackness(evaluator: ConstraintEvaluator, q: Floats) -> dict[str, float]:
    """Return the gap of each rope and stop over its scale: by how much a rope is slack, over its length."""
    names = unilateral_elements(evaluator.eqs.formed)
    if not names:
        return {}
    words = [f"{word} {name}" for name in names for word in _MEASURES]
    values = np.ravel(evaluator.compile(words)(evaluator.t, q, np.zeros(len(evaluator.eqs.speed_names))))
    pairs = zip(values[::2].tolist(), values[1::2].tolist(), strict=True)
    return {
        name: slack / max(abs(length) or evaluator.mechanism.gap(evaluator.eqs, name), TINY)
        for name, (slack, length) in zip(names, pairs, strict=True)
    }


def equations_with_ropes(
    eqs: EquationSet, q: Floats, parameters: Mapping[str, Value], t: float
) -> tuple[EquationSet, tuple[str, ...]]:
    """Return equations with the ropes at their length at a configuration as constraints, and notes on it.

    Whether a rope at its length pulls does not follow from positions; it is taken to.
    """
    if not unilateral_elements(eqs.formed):
        return eqs, ()
    shares = slackness(constraint_evaluator(with_taut(eqs, ()), parameters, {}, t), q)
    taut = [name for name, share in shares.items() if share <= AT_LENGTH]
    notes = tuple(
        f"rope {name} is at its full length and assumed taut, regardless of its tension"
        if name in taut
        else f"rope {name} is slack here by {share:.3g} of its length, so it constrains nothing"
        for name, share in shares.items()
    )
    return with_taut(eqs, taut), notes


def rope_assumptions(eqs: EquationSet) -> tuple[str, ...]:
    """Return notes on the ropes and gaps that an analysis of all configurations takes as taut or closed."""
    rows = {row.gap: row for row in eqs.formed.rows}
    return tuple(
        f"rope {name} is assumed to be taut"
        if rows[name].sense < 0
        else f"gap {name} is assumed to be closed"
        for name in unilateral_elements(eqs.formed)
        if name in rows
    )


def ropes_out_of_place(eqs: EquationSet, evaluator: ConstraintEvaluator, q: Floats) -> str:
    """Return a sentence on the ropes that are not as these equations have them; empty if all are.

    Parameters
    ----------
    eqs : EquationSet
        With taut ropes as constraints and without those that are slack.
    evaluator : ConstraintEvaluator
        Measures the ropes.
    """
    taut = {row.gap for row in eqs.formed.rows}
    misplaced = []
    for name, share in slackness(evaluator, q).items():
        if name in taut and share > LOOSE:
            misplaced.append(f"rope {name} is slack, by {share:.3g} of its length")
        elif share < -LOOSE:
            misplaced.append(f"the ends of rope {name} are farther apart than its length")
    return ", ".join(misplaced)


def _place(
    loose: ConstraintEvaluator, eqs: EquationSet, fixed: Mapping[str, float], attempt: Attempt
) -> State:
    """Return a state in which no gap is negative; its speeds do not matter."""
    taut: list[str] = []
    state = attempt(with_taut(eqs, taut), fixed)
    while True:
        shares = slackness(loose, np.array([*state.q.values()]))
        longer = [name for name, share in shares.items() if name not in taut and share < -AT_LENGTH]
        if not longer:
            return state
        taut += longer
        try:
            state = attempt(with_taut(eqs, taut), fixed)
        except AssemblyError as error:
            problems = [_too_short(state, name, error) for name in longer]
            raise AssemblyError(*problems) from error


def _too_short(state: State, name: str, error: AssemblyError) -> Problem:
    length, slack = float(state[f"gap_scale {name}"]), float(state[f"row_gap {name}"])
    if not length:
        return Problem(
            "assembly.closed_stop", f"constraint {name}", f"its gap is {slack:.6g}, but cannot be negative",
            f"no free motion opens it: {error.problems[0].what}",
            "give other initial positions, or another gap",
        )  # fmt: skip
    return Problem(
        "assembly.rope_too_short", f"constraint {name}",
        f"its ends are {length - slack:.9g} m apart, but the rope is {length:.9g} m long",
        f"no free motion brings them closer: {error.problems[0].what}",
        "give other initial positions, or a longer rope",
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Speeds:
    """The speeds at given positions, and which ropes they keep taut."""

    eqs: EquationSet
    q: Floats
    rates: Mapping[str, float]
    guess: Mapping[str, float]
    closed: Callable[[EquationSet], ConstraintEvaluator]

    def solve(self, state: State) -> State:
        """Return the state with speeds and accelerations; the ropes that pull are its constraints."""
        shares = slackness(self.closed(with_taut(self.eqs, ())), self.q)
        near = [name for name, share in shares.items() if not share > AT_LENGTH]
        u, apart = self._speeds(near)
        taut = [name for name in near if abs(apart[name]) <= AT_REST]
        while True:
            evaluator = self.closed(with_taut(self.eqs, taut))
            result = complete_state(evaluator, self.q, u, self.q, self._guessed_rates(evaluator))
            pushes = {name: -float(result[f"opening_effort {name}"]) for name in taut}
            worst = max(pushes, key=lambda name: pushes[name], default="")
            if not worst or pushes[worst] <= 0.0:
                return result
            taut.remove(worst)

    def _speeds(self, near: list[str]) -> tuple[Floats, dict[str, float]]:
        """Return speeds, and the rates at which the ends of ropes at their length move apart."""
        taut: list[str] = []
        refused: set[str] = set()
        u = self._consistent(taut)
        while True:
            apart = self._apart(near, u)
            longer = [n for n in near if apart[n] > AT_REST and n not in taut and n not in refused]
            if not longer:
                return u, apart
            try:
                u = self._consistent([*taut, longer[0]])
                taut.append(longer[0])
            except AssemblyError:
                refused.add(longer[0])

    def _consistent(self, taut: list[str]) -> Floats:
        evaluator = self.closed(with_taut(self.eqs, taut))
        return solve_speeds(evaluator, self.q, self.rates, self._guessed_rates(evaluator))

    def _guessed_rates(self, evaluator: ConstraintEvaluator) -> dict[str, float]:
        """Return the rates guessed that are not fixed."""
        return {
            name: x for name, x in evaluator.split_values(self.guess)[1].items() if name not in self.rates
        }

    def _apart(self, names: list[str], u: Floats) -> dict[str, float]:
        """Return the rates at which ends move apart, over the largest speed or the mechanism's own."""
        evaluator = self.closed(with_taut(self.eqs, ()))
        mechanism, rates = evaluator.mechanism, np.abs(u / evaluator.speed_sizes)
        fastest = float(rates.max(initial=1.0 / mechanism.time))
        rates_of = {
            name: float(evaluator.compile(f"gap_dot {name}")(evaluator.t, self.q, u)) for name in names
        }
        return {
            name: -rate / (fastest * mechanism.gap(evaluator.eqs, name)) for name, rate in rates_of.items()
        }
