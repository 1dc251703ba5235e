"""`Screw`: an angle that brings a displacement with it."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag, Quantity
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    FRICTION,
    TREE,
    Coordinate,
    CoordinateDrive,
    DryFriction,
    PrescribedCoordinate,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.numeric_checks import need_value
from symbody.model.simple_rotation import shift_along, unit_axis


@final
@element
class Screw(Joint):
    """Turns about an axis and moves along it in proportion.

    Friction is a torque; its `radius` is that of the thread.

    Examples
    --------
    >>> Screw("nut", "ground", "Nut", pitch="p", coordinate="theta").shift()[2].text
    '(p)*theta/(2*pi)'
    """

    letters: ClassVar[tuple[str, ...]] = ("theta",)
    law: ClassVar[str] = "R = Rot(axis, theta), d = pitch theta / (2 pi) axis"

    pitch: Quantity = Quantity(
        "Displacement of end along the axis per full turn; negative for a left-hand thread.",
        unit="m",
        fits=need_value,
    )
    axis: Direction = Direction("Axis, in the start frame.", default="z")
    coordinate: Coordinate = Coordinate("Name of the angle.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrive = CoordinateDrive("Drive about the axis.")
    motion: PrescribedCoordinate = PrescribedCoordinate(
        "Prescribed angle, a formula in parameters and t.", unit="rad"
    )
    as_constraint: Flag = AS_CONSTRAINT
    friction: DryFriction = FRICTION

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the pitch for each full turn."""
        length = f"({self.pitch.text})*{self.coordinates[0]}/(2*pi)"
        return shift_along(self.axis, length)
