"""Kernel trees as text: the walk over a tree, and what a language has to define for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Assign,
    Call,
    Choose,
    Count,
    Expression,
    KernelTree,
    Leave,
    Literal,
    Part,
    Perform,
    Repeat,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
    walk,
)

# How tightly an operator binds; a format of its own, such as a call, binds like a name.
BINDING: Final = {
    "or": 1, "and": 2, "<": 4, "<=": 4, ">": 4, ">=": 4, "==": 4, "!=": 4,
    "+": 5, "-": 5, "*": 6, "/": 6, "neg": 7,
}  # fmt: skip
NAME: Final = 9
PREFIX: Final = "symbody_"  # of the names of all kernels
WIDTH: Final = 110

Names = Mapping[str, str]


def no_names(tree: KernelTree) -> Names:
    """Return no names: parameters and variables keep theirs."""
    return {}


class Arrays(Enum):
    """How a language refers to a part of an array."""

    POINTERS = "a part is a value, like an array: a pointer or a view"
    OFFSETS = "each array is passed with the index at which it begins"
    ADDRESSES = "an array is passed by the entry at which it begins; local parts are offsets"
    COPIES = "arrays are values: a kernel returns those that it changes; local parts are places in them"


@dataclass(frozen=True, slots=True)
class KernelDialect:
    """How one language writes kernels.

    Attributes
    ----------
    literal : callable
        Text of a number.
    head : callable
        Lines before the body of a kernel, declarations among them; it takes the names in this language.
    operators : mapping of operator to text
        Of ``+ - * / < .. and or neg``; what is missing is written as in Python.
    words : mapping of word to format
        Of the words of the language, conversions and ``not``; ``"max int"`` is that for integers.
    arrays : Arrays
    entry, part : format
        With ``array``, ``index`` (counted from 0) and ``next`` (from 1); for `part` where it begins, and
        ``last`` (from 1).
    assign, store, perform, returns, returns_nothing, leave : format
        Statements; with ``name``, ``value``, and of an entry ``array``, ``index``, ``next``.
    count, count_down, repeat, choose, choose_next : format
        First lines of compound statements; with ``name``, ``start``, ``stop``, ``last`` (the last value
        reached), ``condition``.
    otherwise, close, end : str
        Lines between both branches, behind a compound statement, behind a kernel; none if empty.
    close_loop : str
        Behind a loop, if that is not `close`.
    helpers : mapping of word to text
        What a word needs in front of the kernels, where one uses it.
    continuation : str
        Ends a line that goes on.
    result : str
        Name of the result, where arrays are copies.
    rename : callable
        Names in this language, of those parameters and variables that change theirs.
    """

    literal: Callable[[float | int, Type], str]
    head: Callable[[KernelTree, Names], Iterator[str]]
    operators: Mapping[str, str]
    words: Mapping[str, str]
    arrays: Arrays
    entry: str
    part: str
    assign: str
    store: str
    perform: str
    returns: str
    returns_nothing: str
    leave: str
    count: str
    count_down: str
    repeat: str
    choose: str
    choose_next: str
    otherwise: str
    close: str
    end: str
    close_loop: str = ""
    helpers: Mapping[str, str] = field(default_factory=dict)
    continuation: str = ""
    result: str = ""
    rename: Callable[[KernelTree], Mapping[str, str]] = no_names


def kernel_text(kernels: Mapping[str, KernelTree], dialect: KernelDialect) -> str:
    """Return kernels as text, each behind the kernels that it calls."""
    nodes = (node for tree in kernels.values() for node in walk(tree.body))
    words = {node.operator for node in nodes if isinstance(node, Apply)}
    helpers = [text for word, text in dialect.helpers.items() if word in words]
    written = ["\n".join(_KernelWriter(tree, kernels, dialect).lines()) + "\n" for tree in kernels.values()]
    return "\n".join([*helpers, *written])


def saddle_text(dialect: KernelDialect, call: str = "") -> str:
    """Return `solve_saddle` and the kernels below it as text, and behind them what calls it."""
    return kernel_text(read_kernels("solve_saddle"), dialect) + ("\n" + call if call else "")


def offset_name(array: str) -> str:
    """Return the name of the index at which an array begins."""
    return f"{array}_0"


def size_name(array: str) -> str:
    """Return the name of the number of entries of a part, where arrays are copies."""
    return f"{array}_n"


class _KernelWriter:
    """Writes one kernel."""

    def __init__(self, tree: KernelTree, kernels: Mapping[str, KernelTree], dialect: KernelDialect) -> None:
        self._tree = tree
        self._kernels = kernels
        self._dialect = dialect
        self._names = dialect.rename(tree)
        self._bases: dict[str, str] = {}  # of local parts, where these are places in another array

    def lines(self) -> Iterator[str]:
        """Yield the lines of the kernel."""
        lines = [
            *self._dialect.head(self._tree, self._names),
            *self._block(self._tree.body),
            self._dialect.end,
        ]
        for line in lines:
            yield from _wrap(line, self._dialect.continuation)

    # Statements

    def _block(self, body: tuple[Statement, ...]) -> Iterator[str]:
        for statement in body:
            for line in self._statement(statement):
                yield f"    {line}"

    def _statement(self, statement: Statement) -> Iterator[str]:
        d = self._dialect
        match statement:
            case Assign(name, value):
                yield from self._assign(name, value)
            case StoreEntry(array, index, value):
                yield d.store.format(value=self._text(value), **self._place_words(array, index))
            case Perform(call):
                yield self._perform(call)
            case Return(None):
                yield d.returns_nothing
            case Return(Call() as call) if d.arrays == Arrays.COPIES:
                yield self._assign_call(d.result, call)
                yield d.returns_nothing
            case Return(value) if value is not None:
                yield d.returns.format(value=self._text(value))
            case Leave():
                yield d.leave
            case _:
                yield from self._compound(statement)

    def _assign(self, name: str, value: Expression) -> Iterator[str]:
        d = self._dialect
        if isinstance(value, Part) and d.arrays != Arrays.POINTERS:
            self._bases[name], offset = self._place(value)
            yield d.assign.format(name=offset_name(self._name(name)), value=self._text(offset))
            if d.arrays == Arrays.COPIES:
                yield d.assign.format(name=size_name(self._name(name)), value=self._text(value.size))
        elif isinstance(value, Call) and d.arrays == Arrays.COPIES:
            yield self._assign_call(self._name(name), value)
        else:
            yield d.assign.format(name=self._name(name), value=self._text(value))

    def _assign_call(self, name: str, call: Call) -> str:
        """Return the assignment of all that a call returns, where arrays are copies."""
        changed = self._changed_arrays(call)
        targets = [name, *changed] if name else changed
        target = f"[{', '.join(targets)}]" if len(targets) > 1 else targets[0]
        return self._dialect.assign.format(name=target, value=self._text(call))

    def _changed_arrays(self, call: Call) -> list[str]:
        parameters = self._kernels[call.kernel].parameters
        pairs = zip(call.arguments, parameters, strict=True)
        return [self._array(argument) for argument, parameter in pairs if parameter.is_changed]

    def _perform(self, call: Call) -> str:
        d = self._dialect
        if d.arrays == Arrays.COPIES:
            return self._assign_call(d.result if self._kernels[call.kernel].result else "", call)
        return d.perform.format(value=self._text(call))

    def _compound(self, statement: Statement) -> Iterator[str]:
        d = self._dialect
        match statement:
            case Count(name, start, stop, is_downwards, body):
                last = self._text(add(stop, 1 if is_downwards else -1))
                words = {"start": self._text(start), "stop": self._text(stop, BINDING["<"] + 1), "last": last}
                yield (d.count_down if is_downwards else d.count).format(name=self._name(name), **words)
                yield from self._block(body)
            case Repeat(condition, body):
                yield d.repeat.format(condition=self._text(condition))
                yield from self._block(body)
            case Choose():
                yield from self._choose(statement, d.choose)
        if end := d.close if isinstance(statement, Choose) else d.close_loop or d.close:
            yield end

    def _choose(self, statement: Choose, first: str) -> Iterator[str]:
        yield first.format(condition=self._text(statement.condition))
        yield from self._block(statement.body)
        match statement.otherwise:
            case (Choose() as following,):
                yield from self._choose(following, self._dialect.choose_next)
            case (_, *_):
                yield self._dialect.otherwise
                yield from self._block(statement.otherwise)

    # Expressions

    def _name(self, name: str) -> str:
        return self._names.get(name, name)

    def _place(self, array: Expression) -> tuple[str, Expression]:
        """Return the array in which a part lies, and the index at which it begins."""
        match array:
            case Part(inner, offset, _):
                base, first = self._place(inner)
                return base, add(first, offset)
            case Variable(name) if name in self._bases:
                return self._bases[name], Variable(offset_name(self._name(name)), Type.INTEGER)
            case Variable(name) if self._dialect.arrays == Arrays.OFFSETS:
                return self._name(name), Variable(offset_name(self._name(name)), Type.INTEGER)
            case Variable(name):
                return self._name(name), Literal(0, Type.INTEGER)
        raise AssertionError(array)

    def _place_words(self, array: Expression, index: Expression) -> dict[str, str]:
        if self._dialect.arrays == Arrays.POINTERS:
            text = self._text(array, NAME)
        else:
            text, first = self._place(array)
            index = add(first, index)
        return {"array": text, "index": self._text(index), "next": self._text(add(index, 1))}

    def _array(self, array: Expression) -> str:
        """Return an array as an argument."""
        d, last = self._dialect, ""
        if d.arrays == Arrays.POINTERS:
            if not isinstance(array, Part):
                return self._text(array)
            base, offset = self._text(array.array, NAME), array.offset
        else:
            base, offset = self._place(array)
            if offset == Literal(0, Type.INTEGER) and not isinstance(array, Part):
                return base
        if d.arrays == Arrays.COPIES:
            last = self._text(add(offset, self._size(array)))
        return d.part.format(array=base, index=self._text(offset), next=self._text(add(offset, 1)), last=last)

    def _size(self, array: Expression) -> Expression:
        """Return the size of a part."""
        match array:
            case Part(size=size):
                return size
            case Variable(name):
                return Variable(size_name(self._name(name)), Type.INTEGER)
        raise AssertionError(array)

    def _text(self, expression: Expression, binding: int = 0) -> str:
        """Return an expression, in brackets if it binds less tightly than `binding`."""
        match expression:
            case Literal(value, kind):
                text = self._dialect.literal(value, kind)
                return f"({text})" if text.startswith("-") and binding > BINDING["+"] else text
            case Variable(name):
                return self._name(name)
            case ArrayEntry(array, index):
                return self._dialect.entry.format(**self._place_words(array, index))
            case Part():
                return self._array(expression)
            case Call(kernel, arguments):
                written = (self._array(a) if a.type == Type.ARRAY else self._text(a) for a in arguments)
                return f"{PREFIX}{kernel}({', '.join(written)})"
            case Apply(operator, operands, kind):
                word = f"{operator} {kind.value}"  # one for integers goes first
                if word in self._dialect.words or operator in self._dialect.words:
                    text = self._dialect.words.get(word) or self._dialect.words[operator]
                    return text.format(*(self._text(operand) for operand in operands))
                return self._operation(expression, binding)

    def _operation(self, expression: Apply, binding: int) -> str:
        operator, operands = expression.operator, expression.operands
        strength = BINDING[operator]
        symbol = self._dialect.operators.get(operator, operator)
        if len(operands) == 1:
            text = f"{symbol}{self._text(operands[0], strength)}"
        else:
            # Of reals a + (b + c) is another number than a + b + c: right operands keep their brackets.
            is_associative = operator == "+" and expression.type == Type.INTEGER
            texts = (self._text(x, strength + (k > 0 and not is_associative)) for k, x in enumerate(operands))
            text = f" {symbol} ".join(texts)
        return f"({text})" if strength < binding else text


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


def _wrap(line: str, continuation: str) -> Iterator[str]:
    """Break a line that is too long behind commas."""
    indent = " " * (len(line) - len(line.lstrip()) + 8)
    while len(line) > WIDTH and (place := line.rfind(", ", len(indent), WIDTH)) > 0:
        yield line[: place + 1] + continuation
        line = indent + line[place + 2 :]
    yield line
