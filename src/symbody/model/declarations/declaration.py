"""How elements declare themselves: every argument once, as a `Field` with unit, default and one sentence.

`declared` makes a frozen dataclass of a class with such fields. The constructor and its signature, the
documentation, the entry of the model file and the forms of the diagram editor follow from them.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import reprlib
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import wraps
from types import MappingProxyType
from typing import Any, ClassVar, Final, Generic, Never, Self, TypeVar, overload

from symbody.arguments import call_problem
from symbody.errors import CallError, Problem, SymbodyError, UsageError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.formula_site import FormulaSite
from symbody.model.numeric_checks import NumericChecks
from symbody.model.simple_rotation import Axis
from symbody.notebook import Displayed

Given = TypeVar("Given", contravariant=True)
Kept = TypeVar("Kept", covariant=True)
C = TypeVar("C", bound="Declared")

REQUIRED: Final = object()
_WIDTH: Final = 100
_POSITIONAL: Final = frozenset(("name", "start", "end"))  # arguments without their names in `repr`
_IN_WORDS: Final = MappingProxyType({"str": "a text", "bool": "true or false"})


@dataclass(frozen=True, eq=False, repr=False)
class Field(Generic[Given, Kept]):
    """One argument of an element: a constructor takes `Given`, the element holds `Kept`.

    A subclass is a role: it says how a value is read, where its formulas stand, and what fits.

    Attributes
    ----------
    role : str
        The word for what it is: ``"direction"``.
    takes, annotation : str
        What the constructor takes, as documentation and as signatures write it.
    explanation : str
        A sentence for every field of the role.
    sentence : str
        What this one is.
    default : object
        Of the argument; REQUIRED if there is none.
    unit : str
        Of its value; "" if it has none, or several, which the sentence then contains.
    place : str
        Where it stands in an entry of the model file, if that is not its name.
    is_content : bool
        Whether it is written to files and counts where elements are compared.
    """

    role: ClassVar[str]
    takes: ClassVar[str]
    annotation: ClassVar[str]
    explanation: ClassVar[str] = ""

    sentence: str = ""
    _: KW_ONLY
    default: Any = REQUIRED
    unit: str = ""
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

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> Kept:
        """Return what is kept of an argument; the owner holds what stands before it."""
        raise NotImplementedError(self.role)

    def formula_sites(self, owner: Any, value: Any, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas of the value stand."""
        return iter(())

    def check_numbers(self, check: NumericChecks, owner: Any, value: Any, where: str) -> None:
        """Note numbers that cannot be, as far as parameters have values."""

    def directions(self, value: Any, path: str) -> dict[str, Axis]:
        """Return the directions of the value by the places where they stand."""
        return {}

    def default_value(self, owner: object, name: str) -> object:
        """Return what is kept of the default; REQUIRED if there is none."""
        return REQUIRED if self.is_required else self.read(owner, Arguments(""), self.default, name)

    @property
    def is_required(self) -> bool:
        """Whether the argument has no default."""
        return self.default is REQUIRED

    @property
    def description(self) -> str:
        """The sentence with the unit behind its first part."""
        if not self.unit or not self.sentence:
            return f"[{self.unit}]" if self.unit else self.sentence
        first, mark, rest = self.sentence.removesuffix(".").partition(";")
        return f"{first} [{self.unit}]{mark}{rest}."


class Declared(Displayed):
    """What declares its arguments.

    Attributes
    ----------
    fields : mapping of name to Field
        The arguments, in the order of the constructor.
    """

    __slots__ = ()

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]
    fields: ClassVar[Mapping[str, Field[Any, Any]]] = MappingProxyType({})

    def __post_init__(self) -> None:
        """Read the arguments, in their order.

        Raises
        ------
        ModelError
            With everything that is wrong with them.
        """
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

    def _formula_sites(self, before: str = "") -> Iterator[FormulaSite]:
        """Return where the formulas stand; `before` begins each path."""
        for name, field in self.fields.items():
            yield from field.formula_sites(self, getattr(self, name), f"{before}{field.place or name}")

    def _check_numbers(self, check: NumericChecks, before: str) -> None:
        """Note numbers that cannot be, as far as parameters have values; `before` begins each place."""
        for name, field in self.fields.items():
            field.check_numbers(check, self, getattr(self, name), f"{before}{field.place or name}")

    def _misfit(self, name: str, value: object) -> Problem:
        fits = self.fields[name].takes
        try:
            shown = reprlib.repr(value)
        except Exception:  # whatever it is, it is not ours
            shown = "something"
        return Problem(
            "call.argument", f"{type(self).__name__}, argument {name}",
            f"{shown}, of type {type(value).__name__}, is not valid here", "",
            f"give {_IN_WORDS.get(fits, fits)}",
        )  # fmt: skip


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


class ElementPart(Declared):
    """What is declared as a part of elements: a frame, a drive, a shape."""

    __slots__ = ()

    def formula_sites(self, path: str) -> Iterator[FormulaSite]:
        """Return where the formulas stand, below `path`."""
        return self._formula_sites(f"{path}.")

    def check_numbers(self, check: NumericChecks, where: str) -> None:
        """Note numbers that cannot be, as far as parameters have values; `where` begins their places."""
        self._check_numbers(check, f"{where}.")


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
        lines += [f"{name} : {field.takes}{optional}", textwrap.indent(textwrap.fill(words, _WIDTH), "    ")]
    lines += ["", "Raises", "------", "ModelError", "    Listing everything that is not valid."]
    return "\n".join(lines) + (f"\n\nExamples\n{examples}" if examples else "\n")
