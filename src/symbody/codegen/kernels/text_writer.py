"""Kernel trees as text in a language: the walk over a tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from symbody.codegen.kernels import tree as syntax
from symbody.codegen.kernels.dialect import PREFIX, Arrays, KernelDialect, offset_name, size_name
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.source import KernelError
from symbody.errors import Problem

# How tightly an operator binds; a format of its own, such as a call, binds like a name.
BINDING: Final = {
    "or": 1, "and": 2, "<": 4, "<=": 4, ">": 4, ">=": 4, "==": 4, "!=": 4,
    "+": 5, "-": 5, "*": 6, "/": 6, "neg": 7,
}  # fmt: skip
NAME: Final = 9
WIDTH: Final = 110


def kernel_text(kernels: Mapping[str, syntax.KernelTree], dialect: KernelDialect) -> str:
    """Return kernels as text, each behind the kernels that it calls.

    Raises
    ------
    KernelError
        Where arrays are copies, of a call that changes arrays and is an operand: its changes would be lost.
    """
    nodes = (node for tree in kernels.values() for node in syntax.walk(tree.body))
    words = {node.operator for node in nodes if isinstance(node, syntax.Apply)}
    words |= {p.type.value for tree in kernels.values() for p in tree.parameters}
    helpers = [text for word, text in dialect.helpers.items() if word in words]
    written = ["\n".join(_KernelWriter(tree, kernels, dialect).lines()) + "\n" for tree in kernels.values()]
    return "\n".join([*helpers, *written])


def saddle_text(dialect: KernelDialect, call: str = "") -> str:
    """Return `solve_saddle` and the kernels below it as text, and behind them what calls it."""
    return kernel_text(read_kernels("solve_saddle"), dialect) + ("\n" + call if call else "")


class _KernelWriter:
    """Writes one kernel."""

    def __init__(
        self, tree: syntax.KernelTree, kernels: Mapping[str, syntax.KernelTree], dialect: KernelDialect
    ) -> None:
        self._tree = tree
        self._kernels = kernels
        self._dialect = dialect
        self._form = dialect.statements
        self._names = dialect.rename(tree)
        self._bases: dict[str, str] = {}  # of local parts, where these are places in another array

    def lines(self) -> Iterator[str]:
        """Yield the lines of the kernel."""
        lines = [
            *self._dialect.head(self._tree, self._names),
            *self._block(self._tree.body),
            self._form.end,
        ]
        for line in lines:
            yield from _wrap(line, self._dialect.continuation)

    # Statements

    def _block(self, body: tuple[syntax.Statement, ...]) -> Iterator[str]:
        for statement in body:
            for line in self._statement(statement):
                yield f"    {line}"

    def _statement(self, statement: syntax.Statement) -> Iterator[str]:
        d = self._dialect
        match statement:
            case syntax.Assign(name, value):
                yield from self._assign(name, value)
            case syntax.StoreEntry(array, index, value):
                yield self._form.store.format(value=self._text(value), **self._place_words(array, index))
            case syntax.Perform(call):
                yield self._perform(call)
            case syntax.Return(None):
                yield self._form.returns_nothing
            case syntax.Return(syntax.Call() as call) if d.arrays == Arrays.COPIES:
                yield self._assign_call(d.result, call)
                yield self._form.returns_nothing
            case syntax.Return(value) if value is not None:
                yield self._form.returns.format(value=self._text(value))
            case syntax.Leave():
                yield self._form.leave
            case _:
                yield from self._compound(statement)

    def _assign(self, name: str, value: syntax.Expression) -> Iterator[str]:
        d = self._dialect
        if isinstance(value, syntax.Part) and d.arrays != Arrays.POINTERS:
            self._bases[name], offset = self._place(value)
            yield self._form.assign.format(name=offset_name(self._name(name)), value=self._text(offset))
            if d.arrays == Arrays.COPIES:
                yield self._form.assign.format(name=size_name(self._name(name)), value=self._text(value.size))
        elif isinstance(value, syntax.Call) and d.arrays == Arrays.COPIES:
            yield self._assign_call(self._name(name), value)
        else:
            yield self._form.assign.format(name=self._name(name), value=self._text(value))

    def _assign_call(self, name: str, call: syntax.Call) -> str:
        """Return the assignment of all that a call returns, where arrays are copies."""
        changed = self._changed_arrays(call)
        targets = [name, *changed] if name else changed
        target = f"[{', '.join(targets)}]" if len(targets) > 1 else targets[0]
        return self._form.assign.format(name=target, value=self._call(call))

    def _changed_arrays(self, call: syntax.Call) -> list[str]:
        return [self._array(argument) for argument in syntax.changed_arguments(call, self._kernels)]

    def _perform(self, call: syntax.Call) -> str:
        d = self._dialect
        if d.arrays == Arrays.COPIES:
            return self._assign_call(d.result if self._kernels[call.kernel].result else "", call)
        return self._form.perform.format(value=self._text(call))

    def _compound(self, statement: syntax.Statement) -> Iterator[str]:
        match statement:
            case syntax.Count(name, start, stop, is_downwards, body):
                last = self._text(syntax.add(stop, 1 if is_downwards else -1))
                words = {"start": self._text(start), "stop": self._text(stop, BINDING["<"] + 1), "last": last}
                yield (self._form.count_down if is_downwards else self._form.count).format(
                    name=self._name(name), **words
                )
                yield from self._block(body)
            case syntax.Repeat(condition, body):
                yield self._form.repeat.format(condition=self._text(condition))
                yield from self._block(body)
            case syntax.Choose():
                yield from self._choose(statement, self._form.choose)
        if (
            end := self._form.close
            if isinstance(statement, syntax.Choose)
            else self._form.close_loop or self._form.close
        ):
            yield end

    def _choose(self, statement: syntax.Choose, first: str) -> Iterator[str]:
        yield first.format(condition=self._text(statement.condition))
        yield from self._block(statement.body)
        match statement.otherwise:
            case (syntax.Choose() as following,):
                yield from self._choose(following, self._form.choose_next)
            case (_, *_):
                yield self._form.otherwise
                yield from self._block(statement.otherwise)

    # Expressions

    def _name(self, name: str) -> str:
        return self._names.get(name, name)

    def _place(self, array: syntax.Expression) -> tuple[str, syntax.Expression]:
        """Return the array in which a part lies, and the index at which it begins."""
        match array:
            case syntax.Part(inner, offset, _):
                base, first = self._place(inner)
                return base, syntax.add(first, offset)
            case syntax.Variable(name) if name in self._bases:
                return self._bases[name], syntax.Variable(offset_name(self._name(name)), syntax.Type.INTEGER)
            case syntax.Variable(name) if self._dialect.arrays == Arrays.OFFSETS:
                return self._name(name), syntax.Variable(offset_name(self._name(name)), syntax.Type.INTEGER)
            case syntax.Variable(name):
                return self._name(name), syntax.Literal(0, syntax.Type.INTEGER)
        raise AssertionError(array)

    def _place_words(self, array: syntax.Expression, index: syntax.Expression) -> dict[str, str]:
        if self._dialect.arrays == Arrays.POINTERS:
            text = self._text(array, NAME)
        else:
            text, first = self._place(array)
            index = syntax.add(first, index)
        return {"array": text, "index": self._text(index), "next": self._text(syntax.add(index, 1))}

    def _array(self, array: syntax.Expression) -> str:
        """Return an array as an argument."""
        d, last = self._dialect, ""
        if d.arrays == Arrays.POINTERS:
            if not isinstance(array, syntax.Part):
                return self._text(array)
            base, offset = self._text(array.array, NAME), array.offset
        else:
            base, offset = self._place(array)
            if offset == syntax.Literal(0, syntax.Type.INTEGER) and not isinstance(array, syntax.Part):
                return base
        if d.arrays == Arrays.COPIES:
            last = self._text(syntax.add(offset, self._size(array)))
        return d.part.format(
            array=base, index=self._text(offset), next=self._text(syntax.add(offset, 1)), last=last
        )

    def _size(self, array: syntax.Expression) -> syntax.Expression:
        """Return the size of a part."""
        match array:
            case syntax.Part(size=size):
                return size
            case syntax.Variable(name):
                return syntax.Variable(size_name(self._name(name)), syntax.Type.INTEGER)
        raise AssertionError(array)

    def _text(self, expression: syntax.Expression, binding: int = 0) -> str:
        """Return an expression, in brackets if it binds less tightly than `binding`."""
        match expression:
            case syntax.Literal(value, kind):
                text = self._dialect.literal(value, kind)
                return f"({text})" if text.startswith("-") and binding > BINDING["+"] else text
            case syntax.Variable(name):
                return self._name(name)
            case syntax.ArrayEntry(array, index):
                return self._dialect.entry.format(**self._place_words(array, index))
            case syntax.Part():
                return self._array(expression)
            case syntax.Call():
                if self._dialect.arrays == Arrays.COPIES:
                    self._check_operand(expression)
                return self._call(expression)
            case syntax.Apply(operator, operands, kind):
                word = f"{operator} {kind.value}"  # one for integers goes first
                if word in self._dialect.words or operator in self._dialect.words:
                    text = self._dialect.words.get(word) or self._dialect.words[operator]
                    return text.format(*(self._text(operand) for operand in operands))
                return self._operation(expression, binding)

    def _call(self, call: syntax.Call) -> str:
        written = (self._array(a) if a.type == syntax.Type.ARRAY else self._text(a) for a in call.arguments)
        name = self._name(call.kernel) if call.is_parameter else f"{PREFIX}{call.kernel}"
        return f"{name}({', '.join(written)})"

    def _check_operand(self, call: syntax.Call) -> None:
        """Refuse a call whose arrays could not be returned: only an assignment takes them."""
        if syntax.changed_arguments(call, self._kernels):
            raise KernelError(
                Problem("kernel.changes_in_expression", f"kernel {self._tree.name}",
                        f"{call.kernel} changes arrays inside an expression",
                        "in this language arrays are values, and the changed ones would be lost",
                        f"assign it first: value = {call.kernel}(...)")
            )  # fmt: skip

    def _operation(self, expression: syntax.Apply, binding: int) -> str:
        operator, operands = expression.operator, expression.operands
        strength = BINDING[operator]
        symbol = self._dialect.operators.get(operator, operator)
        if len(operands) == 1:
            text = f"{symbol}{self._text(operands[0], strength)}"
        else:
            # Of reals a + (b + c) is another number than a + b + c: right operands keep their brackets.
            is_associative = operator == "+" and expression.type == syntax.Type.INTEGER
            texts = (self._text(x, strength + (k > 0 and not is_associative)) for k, x in enumerate(operands))
            text = f" {symbol} ".join(texts)
        return f"({text})" if strength < binding else text


def _wrap(line: str, continuation: str) -> Iterator[str]:
    """Break a line that is too long behind commas."""
    indent = " " * (len(line) - len(line.lstrip()) + 8)
    while len(line) > WIDTH and (place := line.rfind(", ", len(indent), WIDTH)) > 0:
        yield line[: place + 1] + continuation
        line = indent + line[place + 2 :]
    yield line
