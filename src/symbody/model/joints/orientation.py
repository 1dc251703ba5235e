"""Orientations: three successive angles, or a quaternion; the speeds of a rotation; and joints with one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import OptionalField, list_of
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.field import NULL
from symbody.model.declarations.fields import Direction, Flag, SymbolName, TextField
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    ALL_LIMITS,
    AS_CONSTRAINT,
    MOTIONS,
    TREE,
    AllLimits,
    CoordinateDrives,
    Coordinates,
    PrescribedMotions,
    TreeMembership,
    read_names,
)
from symbody.model.declarations.misfits import Misfit, Path, Schema, text_misfits
from symbody.model.joint import RATES, Joint, QuasiSpeeds
from symbody.model.naming import make_symbol
from symbody.model.simple_rotation import LETTERS, SimpleRotation, shift_along

QUATERNION: Final = "quaternion"
_SPACE: Final = "space "
_DIGITS: Final = MappingProxyType({"x": "1", "y": "2", "z": "3", "1": "1", "2": "2", "3": "3"})
_AXES: Final = MappingProxyType({"1": LETTERS["x"], "2": LETTERS["y"], "3": LETTERS["z"]})


class AngleSequence(TextField[str, str]):
    """Three successive turns, or a quaternion."""

    role: ClassVar[str] = "angles"
    pattern: ClassVar[str] = "^((space )?[1-3xyz]{3}|quaternion)$"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return ``"quaternion"`` or a sequence in digits, such as ``"313"`` or ``"space 123"``."""
        text = value if isinstance(value, str) else ""
        if text == QUATERNION:
            return text
        axes = text.removeprefix(_SPACE)
        digits = "".join(_DIGITS.get(letter, "") for letter in axes)
        is_known = len(digits) == len(axes) == 3
        if is_known and digits[0] != digits[1] != digits[2]:
            return f"{text[: -len(axes)]}{digits}"
        why = "two successive rotations about one axis are a single rotation" if is_known else ""
        fix = 'write three axes such as "313" or "zxz", "space 313" for axes fixed in start, or "quaternion"'
        arguments.add("model.angle_sequence", path, f"{value!r} is not a sequence of rotations", why, fix)
        return QUATERNION

    def schema(self) -> Schema:
        """Return a string of a pattern."""
        return {"type": "string", "pattern": self.pattern}


class ThreeAngles(AngleSequence):
    """Three successive turns."""

    pattern: ClassVar[str] = "^(space )?[1-3xyz]{3}$"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return a sequence in digits; a quaternion is refused."""
        if value != QUATERNION:
            digits = super().read(owner, arguments, value, path)
            return "123" if digits == QUATERNION else digits
        fix = 'write three axes such as "123", or make it a spherical or free joint'
        arguments.add("model.angle_sequence", path, "the joint has three angles, no quaternion", "", fix)
        return "123"


@dataclass(frozen=True, eq=False, repr=False)
class SpeedChoice(TextField[str | None, str]):
    """What the speeds are.

    Attributes
    ----------
    words : tuple of str
        What may be chosen.
    """

    role: ClassVar[str] = "choice"
    annotation: ClassVar[str] = "str | None"

    _: KW_ONLY
    default: Any = None
    words: tuple[str, ...] = ()

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> str:
        """Return the speeds, by default the rates of angles, and components in end axes with a quaternion."""
        default = "end" if owner.quaternion else RATES
        if value is None:
            return default
        if not isinstance(value, str) or value not in self.words:
            words = ", ".join(f'"{word}"' for word in self.words[:-1])
            what = f"{value!r} is not a valid choice of speeds"
            arguments.add("model.speeds", path, what, "", f'write {words} or "{self.words[-1]}"')
            return default
        if value == RATES and owner.quaternion:
            what = "the rates of a quaternion cannot be the speeds"
            why = "four rates describe three degrees of freedom"
            fix = 'write speeds = "end" or "start", or choose angles, for instance angles = "313"'
            arguments.add("model.quaternion_rates", path, what, why, fix)
            return default
        return value

    def schema(self) -> Schema:
        """Return one of the words."""
        return {"anyOf": [TextField.schema(self), NULL], "enum": [*self.words]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a text."""
        return () if entry is None else text_misfits(entry, path)


@dataclass(frozen=True, eq=False, repr=False)
class SpeedNames(OptionalField[Iterable[str], tuple[str, ...]]):
    """Names of quasi-speeds, three for each kind.

    Attributes
    ----------
    kinds : str
        ``"v"`` for the rate of the position, ``"w"`` for the angular velocity.
    """

    _: KW_ONLY
    inner: Any = field(default_factory=lambda: list_of(SymbolName()))
    is_nullable: bool = True
    kinds: str = "w"

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> tuple[str, ...] | None:
        """Return the names, or None for those after the joint's name."""
        if value is None:
            return None
        if owner.speeds == RATES:
            what = "the speeds are rates of coordinates, which already have names"
            why = f"they are called {owner.coordinates[-1]}_dot and so on"
            fix = 'write speeds = "end" or "start", or leave speed_names out'
            arguments.add("model.names_of_rates", path, what, why, fix)
            return None
        return read_names(
            arguments, value, path, tuple(name for kind in self.kinds for name in _own_names(owner, kind))
        )


THREE_ANGLES: Final = ThreeAngles(
    'Successive rotations about body axes such as "123", or about fixed axes such as "space 123".',
    default="xyz",
)
ORIENTATION: Final = AngleSequence(
    'Successive rotations about body axes such as "313", or about fixed axes such as "space 313", or '
    '"quaternion" '
    "(Euler parameters, scalar first).",
    default=QUATERNION,
)


def orientation_suffixes(angles: str) -> tuple[str, ...]:
    """Return what follows the joint's name in the default names of the coordinates."""
    return ("_qw", "_qx", "_qy", "_qz") if angles == QUATERNION else ("_1", "_2", "_3")


def orientation_quaternion(angles: str, names: tuple[str, ...]) -> tuple[str, str, str, str] | None:
    """Return the names of the Euler parameters, or None for angles."""
    if angles != QUATERNION:
        return None
    w, x, y, z = names
    return (w, x, y, z)


def orientation_turns(angles: str, names: tuple[str, ...]) -> tuple[SimpleRotation, ...]:
    """Return the turns about body axes from start to end; none for a quaternion.

    Angles about axes fixed in start are those about body axes in the opposite order.
    """
    if angles == QUATERNION:
        return ()
    digits = angles.removeprefix(_SPACE)
    turns = [
        SimpleRotation(_AXES[digit], Formula.from_value(name))
        for digit, name in zip(digits, names, strict=True)
    ]
    return tuple(reversed(turns) if angles.startswith(_SPACE) else turns)


def quasi_speeds(joint: Joint, kind: str, frame: str) -> QuasiSpeeds | None:
    """Return the three quasi-speeds of a kind, ``"v"`` or ``"w"``, in axes of `frame`; None for rates."""
    if joint.speeds == RATES:
        return None
    given = joint.speed_names or _own_names(joint, kind)
    x, y, z = given[-3:] if kind == "w" else given[:3]
    return QuasiSpeeds((x, y, z), "start" if frame == "start" else "end")


def _own_names(joint: Joint, kind: str) -> tuple[str, ...]:
    own = make_symbol(joint.name)
    return tuple(f"{own}_{kind}{axis}" for axis in "xyz")


@final
@element
class Gimbal(Joint):
    """Turns about three axes in succession, as in three rings.

    Where the first axis meets the third, the gimbal is locked.

    Examples
    --------
    >>> rings = Gimbal("rings", "ground", "Rotor", angles="zxy", coordinates=["yaw", "roll", "pitch"])
    >>> [turn.angle.text for turn in rings.turns()]
    ['yaw', 'roll', 'pitch']
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b", "c")
    law: ClassVar[str] = "R by the sequence; the rates of the angles are the speeds"

    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the angles.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates)


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
    limits: AllLimits = ALL_LIMITS

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


@final
@element
class Bearing(Joint):
    """Slides along an axis of start and turns in any direction.

    Examples
    --------
    >>> Bearing("bush", "ground", "Shaft", coordinates=["s", "a", "b", "c"]).shift()[2].text
    's'
    """

    letters: ClassVar[tuple[str, ...]] = ("s", "a", "b", "c")
    law: ClassVar[str] = "d = s axis, R by the sequence"

    axis: Direction = Direction("Axis, in the start frame.", default="z")
    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the displacement [m] and the angles [rad].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[1:])

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        return shift_along(self.axis, self.coordinates[0])


@final
@element
class Telescoping(Joint):
    """Turns in any direction and slides along an axis of end, which goes through the origin of start.

    Examples
    --------
    >>> arm = Telescoping("arm", "ground", "Boom", axis="x", coordinates=["a", "b", "c", "s"])
    >>> (arm.shift_in, arm.shift()[0].text)
    ('end', 's')
    """

    letters: ClassVar[tuple[str, ...]] = ("a", "b", "c", "s")
    law: ClassVar[str] = "R by the sequence, d = s R axis"
    shift_in: ClassVar[Literal["start", "end"]] = "end"

    axis: Direction = Direction("Axis, in the end frame.", default="z")
    angles: ThreeAngles = THREE_ANGLES
    coordinates: Coordinates = Coordinates("Names of the angles [rad] and the displacement [m].")
    tree: TreeMembership = TREE
    force: CoordinateDrives = CoordinateDrives("Drive along the displacement, by coordinate.")
    torque: CoordinateDrives = CoordinateDrives("Drives along the angles, by coordinate.")
    motion: PrescribedMotions = MOTIONS
    as_constraint: Flag = AS_CONSTRAINT
    limits: AllLimits = ALL_LIMITS

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[:3])

    def shift(self) -> Triple:
        """Return the axis times the displacement, in end axes."""
        return shift_along(self.axis, self.coordinates[3])


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
    limits: AllLimits = ALL_LIMITS

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
