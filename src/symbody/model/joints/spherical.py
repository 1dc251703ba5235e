"""`Spherical`: an orientation."""

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
from symbody.model.joint import RATES, Joint, QuasiSpeeds, SimpleRotation
from symbody.model.joints.orientation import (
    ORIENTATION,
    AngleSequence,
    SpeedChoice,
    SpeedNames,
    orientation_quaternion,
    orientation_suffixes,
    orientation_turns,
    quasi_speeds,
)


@final
@element
class Spherical(Joint):
    """Turns in any direction about a point.

    Examples
    --------
    >>> pivot = Spherical("pivot", "ground", "Top", angles="313", coordinates=["zeta", "eta", "xi"])
    >>> [turn.angle.text for turn in pivot.turns()]
    ['zeta', 'eta', 'xi']
    """

    letters: ClassVar[tuple[str, ...]] = ("3 angles, or a quaternion",)
    law: ClassVar[str] = "R by the sequence"

    angles: AngleSequence = ORIENTATION
    coordinates: Coordinates = Coordinates("Names of the angles [rad] or Euler parameters.")
    speeds: SpeedChoice = SpeedChoice(
        "Rates of the angles, or the angular velocity along axes of start or end.",
        words=(RATES, "start", "end"),
    )
    speed_names: SpeedNames = SpeedNames(
        "Names of the components x, y, z of the angular velocity.", unit="rad/s"
    )
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Numbers of the angles, or letters of the Euler parameters."""
        return orientation_suffixes(self.angles)

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """The coordinates, where they are Euler parameters."""
        return orientation_quaternion(self.angles, self.coordinates)

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The components of the angular velocity, or None."""
        return quasi_speeds(self, "w", self.speeds)

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates)
