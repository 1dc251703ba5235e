"""Points held at a distance, on a line, a plane, a curve or a surface; directions held at an angle."""

from __future__ import annotations

import math
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.constraint import FrameConstraint
from symbody.model.declarations.element_fields import CurvePoint, Directions, VanishingFormulas, element
from symbody.model.declarations.fields import AngleQuantity, Direction, Flag, Quantity, SymbolName
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NumericChecks, check_angle, positive_length
from symbody.tolerances import TYPED


@final
@element
class Distance(FrameConstraint):
    """Keeps two points at a distance, as a massless rod does; a rope lets them come closer.

    Its one multiplier is the force with which it pushes the points apart [N]; in a rope it is never positive.

    Examples
    --------
    >>> import symbody as sb
    >>> rod = sb.Distance("rod", "ground", "Ball", "L")
    >>> rope = sb.Distance("rope", "ground", "Ball", "L", rope=True)
    >>> rod.rope, rope.rope
    (False, True)
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`sqrt(p . p) = value`"
    multiplier: ClassVar[str] = "the force along the line, positive if it pushes the points apart"
    multiplier_unit: ClassVar[str] = "N"

    value: Quantity = Quantity(
        "The distance, a formula in parameters and t.",
        unit="m",
        scope=Scope.PRESCRIBED,
        fits=positive_length("two coincident points need a spherical joint"),
    )
    rope: Flag = Flag("Whether the points may come closer.", default=False)

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind, of ropes alone in those of ropes."""
        return ("",) * self.rope if kind in ("rope", "mode") else FrameConstraint.output_words(self, kind)


@final
@element
class PointOnLine(FrameConstraint):
    """Holds the origin of end on a line through the origin of start.

    Examples
    --------
    >>> import symbody as sb
    >>> sb.PointOnLine("slot", "ground", "Pin", axis="x").axis
    'x'
    """

    rows: ClassVar[str] = "2"
    holds: ClassVar[str] = "`p` has no component across the axis"
    multiplier: ClassVar[str] = "the force on end along a direction of start across the axis"
    multiplier_unit: ClassVar[str] = "N"

    axis: Direction = Direction("Direction of the line, in the start frame.", default="x")


@final
@element
class PointOnPlane(FrameConstraint):
    """Holds the origin of end in a plane through the origin of start.

    Examples
    --------
    >>> import symbody as sb
    >>> sb.PointOnPlane("table", "ground", "Foot", axis="z").axis
    'z'
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`p . axis = 0`"
    multiplier: ClassVar[str] = "the force on end along the normal"
    multiplier_unit: ClassVar[str] = "N"

    axis: Direction = Direction("Normal of the plane, in the start frame.", default="z")


@final
@element
class PointOnCurve(FrameConstraint):
    """Holds the origin of end on a curve fixed in start.

    The curve's parameter becomes a coordinate of the mechanism, without mass; the derivative of the curve
    with respect to it must not vanish.

    Examples
    --------
    >>> import symbody as sb
    >>> helix = sb.PointOnCurve("helix", "ground", "Bead", ["r*cos(s)", "r*sin(s)", "h*s"], parameter="s")
    >>> helix.parameter
    's'
    """

    rows: ClassVar[str] = "3"
    holds: ClassVar[str] = "`p = curve(parameter, t)`; the parameter becomes a coordinate"
    multiplier: ClassVar[str] = (
        "the force on end along x, y, z of start; together they have no component along the curve"
    )
    multiplier_unit: ClassVar[str] = "N"

    curve: CurvePoint = CurvePoint(
        "Position in the start frame, a formula in the curve parameter, parameters and t.", unit="m"
    )
    parameter: SymbolName = SymbolName("Name of the parameter, which becomes a coordinate.")

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The curve's parameter."""
        return (self.parameter,)

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Reject a curve that does not change with its parameter."""
        if not any(self.parameter in formula.names for formula in self.curve):
            check.refuse(
                "model.no_curve",
                f"{label}, curve",
                f"{self.parameter} does not appear in it",
                "a curve that does not depend on its parameter is a point",
                f"write the position as a function of {self.parameter}; for a fixed point use a spherical "
                f"joint",
            )


@final
@element
class PointOnSurface(FrameConstraint):
    """Holds the origin of end on a surface fixed in start; several equations make a curve.

    A multiplier times the gradient of its equation is the force on end.

    Examples
    --------
    >>> import symbody as sb
    >>> bowl = sb.PointOnSurface("bowl", "ground", "Bead", "x^2 + y^2 + z^2 - R^2")
    >>> [equation.text for equation in bowl.equations]
    ['x^2 + y^2 + z^2 - R^2']
    """

    rows: ClassVar[str] = "their number"
    holds: ClassVar[str] = "`f(p, t) = 0`"
    multiplier: ClassVar[str] = "times the gradient of f: the force on end"

    equations: VanishingFormulas = VanishingFormulas(
        "Left-hand side that is 0: a formula in x, y, z of the point in the start frame [m], parameters and "
        "t.",
        scope=Scope.POINT,
    )


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
    """Holds a direction of end parallel to one of start.

    Examples
    --------
    >>> import symbody as sb
    >>> sb.Parallel("upright", "ground", "Table", axes=("z", "z")).axes
    ('z', 'z')
    """

    rows: ClassVar[str] = "2"
    holds: ClassVar[str] = "the second axis has no component along two perpendiculars `n` of the first"
    multiplier: ClassVar[str] = "the moment on end about `second x n`"
    multiplier_unit: ClassVar[str] = "N m"

    axes: Directions = Directions(_BOTH, default=("z", "z"))


@final
@element
class Perpendicular(FrameConstraint):
    """Holds a direction of end perpendicular to one of start.

    Examples
    --------
    >>> import symbody as sb
    >>> sb.Perpendicular("square", "ground", "Blade", axes=("z", "x")).axes
    ('z', 'x')
    """

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

    Examples
    --------
    >>> import symbody as sb
    >>> angle = sb.Angle("fold", "ground", "Leaf", axes=("x", "x"), value="60 deg")
    >>> angle.axes, angle.value.text
    (('x', 'x'), '60 deg')
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`first . second = cos(value)`"
    multiplier: ClassVar[str] = "times the sine of the angle: the moment on end about `second x first`"
    multiplier_unit: ClassVar[str] = "N m"

    axes: Directions = Directions(_BOTH)
    value: AngleQuantity = AngleQuantity(
        "The angle, a formula in parameters and t.", unit="rad", scope=Scope.PRESCRIBED, fits=_check_cosine
    )
