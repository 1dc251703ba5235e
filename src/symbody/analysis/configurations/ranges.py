"""Ranges of coordinates: assemblies outside are not taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.errors import AssemblyError, Problem

Floats = NDArray[np.float64]
Ranges = Mapping[str, tuple[float, float]]

# Assembly leaves 1e-9 of the size; an end of a range is still inside.
_EDGE: Final = 1e-8


def checked_ranges(
    evaluator: ConstraintEvaluator, lower: Mapping[str, float], upper: Mapping[str, float]
) -> Ranges:
    """Return ranges with their ends.

    Raises
    ------
    AssemblyError
        Naming each range that is empty or is not of a position.
    """
    positions, _ = evaluator.split_values(lower)
    problems = [
        Problem("assembly.range", name, f"{name} is not a position", "only positions have ranges",
                "leave it out, or give its value in fixed=")
        for name in lower if name not in positions
    ]  # fmt: skip
    problems += [
        Problem("assembly.range", name, f"the range from {lower[name]:g} to {upper[name]:g} is empty",
                "its lower bound is not below its upper bound", "give (lower, upper)")
        for name in lower if not lower[name] < upper[name]
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)
    return {name: (lower[name], upper[name]) for name in lower}


def turn_into_ranges(evaluator: ConstraintEvaluator, q: Floats, ranges: Ranges) -> Floats | None:
    """Return coordinates with angles turned by whole turns into their ranges; None if one is outside."""
    result = q.copy()
    names = evaluator.eqs.coordinate_names
    # What is measured follows from coordinates, so that these are turned before.
    for name, (low, high) in sorted(ranges.items(), key=lambda entry: entry[0] not in names):
        edge = _EDGE * (1.0 if name in evaluator.angles else float(evaluator.sizes.max(initial=1.0)))
        value = float(q[names.index(name)]) if name in names else evaluator.measure(name, result)
        if name in evaluator.angles and (name in names or name in evaluator.eqs.measured_angles):
            value += 2 * np.pi * np.ceil((low - edge - value) / (2 * np.pi))
        if not low - edge <= value <= high + edge:
            return None
        if name in names:
            result[names.index(name)] = value
    return result


def clip_to_ranges(
    evaluator: ConstraintEvaluator, q: Floats, ranges: Ranges, fixed: Mapping[str, float]
) -> Floats:
    """Return coordinates with those outside their ranges at the nearer end; fixed ones stay."""
    result = q.copy()
    for k, name in enumerate(evaluator.eqs.coordinate_names):
        if name in ranges and name not in fixed:
            turned = turn_into_ranges(evaluator, result, {name: ranges[name]})
            result[k] = np.clip(result[k], *ranges[name]) if turned is None else turned[k]
    return result


def draw_starts(
    evaluator: ConstraintEvaluator, start: Floats, ranges: Ranges, fixed: Mapping[str, float], count: int
) -> list[Floats]:
    """Return starts whose coordinates lie anywhere in their ranges, the same at every call."""
    names = evaluator.eqs.coordinate_names
    places = [k for k, name in enumerate(names) if name in ranges and name not in fixed]
    if not places:
        return []
    random = np.random.default_rng(2)
    free = evaluator.free_coordinates(fixed)
    starts = []
    for _ in range(count):
        moved = start.copy()
        moved[free] += random.standard_normal(int(free.sum())) * evaluator.sizes[free]
        moved[places] = [random.uniform(*ranges[names[k]]) for k in places]
        starts.append(evaluator.normalize(moved))
    return starts


def draw_measured_values(
    evaluator: ConstraintEvaluator, ranges: Ranges, fixed: Mapping[str, float], count: int
) -> list[dict[str, float]]:
    """Return values of coordinates of cut joints in their ranges, the middle first."""
    names = [name for name in ranges if name not in evaluator.eqs.coordinate_names and name not in fixed]
    if not names:
        return []
    random = np.random.default_rng(3)
    middle = {name: (ranges[name][0] + ranges[name][1]) / 2 for name in names}
    return [middle, *({name: random.uniform(*ranges[name]) for name in names} for _ in range(count - 1))]


def out_of_range_problem(
    evaluator: ConstraintEvaluator, configurations: Sequence[Floats], ranges: Ranges
) -> Problem:
    """Say that loops close outside the ranges only, and where."""
    names = evaluator.eqs.coordinate_names
    limits = ", ".join(f"{name} from {low:g} to {high:g}" for name, (low, high) in ranges.items())
    values = [
        {
            name: float(q[names.index(name)]) if name in names else evaluator.measure(name, q)
            for name in ranges
        }
        for q in configurations
    ]
    closed_at = "; ".join(", ".join(f"{name} = {value:.6g}" for name, value in one.items()) for one in values)
    return Problem(
        "assembly.out_of_range", "ranges", f"no configuration found has {limits}",
        f"the loops close with {closed_at}", "widen the ranges, or give fixed= values that reach them",
    )  # fmt: skip
