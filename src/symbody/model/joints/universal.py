"""`Universal`: two angles about perpendicular axes."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    MOTIONS,
    TREE,
    CoordinateDrives,
    Coordinates,
    PerpendicularAxes,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.simple_rotation import unit_axis


@final
@element
class Universal(Joint):
    """Turns about an axis of start, then about one of end that stays perpendicular to it.

    Examples
    --------
    >>> cross = Universal("cross", "ground", "Shaft", axes=["x", "y"], coordinates=["a", "b"])
    >>> [turn.angle.text for turn in cross.turns()]
    ['a', 'b']
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b")
    law: ClassVar[str] = "R = Rot(first, a) Rot(second, b)"

    axes: PerpendicularAxes = PerpendicularAxes(
        "First in start, second in end; perpendicular.", default=("x", "y")
    )
    coordinates: Coordinates = Coordinates("Names of the two angles.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis of start, then that about the axis of end."""
        pairs = zip(self.axes, self.coordinates, strict=True)
        return tuple(SimpleRotation(unit_axis(axis), Formula.from_value(name)) for axis, name in pairs)
