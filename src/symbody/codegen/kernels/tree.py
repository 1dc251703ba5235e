"""Kernels as trees: what the reader makes of a file and the writers print.

Every expression has a type; conversions between them are nodes of their own, so a writer decides nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Final

from symbody.kernels.record import Record

RecordClass = type[Record]


class Type(Enum):
    """The types of values: arrays hold reals, functions are parameters only, comparing lanes gives a mask."""

    REAL = "float"
    INTEGER = "int"
    TRUTH = "bool"
    ARRAY = "Reals"
    FUNCTION = "Function"
    LANES = "Lanes"
    MASK = "mask"

    __hash__ = object.__hash__  # that of Enum is Python, and takes a tenth of the time to read kernels


# What a function given as parameter takes: t, q, u, r, p, c, out, work. It returns an integer.
FUNCTION_ARGUMENTS: Final = 8
FUNCTION_RESULTS: Final = (6, 7)  # which of them it changes


# Expressions


@dataclass(frozen=True, slots=True)
class Literal:
    """A number; infinities and NaN are literals, too."""

    value: float | int
    type: Type


@dataclass(frozen=True, slots=True)
class Variable:
    """A parameter or local variable."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class ArrayEntry:
    """One real of an array, or as many as there are lanes."""

    array: Expression
    index: Expression
    type: Type = Type.REAL


@dataclass(frozen=True, slots=True)
class Part:
    """Some entries of an array, from an offset on."""

    array: Expression
    offset: Expression
    size: Expression
    type: Type = Type.ARRAY


@dataclass(frozen=True, slots=True)
class Apply:
    """An operator or word of the language applied to operands.

    `operator` is one of ``+ - * / < <= > >= == != and or not neg``, or a word: ``abs sqrt min max is_finite
    exponent power_of_two half real integer``, and of lanes ``spread where lanes`` (how many there are).
    """

    operator: str
    operands: tuple[Expression, ...]
    type: Type


@dataclass(frozen=True, slots=True)
class Call:
    """A call of another kernel, or of a function that is a parameter."""

    kernel: str
    arguments: tuple[Expression, ...]
    type: Type | None
    is_parameter: bool = False


Expression = Literal | Variable | ArrayEntry | Part | Apply | Call

# Statements


@dataclass(frozen=True, slots=True)
class Assign:
    """A local variable becomes a value."""

    name: str
    value: Expression


@dataclass(frozen=True, slots=True)
class StoreEntry:
    """An entry of an array becomes a value."""

    array: Expression
    index: Expression
    value: Expression


@dataclass(frozen=True, slots=True)
class Count:
    """``for name in range(start, stop)``, or downwards from `start` to above `stop`."""

    name: str
    start: Expression
    stop: Expression
    is_downwards: bool
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """``while condition``."""

    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Choose:
    """``if`` and ``else``."""

    condition: Expression
    body: tuple[Statement, ...]
    otherwise: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Leave:
    """``break``."""


@dataclass(frozen=True, slots=True)
class Return:
    """``return``, with a value unless the kernel has no result."""

    value: Expression | None


@dataclass(frozen=True, slots=True)
class Perform:
    """A call of a kernel for its effect on arrays."""

    call: Call


Statement = Assign | StoreEntry | Count | Repeat | Choose | Leave | Return | Perform


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter; `is_changed` if the kernel, or one that it calls, stores into the array.

    A record is an array.
    """

    name: str
    type: Type
    is_changed: bool = False
    record: RecordClass | None = None


@dataclass(frozen=True, slots=True)
class KernelTree:
    """One kernel.

    Attributes
    ----------
    parameters : sequence of Parameter
    result : Type or None
        REAL, INTEGER or nothing.
    variables : mapping of name to Type
        Local variables in the order of their first assignment, counters of loops among them.
    body : sequence of statements
    summary : str
        First line of the docstring.
    read_only : set of str
        Local variables that are arrays into which nothing is stored.
    """

    name: str
    parameters: Sequence[Parameter]
    result: Type | None
    variables: Mapping[str, Type]
    body: tuple[Statement, ...]
    summary: str
    read_only: frozenset[str] = frozenset()


# Contents

# Names of fields by class, None for what is not a node: finding them takes longer than all the rest.
_FIELDS: Final[dict[type, tuple[str, ...] | None]] = {}


def walk(node: object) -> Iterator[object]:
    """Yield a node of a tree, or each of several, and all nodes below, each before those below it."""
    waiting = [node]
    while waiting:
        node = waiting.pop()
        if isinstance(node, tuple):
            waiting.extend(reversed(node))
            continue
        kind = type(node)
        if kind not in _FIELDS:
            _FIELDS[kind] = _inner_fields(kind) if is_dataclass(kind) else None
        names = _FIELDS[kind]
        if names is not None:
            yield node
            waiting.extend(getattr(node, name) for name in names)


def _inner_fields(kind: type) -> tuple[str, ...]:
    """Return the fields of a class of nodes that may hold nodes, the last one first."""
    leaves = {"str", "bool", "Type", "Type | None", "float | int"}
    return tuple(entry.name for entry in reversed(fields(kind)) if entry.type not in leaves)


def variable_names(node: object) -> set[str]:
    """Return the names of the variables that expressions read."""
    return {part.name for part in walk(node) if isinstance(part, Variable)}


def assigned_names(body: tuple[Statement, ...]) -> set[str]:
    """Return the names of the variables that statements assign, counters among them."""
    return {part.name for part in walk(body) if isinstance(part, Assign | Count)}


Effect = Assign | StoreEntry | Call


def effects_of(body: tuple[Statement, ...]) -> tuple[Effect, ...]:
    """Return all assignments, stores and calls, each before those inside it."""
    return tuple(part for part in walk(body) if isinstance(part, Effect))


def called_kernels(effects: Sequence[Effect]) -> set[str]:
    """Return the names of the kernels that are called."""
    return {part.kernel for part in effects if isinstance(part, Call) and not part.is_parameter}


def changed_arrays(effects: Sequence[Effect], kernels: Mapping[str, KernelTree]) -> set[str]:
    """Return the names of the arrays into which statements store, by themselves or through calls."""
    changed: set[str] = set()
    parts = {part.name: part.value for part in effects if isinstance(part, Assign)}
    for part in effects:
        if isinstance(part, StoreEntry):
            changed |= variable_names(_whole_array(part.array))
        elif isinstance(part, Call):
            for argument in changed_arguments(part, kernels):
                changed |= variable_names(_whole_array(argument))
    for name, value in reversed(parts.items()):  # a part of an array is that array
        if name in changed and isinstance(value, Part):
            changed |= variable_names(_whole_array(value))
    return changed


def changed_arguments(call: Call, kernels: Mapping[str, KernelTree]) -> list[Expression]:
    """Return the arguments into which a call stores."""
    if call.is_parameter:
        return [call.arguments[place] for place in FUNCTION_RESULTS]
    pairs = zip(call.arguments, kernels[call.kernel].parameters, strict=True)
    return [argument for argument, parameter in pairs if parameter.is_changed]


def _whole_array(array: Expression) -> Expression:
    while isinstance(array, Part):
        array = array.array
    return array


def always_returns(body: tuple[Statement, ...]) -> bool:
    """Return whether statements end with a return on every way."""
    if not body:
        return False
    last = body[-1]
    if isinstance(last, Choose):
        return always_returns(last.body) and always_returns(last.otherwise)
    return isinstance(last, Return)


def add(expression: Expression, step: Expression | int) -> Expression:
    """Return the sum of two integers without needless terms."""
    if isinstance(step, int):
        step = Literal(step, Type.INTEGER)
    if not isinstance(step, Literal):
        zero = expression == Literal(0, Type.INTEGER)
        return step if zero else Apply("+", (expression, step), Type.INTEGER)
    match expression:
        case Literal(value, kind):
            return Literal(value + step.value, kind)
        case Apply("+" | "-" as operator, (first, Literal(int() as value))):
            return add(first, (value if operator == "+" else -value) + int(step.value))
    if step.value == 0:
        return expression
    size = Literal(abs(step.value), Type.INTEGER)
    return Apply("+" if step.value > 0 else "-", (expression, size), Type.INTEGER)
