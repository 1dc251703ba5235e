"""Orientations: three successive angles, or a quaternion; and the speeds of a rotation."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.door import Door
from symbody.model.joint import RATES, Joint, QuasiSpeeds
from symbody.model.joints.words import names_from
from symbody.model.naming import symbol_from
from symbody.model.turn import LETTERS, Turn

QUATERNION: Final = "quaternion"
_SPACE: Final = "space "
_DIGITS: Final = MappingProxyType({"x": "1", "y": "2", "z": "3", "1": "1", "2": "2", "3": "3"})
_AXES: Final = MappingProxyType({"1": LETTERS["x"], "2": LETTERS["y"], "3": LETTERS["z"]})


def angles_from(joint: Joint, door: Door, value: object, path: str) -> str:
    """Return ``"quaternion"`` or a sequence in digits, such as ``"313"`` or ``"space 123"``."""
    text = value if isinstance(value, str) else ""
    if text == QUATERNION:
        return text
    letters = text.removeprefix(_SPACE)
    digits = "".join(_DIGITS.get(letter, "") for letter in letters)
    is_known = len(digits) == len(letters) == 3
    if is_known and digits[0] != digits[1] != digits[2]:
        return f"{text[: -len(letters)]}{digits}"
    door.refuse(
        "model.angle_sequence",
        path,
        f"{value!r} is not a sequence of turns",
        "two turns in a row about one axis are a single turn" if is_known else "",
        'write three axes such as "313" or "zxz", "space 313" for axes fixed in start, or "quaternion"',
    )
    return QUATERNION


def three_angles_from(joint: Joint, door: Door, value: object, path: str) -> str:
    """Return a sequence in digits; a quaternion is refused."""
    if value != QUATERNION:
        found = angles_from(joint, door, value, path)
        return "123" if found == QUATERNION else found
    door.refuse(
        "model.angle_sequence",
        path,
        "the joint has three angles, no quaternion",
        "",
        'write three axes such as "123", or make it a spherical or free joint',
    )
    return "123"


def orientation_suffixes(angles: str) -> tuple[str, ...]:
    """Return what follows the joint's name in the default names of the coordinates."""
    return ("_qw", "_qx", "_qy", "_qz") if angles == QUATERNION else ("_1", "_2", "_3")


def orientation_quaternion(angles: str, names: tuple[str, ...]) -> tuple[str, str, str, str] | None:
    """Return the names of the Euler parameters, or None for angles."""
    if angles != QUATERNION:
        return None
    w, x, y, z = names
    return (w, x, y, z)


def orientation_turns(angles: str, names: tuple[str, ...]) -> tuple[Turn, ...]:
    """Return the turns about body axes from start to end; none for a quaternion.

    Angles about axes fixed in start are those about body axes in the opposite order.
    """
    if angles == QUATERNION:
        return ()
    digits = angles.removeprefix(_SPACE)
    turns = [Turn(_AXES[digit], Formula.of(name)) for digit, name in zip(digits, names, strict=True)]
    return tuple(reversed(turns) if angles.startswith(_SPACE) else turns)


def speeds_from(
    joint: Joint, door: Door, value: object, path: str, known: tuple[str, ...] = (RATES, "start", "end")
) -> str:
    """Return the speeds, by default the rates of angles, and components in end axes with a quaternion."""
    default = "end" if joint.quaternion else RATES
    if value is None:
        return default
    if not isinstance(value, str) or value not in known:
        words = ", ".join(f'"{word}"' for word in known[:-1])
        door.refuse(
            "model.speeds",
            path,
            f"{value!r} does not say what the speeds are",
            "",
            f'write {words} or "{known[-1]}"',
        )
        return default
    if value == RATES and joint.quaternion:
        door.refuse(
            "model.quaternion_rates",
            path,
            "the rates of a quaternion cannot be the speeds",
            "four rates stand for three freedoms",
            'write speeds = "end" or "start", or choose angles, for instance angles = "313"',
        )
        return default
    return value


def speed_names_from(
    joint: Joint, door: Door, value: object, path: str, kinds: str = "w"
) -> tuple[str, ...] | None:
    """Return names of quasi-speeds, three for each kind, or None for those after the joint's name."""
    if value is None:
        return None
    if joint.speeds == RATES:
        door.refuse(
            "model.names_of_rates",
            path,
            "the speeds are rates of coordinates, which have names already",
            f"they are called {joint.coordinates[-1]}_dot and so on",
            'write speeds = "end" or "start", or leave speed_names out',
        )
        return None
    return names_from(door, value, path, tuple(name for kind in kinds for name in _own_names(joint, kind)))


def quasi_speeds(joint: Joint, kind: str, frame: str) -> QuasiSpeeds | None:
    """Return the three quasi-speeds of a kind, ``"v"`` or ``"w"``, in axes of `frame`; None for rates."""
    if joint.speeds == RATES:
        return None
    given = joint.speed_names or _own_names(joint, kind)
    x, y, z = given[-3:] if kind == "w" else given[:3]
    return QuasiSpeeds((x, y, z), "start" if frame == "start" else "end")


def _own_names(joint: Joint, kind: str) -> tuple[str, ...]:
    own = symbol_from(joint.name)
    return tuple(f"{own}_{kind}{axis}" for axis in "xyz")
