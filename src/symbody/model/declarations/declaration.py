"""How elements declare themselves: every argument once, as a `Field` with unit, default and one sentence.

`declared` makes a frozen dataclass of a class with such fields. The constructor and its signature, the
documentation, the entry of the model file and the forms of the diagram editor follow from them.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import reprlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, wraps
from types import MappingProxyType
from typing import Any, ClassVar, Final, NamedTuple, Self, TypeVar

from symbody.arguments import call_problem
from symbody.errors import CallError, Problem, SymbodyError, UsageError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import list_of
from symbody.model.declarations.field import Field, FileRole, FileTable, FileTarget, NewNames, Node, TypeWord
from symbody.model.declarations.formula_site import FormulaSite
from symbody.model.numeric_checks import NumericChecks
from symbody.notebook import Displayed

C = TypeVar("C", bound="Declared")

_LINE: Final = re.compile(r"(.{1,100})(?: |$)")  # textwrap takes as long as all else that makes a class
_POSITIONAL: Final = frozenset(("name", "start", "end"))  # arguments without their names in `repr`
_IN_WORDS: Final = MappingProxyType({"str": "a text", "bool": "true or false"})
# Written to files even where they have their default: a reader looks for them.
_ALWAYS: Final = frozenset({"angles", "axes", "axis"})


class FileKey(NamedTuple):
    """Where an argument stands in an entry of a model file.

    Attributes
    ----------
    number : int or None
        In the list under its key, which then has several arguments.
    """

    name: str
    key: str
    number: int | None
    field: Field[Any, Any]


def _file_key(name: str, field: Field[Any, Any]) -> FileKey:
    key, _, number = (field.place or name).partition("[")
    return FileKey(name, key, int(number.rstrip("]")) if number else None, field)


class Declared(Displayed):
    """What declares its arguments: an element, or a part of one, as a frame, a drive, a shape.

    Attributes
    ----------
    fields : mapping of name to Field
        The arguments, in the order of the constructor.
    file_keys : tuple of FileKey
        Where they stand in an entry of a model file.
    mark : str
        What stands between it and an argument in the places of messages.
    """

    __slots__ = ()

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]
    fields: ClassVar[Mapping[str, Field[Any, Any]]] = MappingProxyType({})
    file_keys: ClassVar[tuple[FileKey, ...]] = ()
    mark: ClassVar[str] = "."

    def __post_init__(self) -> None:
        """Read the arguments, in their order; a ModelError has all that is wrong with them."""
        arguments = Arguments(self.label())
        for name, field in self.fields.items():
            value = getattr(self, name)
            try:
                kept = field.read(self, arguments, value, field.place or name)
            except SymbodyError:
                raise
            except Exception as error:  # of a value that no reader thought of, such as an array of texts
                raise UsageError(self._misfit(name, value)) from error
            object.__setattr__(self, name, kept)
        self.check(arguments)
        arguments.raise_all()

    def __eq__(self, other: object) -> bool:
        return self._content() == other._content() if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._content())

    def __repr__(self) -> str:
        texts = [
            _argument_text(value) if name in _POSITIONAL else f"{name}={_argument_text(value)}"
            for name, value in self.given_arguments().items()
        ]
        return f"{type(self).__qualname__}({', '.join(texts)})"

    def given_arguments(self) -> dict[str, Any]:
        """Return the arguments that differ from their defaults, as they are kept, by name."""
        return {
            name: value
            for name, field in self.fields.items()
            if (value := getattr(self, name)) != field.default_value(self, name)
        }

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any], label: str, folder: str = "") -> Self:
        """Return what an entry of a model file describes, or a ModelError; paths in it begin in `folder`."""
        arguments = Arguments(label)
        values: dict[str, object] = {}
        for name, key, number, field in cls.file_keys:
            if not field.is_content:
                values[name] = folder
            elif key in entry:
                item = entry[key] if number is None else entry[key][number]
                values[name] = field.from_file(item, arguments, key, folder)
        make: Callable[..., Self] = cls
        made = arguments.attempt(lambda: make(**values))
        arguments.raise_all()
        assert made is not None
        return made

    def to_entry(self, target: FileTarget) -> dict[str, Node]:
        """Return the entry of a model file, without what has its default."""
        entry: dict[str, Node] = {}
        for name, key, number, field in self.file_keys:
            value = getattr(self, name)
            if not field.is_content or (name not in _ALWAYS and value == field.default_value(self, name)):
                continue
            node = field.to_file(self, value, target)
            if node is not None:
                before = entry.get(key)
                entry[key] = node if number is None else [*(before if isinstance(before, list) else ()), node]
        return entry

    def rename(self, names: NewNames) -> Self:
        """Return a copy with new names in the place of those of a part."""
        changes: dict[str, Any] = {}
        for name, field in self.fields.items():
            value = getattr(self, name)
            changed = field.rename(value, names)
            if changed is not value:
                changes[name] = changed
        return dataclasses.replace(self, **changes) if changes else self

    def _content(self) -> tuple[object, ...]:
        """Return what counts where elements are compared."""
        return tuple(getattr(self, name) for name, field in self.fields.items() if field.is_content)

    @classmethod
    def summary(cls) -> str:
        """Return the first line of the documentation."""
        return (cls.__doc__ or "").partition("\n")[0].replace("``", "")

    def label(self) -> str:
        """Return what it is in words, the first part of the place of a fault."""
        return type(self).__name__.lower()

    def check(self, arguments: Arguments) -> None:
        """Note arguments that contradict each other."""

    def formula_sites(self, path: str = "") -> Iterator[FormulaSite]:
        """Return where the formulas stand, below `path`."""
        before = path and f"{path}."
        for name, field in self.fields.items():
            yield from field.formula_sites(self, getattr(self, name), f"{before}{field.place or name}")

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers that cannot be, as far as parameters have values; `label` begins their places."""
        for name, field in self.fields.items():
            place = f"{label}{self.mark}{field.place or name}"
            field.check_numbers(check, self, getattr(self, name), place)

    def _misfit(self, name: str, value: object) -> Problem:
        fits = self.fields[name].takes
        try:
            shown = reprlib.repr(value)
        except Exception:  # whatever it is, it is not ours
            shown = "something"
        what = f"{shown}, of type {type(value).__name__}, is not valid here"
        fix = f"give {_IN_WORDS.get(fits, fits)}"
        return Problem("call.argument", f"{type(self).__name__}, argument {name}", what, "", fix)


def _argument_text(value: object) -> str:
    """Return what an element holds as it may be given to a constructor."""
    if isinstance(value, Formula):
        return value.text if value.is_number and _is_literal(value.text) else repr(value.text)
    if isinstance(value, tuple):
        return f"({', '.join(map(_argument_text, value))}{',' * (len(value) == 1)})"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{name!r}: {_argument_text(item)}' for name, item in value.items())}}}"
    return repr(value)


def _is_literal(number: str) -> bool:
    """Return whether Python reads the same number; 60/18 it would round."""
    try:
        return math.isfinite(float(number))
    except ValueError:
        return False


def file_table(kind: type[Declared], title: str, word: str = "") -> FileTable:
    """Return the table that describes what declares its fields; `word` is its type, if it has one."""
    hashable: Any = kind  # as all classes are, which type checkers do not see
    return _make_table(hashable, title, word)


@cache
def _make_table(kind: type[Declared], title: str, word: str) -> FileTable:
    keys: dict[str, FileRole] = {}
    for _, key, number, field in kind.file_keys:
        if number is not None:
            keys[key] = list_of(type(field)("Start and end frame."), number + 1)
        elif field.is_content:
            keys[key] = field
    first: dict[str, FileRole] = {key: keys.pop(key) for key in ("name", "between", "tree") if key in keys}
    if word:
        first["type"] = TypeWord(word=word)
    return FileTable(title, kind.summary(), {**first, **keys})


def declare(kind: type[C]) -> type[C]:
    """Return a class with declared fields as a frozen dataclass with a constructor that reads them."""
    for name, value in list(vars(kind).items()):
        if isinstance(value, Field):
            given = {} if value.is_required else {"default": value.default}
            plain = dataclasses.field(**given, metadata={"declared": value})
            type.__setattr__(kind, name, plain)
    made = dataclass(frozen=True, slots=True, eq=False, repr=False)(kind)
    fields = {field.name: field.metadata["declared"] for field in dataclasses.fields(made)}
    made.fields = MappingProxyType(fields)
    made.file_keys = tuple(_file_key(name, field) for name, field in fields.items())
    hints = {name: field.annotation for name, field in fields.items()}
    made.__init__.__annotations__ = {**hints, "return": "None"}
    constructor: Callable[..., None] = type.__getattribute__(made, "__init__")
    type.__setattr__(made, "__init__", _checked_call(made, constructor))
    made.__doc__ = _documentation(made)
    return made


def _checked_call(kind: type[Declared], constructor: Callable[..., None]) -> Callable[..., None]:
    """Return a constructor whose calls with unknown, missing or too many arguments are faults of symbody."""

    @wraps(constructor)
    def construct(self: object, *given: object, **named: object) -> None:
        try:
            constructor(self, *given, **named)
        except TypeError as error:
            signature = inspect.signature(constructor)
            try:
                signature.bind(self, *given, **named)
            except TypeError:
                problem = call_problem(kind.__name__, signature, (self, *given), named, str(error))
                raise CallError(problem) from None
            raise

    return construct


def _documentation(kind: type[Declared]) -> str:
    """Return the docstring with its parameters, and with what the constructor raises, before examples."""
    text, _, examples = inspect.cleandoc(kind.__doc__ or "").partition("\n\nExamples\n")
    lines = [text, "", "Parameters", "----------"]
    for name, field in kind.fields.items():
        optional = ", optional" if field.default is None else ""
        words = " ".join(filter(None, (field.description, field.explanation)))
        lines += [f"{name} : {field.takes}{optional}", _LINE.sub(r"    \1\n", words).rstrip()]
    lines += ["", "Raises", "------", "ModelError", "    Listing everything that is not valid."]
    return "\n".join(lines) + (f"\n\nExamples\n{examples}" if examples else "\n")
