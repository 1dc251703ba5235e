"""`Field`: one argument of an element, declared by its role, which knows all that is done to its value."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from types import MappingProxyType
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Final,
    Generic,
    NamedTuple,
    Never,
    Protocol,
    Self,
    TypeVar,
    overload,
)

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.formula_site import FormulaSite
from symbody.model.declarations.misfits import (
    Misfit,
    Path,
    Schema,
    missing_key,
    unknown_key,
    wrong_type,
)
from symbody.model.numeric_checks import NumericChecks
from symbody.model.simple_rotation import Axis

if TYPE_CHECKING:
    from symbody.model.element import FrameRef

Given = TypeVar("Given", contravariant=True)
Kept = TypeVar("Kept", covariant=True)

REQUIRED: Final = object()
NULL: Final = {"type": "null"}

# What a model file consists of; formulas become text or numbers when it is written.
Node = Formula | str | bool | int | list["Node"] | dict[str, "Node"]


class NewNames(Protocol):
    """The names that elements, symbols, frames and outputs of a part get in the whole."""

    @property
    def ground(self) -> str:
        """The frame that is the ground of the part; "" if it is the ground of the whole."""
        ...

    def element_name(self, name: str, /) -> str:
        """Return the new name of an element."""
        ...

    def symbol(self, name: str, /) -> str:
        """Return the new name of a symbol."""
        ...

    def frame(self, address: FrameRef, /) -> FrameRef:
        """Return where a frame of the part is."""
        ...

    def address(self, word: str, /) -> str:
        """Return the new address of a frame, or of a contact, which has one of its own."""
        ...

    def formula(self, formula: Formula, /) -> Formula:
        """Return a formula in the new names."""
        ...

    def output(self, text: str, /) -> str:
        """Return the name of an output in the new names."""
        ...


class FileTarget(NamedTuple):
    """The file to which elements are written.

    Attributes
    ----------
    folder : str or None
        Where it stands: paths of other files lead from there; None leaves them as they are.
    is_alone : bool
        Whether it is to be read without other files, whose content it then has.
    is_script : bool
        Whether it is a script, in which parts of elements stay what they are: calls of their classes.
    """

    folder: str | None = None
    is_alone: bool = False
    is_script: bool = False

    def part(self, value: Any, word: str = "") -> Node:
        """Return a part of an element, of a file as its table, after the word for its type if it has one."""
        node: Node = value if self.is_script else {**({"type": word} if word else {}), **value.to_entry(self)}
        return node


@dataclass(frozen=True, eq=False, repr=False)
class FileRole(ABC):
    """What the value of a key in a model file is.

    Attributes
    ----------
    sentence : str
        What this one is.
    default : object
        What stands for a value that is left out; REQUIRED if it must not be.
    unit : str
        Of the value; "" if it has none, or several, which the sentence then contains.
    example : str
        What to write where something else than a list is found.
    is_nullable : bool
        Whether JSON data may have null in its place.
    """

    sentence: str = ""
    _: KW_ONLY
    default: Any = REQUIRED
    unit: str = ""
    example: str = ""
    is_nullable: bool = False

    @abstractmethod
    def schema(self) -> Schema:
        """Return the JSON Schema of the value."""

    @abstractmethod
    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what in the value is of the wrong type; which words are legal, `read` says."""

    def tables(self) -> Iterable[FileTable]:
        """Return the tables that the schema refers to."""
        return ()

    @property
    def file_default(self) -> object:
        """The default as a file would have it."""
        return list(self.default) if isinstance(self.default, tuple) else self.default

    @property
    def is_required(self) -> bool:
        """Whether there is no default."""
        return self.default is REQUIRED

    @property
    def description(self) -> str:
        """The sentence with the unit behind its first part."""
        if not self.unit or not self.sentence:
            return f"[{self.unit}]" if self.unit else self.sentence
        first, mark, rest = self.sentence.removesuffix(".").partition(";")
        return f"{first} [{self.unit}]{mark}{rest}."


@dataclass(frozen=True, eq=False, repr=False)
class Field(FileRole, Generic[Given, Kept]):
    """One argument of an element: a constructor takes `Given`, the element holds `Kept`.

    A subclass is a role: it says how a value is read and checked, what it is in a model file, and what
    becomes of the names in it.

    Attributes
    ----------
    role : str
        The word for what it is: ``"direction"``.
    takes, annotation : str
        What the constructor takes, as documentation and as signatures write it.
    explanation : str
        A sentence for every field of the role.
    place : str
        Where it stands in an entry of the model file, if that is not its name.
    is_content : bool
        Whether it is written to files and counts where elements are compared.
    """

    role: ClassVar[str]
    takes: ClassVar[str]
    annotation: ClassVar[str]
    explanation: ClassVar[str] = ""

    _: KW_ONLY
    place: str = ""
    is_content: bool = True

    # For type checkers alone, which take the argument from one and the attribute from the other: at run
    # time a slot stands in the place of the field. Never: nothing can be assigned to an element.
    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...
    @overload
    def __get__(self, owner: object, kind: type) -> Kept: ...
    def __get__(self, owner: object, kind: type) -> Kept | Self:
        return self

    def __set__(self, owner: Never, value: Given) -> None:
        raise AttributeError(self.sentence)

    @abstractmethod
    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> Kept:
        """Return what is kept of an argument; the owner holds what stands before it."""

    @abstractmethod
    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the value as a model file has it; None if it is left out."""

    @abstractmethod
    def rename(self, value: Any, names: NewNames) -> Kept:
        """Return the value with new names in the place of those of a part."""

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the argument for the constructor; other files are named from `folder`."""
        return entry

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the values in a value, each with its role and place, to which the following is handed on."""
        return ()

    def formula_sites(self, owner: Any, value: Any, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas of the value stand."""
        for role, part, at in self.parts(owner, value, path):
            yield from role.formula_sites(owner, part, at)

    def check_numbers(self, check: NumericChecks, owner: Any, value: Any, where: str) -> None:
        """Note numbers that cannot be, as far as parameters have values."""
        for role, part, at in self.parts(owner, value, where):
            role.check_numbers(check, owner, part, at)

    def directions(self, owner: Any, value: Any, path: str) -> Iterator[tuple[str, Axis]]:
        """Return the directions of the value, each after its place."""
        for role, part, at in self.parts(owner, value, path):
            yield from role.directions(owner, part, at)

    def default_value(self, owner: object, name: str) -> object:
        """Return what is kept of the default; REQUIRED if there is none."""
        return REQUIRED if self.is_required else self.read(owner, Arguments(""), self.default, name)

    def panel(self, name: str) -> dict[str, Any]:
        """Return what a form of the diagram editor shows of the argument, as JSON data."""
        return {
            "name": name,
            "place": self.place or name,
            "role": self.role,
            "unit": self.unit,
            "required": self.is_required,
            "default": None if self.is_required else self.default,
            "sentence": self.sentence,
        }


@dataclass(frozen=True, eq=False, repr=False)
class FileTable:
    """A table of a model file: its keys, each with the role of its value.

    Attributes
    ----------
    title : str
        Its name in the schema.
    """

    title: str
    summary: str
    fields: Mapping[str, FileRole]

    @property
    def reference(self) -> Schema:
        """The schema that refers to this one."""
        return {"$ref": f"#/$defs/{self.title}"}

    def schema(self) -> Schema:
        """Return the JSON Schema of the table."""
        keys: dict[str, object] = {key: _key_schema(key, field) for key, field in self.fields.items()}
        needed = [key for key, field in self.fields.items() if field.is_required]
        found = {
            "additionalProperties": False,
            "description": self.summary,
            "properties": keys,
            "required": needed,
            "title": self.title,
            "type": "object",
        }
        return {key: value for key, value in found.items() if value or key != "required"}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what in an entry has another structure: values, missing keys, then unknown ones."""
        if not isinstance(entry, dict):
            return wrong_type(entry, path, "a table")
        misfits: list[Misfit] = []
        fields, count = self.fields, 0
        for key, field in fields.items():
            if key in entry:
                count += 1
                if entry[key] is not None or not field.is_nullable:
                    misfits += field.misfits(entry[key], (*path, key))
            elif field.is_required:
                misfits.append(missing_key(path, key))
        if count < len(entry):
            misfits += [unknown_key(path, key, fields) for key in entry if key not in fields]
        return misfits


def _key_schema(key: str, field: FileRole) -> Schema:
    schema: Schema = {"anyOf": [field.schema(), NULL]} if field.is_nullable else dict(field.schema())
    choices = schema.get("anyOf", [schema])
    if not any("$ref" in choice for choice in (choices if isinstance(choices, list) else [])):
        schema["title"] = key.replace("_", " ").title()
    if field.description:
        schema["description"] = field.description
    default = field.file_default
    return schema if default is REQUIRED else {**schema, "default": default}


class PlainField(Field[Given, Kept]):
    """A role whose values a file has as they are, and which contain no names: words, flags, numbers."""

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the value."""
        node: Node = value
        return node

    def rename(self, value: Any, names: NewNames) -> Kept:
        """Return the value."""
        same: Kept = value
        return same


@dataclass(frozen=True, eq=False, repr=False)
class TypeWord(PlainField[str, str]):
    """The word for the type of an entry, which says what its other keys are."""

    role: ClassVar[str] = "type"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"

    _: KW_ONLY
    word: str = ""

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> str:
        """Return the word."""
        return self.word

    def schema(self) -> Schema:
        """Return a constant."""
        return {"const": self.word, "type": "string"}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return nothing: the word has led to its table."""
        return ()


# What other programs, and books, call our types.
OTHER_NAMES: Final = MappingProxyType(
    {
        other: ours
        for ours, others in (
            ("revolute", "hinge pin pivot rotational continuous"),
            ("prismatic", "slider slide translational linear"),
            ("spherical", "ball"),
            ("weld", "fixed rigid"),
            ("free", "floating"),
            ("universal", "cardan hooke"),
            ("constant_velocity", "rzeppa"),
            ("screw", "helical"),
            ("pin_slot", "slot"),
            ("distance", "rod link"),
            ("point_on_curve", "cam"),
            ("rolling", "wheel disc"),
            ("knife_edge", "skate blade"),
        )
        for other in others.split()
    }
)
_USUAL_TYPES: Final = MappingProxyType(
    {"block": "pid", "constraint": "distance", "joint": "revolute", "shape": "box"}
)


def typed_list_schema(tables: Mapping[str, FileTable]) -> Schema:
    """Return the schema of a list of tables, by type where there are several."""
    if len(tables) == 1:
        return {"type": "array", "items": next(iter(tables.values())).reference}
    references = {word: table.reference for word, table in tables.items()}
    mapping = {word: reference["$ref"] for word, reference in references.items()}
    discriminator = {"mapping": mapping, "propertyName": "type"}
    items = {"discriminator": discriminator, "oneOf": list(references.values())}
    return {"type": "array", "items": items}


def typed_misfits(entry: object, path: Path, kind: str, tables: Mapping[str, FileTable]) -> Iterable[Misfit]:
    """Return the misfits of an entry by the table of its type, where there are several."""
    if "" in tables:
        return tables[""].misfits(entry, path)
    if not isinstance(entry, dict):
        return wrong_type(entry, path, "a table")
    if "type" not in entry:
        cure = f'add type = "{_USUAL_TYPES[kind]}", for instance'
        return (Misfit(path, "missing_key", "'type' is missing", "", cure),)
    word = entry["type"]
    table = tables.get(word) if isinstance(word, str) else None
    if table is not None:
        return table.misfits(entry, path)
    meant = OTHER_NAMES.get(str(word).lower(), "")
    cure = f"the key is called {meant!r}" if meant in tables else nearest(str(word), tables)
    return (Misfit(path, "unknown_type", f"there is no {kind} type {str(word)!r}", "", cure),)
