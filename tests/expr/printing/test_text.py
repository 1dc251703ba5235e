"""Expressions as text that reads as the same node."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import add, apply, make, mul, neg, power, select
from symbody.expr.expression import Expr, cos, maximum, sin, sqrt, symbol
from symbody.expr.graph import TIME, Constant, Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.language.formula import build
from symbody.expr.language.literals import read_number
from symbody.expr.parser import parse
from symbody.expr.printing.layout import number_text
from symbody.expr.printing.text import to_text
from tests.expr.strategies import Sample, both_tiers, built, samples

HALF = Fraction(1, 2)


def read(text: str, graph: Graph) -> int:
    """Return the node of a text whose names are the labels of the graph's symbols."""
    places = {known.label: known for known in graph.symbols}

    def lookup(name: str, column: int) -> int:
        return graph.pi() if name == "pi" else graph.symbol(places[name])

    return build(parse(text), graph, lookup)


@pytest.fixture
def graph() -> Graph:
    return Graph()


def parameters(graph: Graph, names: str) -> list[Expr]:
    return [symbol(graph, Symbol(name)) for name in names.split()]


@both_tiers
@given(samples())
def test_reading_the_text_gives_the_same_node(sample: Sample) -> None:
    graph = Graph()
    for node in built(sample.program, graph):
        assert read(to_text(graph, node), graph) == node


@st.composite
def conditions(draw: st.DrawFn) -> tuple[Graph, int]:
    """Return a choice whose condition is nested."""
    graph = Graph()
    values = [graph.symbol(Symbol(name)) for name in "xyz"] + [graph.constant(HALF)]
    value = st.sampled_from(values)
    pool = [
        make(graph, draw(st.sampled_from([op.LT, op.LE, op.EQ])), (draw(value), draw(value)))
        for _ in range(3)
    ]
    for _ in range(draw(st.integers(1, 6))):
        code = draw(st.sampled_from([op.AND, op.OR, op.NOT]))
        operands = [draw(st.sampled_from(pool)) for _ in range(op.ARITY[code])]
        pool.append(make(graph, code, tuple(operands)))
    return graph, select(graph, pool[-1], values[0], values[1])


@both_tiers
@given(conditions())
def test_reading_a_condition_gives_the_same_node(case: tuple[Graph, int]) -> None:
    graph, node = case
    assert read(to_text(graph, node), graph) == node


@pytest.mark.parametrize(
    ("build_it", "text"),
    [
        (lambda a, b, c: a - b, "a - b"),
        (lambda a, b, c: -(a - b), "b - a"),
        (lambda a, b, c: a * a * (b + c), "a**2*(b + c)"),
        (lambda a, b, c: -a * b, "-a*b"),
        (lambda a, b, c: -((a + b) ** 2), "-(a + b)**2"),
        (lambda a, b, c: a / (b * c), "a/(b*c)"),
        (lambda a, b, c: a / b / c, "a/b/c"),
        (lambda a, b, c: HALF * a, "a/2"),
        (lambda a, b, c: Fraction(3, 4) * a, "3/4*a"),
        (lambda a, b, c: Fraction(981, 100) * a, "9.81*a"),
        (lambda a, b, c: sqrt(a) * 2, "2*sqrt(a)"),
        (lambda a, b, c: a ** Fraction(2, 3), "a**(2/3)"),
        (lambda a, b, c: (a**b) ** c, "(a**b)**c"),
        (lambda a, b, c: a**-b, "a**(-b)"),
        (lambda a, b, c: a + 0.1, "0.10000000000000001 + a"),
        (lambda a, b, c: cos(a - b) + 1, "1 + cos(a - b)"),
        (lambda a, b, c: maximum(a, 0), "max(0, a)"),
    ],
)
def test_brackets_and_numbers(build_it: object, text: str, graph: Graph) -> None:
    assert callable(build_it)
    expression = build_it(*parameters(graph, "a b c"))
    # The order of commuting operands follows their hashes: the characters are the same.
    written = to_text(graph, expression.index)
    assert sorted(written) == sorted(text)
    assert read(text, graph) == read(written, graph) == expression.index


def test_grouping_is_kept_without_brackets_to_the_left(graph: Graph) -> None:
    a, b, c, d = (value.index for value in parameters(graph, "a b c d"))
    left = add(graph, add(graph, add(graph, a, b), c), d)
    balanced = add(graph, add(graph, a, b), add(graph, c, d))
    assert "(" not in to_text(graph, left)
    assert to_text(graph, balanced).count("(") == 1
    assert read(to_text(graph, left), graph) == left != balanced == read(to_text(graph, balanced), graph)


def test_symbols_are_written_by_their_labels(graph: Graph) -> None:
    x = Symbol("x", SymbolKind.COORDINATE)
    node = mul(graph, graph.symbol(x.derivative), graph.symbol(x.derivative.derivative))
    assert sorted(to_text(graph, node).split("*")) == ["x_ddot", "x_dot"]
    assert to_text(graph, graph.symbol(TIME)) == "t"


@pytest.mark.parametrize(
    "name", "I E S N O Q pi lambda beta test sum max True None nan inf sin t e j".split()
)
def test_any_word_is_a_name(name: str, graph: Graph) -> None:
    node = neg(graph, graph.symbol(Symbol(name)))
    assert to_text(graph, node) == f"-{name}"
    assert parse(f"-{name}").names == (name,)


@pytest.mark.parametrize(
    "name", ["x_{1}", "q1'", "a b", "if", "and", "1x", "", "x\u202e", "\uff58\u00b7", "\uff0b"]
)
def test_a_name_that_cannot_be_read_is_an_error(name: str, graph: Graph) -> None:
    with pytest.raises(ExpressionError, match="unwritable_name"):
        to_text(graph, graph.symbol(Symbol(name)))


@both_tiers
@given(
    st.one_of(
        st.integers(0, 10**40),
        st.fractions(0, 1000, max_denominator=10**6),
        st.decimals(0, 10**6, places=9).map(Fraction),
        st.integers(0, 40).map(lambda k: Fraction(1, 10**k)),
        st.floats(5e-324, 1.7e308),
    )
)
def test_reading_a_number_gives_the_same_constant(value: Constant) -> None:
    top, slash, bottom = number_text(value).partition("/")
    number = Fraction(read_number(top)) / Fraction(read_number(bottom)) if slash else read_number(top)
    assert (number, isinstance(number, float)) == (value, isinstance(value, float))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(1, 8), "1/8"), (Fraction(9, 2), "9/2"), (Fraction(1, 10), "0.1"),
        (Fraction(1, 16), "0.0625"),
        (Fraction(981, 100), "9.81"), (Fraction(1, 30), "1/30"), (Fraction(1, 10**20), "1e-20"),
        (Fraction(123, 10**12), "1.23e-10"), (Fraction(10**15 + 1, 10), "1000000000000001/10"), (7, "7"),
        (0.1, "0.10000000000000001"), (1e300, "1.0000000000000001e+300"), (2.0, "2.0000000000000000"),
    ],
)  # fmt: skip
def test_how_numbers_are_written(value: Constant, text: str) -> None:
    assert number_text(value) == text


def test_a_long_sum_is_written_in_linear_time(graph: Graph) -> None:
    total = graph.symbol(Symbol("x"))
    for k in range(19_000):
        total = add(graph, total, graph.symbol(Symbol(f"a{k}")))
    assert to_text(graph, total).count("+") == 19_000


def test_a_deep_formula_is_written_without_recursion(graph: Graph) -> None:
    node = graph.symbol(Symbol("x"))
    for _ in range(5000):
        node = apply(graph, op.SIN, node)
    assert to_text(graph, node) == "sin(" * 5000 + "x" + ")" * 5000


def doubling(graph: Graph, depth: int) -> Expr:
    x, m = parameters(graph, "x m")
    for _ in range(depth):
        x = sin(x) * x + m
    return x


def test_a_formula_with_too_many_operations_is_an_error_that_tells_their_number(graph: Graph) -> None:
    with pytest.raises(ExpressionError, match=r"98301 operations.*\n.*\n.*z1, z2"):
        to_text(graph, doubling(graph, 15).index)
    with pytest.raises(ExpressionError, match=r"about 2\*\*5001 operations"):
        to_text(graph, doubling(graph, 5000).index)


def test_an_entry_of_a_kernel_has_no_text(graph: Graph) -> None:
    m, f = (value.index for value in parameters(graph, "m f"))
    entry = graph.node(op.PICK, graph.many(op.SADDLE, (m, f), graph.kernel(KernelNode(1, 0))), 0)
    with pytest.raises(ExpressionError, match="no_formula"):
        to_text(graph, power(graph, entry, graph.constant(2)))


def test_a_fused_product_is_written_as_sum(graph: Graph) -> None:
    operands = tuple(value.index for value in parameters(graph, "a b c"))
    assert to_text(graph, graph.many(op.FMA, operands)) == "a*b + c"
