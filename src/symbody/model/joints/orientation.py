"""Orientations: three successive angles, or a quaternion; and the speeds of a rotation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar, Final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import NULL, OptionalField, list_of
from symbody.model.declarations.fields import SymbolName, TextField
from symbody.model.declarations.joint_fields import read_names
from symbody.model.declarations.misfits import Misfit, Path, Schema, text_misfits
from symbody.model.joint import RATES, Joint, QuasiSpeeds
from symbody.model.naming import make_symbol
from symbody.model.simple_rotation import LETTERS, SimpleRotation

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
