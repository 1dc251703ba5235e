"""`BodyShape`: what every shape of a body has, and the fields that say where it stands and how it looks."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from typing import ClassVar, Final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.declaration import ElementPart, Field
from symbody.model.declarations.fields import Quantity, VectorQuantity
from symbody.model.frame import Frame, RotationMatrix, Turns, check_rotation
from symbody.model.shapes.colors import read_color


class Color(Field[str, str]):
    """A colour."""

    role: ClassVar[str] = "color"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the colour in lower case."""
        return read_color(arguments, value, path)


# The last arguments of every shape.
CENTRE: Final = VectorQuantity(
    "Centre, relative to the centre of mass, in the body's axes.", unit="m", default=(0, 0, 0)
)
ROTATE: Final = Turns("Successive rotations from the body's axes to its own: axis and angle.", default=())
MATRIX: Final = RotationMatrix("Rotation matrix instead of successive rotations.", default=None)
COLOR: Final = Color('"#rrggbb", a CSS name, or "" for the colour of the body.', default="")
OPACITY: Final = Quantity("From 0 to 1.", default=1)


class BodyShape(ElementPart):
    """Something to be seen, fixed on a body.

    A shape declares its size, then the fields above in this order: they are its last arguments.
    """

    __slots__ = ()

    at: VectorQuantity
    rotate: Turns
    matrix: RotationMatrix
    color: Color
    opacity: Quantity

    @property
    @abstractmethod
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """Each number of its size after its place: ``("size[0]", ..)``; none may be negative."""

    @property
    def frame(self) -> Frame:
        """Where it stands on the body."""
        return Frame(self.at, self.rotate, self.matrix)

    def check(self, arguments: Arguments) -> None:
        """Note turns beside a matrix."""
        check_rotation(arguments, self.rotate, self.matrix)


def read_shapes(arguments: Arguments, values: object, path: str) -> tuple[BodyShape, ...]:
    """Return the shapes of a list."""
    items = [values] if isinstance(values, BodyShape) else arguments.items(values, path)
    for k, item in enumerate(items):
        if not isinstance(item, BodyShape):
            arguments.add(
                "model.not_a_shape", f"{path}[{k}]", f"{item!r} is not a shape", "",
                "give Box, Cylinder, Sphere, Capsule, Cone or Mesh",
            )  # fmt: skip
    return tuple(item for item in items if isinstance(item, BodyShape))


class Shapes(Field[Iterable[BodyShape], tuple[BodyShape, ...]]):
    """A list of shapes."""

    role: ClassVar[str] = "shapes"
    takes: ClassVar[str] = "iterable of Box, Cylinder, Sphere, Capsule, Cone or Mesh"
    annotation: ClassVar[str] = "Iterable[BodyShape]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[BodyShape, ...]:
        """Return the shapes."""
        return read_shapes(arguments, value, path)
