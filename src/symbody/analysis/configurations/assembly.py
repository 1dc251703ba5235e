"""`assemble`: a configuration and a motion that satisfy all constraints, from fixed values and guesses.

Positions by Newton steps of least length from the guess (Gauss-Newton, Nocedal & Wright 2006, section 10.3),
with fixed values never moved; then velocities, then accelerations and multipliers.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state, state_of_plain
from symbody.analysis.configurations.closed_gaps import assemble_with_gaps
from symbody.analysis.configurations.kept_values import (
    do_values_fit,
    held_initial_values,
    kept_initial_values,
    surplus_initial_values,
)
from symbody.analysis.configurations.loop_search import (
    NO_RANGES,
    check_meeting_ends,
    find_assembly,
    further_assemblies,
    newton_end,
    open_problem,
)
from symbody.analysis.configurations.plain_assembly import plain_state
from symbody.analysis.configurations.ranges import (
    Ranges,
    checked_ranges,
    clip_to_ranges,
)
from symbody.analysis.configurations.unsubstituted import substituted_state, with_followers
from symbody.analysis.constraint_evaluator import (
    ConstraintEvaluator,
    constraint_evaluator,
)
from symbody.analysis.named_values import check_mappings, check_pairs, named_values, unit_quaternions
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.signal_values import split_signals
from symbody.analysis.state import State
from symbody.analysis.velocities import solve_speeds
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.closing_equations import closing_equations
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.errors import AssemblyError
from symbody.model.first_values import FirstValue, by_priority

Floats = NDArray[np.float64]


@named_after(3)
@checked_arguments
def assemble(
    eqs: EquationSet,
    fixed: Mapping[str, FirstValue] | None = None,
    guess: Mapping[str, FirstValue] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> State:
    """Return a state in which all constraints hold.

    Ropes are made taut where the guess would stretch them beyond their length, stops are closed where the
    guess goes beyond them; speeds that would stretch a taut rope or go beyond a closed stop are changed,
    unless they are fixed. Slack ropes and open stops are left alone.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    fixed : mapping of name to number or formula in parameters
        Coordinates, speeds, ``_dot`` names, any named joint coordinate, or states of signals, that must have
        these values; of an angle also ``"30 deg"``. Initial values of the model with the priority "hold" are
        among them.
    guess : mapping of name to number or formula in parameters
        Where to look for the others; by default the model's initial values, then 0. Among several
        assemblies the nearest to the guess is taken; speeds and rates take their guesses exactly, in their
        order, those of the model last, as long as they are independent. `State.moved` lists the others.
        Without a guess of positions those of the model are kept, as if they were fixed, where the loops close
        with them, and either they are no more than there are degrees of freedom left, or nothing else is
        fixed.
    parameters, inputs : mapping
        As for `simulate`; they matter for explicit time, accelerations and multipliers.
    t : float
        Time [s].
    ranges : mapping of name to (lower, upper), numbers or formulas in parameters
        Positions that must lie between these; angles are turned by whole turns into their ranges. Starts
        are spread over the ranges too.
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model. Constraints are closed to
        1e-9 of the length, or rad.

    Returns
    -------
    State
        Positions ``q`` [m, rad], speeds ``u``, accelerations ``udot`` and ``multipliers``, each a mapping of
        names to floats, also as ``state["theta"]``; ``moved`` says which guesses were not kept, ``branches``
        has other assemblies.

    Raises
    ------
    AssemblyError
        If the loops do not close, naming the joint that stays farthest open where the sum of squares of all
        gaps is least, and the others open there; or they close outside the ranges only; or fixed values
        contradict each other, naming the smallest set that does; or if a name is unknown.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> state = sb.assemble(eqs, {"x": 4, "x_dot": 3})
    >>> print(f"{state['y']:.6f} {state['y_dot']:.6f}")
    3.000000 -4.000000
    """
    check_mappings(fixed=fixed, guess=guess, parameters=parameters, inputs=inputs, ranges=ranges)
    check_pairs(ranges or {})
    exact, near = by_priority(fixed or {}, guess or {})
    return find_first_state(eqs, exact, near, parameters, inputs, t, ranges, scales)


def find_first_state(
    eqs: EquationSet,
    exact: Mapping[str, Value],
    near: Mapping[str, Value],
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    scales: Mapping[str, float] | None = None,
) -> State:
    """Return a state as `assemble`, for arguments that were looked at.

    Parameters
    ----------
    exact, near : mapping of name to number or formula
        What is fixed, and what is guessed.
    """
    if closing_equations(eqs) is not eqs:
        return _assemble_whole(eqs, exact, near, parameters, inputs, t, ranges, scales)
    exact = {**held_initial_values(eqs, exact, near), **exact}
    signals, exact, near = split_signals(eqs, exact, near, parameters)
    rest = parameters, inputs, t, ranges, scales
    kept = kept_initial_values(eqs, exact, near) or _fitting_values(eqs, exact, near, *rest[:3], scales)
    if kept:
        with suppress(AssemblyError):
            return _assemble(eqs, {**exact, **kept}, near, *rest, signals)
    return _assemble(eqs, exact, near, *rest, signals)


def _assemble_whole(
    eqs: EquationSet,
    fixed: Mapping[str, Value],
    guess: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    ranges: Mapping[str, tuple[Value, Value]] | None,
    scales: Mapping[str, float] | None,
) -> State:
    """Return a state that is found in other equations, those that close it."""
    known = named_values(eqs, guess, parameters, strict=set(guess))
    near = {**with_followers(eqs, known, parameters or {}), **guess}
    state = find_first_state(closing_equations(eqs), fixed, near, parameters, inputs, t, ranges, scales)
    return substituted_state(eqs, state, scales)


def _fitting_values(
    eqs: EquationSet,
    fixed: Mapping[str, Value],
    guess: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    scales: Mapping[str, float] | None,
) -> Mapping[str, Value]:
    """Return the first positions of the model that fit, though they are more than there are freedoms."""
    surplus = surplus_initial_values(eqs, fixed, guess)
    if not surplus:
        return {}
    values = named_values(eqs, surplus, parameters, strict=set())
    given = dict(parameters or {}), dict(inputs or {})
    evaluator = constraint_evaluator(eqs, *given, t, mechanism_scales(eqs, given[0], scales, values))
    return surplus if do_values_fit(evaluator, values) else {}


def _assemble(
    eqs: EquationSet,
    fixed: Mapping[str, Value],
    guess: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    ranges: Mapping[str, tuple[Value, Value]] | None,
    scales: Mapping[str, float] | None,
    signals: Floats,
) -> State:
    """Return a state in which all constraints hold, as `assemble`."""
    given = eqs, fixed, guess, parameters, inputs, t
    if unilateral_elements(eqs.formed):
        return _assemble_with_gaps(*given, ranges, scales, signals)
    if not (ranges or signals.size):
        plain = _assemble_plain(*given, scales)
        if plain is not None:
            return plain
    return assemble_taut(*given, ranges, scales, signals=signals)


def _assemble_with_gaps(
    eqs: EquationSet,
    fixed: Mapping[str, Value],
    guess: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    ranges: Mapping[str, tuple[Value, Value]] | None,
    scales: Mapping[str, float] | None,
    signals: Floats,
) -> State:
    """Return a state in which no gap of a rope or stop is negative."""

    def attempt(equations: EquationSet, values: Mapping[str, float]) -> State:
        return assemble_taut(equations, values, guess, parameters, inputs, t, ranges, scales, signals=signals)

    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess))
    exact = named_values(eqs, fixed, parameters, strict=set(fixed))
    values = dict(parameters or {}), dict(inputs or {})
    mechanism = mechanism_scales(eqs, values[0], scales, {**near, **exact})
    return assemble_with_gaps(
        eqs, exact, near, attempt,
        lambda held: constraint_evaluator(held, *values, t, mechanism, signals=signals),
    )  # fmt: skip


def _assemble_plain(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None,
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    scales: Mapping[str, float] | None,
) -> State | None:
    """Return a state in which all constraints hold, or None where that takes more than one look."""
    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess or ()))
    values = named_values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    given = dict(parameters or {}), dict(inputs or {})
    mechanism = mechanism_scales(eqs, given[0], scales, {**near, **values})
    plain = plain_state(eqs, values, near, given, t, mechanism)
    if plain is None:
        return None
    others = partial(_branches, eqs, fixed, guess, parameters, inputs, t, scales)
    return state_of_plain(eqs, plain, (values, near), given, t, mechanism, others)


def _branches(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None,
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None,
    t: float,
    scales: Mapping[str, float] | None,
) -> tuple[State, ...]:
    return assemble_taut(eqs, fixed, guess, parameters, inputs, t, None, scales).branches


def assemble_taut(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None,
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    scales: Mapping[str, float] | None = None,
    *,
    signals: Floats | None = None,
) -> State:
    """Return a state in which all constraints hold, those of ropes and stops too; otherwise as `assemble`.

    `signals` are the states of signals, by default those of the model.
    """
    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess or ()))
    values = named_values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    mechanism = mechanism_scales(eqs, dict(parameters or {}), scales, {**near, **values})
    evaluator = constraint_evaluator(
        eqs, dict(parameters or {}), dict(inputs or {}), t, mechanism, signals=signals
    )
    positions, rates = evaluator.split_values(values)
    positions, near = unit_quaternions(eqs.quaternions, positions, near)
    lower, upper = (
        named_values(
            eqs, {name: pair[k] for name, pair in (ranges or {}).items()}, parameters, set(ranges or ())
        )
        for k in (0, 1)
    )
    within = checked_ranges(evaluator, lower, upper)
    start = clip_to_ranges(evaluator, evaluator.initial_coordinates({**near, **positions}), within, positions)
    assembly = find_assembly(evaluator, _measured_start(evaluator, start, positions, near), positions, within)
    if assembly is None:
        raise AssemblyError(
            open_problem(evaluator, evaluator.initial_coordinates(near), start, positions, within)
        )
    q = assembly.q
    guessed = {name: value for name, value in near.items() if name not in positions and name not in rates}
    u = solve_speeds(evaluator, q, rates, guessed)
    others = partial(_other_states, evaluator, start, positions, q, within, rates, guessed)
    return complete_state(evaluator, q, u, start, guessed, others)


def _other_states(
    evaluator: ConstraintEvaluator,
    start: Floats,
    fixed: Mapping[str, float],
    q: Floats,
    ranges: Ranges,
    rates: Mapping[str, float],
    guess: Mapping[str, float],
) -> list[State]:
    attempts = further_assemblies(evaluator, start, fixed, q, ranges)
    return [
        complete_state(evaluator, b.q, solve_speeds(evaluator, b.q, rates, guess), start, guess)
        for b in attempts
    ]


def _all_guesses(eqs: EquationSet, guess: Mapping[str, Value] | None) -> dict[str, Value]:
    """Return the guesses, and behind them what only the model says of the start."""
    given = dict(guess or {})
    return given | {name: value for name, value in eqs.model.initial.items() if name not in given}


def close(
    evaluator: ConstraintEvaluator,
    held: Mapping[str, float],
    near: Mapping[str, float],
    speeds: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Return q and u in which all constraints hold, with what is held, nearest to what is near.

    Positions move least in the sizes of `Scales`. Rates that are near take their values in their order, as
    far as they are still free; the change of all others, from `speeds` (n_u,) or from rest, has the least
    kinetic energy. `kernels.configurations.closing` computes the same without names.

    Raises
    ------
    AssemblyError
        As `assemble`.
    """
    positions, rates = evaluator.split_values(held)
    positions, near = unit_quaternions(evaluator.eqs.quaternions, positions, near)
    q = consistent_positions(evaluator, positions, near)
    guess = {name: value for name, value in near.items() if name not in positions and name not in rates}
    return q, solve_speeds(evaluator, q, rates, guess, speeds)


def consistent_positions(
    evaluator: ConstraintEvaluator, fixed: Mapping[str, float], near: Mapping[str, float]
) -> Floats:
    """Return coordinates (n_q,) in which all constraints hold, with the positions among the fixed values.

    Raises
    ------
    AssemblyError
        As `assemble`.
    """
    positions, near = unit_quaternions(evaluator.eqs.quaternions, evaluator.split_values(fixed)[0], near)
    start = evaluator.initial_coordinates({**near, **positions})
    assembly = find_assembly(evaluator, _measured_start(evaluator, start, positions, near), positions)
    if assembly is None:
        raise AssemblyError(
            open_problem(evaluator, evaluator.initial_coordinates(near), start, positions, NO_RANGES)
        )
    return assembly.q


def _measured_start(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], near: Mapping[str, float]
) -> Floats:
    """Return a start at which coordinates of cut joints have the values guessed for them, if there is one."""
    guessed = {
        name: near[name]
        for name in evaluator.split_values(near)[0]
        if name not in evaluator.eqs.coordinate_names
    }
    measured = {name: value for name, value in guessed.items() if name not in fixed}
    if not measured:
        return start
    attempt = newton_end(evaluator, start, {**fixed, **measured})
    return attempt.q if attempt.is_closed else start


def find_configuration(
    evaluator: ConstraintEvaluator, guess: Mapping[str, Value], parameters: Mapping[str, Value] | None
) -> Floats | None:
    """Return the configuration nearest to a guess that closes the loops, or None."""
    eqs = evaluator.eqs
    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess))
    start = _measured_start(evaluator, evaluator.initial_coordinates(near), {}, near)
    assembly = find_assembly(evaluator, start, {})
    if assembly is None:
        check_meeting_ends(evaluator, newton_end(evaluator, start, {}).q)
    return None if assembly is None else assembly.q
