"""SymPy at the border: what comes in, what goes out, and what is left of it after both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from sympy.physics.vector import dynamicsymbols

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, add, apply, div, mul, neg, power, select, sub
from symbody.expr.expression import Expr, cos, sin, symbol
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.rewrite import substitute, tree_size
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from symbody.expr.sympy.sympy_bridge import (
    from_sympy,
    nodes_from_sympy,
    sympy_equations,
    sympy_matrix,
    to_sympy,
    to_sympy_with_definitions,
)
from tests.expr.strategies import DIGITS, Sample, both_tiers, built, mpmath_values, samples, sequence_of

t = dynamicsymbols._t
x, y = dynamicsymbols("x y")
m, k, d, l = sp.symbols("m k d l")
NAMES = "I E S N O Q pi lambda Lambda beta gamma zeta re im sign test sum max True None nan oo e j".split()

RING = (op.NEG, op.ADD, op.SUB, op.MUL)


@pytest.fixture
def graph() -> Graph:
    return Graph()


def out(graph: Graph, node: int) -> sp.Expr:
    return to_sympy(graph, [node])[0]


def fingerprint(graph: Graph, node: int) -> tuple[int, int]:
    return fingerprints(graph, graph.reachable([0, ONE, node]))[node]


# --- laws -------------------------------------------------------------------------------------


@both_tiers
@given(samples(RING))
def test_out_and_in_again_is_the_same_polynomial(sample: Sample) -> None:
    graph = Graph()
    node = built(sample.program, graph)[-1]
    assert fingerprint(graph, from_sympy(out(graph, node), graph)) == fingerprint(graph, node)


@both_tiers
@given(samples((*RING, op.DIV, op.SIN, op.COS)))
def test_out_and_in_once_more_is_the_same_node_and_the_same_object(sample: Sample) -> None:
    first, second = Graph(), Graph()
    once = from_sympy(out(first, built(sample.program, first)[-1]), first)
    expression = out(first, once)
    assert from_sympy(expression, first) == once
    assert out(second, from_sympy(expression, second)) == expression


@both_tiers
@given(samples())
def test_every_operation_keeps_its_value(sample: Sample) -> None:
    graph = Graph()
    node = built(sample.program, graph)[-1]
    again = from_sympy(out(graph, node), graph)
    with mpmath.workdps(DIGITS):
        point = [mpmath.mpf(value.numerator) / value.denominator for value in sample.point]
        exact = mpmath_values(sample.program, point)[-1]
        value = evaluate_sequence(sequence_of(graph, [again]), {"q": point}, MPMATH)[0][0]
    # A tame step magnifies an error at most by 2 * 200 / 0.02 (a quotient), so 12 steps leave 80 - 52 digits;
    # what SymPy puts together may cost as much again as one step.
    assert abs(value - exact) < mpmath.mpf(10) ** -20


# --- out --------------------------------------------------------------------------------------


def test_symbols_become_dynamicsymbols_and_plain_symbols(graph: Graph) -> None:
    q = Symbol("x", SymbolKind.COORDINATE)
    kinds = [SymbolKind.SPEED, SymbolKind.INPUT, SymbolKind.MULTIPLIER]
    symbols = [q, q.derivative, q.derivative.derivative, TIME, Symbol("m")]
    assert to_sympy(graph, [graph.symbol(name) for name in symbols]) == [x, x.diff(t), x.diff(t, 2), t, m]
    for kind in kinds:
        assert out(graph, graph.symbol(Symbol("f", kind, 1))) == dynamicsymbols("f", 1)


@pytest.mark.parametrize("name", NAMES)
def test_names_are_only_names(name: str, graph: Graph) -> None:
    plain, moving = sp.Symbol(name), sp.Function(name)(t)
    assert graph.symbols[graph.left[from_sympy(plain, graph)]] == Symbol(name)
    assert graph.symbols[graph.left[from_sympy(moving, graph)]] == Symbol(name, SymbolKind.COORDINATE)
    expression = plain * sp.sin(moving) ** 2 + sp.Derivative(moving, t)
    assert out(graph, from_sympy(expression, graph)) == expression
    assert expression.free_symbols == {plain, t}


def test_numbers_keep_their_kind_and_value(graph: Graph) -> None:
    for value, expected in [
        (3, sp.Integer(3)), (-3, sp.Integer(-3)), (Fraction(3, 4), sp.Rational(3, 4)), (0.1, sp.Float(0.1)),
        (-2.0**-1074, sp.Float(-(2.0**-1074))), (10**200, sp.Integer(10**200)),
    ]:  # fmt: skip
        node = graph.constant(value)
        assert out(graph, node) == expected
        assert type(out(graph, node)) is type(expected)
        assert from_sympy(out(graph, node), graph) == node
    assert out(graph, graph.constant(0.1))._prec == 53
    assert from_sympy(sp.Float("0.1", 50), graph) == graph.constant(0.1)


def test_results_equal_what_a_user_types(graph: Graph) -> None:
    g = symbol(graph, Symbol("g"))
    M, K, L = (symbol(graph, Symbol(name)) for name in "mkl")
    q, p = (symbol(graph, Symbol(name, SymbolKind.COORDINATE)) for name in "xy")
    rate = symbol(graph, Symbol("x", SymbolKind.COORDINATE, 1))
    for ours, typed in [
        (
            Fraction(1, 2) * M * rate**2 - M * g * L * cos(q),
            m * x.diff(t) ** 2 / 2 - m * sp.Symbol("g") * l * sp.cos(x),
        ),
        (2 * (q + p), 2 * (x + y)),
        (M * L**2 * sin(p - q), m * l**2 * sp.sin(y - x)),
        ((M * L) ** 2 / (K * L), (m * l) ** 2 / (k * l)),
        ((4 * q) ** Fraction(1, 2), sp.sqrt(4 * x)),
        ((q**2 + L**2) ** Fraction(-3, 2), (x**2 + l**2) ** sp.Rational(-3, 2)),
    ]:
        assert out(graph, ours.index) == typed


def test_choices_and_conditions(graph: Graph) -> None:
    q = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    c, e = (graph.symbol(Symbol(name)) for name in "kl")
    inner = select(graph, apply(graph, op.LT, q, c), e, c)
    both = apply(graph, op.AND, apply(graph, op.LE, 0, q), apply(graph, op.NOT, apply(graph, op.EQ, c, e)))
    assert out(graph, select(graph, apply(graph, op.LT, 0, q), 0, inner)) == sp.Piecewise(
        (0, x > 0), (l, x < k), (k, True)
    )
    assert out(graph, select(graph, both, q, e)) == sp.Piecewise((x, (x >= 0) & sp.Ne(k, l)), (l, True))


def test_an_entry_of_a_kernel_is_a_function_of_its_data(graph: Graph) -> None:
    operands = tuple(graph.symbol(Symbol(name)) for name in ("M", "J", "F", "G"))
    entry = graph.node(op.PICK, graph.many(op.SADDLE, operands, graph.kernel(KernelNode(1, 1))), 1)
    expected = sp.Function("solve_saddle_1_1")(1, *sp.symbols("M J F G"))
    assert out(graph, entry) == expected
    assert from_sympy(expected, graph) == entry
    with pytest.raises(ExpressionError, match="solve_saddle_1_1"):
        from_sympy(expected.func(1, m), graph)


def test_functions_of_the_user_go_by_their_names(graph: Graph) -> None:
    node = graph.many(
        op.CALL, (graph.symbol(TIME), graph.symbol(Symbol("m"))), graph.function(Table("table"))
    )
    expression = out(graph, node)
    assert expression == sp.Function("table")(t, m)
    assert from_sympy(expression * 2, graph) == mul(graph, 2, node)
    alone = graph.many(op.CALL, (graph.symbol(TIME),), graph.function(Table("one")))
    assert from_sympy(sp.Function("one")(t), graph) == alone


class Table:
    """A function of the user."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self, *arguments: float) -> float:
        return sum(arguments)

    def derivative(self, position: int) -> Table:
        return Table(f"{self.name}_{position}")


def test_one_name_for_two_things_of_time_is_an_error(graph: Graph) -> None:
    total = add(
        graph, graph.symbol(Symbol("x", SymbolKind.COORDINATE)), graph.symbol(Symbol("x", SymbolKind.SPEED))
    )
    with pytest.raises(ExpressionError, match="the coordinate and the speed 'x'"):
        to_sympy(graph, [total])
    assert to_sympy(
        graph, [add(graph, graph.symbol(Symbol("x", SymbolKind.COORDINATE)), graph.symbol(Symbol("x")))]
    ) == [x + sp.Symbol("x")]


def test_matrices_and_equations(graph: Graph) -> None:
    a, b = (graph.symbol(Symbol(name)) for name in "mk")
    assert sympy_matrix(graph, 2, 1, [a, b]) == sp.Matrix([m, k])
    assert sympy_matrix(graph, 0, 3, []).shape == (0, 3)
    assert sympy_equations(graph, [a, b], [b, b]) == [sp.Eq(m, k), sp.Eq(k, k, evaluate=False)]


# --- in ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "expression",
    [
        m * x.diff(t, 2) + d * x.diff(t) + k * x - dynamicsymbols("F"), (x + y) ** 2 / (m * l),
        sp.sqrt(x) ** 3, sp.E,
        sp.E**x + sp.exp(2) + sp.pi, sp.tan(x) / sp.cosh(y) ** 2,
        sp.log(x) * sp.asin(m) * sp.acos(k) * sp.atan(l),
        sp.atan2(y, x), sp.Abs(x) * sp.sign(y), sp.floor(x / l), sp.sinh(x) + sp.tanh(y),
        sp.Max(x, y, l) - sp.Min(x, 3),
        sp.Piecewise((x, x > 0), (y, sp.Or(x < y, y < -1)), (0, True)),
        sp.Piecewise((1, sp.Eq(x, y)), (2, True)),
        x**m, 2**x, x ** sp.Rational(-1, 3), x**-2, 0.5 * x + sp.Rational(1, 3), sp.cos(x + sp.pi / 5),
        x / 3 - y * sp.pi,
        sp.Piecewise((x, sp.Or(sp.Not(sp.And(x < y, m < k)), y > 3)), (1, True)),
        dynamicsymbols("z").diff(t, 7), t**2 * sp.sin(3 * t),
        1 / (x * sp.sqrt(m)), sp.exp(-x / l) * sp.exp(y),
    ],
    ids=str,
)  # fmt: skip
def test_in_and_out_again_for_what_users_write(expression: sp.Expr, graph: Graph) -> None:
    assert out(graph, from_sympy(expression, graph)) == expression


@pytest.mark.parametrize(
    ("expression", "same"),
    [
        (sp.sec(x), 1 / sp.cos(x)), (sp.csc(x), 1 / sp.sin(x)), (sp.cot(x), sp.cos(x) / sp.sin(x)),
        (sp.sech(x), 1 / sp.cosh(x)), (sp.csch(x), 1 / sp.sinh(x)), (sp.coth(x), sp.cosh(x) / sp.sinh(x)),
        (sp.Mod(x, m), x - m * sp.floor(x / m)), (sp.ceiling(x), -sp.floor(-x)),
        (sp.frac(x), x - sp.floor(x)),
        (sp.Heaviside(x), sp.Piecewise((0, x < 0), (1, x > 0), (sp.S.Half, True))),
        (x**2.0, x**2), (x**0.5, sp.sqrt(x)), (sp.Float("0.3", 40) * x, sp.Float(0.3) * x),
        (sp.Piecewise((x, sp.Ne(x, y)), (0, True)), sp.Piecewise((0, sp.Eq(x, y)), (x, True))),
        ((m - k) * (k - m), -((m - k) ** 2)),
        (sp.Piecewise((x, sp.ITE(x < y, y < m, m < k)), (0, True)),
         sp.Piecewise((x, ((x < y) & (y < m)) | ((x >= y) & (m < k))), (0, True))),
        (sp.Pow(sp.E, x, evaluate=False), sp.exp(x)),
        (sp.Mul(2, x + y, evaluate=False), 2 * x + 2 * y),
        (Fraction(1, 3), sp.Rational(1, 3)), (7, sp.Integer(7)), (0.25, sp.Float(0.25)),
    ],
    ids=str,
)  # fmt: skip
def test_what_the_graph_writes_otherwise(expression: sp.Expr, same: sp.Expr, graph: Graph) -> None:
    assert out(graph, from_sympy(expression, graph)) == same


def test_a_product_is_read_as_one_quotient(graph: Graph) -> None:
    M, K, L = (graph.symbol(Symbol(name)) for name in "mkl")
    assert from_sympy(m * l / k, graph) == div(graph, mul(graph, M, L), K)
    assert from_sympy(-3 / (2 * m), graph) == neg(graph, div(graph, graph.constant(Fraction(3, 2)), M))
    assert from_sympy(l - m - k, graph) == sub(graph, L, add(graph, M, K))
    assert from_sympy(1 / sp.sqrt(m), graph) == div(
        graph, ONE, power(graph, M, graph.constant(Fraction(1, 2)))
    )


def test_the_order_of_terms_and_the_age_of_symbols_do_not_matter(graph: Graph) -> None:
    other = Graph()
    for name in "zyxw":
        other.symbol(Symbol(name))
    a, b, c, e = sp.symbols("w x y z")
    expression = a * b + sp.Max(a, b, c) + c * e * a / b - e
    turned = sp.Add(-e, *reversed(sp.Add.make_args(expression + e)), evaluate=False)
    nodes = [from_sympy(expression, graph), from_sympy(turned, graph)]
    assert nodes[0] == nodes[1]
    assert other.hashes[from_sympy(expression, other)] == graph.hashes[nodes[0]]


def test_names_are_looked_up_and_derivatives_follow(graph: Graph) -> None:
    seen: list[tuple[str, bool]] = []

    def lookup(name: str, of_time: bool) -> Symbol:
        seen.append((name, of_time))
        return Symbol(
            name.upper(),
            SymbolKind.INPUT if name == "x" else SymbolKind.SPEED if of_time else SymbolKind.PARAMETER,
        )

    node = from_sympy(m * x.diff(t) + y * t, graph, lookup)
    rate = graph.symbol(Symbol("X", SymbolKind.INPUT, 1))
    M, Y = graph.symbol(Symbol("M")), graph.symbol(Symbol("Y", SymbolKind.SPEED))
    assert node == add(graph, mul(graph, M, rate), mul(graph, Y, graph.symbol(TIME)))
    assert sorted(seen) == [("m", False), ("x", True), ("y", True)]


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        (sp.I * x, r"'I' \(ImaginaryUnit\)"), (sp.oo, r"'oo' \(Infinity\)"), (sp.nan, r"'nan' \(NaN\)"),
        (sp.zoo, r"'zoo' \(ComplexInfinity\)"), (sp.Matrix([x]), "ImmutableDenseMatrix|MutableDenseMatrix"),
        (sp.Integral(x, t), r"Integral\(x\(t\), t\)' \(Integral\)"), (sp.gamma(x), r"'gamma\(x\(t\)\)'"),
        (sp.Function("f")(m), r"'f\(m\)' \(f\) is a function of something other(.|\n)*dynamicsymbols"),
        (sp.Function("f")(x, t), "function of something other"), (sp.MatrixSymbol("A", 2, 2), "'A'"),
        (sp.Derivative(x * y, t), r"compound(.|\n)*doit"),
        (sp.Derivative(x, (t, m)), "not a time derivative"),
        (sp.Derivative(sp.Function("f")(m), m), "compound"),
        (sp.Eq(x, y), r"is true or false(.|\n)*a - b"),
        (x < y, "is true or false"), (sp.true, "is true or false"),
        (sp.And(sp.Symbol("p"), x < y), r"'p' \(Symbol\) is not a condition, as And needs"),
        (sp.Piecewise((x, sp.Symbol("p")), (y, True)), r"'p' \(Symbol\) is not a condition"),
        (sp.Piecewise((x, x < y)), r"no value for the remaining cases(.|\n)*\(value, True\)"),
        (sp.Float("1e400"), "Float"), (sp.Tuple(x, y), "Tuple"), (sp.EulerGamma, "EulerGamma"),
        ("x", "'x' \\(str\\)"), (True, "bool"), (1j, "complex"), (float("nan"), "float"), (None, "NoneType"),
        (sp.Function("f"), "'f'"), (sp.Sum(x, (m, 1, 3)), "Sum"), (sp.Xor(x < y, y < m), "Xor"),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_real_formula_is_named(expression: object, message: str, graph: Graph) -> None:
    with pytest.raises(ExpressionError, match=message) as caught:
        from_sympy(expression, graph)
    assert caught.value.problems[0].fix


def test_a_long_offender_is_not_written_out(graph: Graph) -> None:
    inner = sp.Add(*(sp.sin(sp.Symbol(f"a{i}")) for i in range(1000)))
    with pytest.raises(ExpressionError, match="a long expression"):
        from_sympy(sp.Integral(inner, m), graph)


@pytest.mark.parametrize(
    ("expressions", "message"),
    [
        ([m + sp.Symbol("m", real=True)], r"'m': Symbol\('m'(, real=True)?\) and Symbol\('m'"),
        ([m, sp.Symbol("m", positive=True)], "positive=True"),
        ([x + sp.Function("x", real=True)(t)], "two symbols have the name 'x'"),
        ([sp.Symbol("t", real=True)], "two symbols have the name 't'"),
        ([sp.Dummy("a") + sp.Dummy("a")], "dummy_index"),
    ],
)
def test_symbols_that_differ_in_assumptions_only_are_an_error(
    expressions: Sequence[sp.Expr], message: str, graph: Graph
) -> None:
    with pytest.raises(ExpressionError, match=message):
        nodes_from_sympy(expressions, graph)


def test_one_symbol_with_assumptions_is_a_name(graph: Graph) -> None:
    assert from_sympy(sp.Symbol("m", positive=True), graph) == graph.symbol(Symbol("m"))


# --- size -------------------------------------------------------------------------------------


def test_a_sum_of_5000_terms(graph: Graph) -> None:
    q = total = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    for i in range(5_000):
        term = graph.symbol(Symbol(f"a{i}"))
        total = add(graph, total, mul(graph, term, q)) if i % 3 else sub(graph, total, term)
    expression = out(graph, total)
    assert len(expression.args) == 5_001
    assert fingerprint(graph, from_sympy(expression, graph)) == fingerprint(graph, total)


LEVELS: dict[str, Callable[[Graph, int, int], int]] = {
    "sin": lambda g, a, c: apply(g, op.SIN, a),
    "sinh of sum": lambda g, a, c: apply(g, op.SINH, add(g, a, c)),
    "tanh": lambda g, a, c: apply(g, op.TANH, a),
    "log": lambda g, a, c: apply(g, op.LOG, a),
    "sqrt of sum": lambda g, a, c: apply(g, op.SQRT, add(g, a, ONE)),
    "quotient": lambda g, a, c: div(g, c, add(g, a, ONE)),
    "square of sum": lambda g, a, c: power(g, add(g, a, c), 2),
    "power": lambda g, a, c: power(g, add(g, a, ONE), c),
    "product of sum": lambda g, a, c: mul(g, add(g, a, ONE), c),
    "max": lambda g, a, c: apply(g, op.MAX, add(g, a, ONE), c),
    "choice": lambda g, a, c: select(g, apply(g, op.LT, a, c), mul(g, a, a), c),
    "condition": lambda g, a, c: select(g, apply(g, op.LT, c, a), ONE, c),
    "floor": lambda g, a, c: apply(g, op.FLOOR, div(g, a, c)),
    "atan2": lambda g, a, c: apply(g, op.ATAN2, a, c),
    "fma": lambda g, a, c: add(g, mul(g, apply(g, op.COS, a), c), ONE),
}


QUICK = ("sin", "quotient")


@pytest.mark.parametrize(
    "level", [pytest.param(name, marks=[] if name in QUICK else pytest.mark.exhaustive) for name in LEVELS]
)
def test_formulas_5000_levels_deep(level: str, graph: Graph) -> None:
    node, c = graph.symbol(Symbol("x", SymbolKind.COORDINATE)), graph.symbol(Symbol("m"))
    for _ in range(5000):
        node = LEVELS[level](graph, node, c)
    expression = out(graph, node)
    assert from_sympy(expression, graph) == node
    assert hash(expression) == hash(out(graph, node))


def doubling(graph: Graph, depth: int) -> Expr:
    q, a = symbol(graph, Symbol("x", SymbolKind.COORDINATE)), symbol(graph, Symbol("z1"))
    for _ in range(depth):
        q = (sin(q) * q + a) / 2
    return q


def test_definitions_keep_a_shared_formula_short(graph: Graph) -> None:
    roots = [doubling(graph, 40).index, mul(graph, 2, doubling(graph, 30).index)]
    assert tree_size(graph, roots[0]) > 10**12
    expressions, definitions = to_sympy_with_definitions(graph, roots)
    names = [str(name) for name, _ in definitions]
    assert names == [f"z{number}" for number in range(2, len(names) + 2)]
    known: dict[int, int] = {}
    for name, expression in definitions:
        assert expression.count_ops() < 10
        known[graph.symbol(Symbol(str(name)))] = substitute(graph, [from_sympy(expression, graph)], known)[0]
    again = substitute(graph, nodes_from_sympy(expressions, graph), known)
    assert [fingerprint(graph, node) for node in again] == [fingerprint(graph, node) for node in roots]


def test_without_need_there_are_no_definitions(graph: Graph) -> None:
    node = doubling(graph, 3).index
    assert to_sympy_with_definitions(graph, [node]) == (to_sympy(graph, [node]), [])
