"""The roles that arguments of every kind of element have: quantities, vectors, directions, choices."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, Generic, NamedTuple, TypeAlias, TypeVar, dataclass_transform

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import ListOf, OptionalField, list_of
from symbody.model.declarations.declaration import Declared, declare, file_table
from symbody.model.declarations.field import (
    Field,
    FileTable,
    FileTarget,
    Given,
    Kept,
    NewNames,
    Node,
    PlainField,
)
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.declarations.misfits import (
    FORMULA_SCHEMA,
    Misfit,
    Path,
    Schema,
    formula_misfits,
    list_misfits,
    text_misfits,
    wrong_type,
)
from symbody.model.numeric_checks import NumberCheck, NumericChecks, check_axis
from symbody.model.simple_rotation import LETTERS, Axis, read_axis

L = TypeVar("L", bound=str)
D = TypeVar("D", bound=Declared)
AxisLike = str | Iterable[Value]
# What elements hold of numbers or formulas that may be left out, and of lists of them.
OptionalQuantity: TypeAlias = OptionalField[Value, Formula]
Formulas: TypeAlias = ListOf[Iterable[Value], tuple[Formula, ...]]

THREE_FORMULAS: Final = {"type": "array", "items": FORMULA_SCHEMA, "minItems": 3, "maxItems": 3}
_AXIS: Final = '"x", "y", "z", or three components'


class TextField(PlainField[Given, Kept]):
    """A role whose values are texts."""

    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    def schema(self) -> Schema:
        """Return a string."""
        return {"type": "string"}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a text."""
        return text_misfits(entry, path)


class ElementName(TextField[str, str]):
    """The name of an element."""

    role: ClassVar[str] = "name"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the name in composed letters."""
        return arguments.element_name(value, path)

    def rename(self, value: Any, names: NewNames) -> str:
        """Return the new name of the element."""
        return names.element_name(value)


class SymbolName(TextField[str, str]):
    """The name of a coordinate that an element brings with it."""

    role: ClassVar[str] = "symbol"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the name as formulas contain it."""
        return arguments.symbol_name(value, path)

    def rename(self, value: Any, names: NewNames) -> str:
        """Return the new name of the symbol."""
        return names.symbol(value)


class SymbolElementName(SymbolName):
    """The name of an element that formulas contain."""

    role: ClassVar[str] = "name"


class OutputText(TextField[str, str | None]):
    """The name of an output of the mechanism."""

    role: ClassVar[str] = "text"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str | None:
        """Return the name without blanks about it."""
        if isinstance(value, str) and value.strip():
            return value.strip()
        why = "an output is named as in notation.md"
        cure = 'write for instance "frame r Foot.heel ground ground z"'
        arguments.add("model.not_a_text", path, f"{value!r} is not a name of an output", why, cure)
        return None

    def rename(self, value: Any, names: NewNames) -> str:
        """Return the output in the new names."""
        return names.output(value)


class Text(TextField[str, str]):
    """A text of any kind."""

    role: ClassVar[str] = "text"

    def read(self, owner: object, arguments: Arguments, value: Any, path: str) -> str:
        """Return the text as it is."""
        return str(value)


@dataclass(frozen=True, eq=False, repr=False)
class Folder(Text):
    """The directory in which paths of the element begin; of a model file its own."""

    _: KW_ONLY
    default: Any = ""
    is_content: bool = False


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
    meaning: ClassVar[str] = "A number, or a formula in the names allowed there."

    _: KW_ONLY
    scope: Scope = Scope.CONSTANT
    fits: NumberCheck | None = None

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Formula:
        """Return the formula."""
        formula = arguments.formula(value, path)
        has_angles = "rad" in self.unit or not self.unit or self.scope is Scope.LOAD
        if formula.is_in_degrees and not has_angles:
            what = f"{formula} is not a value in {self.unit}"
            why = "deg is allowed for angles only"
            arguments.add("model.not_an_angle", path, what, why, "write the value in SI units")
        return formula

    def schema(self) -> Schema:
        """Return a string or number."""
        return {**FORMULA_SCHEMA, "description": self.meaning}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a formula."""
        return formula_misfits(entry, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the formula."""
        node: Formula = value
        return node

    def rename(self, value: Any, names: NewNames) -> Formula:
        """Return the formula in the new names."""
        return names.formula(value)

    def formula_sites(self, owner: object, value: Formula, path: str) -> Iterator[FormulaSite]:
        """Return where the formula stands."""
        yield FormulaSite(path, value, self.scope, (), self.unit)

    def check_numbers(self, check: NumericChecks, owner: object, value: Formula, where: str) -> None:
        """Note a value that does not fit."""
        if self.fits is not None:
            self.fits(check, value, where)


class AngleQuantity(Quantity):
    """A number or formula in radians; a text may be in degrees."""

    role: ClassVar[str] = "angle"
    meaning: ClassVar[str] = 'An angle in rad, or a text such as "30 deg".'

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Formula:
        """Return the formula [rad]."""
        return arguments.formula(value, path)


@dataclass(frozen=True, eq=False, repr=False)
class VectorQuantity(ListOf[Iterable[Value], Triple]):
    """Three numbers or formulas."""

    role: ClassVar[str] = "vector"
    takes: ClassVar[str] = "(3,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    _: KW_ONLY
    scope: Scope = Scope.CONSTANT
    item: Any = field(default_factory=Quantity)
    count: int | None = 3

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Triple:
        """Return three formulas."""
        return arguments.triple(value, path)

    def formula_sites(self, owner: object, value: Triple, path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        return component_sites(path, value, self.scope, self.unit)


class Direction(Field[AxisLike, Axis]):
    """A direction: a letter, or components."""

    role: ClassVar[str] = "direction"
    takes: ClassVar[str] = "str or (3,) number or formula"
    annotation: ClassVar[str] = "str | Iterable[Value]"
    explanation: ClassVar[str] = '"x", "y", "z", or components of any length.'

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Axis:
        """Return a letter or three formulas."""
        return read_axis(arguments, value, path)

    def schema(self) -> Schema:
        """Return a letter or an array of three."""
        return {
            "anyOf": [{"enum": [*LETTERS]}, THREE_FORMULAS],
            "description": "A letter, or components of a vector of any length.",
        }

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a text or three formulas; which letters there are is seen later."""
        if isinstance(entry, str):
            return ()
        if isinstance(entry, list) and len(entry) == 3:
            return list_misfits(entry, path, formula_misfits)
        return wrong_type(entry, path, _AXIS)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the letter or the components."""
        node: Node = value if isinstance(value, str) else list(value)
        return node

    def rename(self, value: Any, names: NewNames) -> Axis:
        """Return the components in the new names."""
        if isinstance(value, str):
            return value
        x, y, z = map(names.formula, value)
        return (x, y, z)

    def formula_sites(self, owner: object, value: Axis, path: str) -> Iterator[FormulaSite]:
        """Return where the components stand."""
        return iter(()) if isinstance(value, str) else component_sites(path, value, Scope.CONSTANT)

    def directions(self, owner: object, value: Axis, path: str) -> Iterator[tuple[str, Axis]]:
        """Return the direction after its place."""
        yield path, value

    def check_numbers(self, check: NumericChecks, owner: object, value: Axis, where: str) -> None:
        """Refuse a direction of length zero."""
        if not isinstance(value, str):
            check_axis(check, value, where)


class Flag(PlainField[bool, bool]):
    """True or false."""

    role: ClassVar[str] = "flag"
    takes: ClassVar[str] = "bool"
    annotation: ClassVar[str] = "bool"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> bool:
        """Return a truth value."""
        if isinstance(value, bool) or type(value).__name__ == "bool_":  # NumPy's
            return bool(value)
        what = f"{value!r} is neither true nor false"
        arguments.add("model.not_a_flag", path, what, "", "write true or false")
        return False

    def schema(self) -> Schema:
        """Return a boolean."""
        return {"type": "boolean"}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being true or false."""
        return () if isinstance(entry, bool) else wrong_type(entry, path, "true or false")


@dataclass(frozen=True, eq=False, repr=False)
class WordChoice(TextField[L, L], Generic[L]):
    """One of some words.

    Attributes
    ----------
    words : tuple of str
        What may be chosen; the first stands for what is none of them.
    """

    role: ClassVar[str] = "choice"

    _: KW_ONLY
    words: tuple[L, ...] = field(default=())

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> L:
        """Return the word."""
        for word in self.words:
            if isinstance(value, str) and value == word:
                return word
        choices = " or ".join(repr(word) for word in self.words)
        what = f"{path} = {value!r} is not a valid choice"
        arguments.add("model.curve_kind", path, what, "", f"write {choices}")
        return self.words[0]

    def schema(self) -> Schema:
        """Return one of the words."""
        return {"type": "string", "enum": [*self.words]}


@dataclass(frozen=True, eq=False, repr=False)
class Numbers(ListOf[Iterable[Value], tuple[Formula, ...]]):
    """A list of numbers."""

    role: ClassVar[str] = "numbers"
    takes: ClassVar[str] = "(N,) numbers"
    annotation: ClassVar[str] = "Iterable[Value]"

    _: KW_ONLY
    item: Any = field(default_factory=Quantity)

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return the numbers as formulas."""
        formulas = ListOf.read(self, owner, arguments, value, path)
        for k, formula in enumerate(formulas):
            if formula.names:
                why = "a curve consists of numbers, so that its slopes can be computed once"
                fix = "write a number; scale a curve by a formula with interp1"
                arguments.add("model.curve_number", f"{path}[{k}]", f"{formula} is not a number", why, fix)
        return formulas

    def formula_sites(self, owner: object, value: object, path: str) -> Iterator[FormulaSite]:
        """Return nothing: numbers contain no names."""
        return iter(())


class FilePath(TextField[str | os.PathLike[str], str]):
    """The path of a file of the owner, which leads to it from other folders by `path_from`.

    Whether the file is there is seen when it is read.
    """

    role: ClassVar[str] = "path"
    takes: ClassVar[str] = "str or path"
    annotation: ClassVar[str] = "str | os.PathLike[str]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> str:
        """Return the path as text."""
        text = os.fsdecode(value) if isinstance(value, str | os.PathLike) else ""
        if not text.strip() or not text.isprintable():
            fix = 'write the path of a file, such as "meshes/link.stl"'
            arguments.add("model.mesh_path", path, f"{value!r} is not the path of a file", "", fix)
        return text

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the path from the folder of the file that is written."""
        path: str = value if target.folder is None else owner.path_from(target.folder)
        return path


@dataclass_transform(
    field_specifiers=(
        Field, ElementName, SymbolName, Text, FilePath, Quantity, AngleQuantity, Numbers, VectorQuantity,
        Direction, Flag, list_of,
    )
)  # fmt: skip
def part(kind: type[D]) -> type[D]:
    """Return a class as one that declares its arguments by the roles above."""
    return declare(kind)


P = TypeVar("P", bound=Declared)


class Refusal(NamedTuple):
    """A fault; `what` contains ``{value}`` where what is wrong is shown."""

    code: str
    what: str = ""
    fix: str = ""
    why: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class DeclaredPart(Field[P, P], Generic[P]):
    """A part of an element, which is a table of its own in a file.

    Attributes
    ----------
    kind : type
        Its class.
    refusal : Refusal
        The fault of something else in its place.
    """

    role: ClassVar[str] = "part"
    takes: ClassVar[str]
    annotation: ClassVar[str]

    _: KW_ONLY
    kind: Any = None
    refusal: Refusal = Refusal("")

    def __post_init__(self) -> None:
        """Take over the name of the class."""
        for word in ("takes", "annotation"):
            object.__setattr__(self, word, self.kind.__name__)

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> P:
        """Return the part; an empty one stands for something else."""
        if not isinstance(value, self.kind):
            code, what, fix, why = self.refusal
            arguments.add(code, path, what.format(value=repr(value)), why, fix)
        part: P = value if isinstance(value, self.kind) else self.kind()
        return part

    def schema(self) -> Schema:
        """Return the name of its table."""
        return self._table.reference

    def tables(self) -> Iterable[FileTable]:
        """Return its table."""
        return (self._table,)

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the table."""
        return self._table.misfits(entry, path)

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the part that a table describes; an empty one for a table with faults."""
        return read_part(self.kind, entry, arguments, path, folder) or self.kind()

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return its table."""
        return target.part(value)

    def rename(self, value: Any, names: NewNames) -> P:
        """Return the part in the new names."""
        part: P = value.rename(names)
        return part

    def formula_sites(self, owner: Any, value: Any, path: str) -> Iterator[FormulaSite]:
        """Return where its formulas stand."""
        sites: Iterator[FormulaSite] = value.formula_sites(path)
        return sites

    def check_numbers(self, check: NumericChecks, owner: Any, value: Any, where: str) -> None:
        """Note its numbers that cannot be."""
        value.check_numbers(check, where)

    @property
    def _table(self) -> FileTable:
        return file_table(self.kind, f"{self.kind.__name__}Entry")


def read_part(kind: type[P], entry: object, arguments: Arguments, path: str, folder: str) -> P | None:
    """Return the part that a table describes; its faults are placed below `path`, with None for them."""
    if not isinstance(entry, Mapping):
        return None
    return arguments.attempt(lambda: kind.from_entry(entry, "", folder), path)
