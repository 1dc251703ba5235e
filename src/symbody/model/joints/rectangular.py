"""`Rectangular`: two displacements."""

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
    Letter,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint
from symbody.model.simple_rotation import in_plane


@final
@element
class Rectangular(Joint):
    """Slides in a plane of the start frame, without turning.

    Examples
    --------
    >>> table = Rectangular("table", "ground", "Top", coordinates=["x", "y"])
    >>> [component.text for component in table.shift()]
    ['x', 'y', '0']
    """

    letters: ClassVar[tuple[str, ...]] = ("x", "y")
    law: ClassVar[str] = "R = 1, d = x, y along the next two axes"

    axis: Letter = Letter("The normal; the displacements follow in cyclic order.", default="z")
    coordinates: Coordinates = Coordinates("Names of the two displacements.", unit="m")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drives along the displacements, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def shift(self) -> Triple:
        """Return the two displacements, in cyclic order after the normal."""
        first, second = (Formula.from_value(name) for name in self.coordinates)
        return in_plane(self.axis, first, second)
