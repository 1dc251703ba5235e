"""`BodyShape`: what every shape of a body has, and the fields that say where it stands and how it looks."""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, ClassVar, Final

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.class_folders import definition_name, final_classes, snake_case
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.declaration import Declared, file_table
from symbody.model.declarations.field import (
    Field,
    FileTable,
    FileTarget,
    NewNames,
    Node,
    typed_list_schema,
    typed_misfits,
)
from symbody.model.declarations.fields import Quantity, TextField, VectorQuantity, read_part
from symbody.model.declarations.misfits import Misfit, Path, Schema, list_misfits
from symbody.model.frame import Frame, RotationMatrix, Turns, check_rotation
from symbody.model.numeric_checks import FINITE, Domain


class Color(TextField[str, str]):
    """A colour."""

    role: ClassVar[str] = "color"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the colour in lower case."""
        return read_color(arguments, value, path)


# The last arguments of every shape.
CENTRE: Final = VectorQuantity(
    "Centre, relative to the centre of mass, in the body's axes.", unit="m", default=(0, 0, 0),
    item=Quantity(fits=FINITE),
)  # fmt: skip
ROTATE: Final = Turns("Successive rotations from the body's axes to its own: axis and angle.", default=())
MATRIX: Final = RotationMatrix("Rotation matrix instead of successive rotations.", default=None)
COLOR: Final = Color('"#rrggbb", a CSS name, or "" for the colour of the body.', default="")
_SHARES: Final = Domain(
    "model.opacity", "the opacity is {value}", "0 is invisible, 1 is opaque", "give a number from 0 to 1",
    0.0, most=1.0,
)  # fmt: skip
OPACITY: Final = Quantity("From 0 to 1.", default=1, fits=_SHARES)
SIZES: Final = Domain(
    "model.negative_size", "the length is {value} m", "a sign is wrong", "give a positive length", 0.0
)


class BodyShape(Declared):
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
        return list_misfits(
            entry, path, lambda item, place: typed_misfits(item, place, "shape", _shape_tables())
        )

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
        return [target.part(shape, snake_case(type(shape).__name__)) for shape in value]

    def rename(self, value: Any, names: NewNames) -> tuple[BodyShape, ...]:
        """Return the shapes in the new names."""
        return tuple(shape.rename(names) for shape in value)


# The shapes of the ground, which has no declaration of its own.
GROUND_SHAPES: Final = Shapes("Shapes to draw.")


_HEX: Final = re.compile(r"#[0-9a-fA-F]{6}")

# Name and six hexadecimal digits of each.
_TABLE: Final = """
    aliceblue f0f8ff antiquewhite faebd7 aqua 00ffff aquamarine 7fffd4 azure f0ffff beige f5f5dc bisque
    ffe4c4 black 000000 blanchedalmond ffebcd blue 0000ff blueviolet 8a2be2 brown a52a2a burlywood deb887
    cadetblue 5f9ea0 chartreuse 7fff00 chocolate d2691e coral ff7f50 cornflowerblue 6495ed cornsilk fff8dc
    crimson dc143c cyan 00ffff darkblue 00008b darkcyan 008b8b darkgoldenrod b8860b darkgray a9a9a9
    darkgreen 006400 darkgrey a9a9a9 darkkhaki bdb76b darkmagenta 8b008b darkolivegreen 556b2f darkorange
    ff8c00 darkorchid 9932cc darkred 8b0000 darksalmon e9967a darkseagreen 8fbc8f darkslateblue 483d8b
    darkslategray 2f4f4f darkslategrey 2f4f4f darkturquoise 00ced1 darkviolet 9400d3 deeppink ff1493
    deepskyblue 00bfff dimgray 696969 dimgrey 696969 dodgerblue 1e90ff firebrick b22222 floralwhite fffaf0
    forestgreen 228b22 fuchsia ff00ff gainsboro dcdcdc ghostwhite f8f8ff gold ffd700 goldenrod daa520 gray
    808080 green 008000 greenyellow adff2f grey 808080 honeydew f0fff0 hotpink ff69b4 indianred cd5c5c
    indigo 4b0082 ivory fffff0 khaki f0e68c lavender e6e6fa lavenderblush fff0f5 lawngreen 7cfc00
    lemonchiffon fffacd lightblue add8e6 lightcoral f08080 lightcyan e0ffff lightgoldenrodyellow fafad2
    lightgray d3d3d3 lightgreen 90ee90 lightgrey d3d3d3 lightpink ffb6c1 lightsalmon ffa07a lightseagreen
    20b2aa lightskyblue 87cefa lightslategray 778899 lightslategrey 778899 lightsteelblue b0c4de lightyellow
    ffffe0 lime 00ff00 limegreen 32cd32 linen faf0e6 magenta ff00ff maroon 800000 mediumaquamarine 66cdaa
    mediumblue 0000cd mediumorchid ba55d3 mediumpurple 9370db mediumseagreen 3cb371 mediumslateblue 7b68ee
    mediumspringgreen 00fa9a mediumturquoise 48d1cc mediumvioletred c71585 midnightblue 191970 mintcream
    f5fffa mistyrose ffe4e1 moccasin ffe4b5 navajowhite ffdead navy 000080 oldlace fdf5e6 olive 808000
    olivedrab 6b8e23 orange ffa500 orangered ff4500 orchid da70d6 palegoldenrod eee8aa palegreen 98fb98
    paleturquoise afeeee palevioletred db7093 papayawhip ffefd5 peachpuff ffdab9 peru cd853f pink ffc0cb
    plum dda0dd powderblue b0e0e6 purple 800080 rebeccapurple 663399 red ff0000 rosybrown bc8f8f royalblue
    4169e1 saddlebrown 8b4513 salmon fa8072 sandybrown f4a460 seagreen 2e8b57 seashell fff5ee sienna a0522d
    silver c0c0c0 skyblue 87ceeb slateblue 6a5acd slategray 708090 slategrey 708090 snow fffafa springgreen
    00ff7f steelblue 4682b4 tan d2b48c teal 008080 thistle d8bfd8 tomato ff6347 turquoise 40e0d0 violet
    ee82ee wheat f5deb3 white ffffff whitesmoke f5f5f5 yellow ffff00 yellowgreen 9acd32
"""
CSS_COLORS: Final[Mapping[str, str]] = MappingProxyType(
    dict(zip(_TABLE.split()[::2], (f"#{digits}" for digits in _TABLE.split()[1::2]), strict=True))
)


def hex_color(color: str) -> str:
    """Return a colour as ``"#rrggbb"``; "" stays.

    >>> hex_color("orange")
    '#ffa500'
    """
    return CSS_COLORS.get(color, color)


def read_color(arguments: Arguments, value: object, path: str) -> str:
    """Return a colour in lower case; "" stands for the usual one."""
    text = value.strip().lower() if isinstance(value, str) else None
    if text is not None and (not text or _HEX.fullmatch(text) or text in CSS_COLORS):
        return text
    similar = f"{nearest(text, CSS_COLORS)} " if text and not text.startswith("#") else ""
    fix = f'{similar}Write "#rrggbb" in hexadecimal, such as "#d55e00", or a name such as "orange"'
    arguments.add("model.bad_color", path, f"{value!r} is not a colour", "", fix)
    return ""
