"""`Revolute`: one angle."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag
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
from symbody.model.joint import Joint, SimpleRotation
from symbody.model.simple_rotation import unit_axis


@final
@element
class Revolute(Joint):
    """Turns about an axis.

    Examples
    --------
    >>> import symbody as sb
    >>> arm = sb.Body("Arm", mass=2, inertia=(0, 0, 0.1), frames={"hip": sb.Frame(at=(-0.5, 0, 0))})
    >>> hinge = sb.Revolute("hinge", "ground", arm["hip"], axis="z", coordinate="phi")
    >>> sb.form_equations(sb.Model("pendulum", [hinge])).coordinate_names
    ('phi',)
    """

    letters: ClassVar[tuple[str, ...]] = ("theta",)
    law: ClassVar[str] = "R = Rot(axis, theta)"

    axis: Direction = Direction("Axis, in the start frame.", default="z")
    coordinate: Coordinate = Coordinate("Name of the angle.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrive = CoordinateDrive("Drive about the axis.")
    motion: PrescribedCoordinate = PrescribedCoordinate(
        "Prescribed angle, a formula in parameters and t.", unit="rad"
    )
    as_constraint: Flag = AS_CONSTRAINT
    armature: Armature = Armature("Inertia of the drive's rotor.", unit="kg m^2", default=0)
    friction: DryFriction = FRICTION

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)
