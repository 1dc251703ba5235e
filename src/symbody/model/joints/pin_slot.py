"""`PinSlot`: an angle and a displacement across its axis."""

from __future__ import annotations

from typing import ClassVar, final

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
    PerpendicularAxes,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.simple_rotation import shift_along, unit_axis


@final
@element
class PinSlot(Joint):
    """A pin of end that turns in a slot of start and slides along it.

    Examples
    --------
    >>> follower = PinSlot("follower", "Cam", "Rod", axes=["z", "x"], coordinates=["theta", "s"])
    >>> follower.shift()[0].text
    's'
    """

    letters: ClassVar[tuple[str, ...]] = ("theta", "s")
    law: ClassVar[str] = "R = Rot(pin, theta), d = s slot"

    axes: PerpendicularAxes = PerpendicularAxes("Pin and slot, in start; perpendicular.", default=("z", "x"))
    coordinates: Coordinates = Coordinates("Names of angle [rad] and displacement [m].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the slot, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drive about the pin, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the pin."""
        return (SimpleRotation(unit_axis(self.axes[0]), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the direction of the slot times the displacement."""
        return shift_along(self.axes[1], self.coordinates[1])
