"""Ropes and stops of a configuration or a state: which of them are constraints, and which are slack or open.

A rope at its length and a stop that touches have a gap of 0: kinematic analyses take these as constraints
(`equations_with_closed_gaps`); assembly takes those that pull, or push.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.configurations.gap_words import gap_words
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.modes.mode_decision import OPEN, UNDECIDED, mode_numbers
from symbody.analysis.modes.reduced_modes import ModeVerdict
from symbody.analysis.state import State
from symbody.analysis.velocities import solve_speeds
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_MODES
from symbody.equations.solving.unilateral import gap_place, open_gaps, unilateral_elements
from symbody.errors import AssemblyError, Problem
from symbody.kernels.modes.mode_problem import HOLDS
from symbody.tolerances import AT_REST, TINY

Floats = NDArray[np.float64]
# From equations and fixed positions to a state in which their constraints hold.
Attempt = Callable[[EquationSet, Mapping[str, float]], State]

AT_LENGTH: Final = 2e-9  # of its length: a rope that is closer to it is taut; of a stop, of its size
LOOSE: Final = 1e-7  # of the same: what assembly and continuation leave of a gap that is closed
_MEASURES: Final = ("row_gap", "gap_scale")


def assemble_with_gaps(
    eqs: EquationSet,
    fixed: Mapping[str, float],
    guess: Mapping[str, float],
    attempt: Attempt,
    evaluate: Callable[[EquationSet], ConstraintEvaluator],
) -> State:
    """Return a state in which no gap is negative, and no closed one becomes so.

    Fixed speeds may close a gap that is closed already: an impact begins the motion.

    Parameters
    ----------
    attempt : callable
        Assembles equations from the guess, with some coordinates fixed.
    evaluate : callable
        Returns the constraints of equations as numbers.

    Raises
    ------
    AssemblyError
        If the mechanism does not close, or a gap is negative at the positions fixed.
    """
    positions, rates = evaluate(eqs).split_values(fixed)
    loose = evaluate(with_closed_gaps(eqs, ()))
    state = _place(loose, eqs, positions, attempt)
    search = _Speeds(eqs, np.array([*state.q.values()]), rates, guess, evaluate)
    complete = search.solve(state)
    places = {name: change for name, change in state.moved.items() if name in complete.q}
    return replace(complete, moved=places | dict(complete.moved))


def with_closed_gaps(eqs: EquationSet, names: Collection[str]) -> EquationSet:
    """Return equations in which only the ropes and stops named are constraints; the others are open."""
    others = tuple(name for name in unilateral_elements(eqs.formed) if name not in names)
    if not others:
        return eqs
    # Kept with the equations, as their code is: the next state has the same gaps to look at.
    opened: EquationSet = eqs.plans.get(
        ("open gaps", others), lambda: EquationSet(eqs.model, open_gaps(eqs.formed, others), eqs.notes)
    )
    return opened


def gap_shares(evaluator: ConstraintEvaluator, q: Floats) -> dict[str, float]:
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


def equations_with_closed_gaps(
    eqs: EquationSet, q: Floats, parameters: Mapping[str, Value], t: float
) -> tuple[EquationSet, tuple[str, ...]]:
    """Return equations with the gaps that are 0 at a configuration as constraints, and notes on it.

    Whether a rope at its length pulls, or a stop pushes, does not follow from positions; it is taken to.
    """
    if not unilateral_elements(eqs.formed):
        return eqs, ()
    shares = gap_shares(constraint_evaluator(with_closed_gaps(eqs, ()), parameters, {}, t), q)
    closed = [name for name, share in shares.items() if share <= AT_LENGTH]
    notes = []
    for name, share in shares.items():
        words = gap_words(eqs, name)
        notes.append(
            f"{words.subject} is {words.at_gap_zero} and assumed {words.holds}, regardless of its "
            f"{words.force}"
            if name in closed
            else f"{words.subject} is {words.open_by(share, 'here')}, so it constrains nothing"
        )
    return with_closed_gaps(eqs, closed), tuple(notes)


def gap_assumptions(eqs: EquationSet) -> tuple[str, ...]:
    """Return notes on the ropes and stops that an analysis of all configurations takes as taut or closed."""
    rows = {row.gap for row in eqs.formed.rows}
    words = [gap_words(eqs, name) for name in unilateral_elements(eqs.formed) if name in rows]
    return tuple(f"{each.subject} is assumed to be {each.holds}" for each in words)


def gaps_out_of_place(eqs: EquationSet, evaluator: ConstraintEvaluator, q: Floats) -> str:
    """Return a sentence on the ropes and stops that are not as these equations have them; empty if all are.

    Parameters
    ----------
    eqs : EquationSet
        With closed gaps as constraints and without those that are open.
    evaluator : ConstraintEvaluator
        Measures the gaps.
    """
    closed = {row.gap for row in eqs.formed.rows}
    misplaced = []
    for name, share in gap_shares(evaluator, q).items():
        words = gap_words(eqs, name)
        if name in closed and share > LOOSE:
            misplaced.append(f"{words.subject} is {words.open_by(share, ',')}")
        elif share < -LOOSE:
            misplaced.append(words.too_far)
    return ", ".join(misplaced)


def _place(
    loose: ConstraintEvaluator, eqs: EquationSet, fixed: Mapping[str, float], attempt: Attempt
) -> State:
    """Return a state in which no gap is negative; its speeds do not matter."""
    closed: list[str] = []
    state = attempt(with_closed_gaps(eqs, closed), fixed)
    while True:
        shares = gap_shares(loose, np.array([*state.q.values()]))
        negative = [name for name, share in shares.items() if name not in closed and share < -AT_LENGTH]
        if not negative:
            return state
        closed += negative
        try:
            state = attempt(with_closed_gaps(eqs, closed), fixed)
        except AssemblyError as error:
            problems = [_too_short(state, name, error) for name in negative]
            raise AssemblyError(*problems) from error


def _too_short(state: State, name: str, error: AssemblyError) -> Problem:
    place = gap_place(state.eqs.formed, name)
    length, slack = float(state[f"gap_scale {name}"]), float(state[f"row_gap {name}"])
    if not length:
        return Problem(
            "assembly.closed_stop", place, f"its gap is {slack:.6g}, but cannot be negative",
            f"no free motion opens it: {error.problems[0].what}",
            "give other initial positions, or another gap",
        )  # fmt: skip
    return Problem(
        "assembly.rope_too_short", place,
        f"its ends are {length - slack:.9g} m apart, but the rope is {length:.9g} m long",
        f"no free motion brings them closer: {error.problems[0].what}",
        "give other initial positions, or a longer rope",
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Speeds:
    """The speeds at given positions, and which gaps they keep closed."""

    eqs: EquationSet
    q: Floats
    rates: Mapping[str, float]
    guess: Mapping[str, float]
    evaluate: Callable[[EquationSet], ConstraintEvaluator]

    def solve(self, state: State) -> State:
        """Return the state with speeds and accelerations; gaps with efforts are its constraints."""
        shares = gap_shares(self.evaluate(with_closed_gaps(self.eqs, ())), self.q)
        near = [name for name, share in shares.items() if not share > AT_LENGTH]
        u, closing = self._speeds(near)
        closed = [name for name in near if abs(closing[name]) <= AT_REST]
        while True:
            evaluator = self.evaluate(with_closed_gaps(self.eqs, closed))
            try:
                result = complete_state(evaluator, self.q, u, self.q, self._guessed_rates(evaluator))
            except AssemblyError:  # their rows may contradict each other: a stop that begins to rise
                held = self._find_held(u, closed)
                if len(held) == len(closed):
                    raise
                closed = held
                continue
            pushes = {name: -float(result[f"opening_effort {name}"]) for name in closed}
            worst = max(pushes, key=lambda name: pushes[name], default="")
            if not worst or pushes[worst] <= 0.0:
                return result
            closed.remove(worst)

    def _find_held(self, u: Floats, closed: list[str]) -> list[str]:
        """Return which closed gaps are held by efforts, as a motion decides; all where none is found."""
        evaluator = self.evaluate(self.eqs)
        values = evaluator.compile(OF_MODES)(evaluator.t, self.q, u, s=evaluator.signals)
        numbers = mode_numbers(self.eqs, values, evaluator.mechanism)
        openings = {name: UNDECIDED if name in closed else OPEN for name in numbers.gaps}
        found = numbers.decide(openings)
        if found.verdict is not ModeVerdict.ONE:
            return closed
        modes = dict(zip(numbers.names, found.modes, strict=True))
        return [name for name in closed if modes[name] == HOLDS]

    def _speeds(self, near: list[str]) -> tuple[Floats, dict[str, float]]:
        """Return speeds, and the rates at which closed gaps become negative."""
        closed: list[str] = []
        refused: set[str] = set()
        u = self._consistent(closed)
        while True:
            closing = self._closing_rates(near, u)
            negative = [n for n in near if closing[n] > AT_REST and n not in closed and n not in refused]
            if not negative:
                return u, closing
            try:
                u = self._consistent([*closed, negative[0]])
                closed.append(negative[0])
            except AssemblyError:
                refused.add(negative[0])

    def _consistent(self, closed: list[str]) -> Floats:
        evaluator = self.evaluate(with_closed_gaps(self.eqs, closed))
        return solve_speeds(evaluator, self.q, self.rates, self._guessed_rates(evaluator))

    def _guessed_rates(self, evaluator: ConstraintEvaluator) -> dict[str, float]:
        """Return the rates guessed that are not fixed."""
        return {
            name: x for name, x in evaluator.split_values(self.guess)[1].items() if name not in self.rates
        }

    def _closing_rates(self, names: list[str], u: Floats) -> dict[str, float]:
        """Return the rates at which gaps shrink, over the largest speed or the mechanism's own."""
        evaluator = self.evaluate(with_closed_gaps(self.eqs, ()))
        mechanism, rates = evaluator.mechanism, np.abs(u / evaluator.speed_sizes)
        fastest = float(rates.max(initial=1.0 / mechanism.time))
        rates_of = {
            name: float(evaluator.compile(f"gap_dot {name}")(evaluator.t, self.q, u)) for name in names
        }
        return {
            name: -rate / (fastest * mechanism.gap(evaluator.eqs, name)) for name, rate in rates_of.items()
        }
