"""`Cartesian`: three displacements."""

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
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint


@final
@element
class Cartesian(Joint):
    """Slides in all directions, without turning.

    Examples
    --------
    >>> gantry = Cartesian("gantry", "ground", "Tool", coordinates=["x", "y", "z"])
    >>> [component.text for component in gantry.shift()]
    ['x', 'y', 'z']
    """

    letters: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    law: ClassVar[str] = "R = 1, d = (x, y, z)"

    coordinates: Coordinates = Coordinates("Names of the displacements along x, y, z of start.", unit="m")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drives along the displacements, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT

    def shift(self) -> Triple:
        """Return the displacements."""
        x, y, z = (Formula.from_value(name) for name in self.coordinates)
        return (x, y, z)
