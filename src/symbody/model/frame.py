"""`Frame`: a set of axes with an origin, fixed on a body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import ClassVar, Final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value
from symbody.model.declarations.declaration import ElementPart, Field
from symbody.model.declarations.fields import AxisLike, VectorQuantity, part
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.numbers import formula_value
from symbody.model.simple_rotation import LETTERS, Axis, SimpleRotation, read_axis, unit_axis

Matrix = tuple[Triple, Triple, Triple]
Rotation = tuple[tuple[Axis, Formula], ...]

# A matrix typed with 10 digits of cos 30 deg means 30 deg.
_SNAP: Final = 2e-11


class Turns(Field[Iterable[tuple[AxisLike, Value]], Rotation]):
    """Successive rotations."""

    role: ClassVar[str] = "turns"
    takes: ClassVar[str] = "iterable of (axis, angle)"
    annotation: ClassVar[str] = "Iterable[tuple[str | Iterable[Value], Value]]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Rotation:
        """Return pairs of an axis and an angle [rad]."""
        return tuple(
            _turn(arguments, turn, f"{path}[{k}]") for k, turn in enumerate(arguments.items(value, path))
        )

    def formula_sites(self, owner: object, value: Rotation, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas stand."""
        for k, (axis, angle) in enumerate(value):
            if not isinstance(axis, str):
                yield from component_sites(f"{path}[{k}][0]", axis, Scope.CONSTANT)
            yield FormulaSite(f"{path}[{k}][1]", angle, Scope.CONSTANT)


class RotationMatrix(Field[Sequence[Iterable[Value]] | None, Matrix | None]):
    """The rows of a rotation matrix, or None."""

    role: ClassVar[str] = "matrix"
    takes: ClassVar[str] = "(3, 3) number or formula"
    annotation: ClassVar[str] = "Sequence[Iterable[Value]] | None"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Matrix | None:
        """Return three rows of formulas."""
        return None if value is None else _matrix(arguments, value)

    def formula_sites(self, owner: object, value: Matrix | None, path: str) -> Iterator[FormulaSite]:
        """Return where the entries stand."""
        for k, row in enumerate(value or ()):
            yield from component_sites(f"{path}[{k}]", row, Scope.CONSTANT)


@part
class Frame(ElementPart):
    """Axes with an origin, placed on a body by constants.

    Examples
    --------
    >>> Frame(at=("L", 0, 0), rotate=[("z", "pi/2")]).at[0].text
    'L'
    """

    at: VectorQuantity = VectorQuantity(
        "Origin, relative to the centre of mass, in the body's axes.", unit="m", default=(0, 0, 0)
    )
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
        arguments.add(
            "model.two_rotations",
            "",
            "the frame has both rotations and a matrix",
            "either of them defines the orientation of the frame",
            "remove one of them",
        )


def _turn(arguments: Arguments, turn: object, path: str) -> tuple[Axis, Formula]:
    pair = arguments.items(turn, path)
    if len(pair) != 2:
        arguments.add(
            "model.not_a_turn",
            path,
            "a rotation is an axis and an angle",
            "",
            'write for instance ["z", "pi/2"]; several rotations form a list of such pairs',
        )
        return "x", ZERO
    return read_axis(arguments, pair[0], f"{path}[0]"), arguments.formula(pair[1], f"{path}[1]")


def _matrix(arguments: Arguments, rows: object) -> Matrix | None:
    items = arguments.items(rows, "matrix")
    if len(items) != 3:
        arguments.add(
            "model.not_three",
            "matrix",
            f"{len(items)} rows instead of three",
            "",
            "give three rows of three entries",
        )
        return None
    a, b, c = (arguments.triple(row, f"matrix[{k}]") for k, row in enumerate(items))
    return (a, b, c)


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
        angles = tuple(_angle(angle) for angle in _numbers(numbers))
    pairs = zip("zyx", angles, strict=True)
    return tuple(SimpleRotation(LETTERS[letter], angle) for letter, angle in pairs if angle.text != "0")


def _numbers(r: list[list[float]]) -> tuple[float, float, float]:
    """Return the three angles of R = Rz Ry Rx."""
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
