"""Kernels for sizes that are known: loops written out, calls put in, scratch in variables of its own.

The operations and their order stay, and so does every bit. What remains are assignments and choices, so that
a compiler keeps all scratch in registers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Assign,
    Call,
    Choose,
    Count,
    Expression,
    KernelTree,
    Literal,
    Part,
    Perform,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
    walk,
)

_FOLDS: Final[Mapping[str, Callable[..., int]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "neg": lambda a: -a,
    "abs": abs,
    "min": min,
    "max": max,
    "half": lambda a: a >> 1,
    "not": lambda a: not a,
}


@dataclass(frozen=True, slots=True)
class _ArrayPlace:
    """An array of the caller from an offset on, or scratch, whose entries are variables."""

    name: str
    offset: int


@dataclass(frozen=True, slots=True)
class _Turn:
    """A counter gets its value for one turn of a loop."""

    counter: str
    value: int


# A number or a condition that is known is itself.
_Value = int | Expression | _ArrayPlace


@dataclass(frozen=True, slots=True)
class _Traits:
    """Of a statement: whether it can end its kernel, and which variables it assigns."""

    returns: bool
    assigned: frozenset[str]


class _Frame:
    """One call: what its names stand for, where its result goes, and which results were met."""

    def __init__(self, tree: KernelTree, values: dict[str, _Value], result: str) -> None:
        self.tree = tree
        self.values = values
        self.result = result
        self.is_inside = False  # of a choice that is made when the kernel runs
        self.open: frozenset[str] = frozenset()  # variables that are read behind the choices around
        self.returned: list[_Value] = []

    def local(self, name: str) -> str:
        """Return the name of a local variable in the new kernel; all calls of a kernel share it."""
        return f"{self.tree.name}_{name}"


def unroll_kernel(
    kernels: Mapping[str, KernelTree], name: str, sizes: Mapping[str, int], scratch: str, new_name: str
) -> KernelTree:
    """Return one kernel for given integers, without loops, calls, and the array `scratch`.

    Raises
    ------
    ValueError
        If an index of the scratch, or the end of a loop, does not follow from the sizes; of ``while`` and
        ``break`` it never does.
    """
    tree = kernels[name]
    parameters = tuple(p for p in tree.parameters if p.name not in sizes and p.name != scratch)
    values: dict[str, _Value] = dict(sizes)
    values |= {p.name: _ArrayPlace(p.name, 0) for p in tree.parameters if p.type == Type.ARRAY}
    unroller = _Unroller(kernels, scratch)
    body = unroller.body(_Frame(tree, values, ""))
    return KernelTree(new_name, parameters, tree.result, unroller.variables, body, tree.summary)


class _Unroller:
    """Runs kernels with what is known, and writes down what is left to do."""

    def __init__(self, kernels: Mapping[str, KernelTree], scratch: str) -> None:
        self.variables: dict[str, Type] = {}
        self._kernels = kernels
        self._scratch = scratch
        self._calls = 0
        self._out: list[Statement] = []
        self._traits: dict[int, _Traits] = {}  # by the identity of statements, which the kernels keep alive

    def body(self, frame: _Frame) -> tuple[Statement, ...]:
        """Return the statements of a kernel whose arguments are given."""
        self._run(frame.tree.body, frame)
        return tuple(self._out)

    def _call(self, call: Call, frame: _Frame) -> _Value:
        """Put a kernel in, and return its result."""
        tree = self._kernels[call.kernel]
        arguments = [self._value(argument, frame) for argument in call.arguments]
        self._calls += 1
        inner = _Frame(tree, {}, f"{tree.name}_{self._calls}")
        for parameter, argument, given in zip(tree.parameters, arguments, call.arguments, strict=True):
            inner.values[parameter.name] = argument
            if isinstance(argument, Apply) or isinstance(given, ArrayEntry):  # no store changes a parameter
                variable = f"{parameter.name}_{self._calls}"
                inner.values[parameter.name] = self._assign(variable, argument, parameter.type)
        self._run(tree.body, inner)
        match inner.returned:
            case [int() as value]:
                return value
        return Variable(inner.result, tree.result) if tree.result is not None else 0

    # Statements

    def _run(self, statements: Sequence[Statement | _Turn], frame: _Frame) -> None:
        """Run statements up to the first that returns whatever happens."""
        for place, statement in enumerate(statements):
            match statement:
                case Return(value):
                    self._return(value, frame)
                    return
                case Count():
                    turns = self._turns(statement, frame)
                    if self._traits_of(statement).returns:
                        self._run((*turns, *statements[place + 1 :]), frame)
                        return
                    self._run(turns, frame)
                case Choose():
                    if self._choose(statement, statements[place + 1 :], frame):
                        return
                case _:
                    self._simple(statement, frame)

    def _simple(self, statement: Statement | _Turn, frame: _Frame) -> None:
        match statement:
            case _Turn(counter, k):
                frame.values[counter] = k
            case Assign(name, value):
                self._set(name, value, frame)
            case StoreEntry(array, index, value):
                self._store(array, index, self._expression(value, frame), frame)
            case Perform(call):
                self._call(call, frame)
            case _:
                raise ValueError(f"{type(statement).__name__} has no end that follows from the sizes")

    def _turns(self, loop: Count, frame: _Frame) -> list[Statement | _Turn]:
        """Return the body of a loop once for each value of its counter."""
        start, stop = self._integer(loop.start, frame), self._integer(loop.stop, frame)
        turns: list[Statement | _Turn] = []
        for k in range(start, stop, -1 if loop.is_downwards else 1):
            turns += [_Turn(loop.name, k), *loop.body]
        return turns

    def _choose(self, choice: Choose, following: Sequence[Statement | _Turn], frame: _Frame) -> bool:
        """Run a choice; return whether what follows it has been run with it."""
        condition = self._value(choice.condition, frame)
        if isinstance(condition, int):
            branch = choice.body if condition else choice.otherwise
            returns = any(self._traits_of(node).returns for node in branch)
            self._run((*branch, *following) if returns else branch, frame)
            return returns
        if isinstance(condition, _ArrayPlace):
            raise AssertionError(choice)
        returns = self._traits_of(choice).returns
        later = tuple(following) if returns else ()  # in the branch that does not return
        names: frozenset[str] = frozenset() if returns else self._traits_of(choice).assigned
        self._settle(names, frame)
        then, otherwise = (
            self._branch((*branch, *later), frame, names) for branch in (choice.body, choice.otherwise)
        )
        self._out.append(Choose(condition, then, otherwise))
        return returns

    def _branch(
        self, statements: Sequence[Statement | _Turn], frame: _Frame, names: frozenset[str]
    ) -> tuple[Statement, ...]:
        outside, self._out = self._out, []
        before = dict(frame.values), frame.is_inside, frame.open
        frame.is_inside, frame.open = True, frame.open | names
        self._run(statements, frame)
        frame.values, frame.is_inside, frame.open = before
        inside, self._out = self._out, outside
        return tuple(inside)

    def _settle(self, names: frozenset[str], frame: _Frame) -> None:
        """Make variables of what is known so far, where branches change it."""
        for name in sorted(names):
            value, kind = frame.values.get(name), frame.tree.variables[name]
            if isinstance(value, int):
                frame.values[name] = self._assign(frame.local(name), value, kind)
            elif value is None and kind != Type.ARRAY:
                frame.values[name] = Variable(frame.local(name), kind)

    def _set(self, name: str, value: Expression, frame: _Frame) -> None:
        result = self._value(value, frame)
        if isinstance(result, _ArrayPlace) or (isinstance(result, int) and name not in frame.open):
            frame.values[name] = result
        else:
            kind = frame.tree.variables[name]
            frame.values[name] = self._assign(frame.local(name), result, kind)

    def _return(self, value: Expression | None, frame: _Frame) -> None:
        if value is None:
            return
        result, kind = self._value(value, frame), frame.tree.result or Type.INTEGER
        if not frame.result:
            self._out.append(Return(_as_expression(result, kind)))
            return
        frame.returned.append(Literal(0, Type.INTEGER) if frame.is_inside else result)
        self._assign(frame.result, result, kind)

    def _assign(self, name: str, value: _Value, kind: Type) -> Variable:
        self.variables[name] = kind
        self._out.append(Assign(name, _as_expression(value, kind)))
        return Variable(name, kind)

    def _store(self, array: Expression, index: Expression, value: Expression, frame: _Frame) -> None:
        place = self._entry(array, index, frame)
        if isinstance(place, Variable):
            self._assign(place.name, value, Type.REAL)
        else:
            self._out.append(StoreEntry(place.array, place.index, value))

    def _traits_of(self, statement: Statement | _Turn) -> _Traits:
        if isinstance(statement, _Turn):
            return _Traits(returns=False, assigned=frozenset())
        traits = self._traits.get(id(statement))
        if traits is None:
            nodes = list(walk(statement))
            returns = any(isinstance(node, Return) for node in nodes)
            counters = {node.name for node in nodes if isinstance(node, Count)}
            assigned = frozenset(node.name for node in nodes if isinstance(node, Assign)) - counters
            traits = self._traits[id(statement)] = _Traits(returns, assigned)
        return traits

    # Expressions

    def _entry(self, array: Expression, index: Expression, frame: _Frame) -> Variable | ArrayEntry:
        base, position = self._value(array, frame), self._value(index, frame)
        if not isinstance(base, _ArrayPlace) or isinstance(position, _ArrayPlace):
            raise AssertionError(array)
        if base.name != self._scratch:
            return ArrayEntry(Variable(base.name, Type.ARRAY), _sum(position, base.offset))
        if not isinstance(position, int):
            raise ValueError(f"an index of {self._scratch} does not follow from the sizes")
        name = f"{self._scratch}_{base.offset + position}"
        self.variables[name] = Type.REAL
        return Variable(name, Type.REAL)

    def _integer(self, expression: Expression, frame: _Frame) -> int:
        value = self._value(expression, frame)
        if not isinstance(value, int):
            raise ValueError("the end of a loop does not follow from the sizes")
        return value

    def _expression(self, expression: Expression, frame: _Frame) -> Expression:
        return _as_expression(self._value(expression, frame), expression.type)

    def _value(self, expression: Expression, frame: _Frame) -> _Value:
        match expression:
            case Literal(int() as value, Type.INTEGER):
                return value
            case Literal():
                return expression
            case Variable(name):
                return frame.values[name]
            case Part(array, offset, _):
                base = self._value(array, frame)
                if not isinstance(base, _ArrayPlace):
                    raise AssertionError(expression)
                return _ArrayPlace(base.name, base.offset + self._integer(offset, frame))
            case ArrayEntry(array, index):
                return self._entry(array, index, frame)
            case Call():
                return self._call(expression, frame)
            case Apply(operator, operands, kind):
                return self._apply(operator, [self._value(x, frame) for x in operands], operands, kind)

    def _apply(
        self, operator: str, values: list[_Value], operands: Sequence[Expression], kind: Type
    ) -> _Value:
        if operator in {"and", "or"}:
            decided = operator == "or"
            if any(value is decided for value in values):
                return decided
            pairs = [(v, x) for v, x in zip(values, operands, strict=True) if not isinstance(v, bool)]
            if len(pairs) < 2:
                return pairs[0][0] if pairs else not decided
            values, operands = [v for v, _ in pairs], [x for _, x in pairs]
        elif all(isinstance(value, int) for value in values):
            if operator == "real":
                return _as_expression(values[0], Type.REAL)
            if operator in _FOLDS:
                return _FOLDS[operator](*values)
        texts = tuple(_as_expression(v, x.type) for v, x in zip(values, operands, strict=True))
        return Apply(operator, texts, kind)


def _sum(position: int | Expression, offset: int) -> Expression:
    if isinstance(position, int):
        return Literal(position + offset, Type.INTEGER)
    if offset == 0:
        return position
    return Apply("+", (position, Literal(offset, Type.INTEGER)), Type.INTEGER)


def _as_expression(value: _Value, kind: Type | None) -> Expression:
    """Return a value as an expression."""
    if isinstance(value, _ArrayPlace):
        raise AssertionError("arrays are not numbers")
    if isinstance(value, int):
        return Literal(float(value) if kind == Type.REAL else int(value), kind or Type.INTEGER)
    return value
