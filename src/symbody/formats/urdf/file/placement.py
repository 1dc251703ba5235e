"""Places of frames in exact numbers where they are exact, and angles that mean a fraction of pi."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from symbody.expr.graph import Constant

Numbers = tuple[Constant, Constant, Constant]
Rows = tuple[Numbers, Numbers, Numbers]

ONE: Final[Rows] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
_EPS: Final = sys.float_info.epsilon
_TWELFTHS: Final = 12


@dataclass(frozen=True, slots=True)
class PlacementAngle:
    """An angle: a multiple of pi, exactly, or a number [rad]."""

    of_pi: Fraction | None
    radians: float

    @property
    def text(self) -> str:
        """The angle as a formula."""
        if self.of_pi is None:
            return repr(self.radians)
        top, bottom = self.of_pi.numerator, self.of_pi.denominator
        factor = {1: "pi", -1: "-pi"}.get(top, f"{top}*pi")
        return "0" if not top else factor if bottom == 1 else f"{factor}/{bottom}"

    @property
    def is_zero(self) -> bool:
        """Whether it turns nothing."""
        return self.of_pi == 0

    def plus(self, other: PlacementAngle) -> PlacementAngle:
        """Return the sum, between -pi and pi where it is exact."""
        if self.of_pi is not None and other.of_pi is not None:
            return exact_angle((self.of_pi + other.of_pi + 1) % 2 - 1)
        return PlacementAngle(None, self.radians + other.radians)

    def cosine_and_sine(self) -> tuple[Constant, Constant]:
        """Return both, exact for whole numbers of right angles."""
        if self.of_pi is not None and self.of_pi * 2 == int(self.of_pi * 2):
            quarter: tuple[tuple[int, int], ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
            return quarter[int(self.of_pi * 2) % 4]
        return math.cos(self.radians), math.sin(self.radians)


def exact_angle(of_pi: Fraction) -> PlacementAngle:
    """Return a multiple of pi."""
    return PlacementAngle(of_pi, float(of_pi) * math.pi)


def nearest_angle(value: Constant, within: float) -> tuple[PlacementAngle, float]:
    """Return an angle, the multiple of pi/12 if it is near enough, and how far it is from it [rad]."""
    plain = float(value)
    number = round(plain * _TWELFTHS / math.pi) if abs(plain) < 1e6 else 0
    off = abs(plain - number * math.pi / _TWELFTHS)
    return (exact_angle(Fraction(number, _TWELFTHS)) if off <= within else PlacementAngle(None, plain)), off


Turns = tuple[tuple[str, PlacementAngle], ...]


@dataclass(frozen=True, slots=True)
class FramePlacement:
    """A frame in another: where its origin is, and successive turns about its own axes.

    Attributes
    ----------
    at : (3,) number
        [m]
    turns : tuple of (letter, Angle)
        From the other frame's axes to this one's.
    """

    at: Numbers = (0, 0, 0)
    turns: Turns = ()

    @property
    def rows(self) -> Rows:
        """The rotation matrix, from components in this frame to components in the other."""
        rows = ONE
        for letter, angle in self.turns:
            rows = product(rows, turn_rows(letter, angle))
        return rows

    def then(self, inner: FramePlacement) -> FramePlacement:
        """Return the placement of a frame that stands in this one."""
        shift = apply(self.rows, inner.at)
        x, y, z = (total((a, b)) for a, b in zip(self.at, shift, strict=True))
        return FramePlacement((x, y, z), _join(self.turns, inner.turns))


HERE: Final = FramePlacement()


def from_rpy(at: Numbers, roll: PlacementAngle, pitch: PlacementAngle, yaw: PlacementAngle) -> FramePlacement:
    """Return a placement by URDF's angles: about fixed x, then y, then z."""
    return FramePlacement(at, _join((), (("z", yaw), ("y", pitch), ("x", roll))))


def turn_rows(letter: str, angle: PlacementAngle) -> Rows:
    """Return the rotation matrix of a turn about a coordinate axis."""
    c, s = angle.cosine_and_sine()
    return {
        "x": ((1, 0, 0), (0, c, -s), (0, s, c)),
        "y": ((c, 0, s), (0, 1, 0), (-s, 0, c)),
        "z": ((c, -s, 0), (s, c, 0), (0, 0, 1)),
    }[letter]


def product(a: Rows, b: Rows) -> Rows:
    """Return the product of two matrices."""
    if a == ONE and _is_exact(b):
        return b
    if b == ONE and _is_exact(a):
        return a
    x, y, z = (apply(a, column) for column in zip(*b, strict=True))
    return transpose((x, y, z))


def transpose(a: Rows) -> Rows:
    """Return a matrix with rows and columns exchanged."""
    x, y, z = zip(*a, strict=True)
    return (x, y, z)


def apply(a: Rows, v: Sequence[Constant]) -> Numbers:
    """Return a matrix times a vector."""
    x, y, z = (total(_times(p, q) for p, q in zip(row, v, strict=True)) for row in a)
    return (x, y, z)


def total(terms: Iterable[Constant]) -> Constant:
    """Return a sum, exactly 0 where nothing but rounding is left of its terms."""
    listed = list(terms)
    value: Constant = 0
    for term in listed:
        value += term
    if not isinstance(value, float):
        return value
    # Each term is a product of at most three rounded factors, and each addition rounds once.
    noise = 4 * len(listed) * _EPS * sum(abs(float(term)) for term in listed)
    return 0 if abs(value) <= noise else value


def numeral(value: Constant) -> str:
    """Return a number as the shortest decimal text, rounded to a float where it has more digits."""
    if value == int(value) and -(10**15) < value < 10**15:
        return str(int(value))
    return repr(float(value))


def _is_exact(rows: Rows) -> bool:
    """Return whether no entry is rounded; a product with the identity leaves these as they are."""
    return not any(isinstance(entry, float) for row in rows for entry in row)


def _times(p: Constant, q: Constant) -> Constant:
    """Return a product; most have the whole numbers 0 or 1 in them, and fractions take long."""
    if type(p) is int:
        p, q = q, p
    if type(q) is int and q < 2:
        if q == 1:
            return p
        if q == 0 and type(p) is not float:
            return 0
    return p * q


def _join(first: Turns, second: Turns) -> Turns:
    """Return turns one after the other; neighbours about one axis are one, and none is zero."""
    turns = list(first)
    for letter, angle in second:
        if turns and turns[-1][0] == letter:
            angle = turns.pop()[1].plus(angle)
        if not angle.is_zero:
            turns.append((letter, angle))
    return tuple(turns)
