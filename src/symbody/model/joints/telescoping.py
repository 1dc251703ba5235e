"""`Telescoping`: three angles and a displacement."""

from __future__ import annotations

from typing import ClassVar, Literal, final

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
class Telescoping(Joint):
    """Turns in any direction and slides along an axis of end, which goes through the origin of start.

    Examples
    --------
    >>> arm = Telescoping("arm", "ground", "Boom", axis="x", coordinates=["a", "b", "c", "s"])
    >>> (arm.shift_in, arm.shift()[0].text)
    ('end', 's')
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b", "c", "s")
    law: ClassVar[str] = "R by the sequence, d = s R axis"
    shift_in: ClassVar[Literal["start", "end"]] = "end"

    axis: Direction = Direction("Axis, in the end frame.", default="z")
    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the angles [rad] and the displacement [m].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[:3])

    def shift(self) -> Triple:
        """Return the axis times the displacement, in end axes."""
        return shift_along(self.axis, self.coordinates[3])
