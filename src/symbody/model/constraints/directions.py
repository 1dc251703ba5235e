"""Directions held parallel, perpendicular, or at an angle."""

from __future__ import annotations

import math
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.constraint import FrameConstraint
from symbody.model.declarations.element_fields import Directions, element
from symbody.model.declarations.fields import AngleQuantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NumericChecks, check_angle
from symbody.tolerances import TYPED

_BOTH: Final = "A direction in the start frame and one in the end frame."


def _check_cosine(check: NumericChecks, angle: Formula, where: str) -> None:
    """Refuse angles at which the cosine stands still: the constraint would hold two freedoms, not one."""
    value = check.value(angle, where)
    if value is None:
        return
    if abs(math.sin(value)) < TYPED:
        what = f"{angle} is {value:g} rad: the directions are parallel"
        why = "this needs two equations, and the equation for the cosine has a zero derivative there"
        check.refuse("model.flat_angle", where, what, why, 'write type = "parallel" instead')
    check_angle(check, angle, where)


@final
@element
class Parallel(FrameConstraint):
    """Holds a direction of end parallel to one of start."""

    rows: ClassVar[str] = "2"
    holds: ClassVar[str] = "the second axis has no component along two perpendiculars `n` of the first"
    multiplier: ClassVar[str] = "the moment on end about `second x n`"
    multiplier_unit: ClassVar[str] = "N m"

    axes: Directions = Directions(_BOTH, default=("z", "z"))


@final
@element
class Perpendicular(FrameConstraint):
    """Holds a direction of end perpendicular to one of start."""

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`first . second = 0`"
    multiplier: ClassVar[str] = "the moment on end about `second x first`"
    multiplier_unit: ClassVar[str] = "N m"

    axes: Directions = Directions(_BOTH)


@final
@element
class Angle(FrameConstraint):
    """Constrains the angle between a direction of start and one of end, by an equation in its cosine.

    The angle must stay away from 0 and pi, where the cosine has no slope.
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`first . second = cos(value)`"
    multiplier: ClassVar[str] = "times the sine of the angle: the moment on end about `second x first`"
    multiplier_unit: ClassVar[str] = "N m"

    axes: Directions = Directions(_BOTH)
    value: AngleQuantity = AngleQuantity(
        "The angle, a formula in parameters and t.", unit="rad", scope=Scope.PRESCRIBED, fits=_check_cosine
    )
