"""`ConstantVelocity`: a bend and its direction."""

from __future__ import annotations

from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    MOTIONS,
    TREE,
    CoordinateDrives,
    Coordinates,
    Letter,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.simple_rotation import LETTERS

# What a shaft is bent about at azimuth 0: the second axis in cyclic order.
_BENDS: Final = MappingProxyType({"x": "z", "y": "x", "z": "y"})


@final
@element
class ConstantVelocity(Joint):
    """Bends in any direction, without twist: two shafts turn at the same rate.

    At zero bend the azimuth has no meaning: the equations are singular there. With axes other than "z" the
    letters of the law follow in cyclic order.

    Examples
    --------
    >>> joint = ConstantVelocity("cv", "ground", "Shaft", coordinates=["bend", "azimuth"])
    >>> [turn.angle.text for turn in joint.turns()]
    ['azimuth', 'bend', '-azimuth']
    """

    letters: ClassVar[tuple[str, ...]] = ("bend", "azimuth")
    law: ClassVar[str] = "R = Rz(azimuth) Ry(bend) Rz(-azimuth)"

    axis: Letter = Letter("The axis of both shafts.", default="z")
    coordinates: Coordinates = Coordinates("Names of the bend and of its azimuth.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn to the direction of the bend, the bend, and the turn back."""
        bend, azimuth = self.coordinates
        axis, across = LETTERS[self.axis], LETTERS[_BENDS[self.axis]]
        return (
            SimpleRotation(axis, Formula.from_value(azimuth)),
            SimpleRotation(across, Formula.from_value(bend)),
            SimpleRotation(axis, Formula.from_value(f"-{azimuth}")),
        )
