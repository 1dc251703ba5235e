"""`BodyShape`: what every shape of a body has."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.door import Door, Value
from symbody.model.frame import Frame, Matrix, Rotation
from symbody.model.shapes.colors import color_from
from symbody.model.uses import Scope, Triple, Use

Turns: TypeAlias = Iterable[tuple[str | Iterable[Value], Value]]
Rows: TypeAlias = Sequence[Iterable[Value]]
Reader: TypeAlias = Callable[[Door, object, str], object]


@dataclass(frozen=True, slots=True, init=False)
class BodyShape(ABC):
    """Something to be seen, fixed on a body.

    Attributes
    ----------
    at, rotate, matrix
        Where it stands on the body, as in a `Frame`.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the body's own colour.
    opacity : Formula
        From 0, invisible, to 1.
    """

    at: Triple
    rotate: Rotation
    matrix: Matrix | None
    color: str
    opacity: Formula

    @property
    @abstractmethod
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """Each number of its size after its place: ``("size[0]", ..)``; none may be negative."""

    @property
    def frame(self) -> Frame:
        """Where it stands on the body."""
        return Frame(self.at, self.rotate, self.matrix)

    def uses(self, path: str) -> Iterator[Use]:
        """Return where the formulas stand, below `path`."""
        for place, formula in self.lengths:
            yield Use(f"{path}.{place}", formula, Scope.CONSTANT)
        yield from self.frame.uses(path)
        yield Use(f"{path}.opacity", self.opacity, Scope.CONSTANT)


def set_shape(
    shape: BodyShape,
    sizes: Mapping[str, tuple[Reader, object]],
    at: Iterable[Value],
    rotate: Turns,
    matrix: Rows | None,
    color: object,
    opacity: object,
) -> None:
    """Set the fields of a new shape from the arguments of its constructor.

    Parameters
    ----------
    sizes : mapping of word to (reader, value)
        What it has besides its place and its looks.

    Raises
    ------
    ModelError
        With everything that is wrong with them.
    """
    door = Door(type(shape).__name__.lower())
    for word, (read, value) in sizes.items():
        object.__setattr__(shape, word, read(door, value, word))
    frame = _frame(door, at, rotate, matrix)
    object.__setattr__(shape, "at", frame.at)
    object.__setattr__(shape, "rotate", frame.rotate)
    object.__setattr__(shape, "matrix", frame.matrix)
    object.__setattr__(shape, "color", color_from(door, color, "color"))
    object.__setattr__(shape, "opacity", door.formula(opacity, "opacity"))
    door.close()


def shapes_from(door: Door, values: object, path: str) -> tuple[BodyShape, ...]:
    """Return the shapes of a list."""
    items = [values] if isinstance(values, BodyShape) else door.items(values, path)
    for k, item in enumerate(items):
        if not isinstance(item, BodyShape):
            door.refuse(
                "model.not_a_shape", f"{path}[{k}]", f"{item!r} is not a shape", "",
                "give Box, Cylinder, Sphere, Capsule, Cone or Mesh",
            )  # fmt: skip
    return tuple(item for item in items if isinstance(item, BodyShape))


def _frame(door: Door, at: Iterable[Value], rotate: Turns, matrix: Rows | None) -> Frame:
    """Return where a shape stands; faults are those of a frame, with the shape's name before them."""
    try:
        return Frame(at, rotate, matrix)
    except SymbodyError as error:
        for problem in error.problems:
            path = problem.where.partition(", ")[2]
            door.refuse(problem.code, path, problem.what, problem.why, problem.fix)
        return Frame()
