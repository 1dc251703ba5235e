"""Attributes of URDF elements as names and numbers; faults and assumptions are collected with their lines."""

from __future__ import annotations

import re
from collections import Counter
from fractions import Fraction
from typing import Final

from symbody.errors import Problem
from symbody.expr.graph import Constant
from symbody.formats.urdf.file.placement import (
    FramePlacement,
    Numbers,
    PlacementAngle,
    from_rpy,
    nearest_angle,
)
from symbody.formats.urdf.file.xml_tree import XmlNode

EXACT: Final = 2e-11  # nearer to a multiple of pi/12 than this [rad], an angle is written with all its digits
_NEAR: Final = 1e-3
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\Z")
_MAX_DIGITS: Final = 60
_LARGEST: Final = 1e150  # squares of larger numbers overflow


class Attributes:
    """Reads attributes of one file.

    Parameters
    ----------
    where : str
        What messages call the file.
    snap : float
        Angles this near to a multiple of pi/12 are taken as that [rad].
    """

    __slots__ = ("_defaults", "_near", "_snapped", "problems", "remarks", "snap", "where")

    def __init__(self, where: str, snap: float) -> None:
        self.where = where
        self.snap = max(snap, EXACT)
        self.problems: list[Problem] = []
        self.remarks: list[str] = []
        self._snapped: list[tuple[float, int]] = []
        self._near: list[tuple[float, int]] = []
        self._defaults: Counter[str] = Counter()

    def refuse(self, code: str, node: XmlNode, label: str, what: str, why: str, fix: str) -> None:
        """Note a fault."""
        place = f"{self.where}:{node.line}"
        self.problems.append(Problem(f"urdf.{code}", f"{place}, {label}" if label else place, what, why, fix))

    def remark(self, node: XmlNode, text: str) -> None:
        """Note what was assumed or ignored."""
        self.remarks.append(f"line {node.line}: {text}")

    def default(self, what: str) -> None:
        """Count a default that was taken."""
        self._defaults[what] += 1

    def only(self, node: XmlNode, tag: str, label: str, *, needed: bool = False) -> XmlNode | None:
        """Return the only child with a tag, or None."""
        found = node.all(tag)
        if len(found) > 1:
            self.refuse("repeated", found[1], label, f"it contains <{tag}> {len(found)} times",
                        "one of them would silently win", "keep one")  # fmt: skip
        if not found and needed:
            self.refuse("missing", node, label, f"<{tag}> is missing", "", f"add <{tag} ../>")
        return found[0] if found else None

    def name(self, node: XmlNode, label: str, attribute: str = "name") -> str:
        """Return a name; empty where it is missing."""
        text = node.attributes.get(attribute, "")
        if not text.strip():
            self.refuse("missing", node, label, f'<{node.tag}> has no {attribute}', "",
                        f'write <{node.tag} {attribute}="..">')  # fmt: skip
            return ""
        self._refuse_template(node, attribute, text, label)
        if not text.isprintable():
            hidden = next(c for c in text if not c.isprintable())
            self.refuse("name", node, label, f"the {attribute} {text!a} contains U+{ord(hidden):04X}",
                        "it is invisible, and makes the name look different from what it is",
                        "type the name again")  # fmt: skip
        return text

    def number(self, node: XmlNode, attribute: str, label: str, default: Constant | None = None) -> Constant:
        """Return a number; without `default` it must be there."""
        text = node.attributes.get(attribute)
        if text is None and default is not None:
            return default
        if text is None:
            self.refuse("missing", node, label, f"<{node.tag}> has no {attribute}", "",
                        f'write <{node.tag} {attribute}="..">')  # fmt: skip
            return 0
        return self._values(node, attribute, text, label, 1)[0]

    def optional_number(self, node: XmlNode, attribute: str, label: str) -> Constant | None:
        """Return a number that may be missing."""
        return self.number(node, attribute, label) if attribute in node.attributes else None

    def numbers(
        self, node: XmlNode, attribute: str, label: str, default: tuple[Constant, ...]
    ) -> tuple[Constant, ...]:
        """Return as many numbers as `default` has."""
        text = node.attributes.get(attribute)
        return default if text is None else self._values(node, attribute, text, label, len(default))

    def triple(self, node: XmlNode, attribute: str, label: str, default: Numbers = (0, 0, 0)) -> Numbers:
        """Return three numbers."""
        x, y, z = self.numbers(node, attribute, label, default)
        return (x, y, z)

    def origin(self, node: XmlNode, label: str) -> FramePlacement:
        """Return the placement in the <origin> of an element; without one, that of its link or parent."""
        origin = self.only(node, "origin", label)
        if origin is None:
            return FramePlacement()
        at = self.triple(origin, "xyz", label)
        roll, pitch, yaw = (self._angle(origin, value) for value in self.triple(origin, "rpy", label))
        return from_rpy(at, roll, pitch, yaw)

    def notes(self) -> tuple[str, ...]:
        """Return all that was assumed, in the order of the file where it has a line."""
        defaults = [
            f"{what} ({count} times)" if count > 1 else what for what, count in self._defaults.items()
        ]
        angles = []
        if self._snapped:
            worst, line = max(self._snapped)
            angles.append(
                f"{len(self._snapped)} angles were rounded to the nearest multiple of pi/12; the largest "
                f"change, in line {line}, is {worst:.2g} rad"
            )
        if self._near:
            worst, line = max(self._near)
            angles.append(
                f"{len(self._near)} angles are close to a multiple of pi/12 but not equal to it, the "
                f"largest difference, in line {line}, is {worst:.2g} rad: snap_angles={2 * worst:.1g} would "
                f"make them exact"
            )
        return (*self.remarks, *defaults, *angles)

    def _angle(self, node: XmlNode, value: Constant) -> PlacementAngle:
        angle, off = nearest_angle(value, self.snap)
        if angle.of_pi is not None and off > EXACT:
            self._snapped.append((off, node.line))
        elif angle.of_pi is None and off < _NEAR:
            self._near.append((off, node.line))
        return angle

    def _values(
        self, node: XmlNode, attribute: str, text: str, label: str, count: int
    ) -> tuple[Constant, ...]:
        self._refuse_template(node, attribute, text, label)
        words = text.split()
        place = f'{attribute}="{_short(text)}"'
        if len(words) != count:
            why = "separate numbers by spaces, not commas" if "," in text else ""
            self.refuse("wrong_number", node, label, f"{place} has {len(words)} numbers instead of {count}",
                        why, f"give {count}")  # fmt: skip
            return (0,) * count
        values = [_number(word) for word in words]
        if None in values:
            bad = words[values.index(None)]
            self.refuse("not_a_number", node, label, f"{place}: {_short(bad)!r} is not a finite number",
                        "use a decimal point" if "," in bad else "",
                        "write a number such as 0.25 or 1e-3; units are SI and radians")  # fmt: skip
            return (0,) * count
        return tuple(value for value in values if value is not None)

    def _refuse_template(self, node: XmlNode, attribute: str, text: str, label: str) -> None:
        if "${" in text or "$(" in text:
            self.refuse("template", node, label, f'{attribute}="{_short(text)}" is a formula of xacro',
                        "the file is a template: its macros are not expanded",
                        "run xacro first: xacro robot.xacro > robot.urdf")  # fmt: skip


def _number(word: str) -> Constant | None:
    """Return the exact value of a decimal number, or None if it is none that can be calculated with."""
    if not word.isascii() or len(word) > _MAX_DIGITS or not _NUMBER.match(word):
        return None
    if word.isdigit():  # 0 and 1 are most frequent, and fractions take long
        return int(word) if float(word) <= _LARGEST else None
    if abs(float(word)) > _LARGEST:
        return None
    value = Fraction(word)
    return int(value) if value.denominator == 1 else value


def _short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:37]}..."
