"""The roles that arguments of elements have: frames they act on, couplings, equations; and `Connection`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, TypeVar, dataclass_transform

from symbody.expr.language.formula import Formula
from symbody.model.body import FrameLike, read_frame_ref
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import ListOf, list_of
from symbody.model.declarations.declaration import Declared, declare
from symbody.model.declarations.field import Field, FileTarget, NewNames, Node
from symbody.model.declarations.fields import (
    AngleQuantity,
    AxisLike,
    Direction,
    ElementName,
    Flag,
    Quantity,
    Refusal,
    SymbolElementName,
    SymbolName,
    TextField,
    VectorQuantity,
)
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.declarations.misfits import Misfit, Path, Schema, formula_misfits
from symbody.model.element import Element, FrameRef
from symbody.model.simple_rotation import Axis

E = TypeVar("E", bound=Declared)


class AttachedFrame(TextField[FrameLike, FrameRef]):
    """A frame of a body or of the ground."""

    role: ClassVar[str] = "frame"
    takes: ClassVar[str] = "Body, frame or name"
    annotation: ClassVar[str] = "FrameLike"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> FrameRef:
        """Return the address."""
        return read_frame_ref(arguments, value, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the address as text."""
        name: str = value.full_name
        return name

    def rename(self, value: Any, names: NewNames) -> FrameRef:
        """Return the address in the whole."""
        return names.frame(value)


@dataclass(frozen=True, eq=False, repr=False)
class Directions(ListOf[Iterable[AxisLike], tuple[Axis, Axis]]):
    """A direction in start and one in end."""

    role: ClassVar[str] = "directions"
    takes: ClassVar[str] = "(axis, axis)"
    annotation: ClassVar[str] = "Axes"
    explanation: ClassVar[str] = "Each is a letter, or three components of any length."

    _: KW_ONLY
    item: Any = field(default_factory=Direction)
    count: int | None = 2
    nouns: str = "directions"
    why: str = "the first is fixed in start, the second in end"
    fix: str = 'write axes = ["z", "z"]'
    instead: tuple[object, ...] = ("z", "z")


@dataclass(frozen=True, eq=False, repr=False)
class VanishingFormulas(ListOf[Value | Iterable[Value], tuple[Formula, ...]]):
    """What vanishes: one formula or several."""

    role: ClassVar[str] = "equations"
    takes: ClassVar[str] = "formula or list of formula"
    annotation: ClassVar[str] = "Value | Iterable[Value]"

    scope: Scope = Scope.MOTION
    item: Any = field(default_factory=Quantity)

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return the formulas."""
        if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
            return (arguments.formula(value, path),)
        formulas = ListOf.read(self, owner, arguments, value, path)
        if not formulas:
            why = "a constraint consists of left-hand sides that are 0"
            arguments.add("model.empty", path, "there is no equation", why, 'write equations = ["x - y"]')
        return formulas

    def schema(self) -> Schema:
        """Return one formula or a list."""
        return {"anyOf": [self.item.schema(), ListOf.schema(self)]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the formula or of the list."""
        return ListOf.misfits(self, entry, path) if isinstance(entry, list) else formula_misfits(entry, path)

    def formula_sites(self, owner: object, value: tuple[Formula, ...], path: str) -> Iterator[FormulaSite]:
        """Return where the equations stand."""
        return component_sites(path, value, self.scope)


@dataclass(frozen=True, eq=False, repr=False)
class Coupled(ListOf[Iterable[str], tuple[str, ...]]):
    """The coordinates of joints that a constraint couples."""

    role: ClassVar[str] = "coupled"
    takes: ClassVar[str] = "list of str"
    annotation: ClassVar[str] = "Iterable[str]"

    _: KW_ONLY
    item: Any = field(default_factory=SymbolName)
    count: int = 2
    nouns: str = "coordinates"
    why: str = "each wheel, rack or shaft moves with one coordinate"
    fix: str = "name one for each"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[str, ...]:
        """Return as many different names."""
        items = self.items(arguments, value, path)
        names = tuple(_coupled_name(arguments, item, f"{path}[{k}]") for k, item in enumerate(items))
        for name in sorted({name for name in names if names.count(name) > 1 and name != "?"}):
            what = f"{name} is listed {names.count(name)} times"
            why = "a coordinate coupled to itself cannot move"
            arguments.add("model.coupled_twice", path, what, why, "name different coordinates")
        return names or ("?",) * self.count

    def formula_sites(self, owner: object, value: tuple[str, ...], path: str) -> Iterator[FormulaSite]:
        """Return where the names stand."""
        return component_sites(path, map(Formula.from_value, value), Scope.COORDINATE)


def _coupled_name(arguments: Arguments, item: object, path: str) -> str:
    if item != "":
        return arguments.symbol_name(item, path)
    cure = "name the coordinate of a joint, such as theta"
    why = "an end of the coupling is not connected"
    arguments.add("model.not_coupled", path, "there is no coordinate", why, cure)
    return "?"


class CurvePoint(VectorQuantity):
    """A point of a curve, whose parameter the element names."""

    role: ClassVar[str] = "vector"

    def formula_sites(self, owner: Any, value: Triple, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas of the curve stand."""
        for k, formula in enumerate(value):
            yield FormulaSite(f"{path}[{k}]", formula, Scope.PRESCRIBED, (owner.parameter,), self.unit)


# A type checker has to see all roles whose fields may be without default.
@dataclass_transform(
    field_specifiers=(
        Field, ElementName, SymbolName, Quantity, AngleQuantity, VectorQuantity, Direction, Flag,
        AttachedFrame, Directions, VanishingFormulas, Coupled, CurvePoint, SymbolElementName, list_of,
    )
)  # fmt: skip
def element(kind: type[E]) -> type[E]:
    """Return a class as one that declares its arguments by the roles of this file and of `fields`."""
    return declare(kind)


@element
class Connection(Element):
    """An element between two frames, `start` and `end`.

    Attributes
    ----------
    on_one_body : Refusal or None
        The fault of two frames on one body; None if that is none.
    """

    on_one_body: ClassVar[Refusal | None] = None

    start: AttachedFrame = AttachedFrame("The frame at its start.", place="between[0]")
    end: AttachedFrame = AttachedFrame("The frame at its end.", place="between[1]")

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Each direction by the place where it stands."""
        fields = self.fields.items()
        return dict(
            pair for name, role in fields for pair in role.directions(self, getattr(self, name), name)
        )
