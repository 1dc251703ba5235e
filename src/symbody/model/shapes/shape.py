"""`BodyShape`: what every shape of a body has, and the fields that say where it stands and how it looks."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, ClassVar, Final

from symbody.expr.language.formula import Formula
from symbody.model.class_folders import definition_name, final_classes, snake_case
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.declaration import ElementPart, file_table
from symbody.model.declarations.field import Field, FileTable, FileTarget, NewNames, Node
from symbody.model.declarations.fields import Quantity, TextField, VectorQuantity
from symbody.model.declarations.misfits import Misfit, Path, Schema, list_misfits
from symbody.model.declarations.part_fields import read_part
from symbody.model.declarations.typed_tables import typed_list_schema, typed_misfits
from symbody.model.frame import Frame, RotationMatrix, Turns, check_rotation
from symbody.model.shapes.colors import read_color


class Color(TextField[str, str]):
    """A colour."""

    role: ClassVar[str] = "color"

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


@cache
def shape_types() -> Mapping[str, type[BodyShape]]:
    """Return the shapes by their words in model files."""
    kinds = [each for each in final_classes(__package__) if issubclass(each, BodyShape)]
    return MappingProxyType(dict(sorted((snake_case(each.__name__), each) for each in kinds)))


@cache
def _shape_tables() -> Mapping[str, FileTable]:
    types = shape_types().items()
    return MappingProxyType({word: file_table(each, definition_name(word), word) for word, each in types})


@dataclass(frozen=True, eq=False, repr=False)
class Shapes(Field[Iterable[BodyShape], tuple[BodyShape, ...]]):
    """A list of shapes."""

    role: ClassVar[str] = "shapes"
    takes: ClassVar[str] = "iterable of Box, Cylinder, Sphere, Capsule, Cone or Mesh"
    annotation: ClassVar[str] = "Iterable[BodyShape]"

    _: KW_ONLY
    default: Any = ()

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[BodyShape, ...]:
        """Return the shapes."""
        items = [value] if isinstance(value, BodyShape) else arguments.items(value, path)
        for k, item in enumerate(items):
            if not isinstance(item, BodyShape):
                fix = "give Box, Cylinder, Sphere, Capsule, Cone or Mesh"
                arguments.add("model.not_a_shape", f"{path}[{k}]", f"{item!r} is not a shape", "", fix)
        return tuple(item for item in items if isinstance(item, BodyShape))

    def schema(self) -> Schema:
        """Return a list of tables of several types."""
        return typed_list_schema(_shape_tables())

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of each table by its type."""
        return list_misfits(entry, path, self._shape_misfits)

    def tables(self) -> Iterable[FileTable]:
        """Return the tables of all shapes."""
        return _shape_tables().values()

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the shapes of a list of tables."""
        pairs = enumerate(entry if isinstance(entry, list) else ())
        shapes = [
            read_part(shape_types()[item["type"]], item, arguments, f"{path}[{k}]", folder)
            for k, item in pairs
        ]
        return [shape for shape in shapes if shape is not None]

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return a list of tables."""
        return [{"type": snake_case(type(shape).__name__), **shape.to_entry(target)} for shape in value]

    def rename(self, value: Any, names: NewNames) -> tuple[BodyShape, ...]:
        """Return the shapes in the new names."""
        return tuple(shape.rename(names) for shape in value)

    def _shape_misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        return typed_misfits(entry, path, "shape", _shape_tables())


# The shapes of the ground, which has no declaration of its own.
GROUND_SHAPES: Final = Shapes("Shapes to draw.")
