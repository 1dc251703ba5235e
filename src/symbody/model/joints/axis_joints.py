"""Joints about and along axes: weld, hinge, slide, screw, sleeve, pin in a slot; and joints of shafts."""

from __future__ import annotations

from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Direction, Flag, Quantity
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    ALL_LIMITS,
    AS_CONSTRAINT,
    FRICTION,
    LIMITS,
    MOTIONS,
    TREE,
    AllLimits,
    Armature,
    Coordinate,
    CoordinateDrive,
    CoordinateDrives,
    CoordinateLimits,
    Coordinates,
    DryFriction,
    Letter,
    PerpendicularAxes,
    PrescribedCoordinate,
    PrescribedMotions,
    TreeMembership,
)
from symbody.model.joint import Joint
from symbody.model.numeric_checks import FINITE
from symbody.model.simple_rotation import LETTERS, SimpleRotation, shift_along, unit_axis


@final
@element
class Weld(Joint):
    """Holds two frames together.

    Examples
    --------
    >>> import symbody as sb
    >>> tool = sb.Body("Tool", mass="m")
    >>> weld = sb.Weld("flange", "Wrist", tool)
    """

    law: ClassVar[str] = "R = 1, d = 0"

    tree: TreeMembership = TREE


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
    limits: CoordinateLimits = LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)


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
    limits: CoordinateLimits = LIMITS

    def shift(self) -> Triple:
        """Return the axis times the coordinate."""
        return shift_along(self.axis, self.coordinates[0])


@final
@element
class Screw(Joint):
    """Turns about an axis and moves along it in proportion.

    Friction is a torque; its `radius` is that of the thread.

    Examples
    --------
    >>> Screw("nut", "ground", "Nut", pitch="p", coordinate="theta").shift()[2].text
    '(p)*theta/(2*pi)'
    """

    letters: ClassVar[tuple[str, ...]] = ("theta",)
    law: ClassVar[str] = "R = Rot(axis, theta), d = pitch theta / (2 pi) axis"

    pitch: Quantity = Quantity(
        "Displacement of end along the axis per full turn; negative for a left-hand thread.",
        unit="m",
        fits=FINITE,
    )
    axis: Direction = Direction("Axis, in the start frame.", default="z")
    coordinate: Coordinate = Coordinate("Name of the angle.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrive = CoordinateDrive("Drive about the axis.")
    motion: PrescribedCoordinate = PrescribedCoordinate(
        "Prescribed angle, a formula in parameters and t.", unit="rad"
    )
    as_constraint: Flag = AS_CONSTRAINT
    friction: DryFriction = FRICTION
    limits: CoordinateLimits = LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the pitch for each full turn."""
        length = f"({self.pitch.text})*{self.coordinates[0]}/(2*pi)"
        return shift_along(self.axis, length)


@final
@element
class Cylindrical(Joint):
    """Turns about an axis and slides along it.

    Dry friction acts along one free direction, and a sleeve has two: giving `friction` is an error.

    Examples
    --------
    >>> sleeve = Cylindrical("sleeve", "ground", "Rod", coordinates=["theta", "s"])
    >>> [component.text for component in sleeve.shift()]
    ['0', '0', 's']
    """

    letters: ClassVar[tuple[str, ...]] = ("theta", "s")
    law: ClassVar[str] = "R = Rot(axis, theta), d = s axis"

    axis: Direction = Direction("Axis, in the start frame.", default="z")
    coordinates: Coordinates = Coordinates("Names of angle [rad] and displacement [m].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drive about the axis, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    friction: DryFriction = FRICTION
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis."""
        return (SimpleRotation(unit_axis(self.axis), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        return shift_along(self.axis, self.coordinates[1])


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
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the pin."""
        return (SimpleRotation(unit_axis(self.axes[0]), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the direction of the slot times the displacement."""
        return shift_along(self.axes[1], self.coordinates[1])


@final
@element
class Universal(Joint):
    """Turns about an axis of start, then about one of end that stays perpendicular to it.

    Examples
    --------
    >>> cross = Universal("cross", "ground", "Shaft", axes=["x", "y"], coordinates=["a", "b"])
    >>> [turn.angle.text for turn in cross.turns()]
    ['a', 'b']
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b")
    law: ClassVar[str] = "R = Rot(first, a) Rot(second, b)"

    axes: PerpendicularAxes = PerpendicularAxes(
        "First in start, second in end; perpendicular.", default=("x", "y")
    )
    coordinates: Coordinates = Coordinates("Names of the two angles.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn about the axis of start, then that about the axis of end."""
        pairs = zip(self.axes, self.coordinates, strict=True)
        return tuple(SimpleRotation(unit_axis(axis), Formula.from_value(name)) for axis, name in pairs)


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
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn to the direction of the bend, the bend, and the turn back."""
        bend, azimuth = self.coordinates
        axis, across = LETTERS[self.axis], LETTERS[_BENDS[self.axis]]
        return (
            SimpleRotation(axis, Formula.from_value(azimuth)),
            SimpleRotation(across, Formula.from_value(bend)),
            SimpleRotation(axis, Formula.from_value(f"-{azimuth}")),
        )
