"""The roles that arguments of elements have: frames they act on, couplings, equations; and `Connection`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar, dataclass_transform

from symbody.expr.language.formula import Formula
from symbody.model.body import FrameLike, read_frame_ref
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.declaration import Declared, Field, declare
from symbody.model.declarations.fields import (
    AngleQuantity,
    AxisLike,
    Direction,
    ElementName,
    Flag,
    Quantity,
    SymbolElementName,
    SymbolName,
    VectorQuantity,
    read_list,
)
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.element import Element, FrameRef
from symbody.model.numeric_checks import NumericChecks, check_axis, positive_length
from symbody.model.simple_rotation import Axis, read_axis

E = TypeVar("E", bound=Declared)


class AttachedFrame(Field[FrameLike, FrameRef]):
    """A frame of a body or of the ground."""

    role: ClassVar[str] = "frame"
    takes: ClassVar[str] = "Body, frame or name"
    annotation: ClassVar[str] = "FrameLike"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> FrameRef:
        """Return the address."""
        return read_frame_ref(arguments, value, path)


class Directions(Field[Iterable[AxisLike], tuple[Axis, Axis]]):
    """A direction in start and one in end."""

    role: ClassVar[str] = "directions"
    takes: ClassVar[str] = "(axis, axis)"
    annotation: ClassVar[str] = "Axes"
    explanation: ClassVar[str] = "Each is a letter, or three components of any length."

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> tuple[Axis, Axis]:
        """Return two directions."""
        why = "the first is fixed in start, the second in end"
        items = read_list(arguments, value, path, 2, "directions", why, 'write axes = ["z", "z"]')
        first, second = (
            read_axis(arguments, item, f"{path}[{k}]") for k, item in enumerate(items or ("z", "z"))
        )
        return (first, second)

    def formula_sites(self, owner: object, value: tuple[Axis, Axis], path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        for k, axis in enumerate(value):
            if not isinstance(axis, str):
                yield from component_sites(f"{path}[{k}]", axis, Scope.CONSTANT)

    def directions(self, value: tuple[Axis, Axis], path: str) -> dict[str, Axis]:
        """Return both directions after their places."""
        return {f"{path}[{k}]": axis for k, axis in enumerate(value)}

    def check_numbers(self, check: NumericChecks, owner: Any, value: tuple[Axis, Axis], where: str) -> None:
        """Refuse directions of length zero."""
        for k, axis in enumerate(value):
            if not isinstance(axis, str):
                check_axis(check, axis, f"{where}[{k}]")


@dataclass(frozen=True, eq=False, repr=False)
class VanishingFormulas(Field[Value | Iterable[Value], tuple[Formula, ...]]):
    """What vanishes: one formula or several."""

    role: ClassVar[str] = "equations"
    takes: ClassVar[str] = "formula or list of formula"
    annotation: ClassVar[str] = "Value | Iterable[Value]"

    scope: Scope = Scope.MOTION

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return the formulas."""
        if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
            return (arguments.formula(value, path),)
        items = arguments.items(value, path)
        if not items:
            why = "a constraint consists of left-hand sides that are 0"
            arguments.add("model.empty", path, "there is no equation", why, 'write equations = ["x - y"]')
        return tuple(arguments.formula(item, f"{path}[{k}]") for k, item in enumerate(items))

    def formula_sites(self, owner: object, value: tuple[Formula, ...], path: str) -> Iterator[FormulaSite]:
        """Return where the equations stand."""
        return (FormulaSite(f"{path}[{k}]", formula, self.scope) for k, formula in enumerate(value))


@dataclass(frozen=True, eq=False, repr=False)
class Coupled(Field[Iterable[str], tuple[str, ...]]):
    """The coordinates of joints that a constraint couples."""

    role: ClassVar[str] = "coupled"
    takes: ClassVar[str] = "list of str"
    annotation: ClassVar[str] = "Iterable[str]"

    count: int = 2

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[str, ...]:
        """Return as many different names."""
        why = "each wheel, rack or shaft moves with one coordinate"
        items = read_list(arguments, value, path, self.count, "coordinates", why, "name one for each")
        names = tuple(_coupled_name(arguments, item, f"{path}[{k}]") for k, item in enumerate(items or ()))
        for name in sorted({name for name in names if names.count(name) > 1 and name != "?"}):
            what = f"{name} is listed {names.count(name)} times"
            why = "a coordinate coupled to itself cannot move"
            arguments.add("model.coupled_twice", path, what, why, "name different coordinates")
        return names if items else ("?",) * self.count

    def formula_sites(self, owner: object, value: tuple[str, ...], path: str) -> Iterator[FormulaSite]:
        """Return where the names stand."""
        for k, name in enumerate(value):
            yield FormulaSite(f"{path}[{k}]", Formula.from_value(name), Scope.COORDINATE)


def _coupled_name(arguments: Arguments, item: object, path: str) -> str:
    if item != "":
        return arguments.symbol_name(item, path)
    cure = "name the coordinate of a joint, such as theta"
    arguments.add(
        "model.not_coupled", path, "there is no coordinate", "an end of the coupling is not connected", cure
    )
    return "?"


class Radii(Field[Iterable[Value], tuple[Formula, ...]]):
    """The radii of two pulleys."""

    role: ClassVar[str] = "radii"
    takes: ClassVar[str] = "(2,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return two formulas."""
        items = read_list(arguments, value, path, 2, "values", "there are two pulleys", "give one for each")
        return tuple(arguments.formula(item, f"{path}[{k}]") for k, item in enumerate(items or (1, 1)))

    def formula_sites(self, owner: object, value: tuple[Formula, ...], path: str) -> Iterator[FormulaSite]:
        """Return where the radii stand."""
        return (FormulaSite(f"{path}[{k}]", radius, Scope.CONSTANT) for k, radius in enumerate(value))

    def check_numbers(self, check: NumericChecks, owner: Any, value: tuple[Formula, ...], where: str) -> None:
        """Refuse radii that are not above zero."""
        fits = positive_length("the directions of rotation are given by the angles and by crossed")
        for k, radius in enumerate(value):
            fits(check, radius, f"{where}[{k}]")


class CurvePoint(VectorQuantity):
    """A point of a curve, whose parameter the element names."""

    role: ClassVar[str] = "vector"

    def formula_sites(self, owner: Any, value: Triple, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas of the curve stand."""
        for k, formula in enumerate(value):
            yield FormulaSite(f"{path}[{k}]", formula, Scope.PRESCRIBED, (owner.parameter,))


# A type checker has to see all roles whose fields may be without default.
@dataclass_transform(
    field_specifiers=(
        Field, ElementName, SymbolName, Quantity, AngleQuantity, VectorQuantity, Direction, Flag,
        AttachedFrame, Directions, VanishingFormulas, Coupled, CurvePoint, Radii, SymbolElementName,
    )
)  # fmt: skip
def element(kind: type[E]) -> type[E]:
    """Return a class as one that declares its arguments by the roles of this file and of `fields`."""
    return declare(kind)


@element
class Connection(Element):
    """An element between two frames, `start` and `end`."""

    start: AttachedFrame = AttachedFrame("The frame at its start.", place="between[0]")
    end: AttachedFrame = AttachedFrame("The frame at its end.", place="between[1]")

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Each direction by the place where it stands."""
        places: dict[str, Axis] = {}
        for name, field in self.fields.items():
            places |= field.directions(getattr(self, name), name)
        return places
