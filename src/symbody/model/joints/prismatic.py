"""`Prismatic`: one displacement."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    FRICTION,
    TREE,
    Armature,
    Coordinate,
    CoordinateDrive,
    DryFriction,
    PrescribedCoordinate,
    TreeMembership,
)
from symbody.model.joint import Joint
from symbody.model.simple_rotation import shift_along


@final
@element
class Prismatic(Joint):
    """Slides along an axis.

    Examples
    --------
    >>> Prismatic("slider", "ground", "Mass", coordinate="x").shift()[0].text
    'x'
    """

    letters: ClassVar[tuple[str, ...]] = ("s",)
    law: ClassVar[str] = "d = s axis"

    axis: Direction = Direction("Axis, in the start frame.", default="x")
    coordinate: Coordinate = Coordinate("Name of the displacement.", unit="m")
    tree: TreeMembership = TREE
    force: CoordinateDrive = CoordinateDrive("Drive along the axis.")
    motion: PrescribedCoordinate = PrescribedCoordinate(
        "Prescribed displacement, a formula in parameters and t.", unit="m"
    )
    as_constraint: Flag = AS_CONSTRAINT
    armature: Armature = Armature("Inertia of the drive's rotor.", unit="kg", default=0)
    friction: DryFriction = FRICTION

    def shift(self) -> Triple:
        """Return the axis times the coordinate."""
        return shift_along(self.axis, self.coordinates[0])
