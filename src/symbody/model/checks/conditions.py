"""What the numbers of a constraint say: lengths, ratios, angles and curves that cannot be."""

from __future__ import annotations

import math

from symbody.expr.language.formula import Formula
from symbody.model.checker import Checker
from symbody.model.checks.physics import check_angle, check_axis
from symbody.model.constraint import Condition, Contact
from symbody.model.constraints import Angle, Belt, Distance, Gear, PointOnCurve, RackPinion, Rolling
from symbody.tolerances import TYPED


def check_constraint(check: Checker, condition: Condition, label: str) -> None:
    """Check directions and numbers of a constraint."""
    if isinstance(condition, Contact):
        for path, axis in condition.directions.items():
            if not isinstance(axis, str):
                check_axis(check, axis, f"{label}, {path}")
    if isinstance(condition, Angle):
        _check_cosine(check, condition.value, f"{label}, value")
    elif isinstance(condition, PointOnCurve):
        _check_curve(check, condition, label)
    else:
        _check_sizes(check, condition, label)


def _check_sizes(check: Checker, condition: Condition, label: str) -> None:
    """Check distances, radii and ratios."""
    if isinstance(condition, Distance):
        _check_length(check, condition.value, f"{label}, value", "a point on another needs a spherical joint")
    elif isinstance(condition, Rolling):
        _check_length(check, condition.radius, f"{label}, radius", "a point does not roll")
    elif isinstance(condition, Belt):
        for k, radius in enumerate(condition.radii):
            why = "the senses of rotation are those of the angles, and of crossed"
            _check_length(check, radius, f"{label}, radii[{k}]", why)
    elif isinstance(condition, Gear):
        _check_ratio(check, condition.ratio, f"{label}, ratio")
    elif isinstance(condition, RackPinion):
        _check_ratio(check, condition.radius, f"{label}, radius")


def _check_ratio(check: Checker, ratio: Formula, where: str) -> None:
    if check.value(ratio, where) == 0:
        check.refuse(
            "model.no_ratio",
            where,
            f"{ratio} is 0",
            "the first coordinate would stand still, whatever the second does",
            "give a number other than zero; a joint without this freedom holds the first",
        )


def _check_curve(check: Checker, curve: PointOnCurve, label: str) -> None:
    if not any(curve.parameter in formula.names for formula in curve.curve):
        check.refuse(
            "model.no_curve",
            f"{label}, curve",
            f"{curve.parameter} does not occur in it",
            "what does not change with its parameter is a point",
            f"write the place as a function of {curve.parameter}; a point needs a spherical joint",
        )


def _check_cosine(check: Checker, angle: Formula, where: str) -> None:
    """Refuse angles at which the cosine stands still: the constraint would hold two freedoms, not one."""
    value = check.value(angle, where)
    if value is None:
        return
    if abs(math.sin(value)) < TYPED:
        check.refuse(
            "model.flat_angle",
            where,
            f"{angle} is {value:g} rad: the directions are parallel",
            "that takes two equations, and the one for the cosine has no slope there",
            'write type = "parallel" instead',
        )
    check_angle(check, angle, where)


def _check_length(check: Checker, length: Formula, where: str, why: str) -> None:
    value = check.value(length, where)
    if value is not None and value <= 0:
        check.refuse("model.no_length", where, f"{length} is {value:g} m", why, "give a length above zero")
