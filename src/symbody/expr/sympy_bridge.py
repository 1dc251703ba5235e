"""SymPy at the border: objects made by users come in, closed forms go out. Text is never interpreted.

Coordinates, speeds, inputs and multipliers are ``dynamicsymbols`` and their time derivatives, so results
paste into scripts of sympy.physics.mechanics; parameters are plain symbols without assumptions. Names are
only names: a parameter called ``I`` is ``Symbol("I")``, never the imaginary unit.

SymPy flattens sums and products, so going out and coming back gives the same function, not always
the same node; coming in and going out gives the same SymPy object.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from typing import Final, TypeAlias

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.physics.vector import dynamicsymbols

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.canonical import add, apply, constant, make, mul, neg, power, select
from symbody.expr.graph import TIME, Graph, Kind, Symbol

SympyExpr: TypeAlias = sp.Expr
SympyEquation: TypeAlias = sp.Eq
SympyMatrix: TypeAlias = sp.Matrix

Lookup = Callable[[str, bool], Symbol]
_OutRule = Callable[..., SympyExpr]

_OUT: Final[Mapping[int, _OutRule]] = {
    op.NEG: lambda a: -a,
    op.ADD: lambda a, b: a + b,
    op.SUB: lambda a, b: a - b,
    op.MUL: lambda a, b: a * b,
    op.DIV: lambda a, b: a / b,
    op.POW: lambda a, b: a**b,
    op.SIN: sp.sin, op.COS: sp.cos, op.TAN: sp.tan, op.ASIN: sp.asin, op.ACOS: sp.acos, op.ATAN: sp.atan,
    op.SINH: sp.sinh, op.COSH: sp.cosh, op.TANH: sp.tanh, op.EXP: sp.exp, op.LOG: sp.log, op.SQRT: sp.sqrt,
    op.ABS: sp.Abs, op.SIGN: sp.sign, op.FLOOR: sp.floor, op.ATAN2: sp.atan2, op.MIN: sp.Min, op.MAX: sp.Max,
    op.LT: sp.StrictLessThan, op.LE: sp.LessThan, op.EQ: sp.Eq, op.AND: sp.And, op.OR: sp.Or, op.NOT: sp.Not,
    op.SELECT: lambda c, a, b: sp.Piecewise((a, c), (b, True)),
    op.FMA: lambda a, b, c: a * b + c,
}  # fmt: skip

_UNARY_IN: Final[Mapping[type, int]] = {
    sp.sin: op.SIN, sp.cos: op.COS, sp.tan: op.TAN, sp.asin: op.ASIN, sp.acos: op.ACOS, sp.atan: op.ATAN,
    sp.sinh: op.SINH, sp.cosh: op.COSH, sp.tanh: op.TANH, sp.exp: op.EXP, sp.log: op.LOG, sp.Abs: op.ABS,
    sp.sign: op.SIGN, sp.floor: op.FLOOR, sp.atan2: op.ATAN2, sp.Not: op.NOT, sp.Eq: op.EQ,
    sp.StrictLessThan: op.LT, sp.LessThan: op.LE,
}  # fmt: skip

# SymPy flattens these; they come back as left folds.
_FOLDED_IN: Final[Mapping[type, int]] = {sp.Min: op.MIN, sp.Max: op.MAX, sp.And: op.AND, sp.Or: op.OR}
_RECIPROCALS: Final[Mapping[type, int]] = {sp.sec: op.COS, sp.csc: op.SIN, sp.cot: op.TAN}


def to_sympy(graph: Graph, nodes: Iterable[int]) -> list[SympyExpr]:
    """Return nodes as SymPy expressions; shared nodes become shared objects."""
    wanted = list(nodes)
    known: dict[int, SympyExpr] = {}
    for node in graph.reachable(wanted):
        code = graph.ops[node]
        if code in op.LEAVES:
            known[node] = _leaf(graph, node)
        else:
            known[node] = _out_rule(graph, node)(*(known[k] for k in graph.operands(node)))
    return [known[node] for node in wanted]


def sympy_matrix(graph: Graph, rows: int, columns: int, nodes: Sequence[int]) -> SympyMatrix:
    """Return nodes in row-major order as a matrix."""
    return sp.Matrix(rows, columns, to_sympy(graph, nodes))


def sympy_equations(graph: Graph, left: Sequence[int], right: Sequence[int]) -> list[SympyEquation]:
    """Return ``left = right``, entry by entry, unevaluated."""
    sides = to_sympy(graph, [*left, *right])
    return [sp.Eq(a, b, evaluate=False) for a, b in zip(sides[: len(left)], sides[len(left) :], strict=True)]


def from_sympy(expression: object, graph: Graph, lookup: Lookup | None = None) -> int:
    """Return the node of a SymPy expression.

    Parameters
    ----------
    lookup : callable
        ``lookup(name, is_function_of_time)`` returns the symbol a name stands for. By default functions
        of time are coordinates and plain symbols parameters.

    Raises
    ------
    ExpressionError
        For objects that are not real scalar expressions, naming them, and for two symbols of one name
        that differ in their assumptions.
    """
    root = _accepted(expression)
    order = _bottom_up(root)
    _refuse_twins(order)
    symbols = _default_lookup if lookup is None else lookup
    known: dict[sp.Basic, int] = {}
    for item in order:
        known[item] = _in_rule(graph, item, known, symbols)
    return known[root]


def _leaf(graph: Graph, node: int) -> SympyExpr:
    value = graph.number(node)
    if isinstance(value, float):
        return sp.Float(value)
    if value is not None:
        exact = Fraction(value)
        return sp.Rational(exact.numerator, exact.denominator)
    if graph.ops[node] == op.PI:
        return sp.pi
    return symbol_to_sympy(graph.symbols[graph.left[node]])


def symbol_to_sympy(symbol: Symbol) -> SympyExpr:
    """Return a symbol as SymPy writes it: a function of time, its derivative, or a plain symbol."""
    t = dynamicsymbols._t
    if symbol.kind == Kind.TIME:
        return t
    if symbol.kind == Kind.PARAMETER:
        return sp.Symbol(symbol.name)
    function = sp.Function(symbol.name)(t)
    return sp.Derivative(function, (t, symbol.order)) if symbol.order else function


def _out_rule(graph: Graph, node: int) -> _OutRule:
    code = graph.ops[node]
    rule = _OUT.get(code)
    if rule is not None:
        return rule
    if code == op.CALL:
        return sp.Function(graph.functions[graph.right[node]].name)
    if code == op.SADDLE:  # no closed form: a tuple that PICK reads from
        return lambda *operands: sp.Function("solve_saddle")(*operands)
    entry = graph.right[node]
    return lambda kernel: sp.Function("entry")(kernel, sp.Integer(entry))


def _accepted(expression: object) -> sp.Basic:
    if isinstance(expression, bool) or not isinstance(expression, int | float | Fraction | sp.Basic):
        raise _refused(expression)
    if isinstance(expression, Fraction):
        return sp.Rational(expression.numerator, expression.denominator)
    if isinstance(expression, int):
        return sp.Integer(expression)
    return sp.Float(expression) if isinstance(expression, float) else expression


def _bottom_up(root: sp.Basic) -> list[sp.Basic]:
    """Return all distinct subexpressions, arguments first, without recursion."""
    order: list[sp.Basic] = []
    seen: set[sp.Basic] = set()
    stack = [(root, False)]
    while stack:
        item, expanded = stack.pop()
        if expanded:
            order.append(item)
        elif item not in seen:
            seen.add(item)
            stack.append((item, True))
            if not isinstance(item, AppliedUndef | sp.Derivative):
                stack.extend((argument, False) for argument in item.args)
    return order


def _in_rule(graph: Graph, item: sp.Basic, known: Mapping[sp.Basic, int], symbols: Lookup) -> int:
    if isinstance(item, sp.Number | sp.NumberSymbol):
        return _number(graph, item)
    if item in (sp.true, sp.false):
        return constant(graph, int(bool(item)))
    if isinstance(item, sp.Symbol | AppliedUndef | sp.Derivative):
        return graph.symbol(_symbol(item, symbols))
    operands = [known[argument] for argument in item.args]
    kind = type(item)
    if kind in (sp.Add, sp.Mul):
        # SymPy's order depends on names; ordering by structure does not.
        operands.sort(key=graph.hashes.__getitem__)
        rule = add if kind is sp.Add else mul
        return reduce(lambda a, b: rule(graph, a, b), operands)
    if kind in _UNARY_IN:
        return apply(graph, _UNARY_IN[kind], *operands)
    return _other(graph, item, operands, known)


def _other(graph: Graph, item: sp.Basic, operands: list[int], known: Mapping[sp.Basic, int]) -> int:
    kind = type(item)
    if kind is sp.Pow:
        return power(graph, *operands)
    if kind in _FOLDED_IN:
        code = _FOLDED_IN[kind]
        operands.sort(key=graph.hashes.__getitem__)
        return reduce(lambda a, b: apply(graph, code, a, b), operands)
    if kind in (sp.StrictGreaterThan, sp.GreaterThan):
        code = op.LT if kind is sp.StrictGreaterThan else op.LE
        return apply(graph, code, operands[1], operands[0])
    if kind is sp.Ne:
        return apply(graph, op.NOT, apply(graph, op.EQ, *operands))
    if kind in _RECIPROCALS:
        return make(graph, op.DIV, (constant(graph, 1), apply(graph, _RECIPROCALS[kind], *operands)))
    if kind is sp.Mod:
        a, b = operands
        whole = apply(graph, op.FLOOR, make(graph, op.DIV, (a, b)))
        return add(graph, a, neg(graph, mul(graph, b, whole)))
    if isinstance(item, sp.functions.elementary.piecewise.ExprCondPair):
        return operands[0]
    if isinstance(item, sp.Piecewise):
        return _piecewise(graph, item, known)
    raise _refused(item)


def _piecewise(graph: Graph, item: sp.Piecewise, known: Mapping[sp.Basic, int]) -> int:
    values = [known[pair.args[0]] for pair in item.args]
    conditions = [known[pair.args[1]] for pair in item.args]
    if graph.number(conditions[-1]) != 1:
        raise ExpressionError(
            Problem("sympy.open_piecewise", str(item), "a Piecewise has no branch for the remaining cases",
                    "a value is needed everywhere", "end it with (value, True)")
        )  # fmt: skip
    result = values[-1]
    for condition, value in zip(reversed(conditions[:-1]), reversed(values[:-1]), strict=True):
        result = select(graph, condition, value, result)
    return result


def _number(graph: Graph, item: sp.Basic) -> int:
    if item is sp.pi:
        return graph.pi()
    if item is sp.E:
        return apply(graph, op.EXP, constant(graph, 1))
    if isinstance(item, sp.Rational) and item.is_finite:
        return constant(graph, Fraction(int(item.p), int(item.q)))
    if isinstance(item, sp.Float) and item.is_finite:
        return constant(graph, float(item))
    raise _refused(item)


def _symbol(item: sp.Basic, symbols: Lookup) -> Symbol:
    if item == dynamicsymbols._t:
        return TIME
    if isinstance(item, sp.Symbol):
        return symbols(item.name, False)
    order = 0
    function = item
    if isinstance(item, sp.Derivative):
        function = item.expr
        order = sum(int(count) for _, count in item.variable_count)
        if any(variable != dynamicsymbols._t for variable, _ in item.variable_count):
            raise _refused(item)
    if not isinstance(function, AppliedUndef) or function.args != (dynamicsymbols._t,):
        raise _refused(item)
    symbol = symbols(function.func.__name__, True)
    return Symbol(symbol.name, symbol.kind, symbol.order + order)


def _default_lookup(name: str, of_time: bool) -> Symbol:
    return Symbol(name, Kind.COORDINATE if of_time else Kind.PARAMETER)


def _refuse_twins(order: Iterable[sp.Basic]) -> None:
    seen: dict[str, sp.Symbol] = {}
    for item in order:
        if isinstance(item, sp.Symbol) and seen.setdefault(item.name, item) != item:
            raise ExpressionError(
                Problem("sympy.assumptions", item.name,
                        f"two symbols are called {item.name!r} but differ in their assumptions",
                        f"{item.assumptions0} and {seen[item.name].assumptions0}", "create the symbol once")
            )  # fmt: skip


def _refused(item: object) -> ExpressionError:
    return ExpressionError(
        Problem("sympy.not_an_expression", str(item)[:80],
                f"{type(item).__name__} cannot stand in an expression of a mechanism",
                "only real scalar expressions of symbols and functions of time can",
                "evaluate or replace it before")
    )  # fmt: skip
