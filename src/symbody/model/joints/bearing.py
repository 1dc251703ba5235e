"""`Bearing`: a displacement and three angles."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    MOTIONS,
    TREE,
    CoordinateDrives,
    Coordinates,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.joints.orientation import THREE_ANGLES, ThreeAngles, orientation_turns
from symbody.model.simple_rotation import shift_along


@final
@element
class Bearing(Joint):
    """Slides along an axis of start and turns in any direction.

    Examples
    --------
    >>> Bearing("bush", "ground", "Shaft", coordinates=["s", "a", "b", "c"]).shift()[2].text
    's'
    """

    letters: ClassVar[tuple[str, ...]] = ("s", "a", "b", "c")
    law: ClassVar[str] = "d = s axis, R by the sequence"

    axis: Direction = Direction("Axis, in the start frame.", default="z")
    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the displacement [m] and the angles [rad].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[1:])

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        return shift_along(self.axis, self.coordinates[0])
