"""Joints that slide in a plane or in space, and turn about the normal at most."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    ALL_LIMITS,
    AS_CONSTRAINT,
    MOTIONS,
    TREE,
    AllLimits,
    CoordinateDrives,
    Coordinates,
    Letter,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint
from symbody.model.simple_rotation import LETTERS, SimpleRotation, in_plane


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
    limits: AllLimits = ALL_LIMITS

    def shift(self) -> Triple:
        """Return the two displacements, in cyclic order after the normal."""
        first, second = (Formula.from_value(name) for name in self.coordinates)
        return in_plane(self.axis, first, second)


@final
@element
class Planar(Joint):
    """Slides in a plane of the start frame and turns about its normal.

    Examples
    --------
    >>> flight = Planar("flight", "ground", "Ball", coordinates=["X", "Y", "theta"])
    >>> [component.text for component in flight.shift()]
    ['X', 'Y', '0']
    """

    letters: ClassVar[tuple[str, ...]] = ("X", "Y", "theta")
    law: ClassVar[str] = "R = Rot(axis, theta), d = X, Y along the next two axes"

    axis: Letter = Letter("The normal; the displacements follow in cyclic order.", default="z")
    coordinates: Coordinates = Coordinates("Names of the two displacements [m] and of the angle [rad].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drives along the displacements, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drive about the normal, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the normal."""
        return (SimpleRotation(LETTERS[self.axis], Formula.from_value(self.coordinates[2])),)

    def shift(self) -> Triple:
        """Return the two displacements, in cyclic order after the normal."""
        first, second = (Formula.from_value(name) for name in self.coordinates[:2])
        return in_plane(self.axis, first, second)


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
    limits: AllLimits = ALL_LIMITS

    def shift(self) -> Triple:
        """Return the displacements."""
        x, y, z = (Formula.from_value(name) for name in self.coordinates)
        return (x, y, z)
