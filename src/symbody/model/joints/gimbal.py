"""`Gimbal`: three angles."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag
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


@final
@element
class Gimbal(Joint):
    """Turns about three axes in succession, as in three rings.

    Where the first axis meets the third, the gimbal is locked.

    Examples
    --------
    >>> rings = Gimbal("rings", "ground", "Rotor", angles="zxy", coordinates=["yaw", "roll", "pitch"])
    >>> [turn.angle.text for turn in rings.turns()]
    ['yaw', 'roll', 'pitch']
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b", "c")
    law: ClassVar[str] = "R by the sequence; the rates of the angles are the speeds"

    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the angles.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates)
