"""`Cylindrical`: an angle and a displacement along its axis."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    FRICTION,
    MOTIONS,
    TREE,
    CoordinateDrives,
    Coordinates,
    DryFriction,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.simple_rotation import shift_along, unit_axis


@final
@element
class Cylindrical(Joint):
    """Turns about an axis and slides along it.

    Friction is an error: it acts along one free direction, and a sleeve has two.

    Examples
    --------
    >>> sleeve = Cylindrical("sleeve", "ground", "Rod", coordinates=["theta", "s"])
    >>> [component.text for component in sleeve.shift()]
    ['0', '0', 's']
    """

    letters: ClassVar[tuple[str, ...]] = ("theta", "s")
    law: ClassVar[str] = "R = Rot(axis, theta), d = s axis"

    axis: Direction = Direction("Axis, in the start frame.", default="z")
    coordinates: Coordinates = Coordinates("Names of angle [rad] and displacement [m].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drive about the axis, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    friction: DryFriction = FRICTION

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        return shift_along(self.axis, self.coordinates[1])
