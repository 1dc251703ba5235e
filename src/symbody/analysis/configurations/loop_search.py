"""The search for configurations in which all loops close, and why none was found where there is none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.exclusion import why_excluded
from symbody.analysis.configurations.minimum_gap import minimum_gap
from symbody.analysis.configurations.ranges import (
    Ranges,
    draw_measured_values,
    draw_starts,
    out_of_range_problem,
    turn_into_ranges,
)
from symbody.analysis.constraint_evaluator import STARTS, ConstraintEvaluator, indefinite_rows
from symbody.codegen.formation.values import constant_values
from symbody.errors import Problem
from symbody.manifold import Configuration, least_step
from symbody.model.constraints import Distance
from symbody.tolerances import ASSEMBLED

Floats = NDArray[np.float64]

NO_RANGES: Final[Ranges] = MappingProxyType({})
# So many of the nearest ends are starts for the search of the least gaps; smaller gaps are not shown.
_GAP_TRIALS: Final = 3
_VISIBLE: Final = 1e-6


def find_assembly(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> Configuration | None:
    """Return the assembly nearest to the start, trying starts farther and farther away; or None."""
    for guess in _starts(evaluator, start, fixed, ranges):
        attempt = _restrict_to_ranges(evaluator, newton_end(evaluator, guess, fixed), fixed, ranges)
        if attempt.is_closed:
            return attempt
        if evaluator.is_tree and all(name in evaluator.eqs.coordinate_names for name in ranges):
            return None
    starts = _starts(evaluator, start, fixed, ranges)
    trials = zip(starts, draw_measured_values(evaluator, ranges, fixed, STARTS), strict=False)
    names = evaluator.eqs.coordinate_names
    held = {name: float(x) for name, x in zip(names, start, strict=True) if name in ranges}
    for guess, inside in chain([(start, held)] if held else [], trials):
        end = newton_end(evaluator, guess, {**fixed, **inside})
        attempt = _restrict_to_ranges(evaluator, end, fixed, ranges)
        if attempt.is_closed:
            return attempt
    return None


def _restrict_to_ranges(
    evaluator: ConstraintEvaluator, attempt: Configuration, fixed: Mapping[str, float], ranges: Ranges
) -> Configuration:
    """Return an end of Newton's method with angles in their ranges; not closed outside of these."""
    if not attempt.is_closed or not ranges:
        return attempt
    q = turn_into_ranges(evaluator, attempt.q, ranges)
    if q is None:
        return replace(attempt, is_closed=False)
    if np.array_equal(q, attempt.q):
        return attempt
    # Whole turns of one wheel alone are none of the gear it is in.
    return evaluator.manifold(fixed).judge(q)


def _starts(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], ranges: Ranges = NO_RANGES
) -> Iterator[Floats]:
    """Yield the start and starts about it, and in the ranges, the same at every call."""
    yield from evaluator.starts(start, fixed)
    yield from draw_starts(evaluator, start, ranges, fixed, STARTS)


def newton_end(evaluator: ConstraintEvaluator, q: Floats, fixed: Mapping[str, float]) -> Configuration:
    """Return the end of steps of least length."""
    return evaluator.manifold(fixed).project(q, least_step)


def further_assemblies(
    evaluator: ConstraintEvaluator, start: Floats, fixed: Mapping[str, float], q: Floats, ranges: Ranges
) -> list[Configuration]:
    """Return further assemblies, nearest to the start first."""
    if evaluator.is_tree:
        return []
    different = [q]
    others = []
    for guess in islice(_starts(evaluator, start, fixed, ranges), 1, None):
        attempt = _restrict_to_ranges(evaluator, newton_end(evaluator, guess, fixed), fixed, ranges)
        if attempt.is_closed and all(evaluator.differs(attempt.q, other) for other in different):
            if evaluator.is_isolated(attempt.q, fixed):
                different.append(attempt.q)
                others.append(attempt)
    return sorted(others, key=lambda attempt: float(np.abs((attempt.q - start) / evaluator.sizes).max()))


def open_problem(
    evaluator: ConstraintEvaluator, guess: Floats, start: Floats, fixed: Mapping[str, float], ranges: Ranges
) -> Problem:
    """Return the contradiction of fixed values, the joint that stays open, or the ranges that are missed."""
    if ranges:
        outside = find_assembly(evaluator, start, fixed)
        if outside is not None:
            others = further_assemblies(evaluator, start, fixed, outside.q, NO_RANGES)
            return out_of_range_problem(evaluator, [outside.q, *(other.q for other in others)], ranges)
    if fixed and find_assembly(evaluator, guess, {}) is not None:
        conflict = dict(fixed)
        for name in fixed:
            fewer = {key: value for key, value in conflict.items() if key != name}
            near = evaluator.initial_coordinates(
                {**dict(zip(evaluator.eqs.coordinate_names, guess, strict=True)), **fewer}
            )
            if find_assembly(evaluator, near, fewer) is None:
                conflict = fewer
        return _conflict_problem(evaluator, start, conflict)
    attempts = sorted((newton_end(evaluator, guess, fixed) for guess in _starts(evaluator, start, fixed)),
                      key=lambda attempt: np.nan_to_num(attempt.residual, nan=np.inf))  # fmt: skip
    return _open_joints(evaluator, attempts, fixed)


def _conflict_problem(
    evaluator: ConstraintEvaluator, start: Floats, conflict: Mapping[str, float]
) -> Problem:
    """Return values with which no configuration was found, with the nearest where one alone is impossible."""
    listed = ", ".join(f"{name} = {value:g}" for name, value in conflict.items())
    proof = why_excluded(evaluator, conflict)
    why = proof or f"the search from {STARTS} starting points around the guess found none"
    cure = "pass one of them in guess= instead"
    nearest = find_assembly(evaluator, start, {})
    if len(conflict) == 1 and nearest is not None:
        places = dict(zip(evaluator.eqs.coordinate_names, nearest.q.tolist(), strict=True))
        near = [f", for instance {name} = {places[name]:.4g}" for name in conflict if name in places]
        cure = f"give another value{''.join(near)}, or pass it in guess= instead"
    return Problem(
        "assembly.conflict", "fixed", f"no configuration {'has' if proof else 'was found with'} {listed}",
        f"the loops close without these values, but {why}", cure,
    )  # fmt: skip


def _open_joints(
    evaluator: ConstraintEvaluator, attempts: Sequence[Configuration], fixed: Mapping[str, float]
) -> Problem:
    """Say by how much joints stay open, from where Newton's method came nearest to closing them."""
    best = attempts[0]
    proof = why_excluded(evaluator, fixed)
    why = (
        f"there is no configuration: {proof}"
        if proof
        else f"the search from {STARTS} starting points around the guess found none"
    )
    if not evaluator.is_aligned(best.q) and best.residual <= ASSEMBLED:
        joint = next(iter(evaluator.gaps(best.q)), "")
        kind = "joint"
        what = f"joint {joint} closes only with its axes pointing in opposite directions"
    else:
        finite = [attempt.q for attempt in attempts if np.isfinite(attempt.residual)][:_GAP_TRIALS]
        trials = [(best.q, np.inf), *(minimum_gap(evaluator, evaluator.normalize(q), fixed) for q in finite)]
        q, _ = min(trials, key=lambda trial: trial[1])
        (joint, gap), *others = evaluator.gaps(q).items() or [("", (0.0, 0.0))]
        size = evaluator.mechanism.length
        check_meeting_ends(evaluator, q)
        kind = _kind(evaluator, joint)
        what = f"{kind} {joint} cannot be closed: a gap of {_width(gap, size)} remains"
        wide = [(name, gap) for name, gap in others if gap[0] > _VISIBLE * size or gap[1] > _VISIBLE]
        if wide:
            listed = ", ".join(
                f"{_kind(evaluator, name)} {name} has a gap of {_width(gap, size)}" for name, gap in wide
            )
            why += f"; in the best fit {listed}, too"
    return Problem(
        "assembly.open", f"{kind} {joint}", what, why,
        "check lengths and frames of the loop, or give guess= values closer to a configuration that closes",
    )  # fmt: skip


def _kind(evaluator: ConstraintEvaluator, name: str) -> str:
    """Return what an element is: a joint, a constraint, ..."""
    elements = getattr(evaluator.eqs.model, "elements", ())
    return str(next((each.kind for each in elements if each.name == name), "joint"))


def _width(gap: tuple[float, float], size: float) -> str:
    """Return a distance and an angle in words, without the rounding of what is closed."""
    distance, angle = (
        value if value > _VISIBLE * unit else 0.0 for value, unit in zip(gap, (size, 1.0), strict=True)
    )
    return f"{distance:.3g} m and {np.degrees(angle):.3g} deg"


def check_meeting_ends(evaluator: ConstraintEvaluator, q: Floats) -> None:
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
