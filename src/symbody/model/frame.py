"""`Frame`: a set of axes with an origin, fixed on a body."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from symbody.expr.language.formula import Formula
from symbody.model.door import ZERO, Door, Value
from symbody.model.euler_angles import euler_turns
from symbody.model.turn import Axis, Turn, axis_from, unit_axis
from symbody.model.uses import Scope, Triple, Use, triple_uses

Matrix = tuple[Triple, Triple, Triple]
Rotation = tuple[tuple[Axis, Formula], ...]


@dataclass(frozen=True, slots=True, init=False)
class Frame:
    """Axes with an origin, placed on a body by constants.

    Parameters
    ----------
    at : (3,) number or formula
        Origin [m], measured from the body's centre of mass in the body's axes.
    rotate : iterable of (axis, angle)
        Successive body-fixed turns; axis "x", "y", "z" or three components, angle [rad].
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns; it takes components in this frame to components in the body.

    Raises
    ------
    ModelError
        If an entry is not a formula, or both `rotate` and `matrix` are given.

    Examples
    --------
    >>> Frame(at=("L", 0, 0), rotate=[("z", "pi/2")]).at[0].text
    'L'
    """

    at: Triple
    rotate: Rotation
    matrix: Matrix | None

    def __init__(
        self,
        at: Iterable[Value] = (0, 0, 0),
        rotate: Iterable[tuple[str | Iterable[Value], Value]] = (),
        matrix: Sequence[Iterable[Value]] | None = None,
    ) -> None:
        door = Door("frame")
        object.__setattr__(self, "at", door.triple(at, "at"))
        object.__setattr__(self, "rotate", _rotation(door, rotate))
        object.__setattr__(self, "matrix", None if matrix is None else _matrix(door, matrix))
        if self.matrix is not None and self.rotate:
            door.refuse(
                "model.two_rotations",
                "",
                "the frame has both turns and a matrix",
                "each of them alone says how the frame is turned",
                "leave one of them out",
            )
        door.close()

    def turns(self) -> tuple[Turn, ...]:
        """Return the simple rotations from the body's axes to this frame's."""
        if self.matrix is not None:
            return euler_turns(self.matrix)
        return tuple(Turn(unit_axis(axis), angle) for axis, angle in self.rotate)

    def uses(self, path: str) -> Iterator[Use]:
        """Return where the formulas stand, below `path`."""
        yield from triple_uses(f"{path}.at", self.at, Scope.CONSTANT)
        for k, (axis, angle) in enumerate(self.rotate):
            if not isinstance(axis, str):
                yield from triple_uses(f"{path}.rotate[{k}][0]", axis, Scope.CONSTANT)
            yield Use(f"{path}.rotate[{k}][1]", angle, Scope.CONSTANT)
        for k, row in enumerate(self.matrix or ()):
            yield from triple_uses(f"{path}.matrix[{k}]", row, Scope.CONSTANT)


def _rotation(door: Door, turns: object) -> Rotation:
    return tuple(_turn(door, turn, f"rotate[{k}]") for k, turn in enumerate(door.items(turns, "rotate")))


def _turn(door: Door, turn: object, path: str) -> tuple[Axis, Formula]:
    pair = door.items(turn, path)
    if len(pair) != 2:
        door.refuse(
            "model.not_a_turn",
            path,
            "a turn is an axis and an angle",
            "",
            'write for instance ["z", "pi/2"]; several turns form a list of such pairs',
        )
        return "x", ZERO
    return axis_from(door, pair[0], f"{path}[0]"), door.angle(pair[1], f"{path}[1]")


def _matrix(door: Door, rows: object) -> Matrix | None:
    items = door.items(rows, "matrix")
    if len(items) != 3:
        door.refuse(
            "model.not_three",
            "matrix",
            f"{len(items)} rows instead of three",
            "",
            "give three rows of three entries",
        )
        return None
    a, b, c = (door.triple(row, f"matrix[{k}]") for k, row in enumerate(items))
    return (a, b, c)
