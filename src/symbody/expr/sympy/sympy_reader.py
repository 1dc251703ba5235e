"""SymPy objects made by users, read into the graph; see `sympy_bridge` for what becomes of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import islice
from typing import Any, Final, TypeAlias

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.logic.boolalg import Boolean

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, ZERO, add, apply, div, mul, neg, power, select, sub
from symbody.expr.expression import Expr
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.language.caret import printable
from symbody.expr.written_function import WrittenFunction

try:
    from sympy.physics.vector import dynamicsymbols as time_functions
except AttributeError:  # python -OO: that module formats docstrings, which are not there
    time_functions = None
dynamicsymbols: Any = time_functions

Lookup: TypeAlias = Callable[[str, bool], Symbol]
_Rule: TypeAlias = Callable[..., int]

KERNEL_NAME: Final = "solve_saddle_{n}_{m}"


def sympy_time() -> sp.Symbol:
    """Return the symbol of time, ``dynamicsymbols._t``."""
    return sp.Symbol("t") if dynamicsymbols is None else dynamicsymbols._t


def from_sympy(expression: object, graph: Graph, lookup: Lookup | None = None) -> int:
    """Return the node of a SymPy expression, or of a number.

    Parameters
    ----------
    lookup : callable
        ``lookup(name, is_function_of_time)`` returns the symbol a name stands for; derivatives are taken
        of what it returns. By default functions of time are coordinates and plain symbols parameters.
        Time itself is ``dynamicsymbols._t`` and is not looked up.

    Raises
    ------
    ExpressionError
        For objects that are not real scalar expressions, naming them, and for two symbols of one name
        that differ in their assumptions.
    """
    return nodes_from_sympy([expression], graph, lookup)[0]


def nodes_from_sympy(expressions: Iterable[object], graph: Graph, lookup: Lookup | None = None) -> list[int]:
    """Return the nodes of several expressions, which must agree on what their names are."""
    reader = _SympyReader(graph, lookup or _default_lookup)
    return [reader.read(expression) for expression in expressions]


def _default_lookup(name: str, of_time: bool) -> Symbol:
    return Symbol(name, SymbolKind.COORDINATE if of_time else SymbolKind.PARAMETER)


class _SympyReader:
    """Reads expressions one after another; made for them and dropped."""

    __slots__ = ("_functions", "_graph", "_known", "_lookup", "_names", "_time")

    def __init__(self, graph: Graph, lookup: Lookup) -> None:
        self._graph = graph
        self._lookup = lookup
        self._time = sympy_time()
        self._functions = {function.name: place for place, function in enumerate(graph.functions)}
        # By identity: comparing deep expressions recurses. The object is kept so that its id stays its own.
        self._known: dict[int, tuple[sp.Basic, int]] = {}
        self._names: dict[tuple[str, bool], object] = {(self._time.name, False): self._time}

    def read(self, expression: object) -> int:
        root = _check_expression(expression)
        nodes = self._known
        stack: list[tuple[sp.Basic, Sequence[sp.Basic] | None]] = [(root, None)]
        while stack:
            item, arguments = stack.pop()
            if id(item) in nodes:
                continue
            if arguments is None:
                arguments = self._arguments(item)
                if arguments:
                    stack.append((item, arguments))
                    stack.extend((argument, None) for argument in arguments)
                    continue
            operands = [nodes[id(argument)][1] for argument in arguments]
            nodes[id(item)] = (item, self._node(item, arguments, operands))
        if _is_condition(root):
            raise _not_an_expression(
                root, "is true or false, not a number", "for an equation a = b give a - b; else use Piecewise"
            )
        return nodes[id(root)][1]

    def _arguments(self, item: sp.Basic) -> Sequence[sp.Basic]:
        """Return the operands of `item`; none for symbols, functions of time and derivatives."""
        if isinstance(item, sp.Piecewise):
            return [part for pair in item.args for part in pair.args]
        if isinstance(item, AppliedUndef):
            return () if self._place(item) is None and self._is_of_time(item) else item.args
        if isinstance(item, sp.Derivative | sp.Symbol | sp.Number):
            return ()
        _kind(item)  # before its arguments are read: what cannot stand here is named as a whole
        arguments: Sequence[sp.Basic] = item.args
        return arguments

    def _node(self, item: sp.Basic, arguments: Sequence[sp.Basic], operands: list[int]) -> int:
        if isinstance(item, sp.Number):
            return self._graph.constant(_value(item))
        if isinstance(item, sp.Symbol):
            return self._symbol(item)
        if isinstance(item, AppliedUndef):
            return self._read_function(item, operands)
        if isinstance(item, sp.Derivative):
            return self._derivative(item)
        kind = _kind(item)
        is_choice = kind is sp.Piecewise
        for place, argument in enumerate(arguments):
            self._check_truth(item, argument, place % 2 == 1 if is_choice else kind in _CONNECTIVES)
        return _RULES[kind](self._graph, *operands)

    def _check_truth(self, item: sp.Basic, argument: sp.Basic, is_wanted: bool) -> None:
        """Refuse a number where `item` needs a condition, and the other way round."""
        if is_wanted == _is_condition(argument):
            return
        kind = type(item).__name__
        if is_wanted:
            raise _not_an_expression(
                argument, f"is not a condition, as {kind} needs", "compare it: x > 0, or Ne(x, 0)"
            )
        raise _not_an_expression(
            argument, f"is a condition; {kind} needs a number", "write Piecewise((1, c), (0, True))"
        )

    def _symbol(self, item: sp.Symbol) -> int:
        self._check_name(item.name, False, item)
        return self._graph.symbol(TIME if item == self._time else self._lookup(item.name, False))

    def _of_time(self, item: AppliedUndef) -> Symbol:
        self._check_name(item.func.__name__, True, item.func)
        return self._lookup(item.func.__name__, True)

    def _read_function(self, item: AppliedUndef, operands: list[int]) -> int:
        function = getattr(item.func, "_imp_", None)
        if isinstance(function, WrittenFunction):  # a curve by its name
            return function.formula(Expr(self._graph, operands[0])).index
        place = self._place(item)
        if place is not None:
            return self._graph.many(op.CALL, tuple(operands), place)
        if self._is_of_time(item):
            return self._graph.symbol(self._of_time(item))
        return self._kernel_entry(item, operands)

    def _derivative(self, item: sp.Derivative) -> int:
        function = item.expr
        if not isinstance(function, AppliedUndef) or not self._is_of_time(function):
            raise _not_an_expression(item, "is a derivative of a compound expression", "call .doit() first")
        counts = [count for variable, count in item.variable_count if variable == self._time]
        if len(counts) < len(item.variable_count) or not all(isinstance(k, sp.Integer) for k in counts):
            raise _not_an_expression(
                item, "is not a time derivative", f"coordinates depend on {self._time} only"
            )
        symbol = self._of_time(function)
        order = symbol.order + sum(map(int, counts))
        return self._graph.symbol(Symbol(symbol.name, symbol.kind, order))

    def _kernel_entry(self, item: AppliedUndef, operands: list[int]) -> int:
        """Return an entry of a kernel as `to_sympy` writes it."""
        for kernel in self._graph.kernels:
            if item.func.__name__ == KERNEL_NAME.format(n=kernel.n, m=kernel.m) and _fits(kernel, item.args):
                solved = self._graph.many(op.SADDLE, tuple(operands[1:]), self._graph.kernel(kernel))
                return self._graph.node(op.PICK, solved, int(item.args[0]))
        raise _not_an_expression(
            item,
            f"is a function of something other than time ({self._time})",
            "write coordinates as dynamicsymbols('x'), parameters as symbols('m')",
        )

    def _is_of_time(self, item: AppliedUndef) -> bool:
        return bool(item.args == (self._time,))

    def _place(self, item: AppliedUndef) -> int | None:
        return self._functions.get(item.func.__name__)

    def _check_name(self, name: str, of_time: bool, item: object) -> None:
        seen = self._names.setdefault((name, of_time), item)
        if seen != item:
            raise ExpressionError(
                Problem(
                    "sympy.assumptions", printable(name),
                    f"two symbols have the name '{printable(name)}': "
                    f"{_describe_symbol(seen)} and {_describe_symbol(item)}",
                    "they differ in their assumptions, which makes them different symbols to SymPy",
                    "create the symbol once, without assumptions",
                )
            )  # fmt: skip


def _is_condition(item: sp.Basic) -> bool:
    # SymPy lets symbols stand for truth values too; here they are numbers.
    return isinstance(item, Boolean) and not isinstance(item, sp.Symbol)


def _kind(item: sp.Basic) -> type:
    """Return the class by which `item` is read."""
    for kind in type(item).__mro__:
        if kind in _RULES:
            return kind
    raise _not_an_expression(item)


def _check_expression(expression: object) -> sp.Basic:
    if isinstance(expression, sp.Basic):
        return expression
    if isinstance(expression, Fraction):
        return sp.Rational(expression.numerator, expression.denominator)
    if isinstance(expression, int | float) and not isinstance(expression, bool) and math.isfinite(expression):
        return sp.Integer(expression) if isinstance(expression, int) else sp.Float(expression)
    raise _not_an_expression(expression)


def _value(item: sp.Number) -> int | Fraction | float:
    if isinstance(item, sp.Integer):
        return int(item)
    if isinstance(item, sp.Rational):
        return Fraction(int(item.p), int(item.q))
    if isinstance(item, sp.Float) and item.is_finite and math.isfinite(value := float(item)):
        return value
    raise _not_an_expression(item)


def _fits(kernel: KernelNode, arguments: Sequence[sp.Basic]) -> bool:
    entry = arguments[0]
    count = (kernel.n + 1) * (kernel.n + kernel.m)
    return len(arguments) == 1 + count and isinstance(entry, sp.Integer) and 0 <= entry <= kernel.n + kernel.m


def _not_an_expression(
    item: object,
    what: str = "cannot appear in an expression of a mechanism",
    fix: str = "evaluate or replace it first: only real scalars, symbols, functions of time and the usual "
    "functions are known",
) -> ExpressionError:
    kind = type(item).__name__
    return ExpressionError(
        Problem("sympy.not_an_expression", "", f"{_text(item)} ({kind}) {what}",
                "the expression has to become a formula of real numbers", fix)
    )  # fmt: skip


def _text(item: object) -> str:
    """Return a short text of an object; long expressions are not written out, since that recurses."""
    if isinstance(item, sp.Basic) and len(list(islice(sp.preorder_traversal(item), 40))) == 40:
        return "a long expression"
    return f"'{printable(str(item))}'"


def _describe_symbol(item: object) -> str:
    """Return a symbol or function with its assumptions."""
    return str(sp.srepr(item)) if isinstance(item, sp.Symbol) else f"{item} with other assumptions"


def _fold_operands(
    rule: Callable[[Graph, int, int], int], g: Graph, operands: Iterable[int], empty: int
) -> int:
    """Return the left fold of `operands` in an order that does not depend on their names or age."""
    ordered = sorted(operands, key=g.hashes.__getitem__)
    return reduce(lambda a, b: rule(g, a, b), ordered) if ordered else empty


def _sum(g: Graph, *operands: int) -> int:
    """Return positive terms minus negative ones, then the number."""
    numbers = [k for k in operands if g.number(k) is not None]
    others = [k for k in operands if g.number(k) is None]
    plus = _fold_operands(add, g, [k for k in others if g.ops[k] != op.NEG], ZERO)
    minus = _fold_operands(add, g, [g.left[k] for k in others if g.ops[k] == op.NEG], ZERO)
    return reduce(lambda a, b: add(g, a, b), numbers, sub(g, plus, minus))


def _product(g: Graph, *operands: int) -> int:
    """Return one quotient of two products, with numbers and the sign outside."""
    numbers: list[int] = []
    above: list[int] = []
    below: list[int] = []
    for operand in operands:
        is_negative = g.ops[operand] == op.NEG
        factor = g.left[operand] if is_negative else operand
        if is_negative:
            numbers.append(neg(g, ONE))
        if g.number(factor) is not None:
            numbers.append(factor)
        elif g.ops[factor] == op.DIV and g.left[factor] == ONE:
            below.append(g.right[factor])
        else:
            above.append(factor)
    number = reduce(lambda a, b: mul(g, a, b), numbers, ONE)
    divisor = _fold_operands(mul, g, below, ONE)
    if not above:
        return div(g, number, divisor) if below else number
    return mul(g, number, div(g, _fold_operands(mul, g, above, ONE), divisor))


def _power(g: Graph, base: int, exponent: int) -> int:
    if g.ops[base] == op.EXP and g.left[base] == ONE:
        return apply(g, op.EXP, exponent)
    value = g.number(exponent)
    if isinstance(value, Fraction) and value.denominator == 2:
        return power(g, apply(g, op.SQRT, base), g.constant(value.numerator))
    return power(g, base, exponent)


def _piecewise(g: Graph, *operands: int) -> int:
    values, conditions = operands[::2], operands[1::2]
    if conditions[-1] != ONE:
        raise ExpressionError(
            Problem("sympy.open_piecewise", "", "a Piecewise has no value for the remaining cases",
                    "a value is needed everywhere", "end it with (value, True)")
        )  # fmt: skip
    result = values[-1]
    for condition, value in zip(conditions[-2::-1], values[-2::-1], strict=True):
        result = select(g, condition, value, result)
    return result


def _chosen_condition(g: Graph, condition: int, then: int, otherwise: int) -> int:
    first = apply(g, op.AND, condition, then)
    return apply(g, op.OR, first, apply(g, op.AND, apply(g, op.NOT, condition), otherwise))


def _modulo(g: Graph, a: int, b: int) -> int:
    return sub(g, a, mul(g, b, apply(g, op.FLOOR, div(g, a, b))))


def _heaviside(g: Graph, a: int, at_zero: int) -> int:
    return select(g, apply(g, op.LT, a, ZERO), ZERO, select(g, apply(g, op.LT, ZERO, a), ONE, at_zero))


def _apply_rule(code: int) -> _Rule:
    return lambda g, *operands: apply(g, code, *operands)


def _swap_rule(code: int) -> _Rule:
    return lambda g, a, b: apply(g, code, b, a)


def _fold_rule(code: int) -> _Rule:
    return lambda g, *operands: _fold_operands(lambda g, a, b: apply(g, code, a, b), g, operands, ZERO)


def _quotient(above: int | None, below: int) -> _Rule:
    def rule(g: Graph, a: int) -> int:
        return div(g, ONE if above is None else apply(g, above, a), apply(g, below, a))

    return rule


_CONNECTIVES: Final = frozenset({sp.And, sp.Or, sp.Not, sp.ITE})

_RULES: Final[Mapping[type, _Rule]] = {
    sp.Add: _sum, sp.Mul: _product, sp.Pow: _power, sp.Piecewise: _piecewise,
    type(sp.pi): lambda g: g.pi(),
    type(sp.E): lambda g: apply(g, op.EXP, ONE),
    type(sp.true): lambda g: ONE,
    type(sp.false): lambda g: ZERO,
    sp.sin: _apply_rule(op.SIN), sp.cos: _apply_rule(op.COS), sp.tan: _apply_rule(op.TAN),
    sp.asin: _apply_rule(op.ASIN), sp.acos: _apply_rule(op.ACOS), sp.atan: _apply_rule(op.ATAN),
    sp.sinh: _apply_rule(op.SINH), sp.cosh: _apply_rule(op.COSH), sp.tanh: _apply_rule(op.TANH),
    sp.exp: _apply_rule(op.EXP), sp.log: _apply_rule(op.LOG), sp.Abs: _apply_rule(op.ABS),
    sp.sign: _apply_rule(op.SIGN), sp.floor: _apply_rule(op.FLOOR), sp.atan2: _apply_rule(op.ATAN2),
    sp.sec: _quotient(None, op.COS), sp.csc: _quotient(None, op.SIN), sp.cot: _quotient(op.COS, op.SIN),
    sp.sech: _quotient(None, op.COSH), sp.csch: _quotient(None, op.SINH),
    sp.coth: _quotient(op.COSH, op.SINH),
    sp.ceiling: lambda g, a: neg(g, apply(g, op.FLOOR, neg(g, a))),
    sp.frac: lambda g, a: sub(g, a, apply(g, op.FLOOR, a)),
    sp.Mod: _modulo, sp.Heaviside: _heaviside,
    sp.Min: _fold_rule(op.MIN), sp.Max: _fold_rule(op.MAX),
    sp.And: _fold_rule(op.AND), sp.Or: _fold_rule(op.OR),
    sp.Not: _apply_rule(op.NOT), sp.ITE: _chosen_condition, sp.Eq: _apply_rule(op.EQ),
    sp.Ne: lambda g, a, b: apply(g, op.NOT, apply(g, op.EQ, a, b)),
    sp.StrictLessThan: _apply_rule(op.LT), sp.LessThan: _apply_rule(op.LE),
    sp.StrictGreaterThan: _swap_rule(op.LT), sp.GreaterThan: _swap_rule(op.LE),
}  # fmt: skip
