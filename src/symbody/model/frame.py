"""`Frame`: a set of axes with an origin, fixed on a body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass, field
from fractions import Fraction
from typing import Any, ClassVar, Final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value
from symbody.model.declarations.combinators import ListOf, OptionalField
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.field import Field, FileTarget, NewNames, Node
from symbody.model.declarations.fields import (
    AngleQuantity,
    AxisLike,
    Direction,
    Quantity,
    VectorQuantity,
    part,
)
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.misfits import Misfit, Path, Schema, wrong_length, wrong_type
from symbody.model.inertia import determinant
from symbody.model.numbers import formula_value
from symbody.model.numeric_checks import FINITE, NumericChecks, check_angle
from symbody.model.simple_rotation import LETTERS, Axis, SimpleRotation, read_axis, unit_axis

Matrix = tuple[Triple, Triple, Triple]
Rotation = tuple[tuple[Axis, Formula], ...]

# A matrix typed with 10 digits of cos 30 deg means 30 deg.
_SNAP: Final = 2e-11
# What entries of an exact matrix leave that are off by 1e-9 each: 2 * 1e-9 times the sum of a row's entries.
_ORTHONORMAL: Final = 4e-9


@dataclass(frozen=True, eq=False, repr=False)
class Turn(Field[tuple[AxisLike, Value], tuple[Axis, Formula]]):
    """A simple rotation: an axis and an angle."""

    role: ClassVar[str] = "turn"
    takes: ClassVar[str] = "(axis, angle)"
    annotation: ClassVar[str] = "tuple[str | Iterable[Value], Value]"

    _: KW_ONLY
    axis: Any = field(default_factory=Direction)
    angle: Any = field(default_factory=lambda: AngleQuantity(unit="rad", fits=check_angle))

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Axis, Formula]:
        """Return the axis and the angle [rad]."""
        pair = arguments.items(value, path)
        if len(pair) == 2:
            return read_axis(arguments, pair[0], f"{path}[0]"), arguments.formula(pair[1], f"{path}[1]")
        fix = 'write for instance ["z", "pi/2"]; several rotations form a list of such pairs'
        arguments.add("model.not_a_turn", path, "a rotation is an axis and an angle", "", fix)
        return "x", ZERO

    def schema(self) -> Schema:
        """Return an array of both."""
        both = [self.axis.schema(), self.angle.schema()]
        return {"type": "array", "prefixItems": both, "minItems": 2, "maxItems": 2}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of both, or what is missing or too much."""
        if not isinstance(entry, list):
            return wrong_type(entry, path, "a list of an axis and an angle")
        if len(entry) > 2:
            return wrong_length(path, len(entry), 2)
        misfits = [
            misfit
            for k, (role, item) in enumerate(zip((self.axis, self.angle), entry, strict=False))
            for misfit in role.misfits(item, (*path, k))
        ]
        cure = 'write both, such as ["z", "pi/2"]'
        for k in range(len(entry), 2):
            misfits.append(Misfit((*path, k), "wrong_length", f"entry {k + 1} is missing", "", cure))
        return misfits

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return a list of both."""
        return [self.axis.to_file(owner, value[0], target), self.angle.to_file(owner, value[1], target)]

    def rename(self, value: Any, names: NewNames) -> tuple[Axis, Formula]:
        """Return both in the new names."""
        return self.axis.rename(value[0], names), self.angle.rename(value[1], names)

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return both."""
        return ((self.axis, value[0], f"{path}[0]"), (self.angle, value[1], f"{path}[1]"))


@dataclass(frozen=True, eq=False, repr=False)
class Turns(ListOf[Iterable[tuple[AxisLike, Value]], Rotation]):
    """Successive rotations."""

    role: ClassVar[str] = "turns"
    takes: ClassVar[str] = "iterable of (axis, angle)"
    annotation: ClassVar[str] = "Iterable[tuple[str | Iterable[Value], Value]]"

    _: KW_ONLY
    item: Any = field(default_factory=Turn)


@dataclass(frozen=True, eq=False, repr=False)
class _Rows(ListOf[Sequence[Iterable[Value]], Matrix]):
    """Three rows of three numbers or formulas."""

    role: ClassVar[str] = "matrix"
    takes: ClassVar[str] = "(3, 3) number or formula"
    annotation: ClassVar[str] = "Sequence[Iterable[Value]]"

    _: KW_ONLY
    item: Any = field(default_factory=VectorQuantity)
    count: int | None = 3

    def items(self, arguments: Arguments, value: object, path: str) -> Iterable[object]:
        """Return three rows."""
        rows = arguments.items(value, path)
        if len(rows) == 3:
            return rows
        what = f"{len(rows)} rows instead of three"
        arguments.add("model.not_three", path, what, "", "give three rows of three entries")
        return ()


@dataclass(frozen=True, eq=False, repr=False)
class RotationMatrix(OptionalField[Sequence[Iterable[Value]], Matrix]):
    """The rows of a rotation matrix, or None."""

    _: KW_ONLY
    inner: Any = field(default_factory=_Rows)
    is_nullable: bool = True

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Matrix | None:
        """Return three rows of formulas; None also for another number of rows."""
        return OptionalField.read(self, owner, arguments, value, path) or None

    def check_numbers(self, check: NumericChecks, owner: object, value: Matrix | None, where: str) -> None:
        """Refuse rows that are not orthonormal, or left-handed."""
        numbers = [check.values(row, f"{where}[{k}]") for k, row in enumerate(value or ())]
        r = [row for row in numbers if row is not None]
        if len(r) < 3:
            return
        pairs = ((i, j) for i in range(3) for j in range(i + 1))
        defect = max(abs(sum(a * b for a, b in zip(r[i], r[j], strict=True)) - (i == j)) for i, j in pairs)
        if defect > _ORTHONORMAL:
            what = f"the rows deviate from an orthonormal set by {defect:.3g}"
            why = "rows of a rotation matrix have length 1 and are perpendicular"
            check.refuse("model.not_a_rotation", where, what, why, "give more digits, or use rotate instead")
        elif determinant(r) < 0:
            what = "the determinant is -1: the axes are left-handed"
            why = "two rows are swapped, or one has the wrong sign"
            check.refuse("model.not_a_rotation", where, what, why, "use a right-handed set of axes")


@part
class Frame(Declared):
    """Axes with an origin, placed on a body by constants.

    Examples
    --------
    >>> Frame(at=("L", 0, 0), rotate=[("z", "pi/2")]).at[0].text
    'L'
    """

    at: VectorQuantity = VectorQuantity(
        "Origin, relative to the centre of mass, in the body's axes.", unit="m", default=(0, 0, 0),
        item=Quantity(fits=FINITE),
    )  # fmt: skip
    rotate: Turns = Turns("Successive body-fixed rotations: axis and angle.", default=())
    matrix: RotationMatrix = RotationMatrix(
        "Rotation matrix instead of successive rotations; it transforms components in the frame to "
        "components in the body.",
        default=None,
    )

    def check(self, arguments: Arguments) -> None:
        """Note turns beside a matrix."""
        check_rotation(arguments, self.rotate, self.matrix)

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the simple rotations from the body's axes to this frame's."""
        if self.matrix is not None:
            return _euler_turns(self.matrix)
        return tuple(SimpleRotation(unit_axis(axis), angle) for axis, angle in self.rotate)


def check_rotation(arguments: Arguments, rotate: Rotation, matrix: Matrix | None) -> None:
    """Note turns beside a matrix."""
    if matrix is not None and rotate:
        what = "the frame has both rotations and a matrix"
        why = "either of them defines the orientation of the frame"
        arguments.add("model.two_rotations", "", what, why, "remove one of them")


def _euler_turns(matrix: tuple[Triple, Triple, Triple]) -> tuple[SimpleRotation, ...]:
    """Return body-fixed turns about z, y, x that lead to the axes whose rotation matrix is given.

    Numbers give the angles as numbers, multiples of pi/12 exactly; formulas give them by atan2, which
    presumes that the y turn is not a right angle.
    """
    values = [[formula_value(entry) for entry in row] for row in matrix]
    numbers = [[float(value) for value in row if value is not None] for row in values]
    if sum(map(len, numbers)) < 9:
        angles: tuple[Formula, ...] = _formulas(matrix)
    else:
        angles = tuple(_angle(angle) for angle in rotation_angles(numbers))
    pairs = zip("zyx", angles, strict=True)
    return tuple(SimpleRotation(LETTERS[letter], angle) for letter, angle in pairs if angle.text != "0")


def rotation_angles(r: list[list[float]]) -> tuple[float, float, float]:
    """Return the three angles of R = Rz Ry Rx; the first is 0 where only its sum with the third counts."""
    horizontal = math.hypot(r[0][0], r[1][0])
    second = math.atan2(-r[2][0], horizontal)
    if horizontal < 1e-9:  # z and x turn about one line: let x do it
        return 0.0, second, math.atan2(-r[1][2], r[1][1])
    return math.atan2(r[1][0], r[0][0]), second, math.atan2(r[2][1], r[2][2])


def _angle(angle: float) -> Formula:
    steps = round(angle * 12 / math.pi)
    if abs(angle - steps * math.pi / 12) > _SNAP:
        return Formula.from_value(angle)
    part = Fraction(steps, 12)
    return Formula.from_value(f"{part.numerator}*pi/{part.denominator}" if steps else 0)


def _formulas(matrix: tuple[Triple, Triple, Triple]) -> tuple[Formula, Formula, Formula]:
    r = [[entry.text for entry in row] for row in matrix]
    return (
        Formula.from_value(f"atan2({r[1][0]}, {r[0][0]})"),
        Formula.from_value(f"atan2(-({r[2][0]}), sqrt(({r[0][0]})**2 + ({r[1][0]})**2))"),
        Formula.from_value(f"atan2({r[2][1]}, {r[2][2]})"),
    )
