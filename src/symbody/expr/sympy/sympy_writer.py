"""The graph written as SymPy objects; see `sympy_bridge` for what becomes of what."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial, partialmethod
from typing import Any, Final, NamedTuple, TypeAlias, TypeGuard, cast

import sympy as sp
from sympy.functions.elementary.piecewise import ExprCondPair

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes as op
from symbody.expr.canonical import sub
from symbody.expr.graph import Exact, Graph, Symbol, SymbolKind, UserFunction
from symbody.expr.printing.definitions import EXPAND_LIMIT, definitions
from symbody.expr.printing.flattening import SUMS, linear_terms, nested_operands, power_factors
from symbody.expr.rewrite import symbols_of
from symbody.expr.sympy.sympy_reader import KERNEL_NAME, Lookup, nodes_from_sympy, sympy_time
from symbody.expr.written_function import WrittenFunction

SympyExpr: TypeAlias = sp.Expr
SympyEquation: TypeAlias = sp.Eq
SympyMatrix: TypeAlias = sp.Matrix

# Heights up to which SymPy's rules stay on. At these it takes at most some milliseconds an operation,
# and a nest of 5,000 sines or roots, built without its rules, takes under a second.
_FUNCTION_HEIGHT: Final = 4
_HEIGHT: Final = 30
# Bits of a power of a number that is computed; the graph keeps half as many.
_LONGEST: Final = 1024
# What SymPy looks into most eagerly counts for several levels.
_STEEP: Final = frozenset({op.SINH, op.COSH, op.TANH, op.SQRT, op.POW})

_FUNCTIONS: Final[Mapping[int, type]] = {
    op.SIN: sp.sin, op.COS: sp.cos, op.TAN: sp.tan, op.ASIN: sp.asin, op.ACOS: sp.acos, op.ATAN: sp.atan,
    op.SINH: sp.sinh, op.COSH: sp.cosh, op.TANH: sp.tanh, op.EXP: sp.exp, op.LOG: sp.log, op.ABS: sp.Abs,
    op.SIGN: sp.sign, op.FLOOR: sp.floor, op.ATAN2: sp.atan2,
}  # fmt: skip
_LATTICES: Final[Mapping[int, type]] = {op.MIN: sp.Min, op.MAX: sp.Max, op.AND: sp.And, op.OR: sp.Or}
# A comparison, the same with its sides exchanged, and both for its opposite.
_COMPARISONS: Final[Mapping[int, tuple[type, ...]]] = {
    op.LT: (sp.StrictLessThan, sp.StrictGreaterThan, sp.GreaterThan, sp.LessThan),
    op.LE: (sp.LessThan, sp.GreaterThan, sp.StrictGreaterThan, sp.StrictLessThan),
    op.EQ: (sp.Eq, sp.Eq, sp.Ne, sp.Ne),
}  # fmt: skip


class _Plan(NamedTuple):
    """How a node is put together: its operands, and what takes them and whether rules are on."""

    operands: Sequence[int]
    build: Callable[[Sequence[sp.Basic], bool], sp.Basic]
    limit: int = _HEIGHT
    step: int = 1


def to_sympy(graph: Graph, nodes: Iterable[int]) -> list[SympyExpr]:
    """Return nodes as SymPy expressions written out; shared nodes become shared objects.

    Raises
    ------
    ExpressionError
        If two symbols in them would be the same symbol to SymPy.
    """
    wanted = list(nodes)
    writer = _SympyWriter(graph, {})
    writer.check_names(wanted)
    return [writer.expression(node) for node in wanted]


def to_sympy_with_definitions(
    graph: Graph, nodes: Sequence[int], limit: int = EXPAND_LIMIT
) -> tuple[list[SympyExpr], list[tuple[SympyExpr, SympyExpr]]]:
    """Return nodes with shared parts as symbols z1, z2, ... if one exceeds `limit` operations.

    Returns
    -------
    (expressions, definitions)
        Definitions are pairs of symbol and expression, each using earlier symbols only; all together are
        as long as the graph, however often its parts are shared.
    """
    named = {node: sp.Symbol(name) for node, name in definitions(graph, nodes, limit).items()}
    writer = _SympyWriter(graph, named)
    writer.check_names(nodes)
    defined = [(symbol, writer.definition(node)) for node, symbol in named.items()]
    return [writer.expression(node) for node in nodes], defined


def nodes_from_equations(
    equations: Iterable[object], graph: Graph, lookup: Lookup | None = None
) -> list[int]:
    """Return ``left - right`` of equations as nodes; an expression stands for an equation with 0."""
    sides = [(item.lhs, item.rhs) if isinstance(item, sp.Eq) else (item, 0) for item in equations]
    nodes = nodes_from_sympy([side for pair in sides for side in pair], graph, lookup)
    return [sub(graph, a, b) for a, b in zip(nodes[::2], nodes[1::2], strict=True)]


def time_derivatives(functions: Iterable[SympyExpr]) -> list[SympyExpr]:
    """Return the derivatives of SymPy expressions by time."""
    return [sp.diff(function, sympy_time()) for function in functions]


def sympy_matrix(graph: Graph, rows: int, columns: int, nodes: Sequence[int]) -> SympyMatrix:
    """Return nodes in row-major order as a matrix."""
    return sp.Matrix(rows, columns, to_sympy(graph, nodes))


def sympy_equations(graph: Graph, left: Sequence[int], right: Sequence[int]) -> list[SympyEquation]:
    """Return ``left = right``, entry by entry, unevaluated."""
    sides = to_sympy(graph, [*left, *right])
    return [sp.Eq(a, b, evaluate=False) for a, b in zip(sides[: len(left)], sides[len(left) :], strict=True)]


def sympy_derivative(thing: object, variables: Sequence[SympyExpr]) -> object:
    """Return the derivative of a SymPy expression, matrix or equation; of anything else None."""
    if isinstance(thing, sp.Eq):
        return sp.Eq(thing.lhs.diff(*variables), thing.rhs.diff(*variables), evaluate=False)
    return thing.diff(*variables) if isinstance(thing, sp.Expr | sp.MatrixBase) else None


def is_expression(thing: object) -> bool:
    """Return whether something is a scalar SymPy expression."""
    return isinstance(thing, sp.Expr)


def is_matrix(thing: object) -> TypeGuard[SympyMatrix]:
    """Return whether something is a SymPy matrix, mutable or not."""
    return isinstance(thing, sp.MatrixBase)


def symbol_to_sympy(symbol: Symbol) -> SympyExpr:
    """Return a symbol as SymPy writes it: a function of time, its derivative, or a plain symbol."""
    t = sympy_time()
    if symbol.kind == SymbolKind.TIME:
        return t
    if symbol.kind == SymbolKind.PARAMETER:
        return sp.Symbol(symbol.name)
    function = sp.Function(symbol.name)(t)
    return sp.Derivative(function, (t, symbol.order)) if symbol.order else function


def function_to_sympy(function: UserFunction) -> Callable[..., SympyExpr]:
    """Return an undefined function of the same name; one that has a formula keeps its numbers and slopes.

    ``lambdify`` and ``evalf`` take the numbers from ``_imp_``, ``diff`` the slopes from ``fdiff``.
    """
    if not isinstance(function, WrittenFunction):
        return cast("Callable[..., SympyExpr]", sp.Function(function.name))
    # Part of what SymPy compares: its caches must not take the curve of another model for this one.
    kind: Any = sp.Function(function.name, _imp_=function)
    kind.fdiff = partialmethod(_slope, function)
    return cast("Callable[..., SympyExpr]", kind)


def _slope(item: SympyExpr, function: WrittenFunction, argindex: int = 1) -> SympyExpr:
    return function_to_sympy(function.derivative(argindex - 1))(*item.args)


class _SympyWriter:
    """Writes nodes of one graph; made for them and dropped."""

    __slots__ = ("_graph", "_known", "_named")

    def __init__(self, graph: Graph, named: Mapping[int, sp.Symbol]) -> None:
        self._graph = graph
        self._named = named
        # Expressions with their heights.
        self._known: dict[int, tuple[sp.Basic, int]] = {node: (symbol, 0) for node, symbol in named.items()}

    def check_names(self, nodes: Iterable[int]) -> None:
        owners: dict[SympyExpr, Symbol] = {}
        for node in symbols_of(self._graph, nodes):
            symbol = self._graph.symbols[self._graph.left[node]]
            other = owners.setdefault(symbol_to_sympy(symbol), symbol)
            if other != symbol:
                raise ExpressionError(
                    Problem(
                        "sympy.one_name", symbol.label,
                        f"the {other.kind} and the {symbol.kind} '{symbol.label}' are one object to SymPy",
                        "SymPy compares symbols only by name and assumptions", "rename one of them",
                    )
                )  # fmt: skip

    def expression(self, root: int) -> SympyExpr:
        built = self._known
        stack: list[tuple[int, _Plan | None]] = [(root, None)]
        while stack:
            node, plan = stack.pop()
            if node in built:
                continue
            if plan is None:
                plan = self._plan(node)
                stack.append((node, plan))
                stack.extend((operand, None) for operand in plan.operands if operand not in built)
            else:
                built[node] = self._build(plan)
        return built[root][0]

    def definition(self, node: int) -> SympyExpr:
        """Return the SymPy object of a named node."""
        plan = self._plan(node)
        for operand in plan.operands:
            self.expression(operand)
        return self._build(plan)[0]

    def _build(self, plan: _Plan) -> tuple[sp.Basic, int]:
        parts = [self._known[k] for k in plan.operands]
        height = max([height for _, height in parts], default=0)
        operands = [part for part, _ in parts]
        try:
            result = plan.build(operands, height <= plan.limit)
        except Exception:  # the rules cannot be relied on: some recurse, some assert what does not hold
            result = plan.build(operands, False)
        hash(result)  # kept by SymPy; asked for later, at the top, it would recurse all the way down
        if _is_kept_power(result):  # the rules of what it stands in would compute it
            return result, max(height, _HEIGHT) + plan.step
        return result, height + plan.step if result.args else 0

    def _plan(self, node: int) -> _Plan:
        graph = self._graph
        code, a, b = graph.ops[node], graph.left[node], graph.right[node]
        if code in op.LEAVES:
            return _Plan((), partial(_leaf, graph, node))
        if code in SUMS or (code == op.MUL and graph.ops[a] == op.RATIONAL):
            return self._sum(node)
        if code in (op.MUL, op.DIV) or (code == op.POW and isinstance(graph.number(b), int)):
            return self._product(node)
        if code in _LATTICES:
            operands = nested_operands(graph, node, self._named)
            return _Plan(operands, partial(_lattice, _LATTICES[code]))
        if code in _COMPARISONS or code == op.NOT:
            return self._condition(node)
        return self._choice(node) if code == op.SELECT else self._function(node)

    def _sum(self, node: int) -> _Plan:
        terms = linear_terms(self._graph, node, self._named, distribute=True)
        # By structure, so that sums which SymPy does not sort do not depend on when nodes were made.
        order = sorted(terms, key=self._graph.hashes.__getitem__)
        return _Plan(order, partial(_total, [terms[term] for term in order]), step=2)

    def _product(self, node: int) -> _Plan:
        above, below = power_factors(self._graph, node, self._named)
        order = sorted({**above, **below}, key=self._graph.hashes.__getitem__)
        exponents = [above.get(factor, 0) - below.get(factor, 0) for factor in order]
        return _Plan(order, partial(_powers, exponents), step=2)

    def _condition(self, node: int) -> _Plan:
        graph = self._graph
        is_negated = graph.ops[node] == op.NOT
        compared = graph.left[node] if is_negated else node
        if graph.ops[compared] not in _COMPARISONS:
            return _Plan((compared,), partial(_apply_function, sp.Not))
        kinds = _COMPARISONS[graph.ops[compared]][2 * is_negated :][:2]
        return _Plan(graph.operands(compared), partial(_compare, kinds))

    def _choice(self, node: int) -> _Plan:
        graph = self._graph
        parts: list[int] = []
        rest = node
        while graph.ops[rest] == op.SELECT and (rest == node or rest not in self._named):
            condition, then, rest = graph.operands(rest)
            parts += [then, condition]
        return _Plan((*parts, rest), _piecewise)

    def _function(self, node: int) -> _Plan:
        graph = self._graph
        code, operands = graph.ops[node], graph.operands(node)
        step = 3 if code in _STEEP else 1
        if code == op.POW:
            return _Plan(operands, partial(_apply_function, sp.Pow), step=step)
        if code == op.SQRT:
            return _Plan(operands, _root, step=step)
        if code in _FUNCTIONS:
            return _Plan(operands, partial(_apply_function, _FUNCTIONS[code]), _FUNCTION_HEIGHT, step)
        if code == op.FMA:
            return _Plan(operands, _multiply_add, step=2)
        if code == op.CALL:
            function = function_to_sympy(graph.functions[graph.right[node]])
            return _Plan(operands, partial(_apply_function, function), limit=-1)
        solved, entry = operands[0], graph.right[node]
        kernel = graph.kernels[graph.right[solved]]
        function = sp.Function(KERNEL_NAME.format(n=kernel.n, m=kernel.m))
        return _Plan(graph.operands(solved), partial(_entry, function, entry))


def _leaf(graph: Graph, node: int, parts: Sequence[sp.Basic], rules: bool) -> SympyExpr:
    value = graph.number(node)
    if isinstance(value, float):
        return sp.Float(value)
    if value is not None:
        return _rational(value)
    if graph.ops[node] == op.PI:
        return sp.pi
    return symbol_to_sympy(graph.symbols[graph.left[node]])


def _rational(value: Exact) -> SympyExpr:
    return sp.Rational(value.numerator, value.denominator)


def _apply_function(kind: Callable[..., sp.Basic], parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    return kind(*parts, evaluate=rules)


def _compare(kinds: Sequence[type], parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    """Return a comparison, turned round as SymPy does inside Piecewise: numbers stand right."""
    a, b = parts
    turned = a.is_number or (rules and next(iter(sp.ordered(parts))) is not a)
    turned = turned and not b.is_number
    return kinds[turned](*((b, a) if turned else (a, b)), evaluate=a.is_Number and b.is_Number)


def _root(parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    return sp.Pow(parts[0], sp.S.Half, evaluate=rules)


def _total(factors: Sequence[Exact], parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    terms = [
        part if factor == 1 else sp.Mul(_rational(factor), part, evaluate=rules)
        for factor, part in zip(factors, parts, strict=True)
    ]
    return terms[0] if len(terms) == 1 else sp.Add(*terms, evaluate=rules)


def _powers(exponents: Sequence[int], parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    # SymPy would take powers of choices inside, and all their conditions apart.
    rules = rules and not any(isinstance(part.as_base_exp()[0], sp.Piecewise) for part in parts)
    rules = rules and not any(map(_is_long_power, parts, exponents))
    factors = [
        part if exponent == 1 else sp.Pow(part, sp.Integer(exponent), evaluate=rules)
        for exponent, part in zip(exponents, parts, strict=True)
        if exponent
    ]
    return factors[0] if len(factors) == 1 else sp.Mul(*factors, evaluate=rules)


def _is_long_power(base: sp.Basic, exponent: int) -> bool:
    """Return whether a power of a number has digits that nobody wants: SymPy would compute all of them."""
    if not base.is_Rational:
        return False
    return bool(max(abs(base.p).bit_length(), base.q.bit_length()) * abs(exponent) > _LONGEST)


def _is_kept_power(thing: sp.Basic) -> bool:
    """Return whether something is a power of a number that was not computed, or a product of such."""
    return any(
        isinstance(part, sp.Pow) and part.base.is_Rational and part.exp.is_Integer
        for part in (thing, *thing.args)
    )


def _multiply_add(parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    a, b, c = parts
    return sp.Add(sp.Mul(a, b, evaluate=rules), c, evaluate=rules)


def _entry(function: Callable[..., sp.Basic], entry: int, parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    return function(sp.Integer(entry), *parts, evaluate=False)


def _lattice(kind: type, parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    if rules:
        return kind(*parts, evaluate=False) if kind in (sp.Min, sp.Max) else kind(*parts)
    # The constructors sort their operands recursively, evaluate=False or not.
    result = sp.Basic.__new__(kind, *parts)
    result._argset = frozenset(parts)
    return result


def _piecewise(parts: Sequence[sp.Basic], rules: bool) -> sp.Basic:
    # The constructors would search every condition for other choices and multiply them out.
    pairs: list[sp.Basic] = []
    for value, condition in zip(parts[::2], [*parts[1::2], sp.true], strict=True):
        if condition == sp.false:
            continue
        pairs.append(sp.Basic.__new__(ExprCondPair, value, condition))
        if condition == sp.true:
            break
    return pairs[0].args[0] if len(pairs) == 1 else sp.Basic.__new__(sp.Piecewise, *pairs)


def filled_matrix(rows: int, columns: int, entries: Sequence[sp.Expr]) -> sp.Matrix:
    """Return expressions in row-major order as a matrix."""
    return sp.Matrix(rows, columns, entries)


def equations_between(left: sp.Matrix, right: sp.Matrix) -> list[sp.Eq]:
    """Return ``left = right``, entry by entry, unevaluated."""
    return [sp.Eq(a, b, evaluate=False) for a, b in zip(left, right, strict=True)]
