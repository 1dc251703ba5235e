"""Reads one function in the kernel language as a tree, with the types of all its expressions."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Mapping
from typing import Final, NoReturn

from symbody.codegen.kernels.records import RecordReader
from symbody.codegen.kernels.source import KernelSource
from symbody.codegen.kernels.tree import (
    FUNCTION_ARGUMENTS,
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
    Parameter,
    Part,
    Perform,
    Repeat,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
    add,
    always_returns,
    assigned_names,
    variable_names,
)

_TYPES: Final = {kind.value: kind for kind in Type if kind not in {Type.TRUTH, Type.MASK}}
_CONSTANTS: Final = {"NAN": math.nan, "INFINITY": math.inf}
_ARITHMETIC: Final = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_COMPARISONS: Final = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
# Words: types of the operands (None: real or integer, all alike), and of the result (None: as the operands).
_WORDS: Final[Mapping[str, tuple[tuple[Type | None, ...], Type | None]]] = {
    "abs": ((None,), None),
    "min": ((None, None), None),
    "max": ((None, None), None),
    "sqrt": ((Type.REAL,), Type.REAL),
    "is_finite": ((Type.REAL,), Type.TRUTH),
    "exponent": ((Type.REAL,), Type.INTEGER),
    "power_of_two": ((Type.INTEGER,), Type.REAL),
    "half": ((Type.INTEGER,), Type.INTEGER),
}
_CONVERSIONS: Final = {"float": ("real", Type.REAL), "int": ("integer", Type.INTEGER)}


Signature = tuple[tuple[Parameter, ...], Type | None]


def read_signature(source: KernelSource, node: ast.FunctionDef) -> Signature:
    """Return the parameters of a function, and the type of its result."""
    parameters = tuple(_parameter(source, a) for a in node.args.args)
    returns = node.returns
    if returns is None or (isinstance(returns, ast.Constant) and returns.value is None):
        return parameters, None
    result = _type(source, returns)
    if result in {Type.ARRAY, Type.FUNCTION, Type.LANES}:
        source.refuse(
            node, f"{node.name} returns an array or a function", "store into an array that is a parameter"
        )
    return parameters, result


def _parameter(source: KernelSource, node: ast.arg) -> Parameter:
    annotation = node.annotation or node
    if isinstance(annotation, ast.Name) and annotation.id in source.records:
        return Parameter(node.arg, Type.ARRAY, record=source.records[annotation.id])
    return Parameter(node.arg, _type(source, annotation))


def _type(source: KernelSource, annotation: ast.AST) -> Type:
    if not isinstance(annotation, ast.Name) or annotation.id not in _TYPES:
        source.refuse(annotation, "this type is not in the kernel language", f"use {', '.join(_TYPES)}")
    return _TYPES[annotation.id]


class FunctionReader:
    """Reads one function."""

    def __init__(
        self, source: KernelSource, signatures: Mapping[str, Signature], node: ast.FunctionDef
    ) -> None:
        self._source = source
        self._signatures = signatures
        self._node = node
        self._parameters, self._result = signatures[node.name]
        self._given = {parameter.name: parameter.type for parameter in self._parameters}
        classes = {p.name: p.record for p in self._parameters if p.record is not None}
        self._records = RecordReader(source, classes, self._convert)
        self._variables: dict[str, Type] = {}
        self._counters: set[str] = set()

    def read(self) -> KernelTree:
        """Return the tree of the function."""
        summary = (ast.get_docstring(self._node) or "").partition("\n")[0]
        statements = self._node.body[1:] if summary else self._node.body
        body = self._block(statements)
        if self._result is not None and not always_returns(body):
            self._refuse(self._node, "the end is reached without a result", "end with a return")
        return KernelTree(self._node.name, self._parameters, self._result, self._variables, body, summary)

    def _refuse(self, node: ast.AST, what: str, fix: str) -> NoReturn:
        self._source.refuse(node, what, fix)

    # Statements

    def _block(self, nodes: Iterable[ast.stmt]) -> tuple[Statement, ...]:
        return tuple(self._statement(node) for node in nodes)

    def _statement(self, node: ast.stmt) -> Statement:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                return self._assign(node, name, value)
            case ast.Assign(targets=[ast.Subscript() | ast.Attribute() as target], value=value):
                return self._store(target, value)
            case ast.For(target=ast.Name(id=name), orelse=[]):
                return self._count(node, name)
            case ast.While(orelse=[]):
                return Repeat(self._condition(node.test), self._block(node.body))
            case ast.If():
                condition = self._condition(node.test)
                return Choose(condition, self._block(node.body), self._block(node.orelse))
            case ast.Break():
                return Leave()
            case ast.Return():
                return self._return(node)
            case ast.Expr(value=ast.Call(func=ast.Name(id="put"), args=[array, index, value])):
                entry = self._entry(array, index)
                return StoreEntry(entry.array, entry.index, self._convert(value, Type.LANES))
            case ast.Expr(value=ast.Call() as call):
                return Perform(self._call(call))
        self._refuse(node, "this statement is not in the kernel language", "see docs/kernels.md")

    def _store(self, target: ast.Subscript | ast.Attribute, value: ast.expr) -> StoreEntry:
        kind = Type.REAL
        if isinstance(target, ast.Subscript):
            entry = self._entry(target.value, target.slice)
        else:
            entry, kind = self._records.number(target)
        return StoreEntry(
            entry.array, entry.index, self._as_type(value, self._convert(value, kind), Type.REAL)
        )

    def _assign(self, node: ast.stmt, name: str, value: ast.expr) -> Assign:
        record = self._records.find(value)
        if record is not None:
            self._records.classes[name] = record.record
        expression = self._expression(value) if record is None else record.whole
        kind = expression.type
        if kind is None or kind in {Type.TRUTH, Type.FUNCTION, Type.MASK}:
            self._refuse(
                node, f"{name} becomes neither a number nor an array", "assign numbers or parts of arrays"
            )
        previous = self._type_of(name)
        if name in self._counters or name in self._given:
            self._refuse(node, f"{name} is a parameter or the counter of a loop", "use another variable")
        if previous is not None and (previous != kind or kind == Type.ARRAY):
            self._refuse(node, f"{name} is assigned as {previous.value} elsewhere", "use another variable")
        self._variables[name] = kind
        return Assign(name, expression)

    def _count(self, node: ast.For, name: str) -> Count:
        bounds: tuple[ast.expr, ast.expr]
        match node.iter:
            case ast.Call(func=ast.Name(id="range"), args=[stop]):
                bounds, step = (ast.Constant(0), stop), 1
            case ast.Call(func=ast.Name(id="range"), args=[start, stop]):
                bounds, step = (start, stop), 1
            case ast.Call(
                func=ast.Name(id="range"), args=[start, stop, ast.UnaryOp(ast.USub(), ast.Constant(1))]
            ):
                bounds, step = (start, stop), -1
            case _:
                self._refuse(
                    node, "a loop counts by range", "write range(stop), range(a, b) or range(a, b, -1)"
                )
        start_, stop_ = (self._convert(bound, Type.INTEGER) for bound in bounds)
        is_new = self._type_of(name) is None
        if not is_new and name not in self._counters:
            self._refuse(node, f"{name} is a variable, too", "use another counter")
        self._variables[name] = Type.INTEGER
        self._counters.add(name)
        body = self._block(node.body)
        if assigned_names(body) & variable_names((start_, stop_)):
            self._refuse(node, "the body changes the bounds of its loop", "copy the bound before the loop")
        return Count(name, start_, stop_, step < 0, body)

    def _return(self, node: ast.Return) -> Return:
        if self._result is None:
            if node.value is not None:
                self._refuse(node, f"{self._node.name} has no result", "declare it, or return nothing")
            return Return(None)
        if node.value is None:
            self._refuse(node, f"{self._node.name} returns a result", "return a value")
        return Return(self._convert(node.value, self._result))

    # Expressions

    def _type_of(self, name: str) -> Type | None:
        return self._given.get(name) or self._variables.get(name)

    def _condition(self, node: ast.expr) -> Expression:
        expression = self._expression(node)
        if expression.type != Type.TRUTH:
            self._refuse(node, "this is not a condition", "compare with a number")
        return expression

    def _convert(self, node: ast.expr, kind: Type) -> Expression:
        return self._as_type(node, self._expression(node), kind)

    def _as_type(self, node: ast.AST, expression: Expression, kind: Type) -> Expression:
        if expression.type == kind:
            return expression
        if kind == Type.REAL and expression.type == Type.INTEGER:
            if isinstance(expression, Literal):
                return Literal(float(expression.value), Type.REAL)
            return Apply("real", (expression,), Type.REAL)
        if kind == Type.LANES and expression.type == Type.REAL:
            return Apply("spread", (expression,), Type.LANES)
        was = expression.type.value if expression.type is not None else "nothing"
        self._refuse(node, f"a value of type {was} stands where {kind.value} is needed", "convert it")

    def _expression(self, node: ast.expr) -> Expression:
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return Literal(value, Type.INTEGER if isinstance(value, int) else Type.REAL)
            case ast.Name() | ast.Attribute() | ast.Subscript():
                return self._read(node)
            case ast.UnaryOp():
                return self._unary(node)
            case ast.BinOp(left=left, op=operator, right=right):
                return self._arithmetic(node, left, operator, right)
            case ast.BoolOp(op=operator, values=values):
                word = "and" if isinstance(operator, ast.And) else "or"
                return Apply(word, tuple(self._condition(value) for value in values), Type.TRUTH)
            case ast.Compare(left=left, ops=operators, comparators=comparators):
                return self._comparison(node, [left, *comparators], operators)
            case ast.Call():
                return self._call_or_word(node)
        self._refuse(node, "this expression is not in the kernel language", "see docs/kernels.md")

    def _read(self, node: ast.Name | ast.Attribute | ast.Subscript) -> Expression:
        """Return a variable, a constant, a field of a record or an entry of an array."""
        record = self._records.find(node)
        if record is not None:
            return record.whole
        match node:
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.Attribute():
                return self._records.value(node)
        return self._entry(node.value, node.slice)

    def _unary(self, node: ast.UnaryOp) -> Expression:
        match node.op:
            case ast.Not():
                return Apply("not", (self._condition(node.operand),), Type.TRUTH)
            case ast.USub():
                operand = self._expression(node.operand)
                if isinstance(operand, Literal):
                    return Literal(-operand.value, operand.type)
                return Apply("neg", (operand,), self._number_type(node, operand))
        self._refuse(node, "this operator is not in the kernel language", "use - or not")

    def _name(self, node: ast.expr, name: str) -> Expression:
        kind = self._type_of(name)
        if kind is not None:
            return Variable(name, kind)
        if name in self._source.constants:
            return self._source.constants[name]
        if name == "LANES":
            return Apply("lanes", (), Type.INTEGER)
        if name in _CONSTANTS:
            return Literal(_CONSTANTS[name], Type.REAL)
        self._refuse(node, f"{name} has no value here", "assign it first")

    def _entry(self, array: ast.expr, index: ast.expr) -> ArrayEntry:
        expression = self._expression(array)
        if expression.type != Type.ARRAY:
            self._refuse(array, "only arrays have entries", "declare it as Reals")
        place = self._convert(index, Type.INTEGER)
        if isinstance(array, ast.Attribute) and isinstance(expression, Part):
            return ArrayEntry(expression.array, add(expression.offset, place))
        return ArrayEntry(expression, place)

    def _number_type(self, node: ast.AST, *values: Expression) -> Type:
        kinds = {value.type for value in values}
        if Type.LANES in kinds and kinds <= {Type.REAL, Type.LANES}:
            return Type.LANES
        if not kinds <= {Type.REAL, Type.INTEGER}:
            self._refuse(node, "operands are numbers", "use entries of arrays, not arrays or conditions")
        return Type.REAL if Type.REAL in kinds else Type.INTEGER

    def _arithmetic(
        self, node: ast.BinOp, left: ast.expr, operator: ast.operator, right: ast.expr
    ) -> Expression:
        if type(operator) not in _ARITHMETIC:
            self._refuse(node, "this operator is not in the kernel language", "use + - * /")
        word = _ARITHMETIC[type(operator)]
        a, b = self._expression(left), self._expression(right)
        kind = self._number_type(node, a, b)
        if word == "/" and kind == Type.INTEGER:
            self._refuse(node, "integers are divided", "divide reals, or use half")
        return Apply(word, (self._as_type(node, a, kind), self._as_type(node, b, kind)), kind)

    def _comparison(
        self, node: ast.Compare, operands: list[ast.expr], operators: list[ast.cmpop]
    ) -> Expression:
        values = [self._expression(operand) for operand in operands]
        pairs: list[Expression] = []
        for a, operator, b in zip(values, operators, values[1:], strict=False):
            if type(operator) not in _COMPARISONS:
                self._refuse(node, "this comparison is not in the kernel language", "use < <= > >= == !=")
            kind = self._number_type(node, a, b)
            both = (self._as_type(node, a, kind), self._as_type(node, b, kind))
            result = Type.MASK if kind == Type.LANES else Type.TRUTH
            pairs.append(Apply(_COMPARISONS[type(operator)], both, result))
        return pairs[0] if len(pairs) == 1 else Apply("and", tuple(pairs), Type.TRUTH)

    def _call_or_word(self, node: ast.Call) -> Expression:
        record = self._records.find(node)
        if record is not None:
            return record.whole
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name in _CONVERSIONS and len(node.args) == 1:
            word, kind = _CONVERSIONS[name]
            value = self._expression(node.args[0])
            self._number_type(node, value)
            return value if value.type == kind else Apply(word, (value,), kind)
        if name == "part" and len(node.args) == 3:
            array = self._convert(node.args[0], Type.ARRAY)
            offset, size = (self._convert(argument, Type.INTEGER) for argument in node.args[1:])
            return Part(array, offset, size)
        if name == "exists" and len(node.args) == 1 and isinstance(node.args[0], ast.Attribute):
            return self._records.exists(node.args[0])
        if name in {"take", "where", "spread"} and name not in self._signatures:
            return self._lanes_word(node, name)
        if name in _WORDS and len(node.args) == len(_WORDS[name][0]):
            kinds, result = _WORDS[name]
            values = [self._expression(argument) for argument in node.args]
            common = self._number_type(node, *values)
            operands = tuple(self._as_type(node, v, k or common) for v, k in zip(values, kinds, strict=True))
            return Apply(name, operands, result or common)
        return self._call(node)

    def _lanes_word(self, node: ast.Call, name: str) -> Expression:
        match name, node.args:
            case "take", [array, index]:
                entry = self._entry(array, index)
                return ArrayEntry(entry.array, entry.index, Type.LANES)
            case "spread", [value]:
                return Apply(name, (self._convert(value, Type.REAL),), Type.LANES)
            case "where", [mask, first, second]:
                kinds = ((mask, Type.MASK), (first, Type.LANES), (second, Type.LANES))
                return Apply(name, tuple(self._convert(value, kind) for value, kind in kinds), Type.LANES)
        self._refuse(node, f"{name} takes other arguments", "see docs/kernels.md")

    def _call(self, node: ast.Call) -> Call:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if self._type_of(name) == Type.FUNCTION and len(node.args) == FUNCTION_ARGUMENTS:
            arrays = (self._convert(a, Type.ARRAY) for a in node.args)
            return Call(name, tuple(arrays), Type.INTEGER, is_parameter=True)
        if name not in self._signatures or node.keywords:
            self._refuse(
                node, f"{ast.unparse(node.func)} is not a kernel", "call kernels, with arguments in order"
            )
        parameters, result = self._signatures[name]
        if len(parameters) != len(node.args):
            self._refuse(node, f"{name} takes {len(parameters)} arguments", "give all of them")
        arguments = (self._argument(a, p) for a, p in zip(node.args, parameters, strict=True))
        return Call(name, tuple(arguments), result)

    def _argument(self, node: ast.expr, parameter: Parameter) -> Expression:
        if parameter.record is not None:
            place = self._records.find(node)
            if place is None or place.record is not parameter.record:
                wanted = parameter.record.__name__
                self._refuse(node, f"{parameter.name} is a record {wanted}", f"give a {wanted}")
        return self._convert(node, parameter.type)
