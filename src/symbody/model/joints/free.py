"""`Free`: a position and an orientation."""

from __future__ import annotations

from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag
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

_TWIST: Final = "twist"


@final
@element
class Free(Joint):
    """Constrains nothing; its coordinates are the position of end in start axes, then the orientation.

    Examples
    --------
    >>> base = Free("base", "ground", "Trunk", speeds="twist")
    >>> base.coordinates
    ('base_x', 'base_y', 'base_z', 'base_qw', 'base_qx', 'base_qy', 'base_qz')
    """

    letters: ClassVar[tuple[str, ...]] = ("x", "y", "z", "orientation")
    law: ClassVar[str] = "d = (x, y, z), R by the sequence"

    angles: AngleSequence = ORIENTATION
    coordinates: Coordinates = Coordinates(
        "Names of the position [m], then of the angles [rad] or Euler parameters."
    )
    speeds: SpeedChoice = SpeedChoice(
        "Rates; or velocity along start axes and angular velocity along axes of start or end; or both along "
        "end axes (twist).",
        words=(RATES, "start", "end", _TWIST),
    )
    speed_names: SpeedNames = SpeedNames(
        "Names of the velocity [m/s], then of the angular velocity [rad/s].", default=None, kinds="vw"
    )
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drives along the position, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Letters of the position, then those of the orientation."""
        return ("_x", "_y", "_z", *orientation_suffixes(self.angles))

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """The last four coordinates, where they are Euler parameters."""
        return orientation_quaternion(self.angles, self.coordinates[3:])

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The components of the angular velocity, or None."""
        return quasi_speeds(self, "w", self.speeds)

    @property
    def translation_speeds(self) -> QuasiSpeeds | None:
        """The components of the rate of the position, or None."""
        return quasi_speeds(self, "v", "end" if self.speeds == _TWIST else "start")

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[3:])

    def shift(self) -> Triple:
        """Return the position."""
        x, y, z = (Formula.from_value(name) for name in self.coordinates[:3])
        return (x, y, z)
