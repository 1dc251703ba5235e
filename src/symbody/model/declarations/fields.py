"""The roles that arguments of every kind of element have: quantities, vectors, directions, choices."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Generic, TypeVar, dataclass_transform

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.declaration import Declared, Field, declare
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.numeric_checks import NumericChecks, check_axis
from symbody.model.simple_rotation import Axis, read_axis

L = TypeVar("L", bound=str)
D = TypeVar("D", bound=Declared)
AxisLike = str | Iterable[Value]
NumberCheck = Callable[[NumericChecks, Formula, str], None]


class ElementName(Field[str, str]):
    """The name of an element."""

    role: ClassVar[str] = "name"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the name in composed letters."""
        return arguments.element_name(value, path)


class SymbolName(Field[str, str]):
    """The name of a coordinate that an element brings with it."""

    role: ClassVar[str] = "symbol"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the name as formulas contain it."""
        return arguments.symbol_name(value, path)


class SymbolElementName(ElementName):
    """The name of an element that formulas contain."""

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the name as formulas contain it."""
        return arguments.symbol_name(value, path)


@dataclass(frozen=True, eq=False, repr=False)
class OptionalText(Field[str | None, str | None]):
    """A text that may be left out."""

    role: ClassVar[str] = "text"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str | None"

    _: KW_ONLY
    default: Any = None

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str | None:
        """Return the text without blanks about it."""
        if value is None:
            return None
        if isinstance(value, str) and value.strip():
            return value.strip()
        why = "an output is named as in notation.md"
        cure = 'write for instance "frame r Foot.heel ground ground z"'
        arguments.add("model.not_a_text", path, f"{value!r} is not a name of an output", why, cure)
        return None


class Text(Field[str, str]):
    """A text of any kind."""

    role: ClassVar[str] = "text"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    def read(self, owner: object, arguments: Arguments, value: Any, path: str) -> str:
        """Return the text as it is."""
        return str(value)


@dataclass(frozen=True, eq=False, repr=False)
class Quantity(Field[Value, Formula]):
    """A number or formula.

    Attributes
    ----------
    scope : Scope
        The names that it may contain.
    fits : function, optional
        Notes a value that does not fit, as soon as parameters have values.
    """

    role: ClassVar[str] = "quantity"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value"

    _: KW_ONLY
    scope: Scope = Scope.CONSTANT
    fits: NumberCheck | None = None

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Formula:
        """Return the formula."""
        formula = arguments.formula(value, path)
        has_angles = "rad" in self.unit or not self.unit or self.scope is Scope.LOAD
        if formula.is_in_degrees and not has_angles:
            arguments.add(
                "model.not_an_angle", path, f"{formula} is not a value in {self.unit}",
                "deg is allowed for angles only", "write the value in SI units",
            )  # fmt: skip
        return formula

    def formula_sites(self, owner: object, value: Formula, path: str) -> Iterator[FormulaSite]:
        """Return where the formula stands."""
        yield FormulaSite(path, value, self.scope)

    def check_numbers(self, check: NumericChecks, owner: object, value: Formula, where: str) -> None:
        """Note a value that does not fit."""
        if self.fits is not None:
            self.fits(check, value, where)


class AngleQuantity(Quantity):
    """A number or formula in radians; a text may be in degrees."""

    role: ClassVar[str] = "angle"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Formula:
        """Return the formula [rad]."""
        return arguments.formula(value, path)


@dataclass(frozen=True, eq=False, repr=False)
class OptionalQuantity(Field[Value | None, Formula | None]):
    """A number or formula that may be left out."""

    role: ClassVar[str] = "quantity"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value | None"

    _: KW_ONLY
    default: Any = None
    scope: Scope = Scope.CONSTANT
    fits: NumberCheck | None = None

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Formula | None:
        """Return the formula, or None for None."""
        return arguments.optional_formula(value, path)

    def check_numbers(self, check: NumericChecks, owner: object, value: Formula | None, where: str) -> None:
        """Note a value that does not fit."""
        if self.fits is not None and value is not None:
            self.fits(check, value, where)

    def formula_sites(self, owner: object, value: Formula | None, path: str) -> Iterator[FormulaSite]:
        """Return where the formula stands."""
        if value is not None:
            yield FormulaSite(path, value, self.scope)


@dataclass(frozen=True, eq=False, repr=False)
class VectorQuantity(Field[Iterable[Value], Triple]):
    """Three numbers or formulas."""

    role: ClassVar[str] = "vector"
    takes: ClassVar[str] = "(3,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    _: KW_ONLY
    scope: Scope = Scope.CONSTANT

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Triple:
        """Return three formulas."""
        return arguments.triple(value, path)

    def formula_sites(self, owner: object, value: Triple, path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        return component_sites(path, value, self.scope)


class Direction(Field[AxisLike, Axis]):
    """A direction: a letter, or components."""

    role: ClassVar[str] = "direction"
    takes: ClassVar[str] = "str or (3,) number or formula"
    annotation: ClassVar[str] = "str | Iterable[Value]"
    explanation: ClassVar[str] = '"x", "y", "z", or components of any length.'

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Axis:
        """Return a letter or three formulas."""
        return read_axis(arguments, value, path)

    def formula_sites(self, owner: object, value: Axis | None, path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        return (
            iter(())
            if value is None or isinstance(value, str)
            else component_sites(path, value, Scope.CONSTANT)
        )

    def directions(self, value: Axis, path: str) -> dict[str, Axis]:
        """Return the direction after its place."""
        return {path: value}

    def check_numbers(self, check: NumericChecks, owner: object, value: Axis, where: str) -> None:
        """Refuse a direction of length zero."""
        if not isinstance(value, str):
            check_axis(check, value, where)


class OptionalDirection(Field[AxisLike | None, Axis | None]):
    """A direction that may be left out."""

    role: ClassVar[str] = "direction"
    takes: ClassVar[str] = Direction.takes
    annotation: ClassVar[str] = "str | Iterable[Value] | None"
    explanation: ClassVar[str] = Direction.explanation

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Axis | None:
        """Return a letter or three formulas, or None for None."""
        return None if value is None else read_axis(arguments, value, path)

    def formula_sites(self, owner: object, value: Axis | None, path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        return (
            iter(())
            if value is None or isinstance(value, str)
            else component_sites(path, value, Scope.CONSTANT)
        )

    def directions(self, value: Axis | None, path: str) -> dict[str, Axis]:
        """Return the direction, if there is one, after its place."""
        return {} if value is None else {path: value}

    def check_numbers(self, check: NumericChecks, owner: object, value: Axis | None, where: str) -> None:
        """Refuse a direction of length zero."""
        if not (value is None or isinstance(value, str)):
            check_axis(check, value, where)


class Flag(Field[bool, bool]):
    """True or false."""

    role: ClassVar[str] = "flag"
    takes: ClassVar[str] = "bool"
    annotation: ClassVar[str] = "bool"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> bool:
        """Return a truth value."""
        if isinstance(value, bool) or type(value).__name__ == "bool_":  # NumPy's
            return bool(value)
        arguments.add(
            "model.not_a_flag", path, f"{value!r} is neither true nor false", "", "write true or false"
        )
        return False


@dataclass(frozen=True, eq=False, repr=False)
class WordChoice(Field[L, L], Generic[L]):
    """One of some words.

    Attributes
    ----------
    words : tuple of str
        What may be chosen; the first stands for what is none of them.
    """

    role: ClassVar[str] = "choice"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    _: KW_ONLY
    words: tuple[L, ...] = field(default=())

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> L:
        """Return the word."""
        for word in self.words:
            if isinstance(value, str) and value == word:
                return word
        choices = " or ".join(repr(word) for word in self.words)
        arguments.add(
            "model.curve_kind", path, f"{path} = {value!r} is not a valid choice", "", f"write {choices}"
        )
        return self.words[0]


class Numbers(Field[Iterable[Value], tuple[Formula, ...]]):
    """A list of numbers."""

    role: ClassVar[str] = "numbers"
    takes: ClassVar[str] = "(N,) numbers"
    annotation: ClassVar[str] = "Iterable[Value]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return the numbers as formulas."""
        items = arguments.items(value, path)
        formulas = tuple(arguments.formula(item, f"{path}[{k}]") for k, item in enumerate(items))
        for k, formula in enumerate(formulas):
            if formula.names:
                arguments.add(
                    "model.curve_number",
                    f"{path}[{k}]",
                    f"{formula} is not a number",
                    "a curve consists of numbers, so that its slopes can be computed once",
                    "write a number; scale a curve by a formula with interp1",
                )
        return formulas


class FilePath(Field[str | os.PathLike[str], str]):
    """The path of a file; whether it is there is seen when it is read."""

    role: ClassVar[str] = "path"
    takes: ClassVar[str] = "str or path"
    annotation: ClassVar[str] = "str | os.PathLike[str]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the path as text."""
        text = os.fsdecode(value) if isinstance(value, str | os.PathLike) else ""
        if not text.strip() or not text.isprintable():
            arguments.add(
                "model.mesh_path", path, f"{value!r} is not the path of a file", "",
                'write the path of a file, such as "meshes/link.stl"',
            )  # fmt: skip
        return text


def read_list(
    arguments: Arguments, value: object, path: str, count: int, nouns: str, why: str, fix: str
) -> list[object] | None:
    """Return a list of `count` entries; None if it is another, or none, with a fault noted."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        arguments.items(value, path)  # notes that it is none
        return None
    items = arguments.items(value, path)
    if len(items) == count:
        return items
    noun = nouns if len(items) != 1 else nouns.removesuffix("s")
    arguments.add("model.wrong_number", path, f"{len(items)} {noun} instead of {count}", why, fix)
    return None


@dataclass_transform(
    field_specifiers=(
        Field,
        ElementName,
        SymbolName,
        Text,
        FilePath,
        Quantity,
        AngleQuantity,
        Numbers,
        VectorQuantity,
        Direction,
        Flag,
    )
)
def part(kind: type[D]) -> type[D]:
    """Return a class as one that declares its arguments by the roles above."""
    return declare(kind)
