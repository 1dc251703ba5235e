"""`ContactShape`: what touches in a contact; which pairs of shapes have formulas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar, Final, NamedTuple, TypeAlias

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import ListOf
from symbody.model.declarations.field import Field, FileTarget, NewNames, Node
from symbody.model.declarations.formula_site import FormulaSite, Scope
from symbody.model.declarations.misfits import (
    FORMULA_SCHEMA,
    Misfit,
    Path,
    Schema,
    formula_misfits,
    list_misfits,
    unknown_key,
    wrong_type,
)
from symbody.model.numeric_checks import Domain, NumericChecks

_SIZES: Final = Domain(
    "contact.size", "a size of the shape is {value} m", "a shape of this size has no surface to touch",
    "give a length above zero", 0.0, above=True,
)  # fmt: skip
_NOT_NEGATIVE: Final = Domain(
    "contact.size", "a size of the shape is {value} m", "a sign is wrong", "give a length of 0 or more", 0.0
)


class ShapeKind(NamedTuple):
    """A kind of shape.

    Attributes
    ----------
    sizes : tuple of str
        Its sizes, in their order; several are written as a list.
    place : str
        How it lies in its frame.
    reads : tuple of str
        Names that mean something in its formula beside parameters; of sizes none. A model may well have a
        coordinate x, too. Time is not among them: the velocity of a surface is that of its frame.
    """

    sizes: tuple[str, ...]
    place: str
    reads: tuple[str, ...] = ()


# By their words in files. Where one has a length, 0 is one.
SHAPE_KINDS: Final[Mapping[str, ShapeKind]] = MappingProxyType(
    {
        "plane": ShapeKind((), "the plane of x and y, solid below: z points to the free side"),
        "point": ShapeKind((), "the origin"),
        "sphere": ShapeKind(("radius",), "about the origin"),
        "capsule": ShapeKind(
            ("radius", "length"), "about z, its middle in the origin; length without the caps"
        ),
        "cylinder": ShapeKind(("radius", "length"), "about z, its middle in the origin"),
        "disc": ShapeKind(
            ("radius",),
            "a thin disc about z, its centre in the origin; with a hole or cam axes are taken as parallel",
        ),
        "torus": ShapeKind(
            ("radius", "tube"), "about z: radius of the circle of centres, and of the tube about it"
        ),
        "box": ShapeKind(("x", "y", "z"), "edges along the axes, its centre in the origin"),
        "socket": ShapeKind(("radius",), "the hollow inside of a sphere about the origin"),
        "hole": ShapeKind(("radius",), "the hollow inside of a cylinder about z, without ends"),
        "height": ShapeKind(("height",), "solid below z = height(x, y)", ("x", "y")),
        "cam": ShapeKind(
            ("radius",), "solid inside of radius(angle) about z; angle from x towards y", ("angle",)
        ),
    }
)
# What other programs call them.
_OTHER_NAMES: Final = MappingProxyType(
    {"half_space": "plane", "halfspace": "plane", "floor": "plane", "ball": "sphere", "circle": "disc",
     "ring": "torus", "heightfield": "height", "terrain": "height", "profile": "cam", "pin": "disc"}
)  # fmt: skip
# Pairs with formulas, in either order; `equations.contacts.pairs` has a function for each.
PAIRS: Final[frozenset[tuple[str, str]]] = frozenset(
    (
        *(("plane", other) for other in
          ("point", "sphere", "capsule", "cylinder", "disc", "torus", "box")),
        ("sphere", "sphere"), ("sphere", "point"), ("sphere", "capsule"), ("point", "capsule"),
        ("capsule", "capsule"), ("box", "sphere"), ("box", "point"), ("box", "capsule"),
        ("socket", "sphere"), ("socket", "point"),
        ("hole", "disc"), ("hole", "sphere"), ("hole", "point"),
        ("height", "point"), ("height", "sphere"),
        ("cam", "point"), ("cam", "disc"), ("cam", "sphere"),
    )
)  # fmt: skip
# What touches a plane in several points; all else touches in one.
POINTS: Final = MappingProxyType({"capsule": 2, "cylinder": 6, "box": 8})


@dataclass(frozen=True, slots=True)
class ContactShape:
    """A shape that touches, fixed in a frame.

    Attributes
    ----------
    word : str
        One of `SHAPE_KINDS`.
    sizes : tuple of Formula
        In the order of its kind.
    """

    word: str
    sizes: tuple[Formula, ...] = ()

    @property
    def node(self) -> Node:
        """What a model file has for it, and the argument of a constructor."""
        if not self.sizes:
            return self.word
        return {self.word: self.sizes[0] if len(self.sizes) == 1 else list(self.sizes)}

    def __repr__(self) -> str:
        texts = ", ".join(repr(size.text) for size in self.sizes)
        if not texts:
            return repr(self.word)
        return f"{{{self.word!r}: {texts if len(self.sizes) == 1 else f'({texts})'}}}"


ShapeLike: TypeAlias = str | Mapping[str, Value | Iterable[Value]] | ContactShape
_POINT: Final = ContactShape("point")


class ContactShapeRole(Field[ShapeLike, ContactShape]):
    """A shape: its word, or a table of its word and its sizes."""

    role: ClassVar[str] = "contact_shape"
    takes: ClassVar[str] = "str or dict of sizes"
    annotation: ClassVar[str] = "ShapeLike"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> ContactShape:
        """Return the shape; a point stands for what is none."""
        if isinstance(value, ContactShape):
            return value
        word, sizes = _word_and_sizes(value)
        kind = SHAPE_KINDS.get(word)
        if kind is None:
            arguments.add("contact.shape", path, f"{value!r} is not a shape", "", _shape_cure(word))
            return _POINT
        if len(sizes) != len(kind.sizes):
            what = f"a {word} has {', '.join(kind.sizes) or 'no size'}, not {len(sizes)} sizes"
            arguments.add("contact.sizes", path, what, "", f"write {_pattern(word)}")
            return _POINT
        return ContactShape(word, tuple(arguments.formula(size, f"{path}.{word}") for size in sizes))

    def schema(self) -> Schema:
        """Return a word or an object with one key."""
        plain = [word for word, kind in SHAPE_KINDS.items() if not kind.sizes]
        table = {
            "type": "object",
            "properties": {
                word: {
                    **_size_schema(len(kind.sizes)),
                    "title": ", ".join(kind.sizes),
                    "description": kind.place,
                }
                for word, kind in SHAPE_KINDS.items()
                if kind.sizes
            },
            "additionalProperties": False,
            "minProperties": 1,
            "maxProperties": 1,
        }
        return {"anyOf": [{"enum": plain}, table]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the sizes; which words there are is seen later."""
        if isinstance(entry, str):
            return ()
        if not isinstance(entry, dict) or len(entry) != 1:
            return wrong_type(entry, path, 'a shape such as "plane" or { sphere = "r" }')
        ((word, sizes),) = entry.items()
        kind = SHAPE_KINDS.get(word)
        if kind is None or not kind.sizes:
            return (unknown_key(path, word, [each for each, other in SHAPE_KINDS.items() if other.sizes]),)
        place = (*path, word)
        if len(kind.sizes) == 1:
            return formula_misfits(sizes, place)
        return list_misfits(sizes, place, formula_misfits, len(kind.sizes), _pattern(word))

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the word, or the table of its sizes."""
        node: Node = value.node
        return node

    def rename(self, value: Any, names: NewNames) -> ContactShape:
        """Return the shape with its sizes in the new names."""
        own = SHAPE_KINDS[value.word].reads
        return ContactShape(value.word, tuple(_rename_size(size, names, own) for size in value.sizes))

    def formula_sites(self, owner: object, value: ContactShape, path: str) -> Iterator[FormulaSite]:
        """Return where the sizes stand."""
        kind = SHAPE_KINDS[value.word]
        for k, size in enumerate(value.sizes):
            place = f"{path}.{value.word}" + (f"[{k}]" if len(value.sizes) > 1 else "")
            scope = Scope.SURFACE if "x" in kind.reads else Scope.CONSTANT
            yield FormulaSite(place, size, scope, () if scope is Scope.SURFACE else kind.reads, "m")

    def check_numbers(self, check: NumericChecks, owner: object, value: ContactShape, where: str) -> None:
        """Refuse sizes that cannot be."""
        kind = SHAPE_KINDS[value.word]
        for name, size in zip(kind.sizes, value.sizes, strict=True):
            if not kind.reads:
                domain = _NOT_NEGATIVE if name == "length" else _SIZES
                domain(check, size, f"{where}.{value.word}")


@dataclass(frozen=True, eq=False, repr=False)
class ContactShapes(ListOf[Iterable[ShapeLike], tuple[ContactShape, ContactShape]]):
    """The shape on start and that on end."""

    role: ClassVar[str] = "contact_shapes"
    takes: ClassVar[str] = "(2,) str or dict of sizes"
    annotation: ClassVar[str] = "Iterable[ShapeLike]"

    _: KW_ONLY
    item: Any = field(default_factory=ContactShapeRole)
    count: int | None = 2
    nouns: str = "shapes"
    why: str = "one is on start, the other on end"
    fix: str = 'write shapes = ["plane", { sphere = "r" }]'
    instead: tuple[object, ...] = ("plane", "point")
    example: str = '["plane", { sphere = "r" }]'

    def read(
        self, owner: Any, arguments: Arguments, value: object, path: str
    ) -> tuple[ContactShape, ContactShape]:
        """Return two shapes for which there are formulas."""
        count = len(arguments.problems)
        first, second = ListOf.read(self, owner, arguments, value, path)
        pair = (first.word, second.word)
        if len(arguments.problems) == count and not PAIRS.intersection((pair, pair[::-1])):
            partners = sorted({b for a, b in (*PAIRS, *(p[::-1] for p in PAIRS)) if a == first.word})
            what = f"there is no formula for a {first.word} that touches a {second.word}"
            why = f"a {first.word} can touch: {', '.join(partners)}"
            fix = "take another shape, or several contacts of simpler ones"
            arguments.add("contact.pair", path, what, why, fix)
        return first, second


def _pattern(word: str) -> str:
    """Return how a shape is written."""
    names = SHAPE_KINDS[word].sizes
    if not names:
        return f'"{word}"'
    sizes = ", ".join(f'"{name}"' for name in names)
    return f"{{ {word} = {sizes if len(names) == 1 else f'[{sizes}]'} }}"


def _word_and_sizes(value: object) -> tuple[str, tuple[Any, ...]]:
    """Return the word of a shape and its sizes; "" for what is no shape."""
    if isinstance(value, str):
        return value, ()
    if not isinstance(value, Mapping) or len(value) != 1:
        return "", ()
    ((word, sizes),) = value.items()
    is_list = isinstance(sizes, Iterable) and not isinstance(sizes, str | Mapping)
    return str(word), tuple(sizes) if is_list else (sizes,)


def _shape_cure(word: str) -> str:
    meant = _OTHER_NAMES.get(word.lower(), "")
    if meant:
        return f"write {_pattern(meant)}: {SHAPE_KINDS[meant].place}"
    near = nearest(word, SHAPE_KINDS)
    return f'{near} Write "plane", "point" or a table such as {{ sphere = "r" }}'


def _size_schema(count: int) -> Schema:
    if count == 1:
        return dict(FORMULA_SCHEMA)
    return {"type": "array", "items": FORMULA_SCHEMA, "minItems": count, "maxItems": count}


def _rename_size(size: Formula, names: NewNames, own: tuple[str, ...]) -> Formula:
    """Return a size in the new names; what means something in it alone keeps its name."""
    return size.rename({name: names.symbol(name) for name in size.names if name not in own})
