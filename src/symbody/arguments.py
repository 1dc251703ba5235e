"""Arguments of public functions: values of another kind than annotated are refused with a message of symbody.

The annotations alone define what a function takes; one name is a list of one. Python's own faults that leave
a function (TypeError, AttributeError, ...) are traced to the arguments that do not fit them; a fault with
arguments that fit goes on as it is. Paths are looked at before the call, because ``open(1)`` writes to the
terminal.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import reprlib
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Set
from functools import wraps
from numbers import Integral, Real
from os import PathLike
from types import NoneType, SimpleNamespace, UnionType
from typing import (
    Annotated,
    Any,
    Final,
    Literal,
    ParamSpec,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from symbody.errors import CallError, Problem, SymbodyError, UsageError, foreign_cause, nearest

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)

_SYMPY_WRITERS: Final[list[Callable[[object], str]]] = []

# What a count is kept in where it is computed with.
_LARGEST: Final = 2**63 - 1
_DEPTH: Final = 32
_NESTS: Final = frozenset({Mapping, dict, Sequence, Iterable, Collection, Set, list, tuple, set, frozenset})
_WORDS: Final[Mapping[object, str]] = {
    float: "a number", int: "a whole number", str: "a text", bool: "True or False", NoneType: "None",
    dict: "a mapping {NAME: VALUE}", Mapping: "a mapping {NAME: VALUE}", PathLike: "a path",
    type: "a class", tuple: "a tuple",
}  # fmt: skip


# Lists of names, which text would be letter by letter.
_LISTS: Final = frozenset({"Sequence[str]", "Iterable[str]"})


class _Array:
    """Stands for ArrayLike: numbers, nested as evenly as an array is."""


class _Unseen:
    """Stands for classes that annotations name and modules do not import; known by their names."""


def checked_arguments(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function whose faults name the arguments that are of another kind than it takes.

    Raises
    ------
    UsageError
        When it is called so.
    """
    texts = _texts(function)
    paths = [name for name, text in texts.items() if "Path" in text]
    lists = [(place, name) for place, name in _places(function) if _is_list_of_names(texts.get(name, ""))]
    textual = {name for name, text in texts.items() if "str" in text and "Sympy" not in text}

    @wraps(function)
    def call_with_checks(*given: P.args, **named: P.kwargs) -> R:
        if lists:
            given, named = _with_lists(lists, given, named)
        if textual and _hold_sympy((*given, *named.values())):
            given, named = _with_texts(function, textual, given, named)
        if paths:
            _refuse(function, given, named, paths)
        try:
            return function(*given, **named)
        except SymbodyError as error:
            if any(problem.code == "call.argument" for problem in error.problems):
                # What it calls has other words for its arguments.
                _refuse(function, given, named, None, error)
            raise error.with_traceback(None) from foreign_cause(error)
        except Exception as error:
            _refuse(function, given, named, None, error)
            raise

    return call_with_checks


def named_after(count: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return what lets a function take its arguments by name, but for the first ones.

    Others that are given by their places are taken as they always were, with a `DeprecationWarning` that says
    their names.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)
        parameters = list(signature.parameters.values())
        first = count + (parameters[0].name == "self")
        places = [each.name for each in parameters if each.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
        label = function.__qualname__.removesuffix(".__init__")

        @wraps(function)
        def call_by_names(*given: P.args, **named: P.kwargs) -> R:
            late = places[first : len(given)]
            if late and len(given) <= len(places):
                words = ", ".join(f"{name}=" for name in late)
                what = f"{label}: give {words} by name; their places may change in a later version"
                warnings.warn(what, DeprecationWarning, stacklevel=2)
            return function(*given, **named)

        by_name = [
            each.replace(kind=inspect.Parameter.KEYWORD_ONLY) if each.name in places[first:] else each
            for each in parameters
        ]
        vars(call_by_names)["__signature__"] = signature.replace(parameters=by_name)
        return call_by_names

    return decorate


def register_sympy_writer(write: Callable[[object], str]) -> None:
    """Set what writes expressions of SymPy as text; the room of expressions does, which stands above."""
    _SYMPY_WRITERS.append(write)


def is_sympy(value: object) -> bool:
    """Return whether a value is of a class of SymPy; SymPy need not be there."""
    kind = type(value)
    if kind.__module__ == "builtins":  # most are
        return False
    return any(str(base.__module__).startswith("sympy.") for base in kind.__mro__)


def _hold_sympy(values: Iterable[object]) -> bool:
    """Return whether an object of SymPy is among values, or among the keys, values or entries of one."""
    for value in values:
        if isinstance(value, dict | list | tuple):
            entries = (*value, *value.values()) if isinstance(value, dict) else value
            if any(map(is_sympy, entries)):
                return True
        elif is_sympy(value):
            return True
    return False


def _places(function: Callable[..., object]) -> list[tuple[int, str]]:
    """Return arguments with their places among those given without a name, beyond all if they have none."""
    has_place = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    parameters = enumerate(inspect.signature(function).parameters.values())
    return [(place if p.kind in has_place else _LARGEST, p.name) for place, p in parameters]


def _is_list_of_names(annotation: str) -> bool:
    return annotation.removesuffix(" | None") in _LISTS


def _with_lists(lists: Iterable[tuple[int, str]], given: Any, named: Any) -> Any:
    """Return arguments with a list of one name where one name stands for it, as in ``traces="Arm.tip"``."""
    for place, name in lists:
        if place < len(given) and isinstance(given[place], str):
            given = (*given[:place], (given[place],), *given[place + 1 :])
        elif isinstance(named.get(name), str):
            named = {**named, name: (named[name],)}
    return given, named


def _with_texts(function: Callable[..., Any], textual: Set[str], given: Any, named: Any) -> Any:
    """Return arguments with SymPy expressions as text where names and expressions are taken as text."""
    write = _SYMPY_WRITERS[-1]

    def convert(value: Any) -> Any:
        if is_sympy(value):
            return write(value)
        if isinstance(value, dict):
            return {convert(key): convert(item) for key, item in value.items()}
        if type(value) in (list, tuple):
            return type(value)(map(convert, value))
        return value

    signature = inspect.signature(function)
    try:
        bound = signature.bind(*given, **named)
    except TypeError:  # refused later, by name
        return given, named
    bound.arguments |= {name: convert(value) for name, value in bound.arguments.items() if name in textual}
    return bound.args, bound.kwargs


def checked_fields(kind: C) -> C:
    """Return a class whose constructor refuses arguments of another kind than it takes.

    Its own checks come first: they know more about what is wrong.
    """
    constructor: Callable[..., None] = type.__getattribute__(kind, "__init__")
    # Names and formulas are taken as text: `Value` and `Action` hold them.
    words = ("str", "Value", "Action")
    textual = {name for name, text in _texts(constructor).items() if any(word in text for word in words)}

    @wraps(constructor)
    def construct_with_checks(self: object, *given: object, **named: object) -> None:
        if textual and _hold_sympy((*given, *named.values())):
            (self, *given), named = _with_texts(constructor, textual, (self, *given), named)
        try:
            constructor(self, *given, **named)
        except SymbodyError:
            raise
        except Exception as error:
            _refuse(constructor, (self, *given), named, None, error, kind.__name__)
            raise
        _refuse(constructor, (self, *given), named, None, None, kind.__name__)

    type.__setattr__(kind, "__init__", construct_with_checks)
    return kind


def _refuse(
    function: Callable[..., object],
    given: tuple[object, ...],
    named: Mapping[str, object],
    names: Collection[str] | None,
    error: Exception | None = None,
    label: str = "",
) -> None:
    """Raise if an argument does not fit its annotation, of all or those with some names."""
    signature = inspect.signature(function)
    is_constructor = function.__name__ == "__init__" and bool(given)
    label = label or (type(given[0]).__name__ if is_constructor else function.__qualname__)
    try:
        bound = signature.bind(*given, **named).arguments
    except TypeError as misfit:
        raise CallError(call_problem(label, signature, given, named, str(misfit))) from None
    problems = []
    for name, value in bound.items():
        if names is None or name in names:
            hint = _hint(function, name)
            several = signature.parameters[name].kind is inspect.Parameter.VAR_POSITIONAL
            if not all(fits(hint, item) for item in (value if several else [value])):
                problems.append(_problem(label, name, value, hint))
    if problems:
        raise UsageError(*problems) from error and foreign_cause(error)


def call_problem(
    label: str, signature: inspect.Signature, given: Sequence[object], named: Collection[str], misfit: str
) -> Problem:
    """Return what is wrong with a call whose arguments do not fit a signature.

    Parameters
    ----------
    label : str
        The function, or the class that is made.
    misfit : str
        Python's own words, for what is neither unknown nor missing nor too many.
    """
    kinds = inspect.Parameter
    takes = [item for item in signature.parameters.values() if item.name not in ("self", "cls")]
    names = [item.name for item in takes if item.kind not in (kinds.VAR_POSITIONAL, kinds.VAR_KEYWORD)]
    unknown = [name for name in named if name not in names]
    if unknown:
        what = f"there is no argument {' or '.join(map(repr, unknown))}"
        return Problem("call.unknown_argument", label, what, "", nearest(unknown[0], names))
    placed = names[: len(given) - (len(signature.parameters) > len(takes))]
    missing = [
        item.name for item in takes
        if item.name in names and item.default is kinds.empty and item.name not in (*placed, *named)
    ]  # fmt: skip
    if missing:
        what = f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing"
        return Problem("call.missing_argument", label, what, "", f"it takes ({', '.join(names)})")
    return Problem(
        "call.arguments", label, misfit.removeprefix(f"{label}.__init__() ").removeprefix(f"{label}() "), "",
        f"it takes ({', '.join(names)})",
    )  # fmt: skip


def _problem(function: str, name: str, value: object, hint: object) -> Problem:
    kind = type(value).__name__
    return Problem(
        "call.argument", f"{function}, argument {name}",
        f"{_short_repr(value)}, of type {kind}, is not valid here", "", f"give {_words(hint)}",
    )  # fmt: skip


def _short_repr(value: object) -> str:
    try:
        return reprlib.repr(value)
    except Exception:  # whatever it is, it is not ours
        return "something"


def _texts(function: Callable[..., object]) -> dict[str, str]:
    """Return annotations as they are written."""
    return {name: str(text) for name, text in inspect.get_annotations(function).items() if name != "return"}


def _hint(function: Callable[..., object], name: str) -> object:
    """Return the annotation of an argument as an object; names that are not there become classes."""
    written = _texts(function).get(name)
    if written is None:
        return Any
    known = inspect.unwrap(function).__globals__
    used = {node.id for node in ast.walk(ast.parse(written, mode="eval")) if isinstance(node, ast.Name)}
    local: dict[str, object] = {
        word: type(word, (_Unseen,), {}) for word in used if word not in known and word not in vars(builtins)
    }
    local["ArrayLike"] = _Array
    holder = SimpleNamespace(__annotations__={name: written})
    try:
        return get_type_hints(holder, dict(known), local)[name]
    except (NameError, TypeError, AttributeError):
        return Any


def fits(hint: Any, value: object, depth: int = 0) -> bool:
    """Return whether a value is of the kind of an annotation, and so are its entries."""
    origin, args = get_origin(hint), get_args(hint)
    if depth > _DEPTH:
        return False
    if origin is Annotated:
        return fits(args[0], value, depth)
    if origin in (Union, UnionType):
        is_path = any(get_origin(kind) is PathLike for kind in args)
        return not (is_path and isinstance(value, str) and "\0" in value) and any(
            fits(kind, value, depth) for kind in args
        )
    if origin is Literal:
        return any(type(value) is type(word) and value == word for word in args)
    kind = NoneType if hint is None else origin or hint
    if not isinstance(kind, type):
        return True
    return _is_a(kind, value) and (kind not in _NESTS or _entries_fit(args, value, depth))


def _is_a(kind: type, value: object) -> bool:
    """Return whether a value is of a class, as far as numbers are concerned also of NumPy's."""
    if kind is _Array:
        return _is_numeric(value)
    if issubclass(kind, _Unseen):
        return any(own.__name__ == kind.__name__ for own in type(value).__mro__)
    if kind is int:
        return isinstance(value, Integral) and not isinstance(value, bool) and abs(int(value)) <= _LARGEST
    if kind is float:
        return isinstance(value, Real) and not isinstance(value, bool) and _is_double(value)
    try:
        return isinstance(value, kind)
    except TypeError:  # a protocol that cannot be looked for
        return True


def _is_double(value: Real) -> bool:
    try:
        float(value)
    except OverflowError:
        return False
    return True


def _entries_fit(args: tuple[Any, ...], value: Any, depth: int) -> bool:
    if isinstance(value, Mapping) and len(args) == 2:
        return all(
            fits(args[0], key, depth + 1) and fits(args[1], item, depth + 1) for key, item in value.items()
        )
    if isinstance(value, tuple) and args and args[-1] is not Ellipsis and len(args) > 1:
        return len(value) == len(args) and all(
            fits(kind, item, depth + 1) for kind, item in zip(args, value, strict=True)
        )
    if isinstance(value, bytes | bytearray):
        return False
    try:
        iter(value)
    except TypeError:  # an array without axes
        return False
    # What can be read once only is not read here.
    return not (isinstance(value, Collection) and args) or all(
        fits(args[0], item, depth + 1) for item in value
    )


def _is_numeric(value: object) -> bool:
    """Return whether NumPy makes an array of real numbers of it."""
    kind = getattr(getattr(value, "dtype", None), "kind", None)
    if kind is not None:
        return str(kind) in "biuf"
    if isinstance(value, list | tuple | range):
        return all(_is_numeric(item) for item in value) and len({_shape(item) for item in value}) < 2
    return isinstance(value, Real) and _is_double(value)


def _shape(value: object) -> tuple[int, ...]:
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple):
        return shape
    if isinstance(value, list | tuple | range):
        return (len(value), *(_shape(value[0]) if value else ()))
    return ()


def _words(hint: Any) -> str:
    """Return in words what fits an annotation."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _words(args[0])
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(_words(kind) for kind in args))
    if origin is Literal:
        return " or ".join(map(repr, args))
    kind = NoneType if hint is None else origin or hint
    if kind is _Array:
        return "numbers"
    if kind in _WORDS:
        return _WORDS[kind]
    if isinstance(kind, type) and issubclass(kind, Iterable):
        inner = [item for item in args if item is not Ellipsis]
        return f"a list, each entry {_words(inner[0])}" if inner else f"a {kind.__name__}"
    if kind is Callable or not isinstance(kind, type):
        return "a function"
    return f"an object of type {kind.__name__}"
