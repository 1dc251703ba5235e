"""`assemble`: a configuration and a motion that satisfy all constraints, from fixed values and guesses.

Positions by Newton steps of least length from the guess (Gauss-Newton, Nocedal & Wright 2006, section 10.3),
with fixed values never moved; then velocities, then accelerations and multipliers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.constraint_evaluator import (
    STARTS,
    ConstraintEvaluator,
    constraint_evaluator,
    indefinite_rows,
)
from symbody.analysis.minimum_gap import minimum_gap
from symbody.analysis.named_values import check_mappings, check_pairs, named_values, unit_quaternions
from symbody.analysis.ranges import (
    Ranges,
    checked_ranges,
    clip_to_ranges,
    draw_measured_values,
    draw_starts,
    out_of_range_problem,
    turn_into_ranges,
)
from symbody.analysis.ropes import assemble_with_ropes
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.signal_values import split_signals
from symbody.analysis.state import State
from symbody.analysis.velocities import solve_speeds
from symbody.arguments import checked_arguments
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import constant_values
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.ropes import ropes
from symbody.errors import AssemblyError, Problem
from symbody.manifold import Configuration, least_step
from symbody.model.constraints import Distance
from symbody.tolerances import ASSEMBLED

Floats = NDArray[np.float64]

NO_RANGES: Final[Ranges] = MappingProxyType({})
# So many of the nearest ends are starts for the search of the least gaps; smaller gaps are not shown.
_GAP_TRIALS: Final = 3
_VISIBLE: Final = 1e-6


@checked_arguments
def assemble(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    t: float = 0.0,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> State:
    """Return a state in which all constraints hold.

    Parameters
    ----------
    fixed : mapping of name to number or formula in parameters
        Coordinates, speeds, ``_dot`` names, any named joint coordinate, or states of signals, that must have
        these values; of an angle also ``"30 deg"``.
    guess : mapping of name to number or formula in parameters
        Where to look for the others; by default the model's initial values, then 0. Among several
        assemblies the nearest to the guess is taken; speeds and rates take their guesses exactly, in their
        order, those of the model last, as long as they are independent. `State.moved` lists the others.
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

    Ropes are closed where the guess would have them longer than they are, and where their ends would move
    apart although they are taut, unless fixed speeds demand that; those that are shorter are left alone.

    Raises
    ------
    AssemblyError
        If the loops do not close, naming the joint that stays farthest open where the sum of squares of all
        gaps is least, and the others open there; or they close outside the ranges only; or fixed values
        contradict each other, naming the smallest set that does; or if a name is unknown.
    """
    check_mappings(fixed=fixed, guess=guess, parameters=parameters, inputs=inputs, ranges=ranges)
    check_pairs(ranges or {})
    signals, fixed, guess = split_signals(eqs, fixed, guess, parameters)
    if not ropes(eqs.formed):
        return assemble_taut(eqs, fixed, guess, parameters, inputs, t, ranges, scales, signals=signals)

    def attempt(equations: EquationSet, values: Mapping[str, float]) -> State:
        return assemble_taut(equations, values, guess, parameters, inputs, t, ranges, scales, signals=signals)

    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess or ()))
    exact = named_values(eqs, fixed or {}, parameters, strict=set(fixed or ()))
    values = dict(parameters or {}), dict(inputs or {})
    mechanism = mechanism_scales(eqs, values[0], scales, {**near, **exact})
    return assemble_with_ropes(
        eqs, exact, near, attempt,
        lambda held: constraint_evaluator(held, *values, t, mechanism, signals=signals),
    )  # fmt: skip


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
    """Return a state in which all constraints hold, those of ropes too; otherwise as `assemble`.

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
    assembly = _find_assembly(
        evaluator, _measured_start(evaluator, start, positions, near), positions, within
    )
    if assembly is None:
        raise AssemblyError(
            _open_problem(evaluator, evaluator.initial_coordinates(near), start, positions, within)
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
    attempts = _further_assemblies(evaluator, start, fixed, q, ranges)
    return [
        complete_state(evaluator, b.q, solve_speeds(evaluator, b.q, rates, guess), start, guess)
        for b in attempts
    ]


def _all_guesses(eqs: EquationSet, guess: Mapping[str, Value] | None) -> dict[str, Value]:
    """Return the guesses, and behind them what only the model says of the start."""
    given = dict(guess or {})
    return given | {name: value for name, value in eqs.model.initial.items() if name not in given}


def consistent_start(
    evaluator: ConstraintEvaluator, fixed: Mapping[str, float], near: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Return q and u in which all constraints hold, as `assemble` does with values instead of formulas.

    Raises
    ------
    AssemblyError
        As `assemble`.
    """
    positions, rates = evaluator.split_values(fixed)
    positions, near = unit_quaternions(evaluator.eqs.quaternions, positions, near)
    q = consistent_positions(evaluator, positions, near)
    guess = {name: value for name, value in near.items() if name not in positions and name not in rates}
    return q, solve_speeds(evaluator, q, rates, guess)


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
    assembly = _find_assembly(evaluator, _measured_start(evaluator, start, positions, near), positions)
    if assembly is None:
        raise AssemblyError(
            _open_problem(evaluator, evaluator.initial_coordinates(near), start, positions, NO_RANGES)
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
    attempt = _newton(evaluator, start, {**fixed, **measured})
    return attempt.q if attempt.is_closed else start


def find_configuration(
    evaluator: ConstraintEvaluator, guess: Mapping[str, Value], parameters: Mapping[str, Value] | None
) -> Floats | None:
    """Return the configuration nearest to a guess that closes the loops, or None."""
    eqs = evaluator.eqs
    near = named_values(eqs, _all_guesses(eqs, guess), parameters, strict=set(guess))
    start = _measured_start(evaluator, evaluator.initial_coordinates(near), {}, near)
    assembly = _find_assembly(evaluator, start, {})
    if assembly is None:
        _check_meeting_ends(evaluator, _newton(evaluator, start, {}).q)
    return None if assembly is None else assembly.q


def _check_meeting_ends(evaluator: ConstraintEvaluator, q: Floats) -> None:
    """Refuse ends of a rod of length 0, which meet without closing: the rod has no direction there."""
    gaps, size = evaluator.gaps(q).values(), evaluator.mechanism.length
    if all(distance <= _VISIBLE * size and angle <= _VISIBLE for distance, angle in gaps):
        rods = {
            rod.name: rod.value
            for rod in evaluator.eqs.model.constraints
            if isinstance(rod, Distance) and "t" not in rod.value.names
        }
        lengths = constant_values(evaluator.eqs, rods, evaluator.parameters)
        short = [name for name, length in lengths.items() if abs(length) <= _VISIBLE * size]
        if short:  # the ends may be apart by rounding, in any direction
            raise indefinite_rows(", ".join(short))
        evaluator.velocity_rows(q, {})


def _find_assembly(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> Configuration | None:
    """Return the assembly nearest to the start, trying starts farther and farther away; or None."""
    for guess in _starts(evaluator, start, fixed, ranges):
        attempt = _restrict_to_ranges(evaluator, _newton(evaluator, guess, fixed), ranges)
        if attempt.is_closed:
            return attempt
        if evaluator.is_tree:
            return None
    starts = _starts(evaluator, start, fixed, ranges)
    for guess, inside in zip(starts, draw_measured_values(evaluator, ranges, fixed, STARTS), strict=False):
        attempt = _restrict_to_ranges(evaluator, _newton(evaluator, guess, {**fixed, **inside}), ranges)
        if attempt.is_closed:
            return attempt
    return None


def _restrict_to_ranges(
    evaluator: ConstraintEvaluator, attempt: Configuration, ranges: Ranges
) -> Configuration:
    """Return an end of Newton's method with angles in their ranges; not closed outside of these."""
    if not attempt.is_closed or not ranges:
        return attempt
    q = turn_into_ranges(evaluator, attempt.q, ranges)
    return replace(attempt, is_closed=False) if q is None else replace(attempt, q=q)


def _starts(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> Iterator[Floats]:
    """Yield the start and starts about it, and in the ranges, the same at every call."""
    yield from evaluator.starts(start, fixed)
    yield from draw_starts(evaluator, start, ranges, fixed, STARTS)


def _newton(evaluator: ConstraintEvaluator, q: Floats, fixed: Mapping[str, float]) -> Configuration:
    """Return the end of steps of least length."""
    return evaluator.manifold(fixed).project(q, least_step)


def _further_assemblies(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], q: Floats, ranges: Ranges
) -> list[Configuration]:
    """Return further assemblies, nearest to the start first."""
    if evaluator.is_tree:
        return []
    different = [q]
    others = []
    for guess in islice(_starts(evaluator, start, fixed, ranges), 1, None):
        attempt = _restrict_to_ranges(evaluator, _newton(evaluator, guess, fixed), ranges)
        if attempt.is_closed and all(evaluator.differs(attempt.q, other) for other in different):
            if evaluator.is_isolated(attempt.q, fixed):
                different.append(attempt.q)
                others.append(attempt)
    return sorted(others, key=lambda attempt: float(np.abs((attempt.q - start) / evaluator.sizes).max()))


def _open_problem(
    evaluator: ConstraintEvaluator, guess: Floats, start: Floats, fixed: Mapping[str, float], ranges: Ranges
) -> Problem:
    """Return the contradiction of fixed values, the joint that stays open, or the ranges that are missed."""
    if ranges:
        outside = _find_assembly(evaluator, start, fixed)
        if outside is not None:
            others = _further_assemblies(evaluator, start, fixed, outside.q, NO_RANGES)
            return out_of_range_problem(evaluator, [outside.q, *(other.q for other in others)], ranges)
    if fixed and _find_assembly(evaluator, guess, {}) is not None:
        conflict = dict(fixed)
        for name in fixed:
            fewer = {key: value for key, value in conflict.items() if key != name}
            near = evaluator.initial_coordinates(
                {**dict(zip(evaluator.eqs.coordinate_names, guess, strict=True)), **fewer}
            )
            if _find_assembly(evaluator, near, fewer) is None:
                conflict = fewer
        listed = ", ".join(f"{name} = {value:g}" for name, value in conflict.items())
        return Problem(
            "assembly.conflict", "fixed", f"no configuration has {listed}",
            "the loops close without these values, but not with them", "leave one of them to guess=",
        )  # fmt: skip
    attempts = sorted((_newton(evaluator, guess, fixed) for guess in _starts(evaluator, start, fixed)),
                      key=lambda attempt: np.nan_to_num(attempt.residual, nan=np.inf))  # fmt: skip
    return _open_joints(evaluator, attempts, fixed)


def _open_joints(
    evaluator: ConstraintEvaluator, attempts: Sequence[Configuration], fixed: Mapping[str, float]
) -> Problem:
    """Say by how much joints stay open, from where Newton's method came nearest to closing them."""
    best = attempts[0]
    why = f"{STARTS} starts about the guess were tried"
    if not evaluator.is_aligned(best.q) and best.residual <= ASSEMBLED:
        joint = next(iter(evaluator.gaps(best.q)), "")
        what = f"joint {joint} closes only with its axes opposite to each other"
    else:
        finite = [attempt.q for attempt in attempts if np.isfinite(attempt.residual)][:_GAP_TRIALS]
        trials = [(best.q, np.inf), *(minimum_gap(evaluator, evaluator.normalize(q), fixed) for q in finite)]
        q, _ = min(trials, key=lambda trial: trial[1])
        (joint, gap), *others = evaluator.gaps(q).items() or [("", (0.0, 0.0))]
        size = evaluator.mechanism.length
        _check_meeting_ends(evaluator, q)
        what = f"joint {joint} stays open by {_width(gap, size)}"
        wide = [(name, gap) for name, gap in others if gap[0] > _VISIBLE * size or gap[1] > _VISIBLE]
        if wide:
            listed = ", ".join(f"joint {name} by {_width(gap, size)}" for name, gap in wide)
            why += f"; with the least squares of all gaps {listed}"
    return Problem(
        "assembly.open", f"joint {joint}", what, why,
        "check lengths and frames of the loop, or give guess= values nearer to a configuration that closes",
    )  # fmt: skip


def _width(gap: tuple[float, float], size: float) -> str:
    """Return a distance and an angle in words, without the rounding of what is closed."""
    distance, angle = (
        value if value > _VISIBLE * unit else 0.0 for value, unit in zip(gap, (size, 1.0), strict=True)
    )
    return f"{distance:.3g} m and {np.degrees(angle):.3g} deg"
