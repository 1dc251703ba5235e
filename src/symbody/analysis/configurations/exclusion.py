"""Proofs that no configuration exists: linear equations in contradiction, and bounds that exclude 0.

A search shows that nothing was found. That there is nothing is shown by the rank of equations that are linear
in what may move, or by equations whose bounds over all values of it exclude 0, as where a rod does not reach
(branch and prune; Kearfott, Rigorous Global Search (1996), chapter 5).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.analysis.curvature import cyclic_coordinates
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.interval_numbers import INTERVALS, WHOLE, Interval, can_bound, interval
from symbody.tolerances import ASSEMBLED

# Operations in intervals, some 0.1 s, and the width [rad] of parts that are not cut further.
_MOST_WORK: Final = 50_000
_NARROW: Final = 1e-3


def why_excluded(evaluator: ConstraintEvaluator, fixed: Mapping[str, float]) -> str:
    """Return why no configuration has these positions; nothing where that is not proven."""
    manifold = evaluator.manifold(fixed)
    start = evaluator.initial_coordinates(fixed)
    if manifold.contradicts(start):
        rows = evaluator.eqs.formed.holonomic
        linear = zip(rows, manifold.linear if manifold.linear is not None else (), strict=False)
        names = dict.fromkeys(row.element for row, is_linear in linear if is_linear)
        what = "these values" if fixed else "each other"
        return (
            f"equations of {', '.join(names)} are linear in all coordinates that may move, and contradict "
            f"{what}"
        )
    return _why_out_of_reach(evaluator, fixed)


def _why_out_of_reach(evaluator: ConstraintEvaluator, fixed: Mapping[str, float]) -> str:
    """Return which equations exclude each other's zeros over all values of what is not fixed.

    Angles that stand in sines and cosines alone are cut into parts until each part is excluded by one
    equation, or there are too many parts.
    """
    function = evaluator.compile("constraints")
    sequence = function.shared_sequence
    if not can_bound(sequence):
        return ""
    eqs = evaluator.eqs
    in_quaternions = {name for four in eqs.quaternions for name in four}
    limits = [
        interval(fixed[name]) if name in fixed else Interval(-1.0, 1.0) if name in in_quaternions else WHOLE
        for name in eqs.coordinate_names
    ]
    cyclic = cyclic_coordinates(eqs)
    angles = [k for k, name in enumerate(eqs.coordinate_names) if cyclic[k] and name not in fixed]
    for k in angles:
        limits[k] = Interval(-math.pi, math.pi)
    point = {
        "t": [interval(evaluator.t)],
        "u": [WHOLE] * len(eqs.speed_names),
        "p": list(map(interval, function.bound_values.tolist())),
    }
    signals = list(map(interval, evaluator.signals.tolist()))
    boxes = [limits]
    elements: dict[str, bool] = {}
    for _ in range(_MOST_WORK // max(len(sequence.operations), 1)):
        if not boxes:
            return f"{', '.join(elements)} cannot close for any values of the other coordinates"
        box = boxes.pop()
        bounds = evaluate_sequence(sequence, {**point, "q": [*box, *signals]}, INTERVALS)[0]
        element = _farthest_element(evaluator, bounds)
        if element:
            elements[element] = True
            continue
        widest = max(angles, key=lambda k: box[k].high - box[k].low, default=-1)
        if widest < 0 or box[widest].high - box[widest].low < _NARROW:
            return ""
        middle = (box[widest].low + box[widest].high) / 2.0
        for half in (Interval(box[widest].low, middle), Interval(middle, box[widest].high)):
            boxes.append([half if k == widest else side for k, side in enumerate(box)])
    return ""


def _farthest_element(evaluator: ConstraintEvaluator, bounds: Iterable[Interval]) -> str:
    """Return the element of the equation that stays farthest from 0, if one does."""
    farthest, element = ASSEMBLED, ""
    for row, scale, bound in zip(evaluator.eqs.formed.holonomic, evaluator.scales, bounds, strict=True):
        gap = max(bound.low, -bound.high) / scale
        if farthest < gap < math.inf:
            farthest, element = gap, row.element
    return element
