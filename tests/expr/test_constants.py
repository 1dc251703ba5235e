"""Constants: exact and rounded ones are different kinds, and neither is ever quietly changed."""

from __future__ import annotations

import decimal
import math
from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, neg, power, sub
from symbody.expr.constants import fold_function, fold_power, fold_product, fold_quotient, fold_sum
from symbody.expr.graph import Constant, Graph
from symbody.expr.language.formula import build
from symbody.expr.parser import parse
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from tests.expr.strategies import both_tiers, sequence_of

EXACT = st.one_of(st.integers(), st.fractions())
FINITE = st.floats(allow_nan=False, allow_infinity=False)


def test_zero_one_and_two_are_the_first_nodes() -> None:
    graph = Graph()
    assert [graph.constant(k) for k in (0, 1, 2)] == [ZERO, ONE, TWO] == [0, 1, 2]


def test_kinds_and_signs_of_equal_numbers_are_different_nodes() -> None:
    graph = Graph()
    nodes = [graph.constant(value) for value in (1, 1.0, 0, 0.0, -0.0, -1, -1.0)]
    assert len(set(nodes)) == len(nodes)
    assert [type(graph.number(node)) for node in nodes] == [int, float, int, float, float, int, float]
    assert [str(graph.number(node)) for node in nodes[3:5]] == ["0.0", "-0.0"]


def test_equal_exact_numbers_are_one_node() -> None:
    graph = Graph()
    assert graph.constant(Fraction(4, 2)) == TWO
    assert type(graph.number(graph.constant(Fraction(6, 2)))) is int
    assert graph.constant(Fraction(1, 3)) == graph.constant(Fraction(2, 6))


@pytest.mark.parametrize(
    "value",
    [True, False, math.nan, math.inf, -math.inf, 1j, 1 + 0j, "1", None, decimal.Decimal(1), [1]],
    ids=repr,
)
def test_what_is_no_finite_real_number_is_refused(value: Constant) -> None:
    graph = Graph()
    before = len(graph)
    with pytest.raises(ExpressionError) as caught:
        graph.constant(value)
    problem = caught.value.problems[0]
    assert problem.code == "expression.not_a_number"
    assert type(value).__name__ in problem.what
    assert problem.why
    assert problem.fix
    assert len(graph) == before


@both_tiers
@given(st.one_of(EXACT, FINITE))
def test_every_number_comes_back_as_it_was(value: Constant) -> None:
    graph = Graph()
    back = graph.number(graph.constant(value))
    assert back == value
    assert isinstance(back, float) == isinstance(value, float)
    assert math.copysign(1, back) == math.copysign(1, value) or value == 0 == Fraction(value)


@both_tiers
@given(EXACT.filter(bool))
def test_negative_numbers_are_negations(value: Constant) -> None:
    graph = Graph()
    assert graph.constant(-value) == neg(graph, graph.constant(value))
    assert op.NEG in (graph.ops[graph.constant(value)], graph.ops[graph.constant(-value)])


@pytest.mark.parametrize("text", ["0.1", "9.81", "123456789.012345", "1e-3", "2.50"])
def test_decimals_are_exact_and_print_as_written(text: str) -> None:
    graph = Graph()
    assert graph.number(build(parse(text), graph, lambda name, column: ZERO)) == Fraction(text)


@both_tiers
@given(EXACT, EXACT)
def test_exact_arithmetic_is_exact(x: Constant, y: Constant) -> None:
    graph = Graph()
    a, b = graph.constant(x), graph.constant(y)
    assert graph.number(add(graph, a, b)) == Fraction(x) + Fraction(y)
    assert graph.number(sub(graph, a, b)) == Fraction(x) - Fraction(y)
    assert graph.number(mul(graph, a, b)) == Fraction(x) * Fraction(y)
    if y:
        assert graph.number(div(graph, a, b)) == Fraction(x) / Fraction(y)


@both_tiers
@given(FINITE, st.one_of(FINITE, EXACT))
def test_rounded_arithmetic_is_that_of_floats(x: float, y: Constant) -> None:
    """One operation on two constants is folded as a processor would compute it, unless it overflows."""
    try:
        exact = Fraction(x) + Fraction(float(y))
        expected = x + float(y)
    except OverflowError:
        assert fold_sum(x, y) is None
        return
    assert fold_sum(x, y) == (expected if math.isfinite(expected) else None)
    if math.isfinite(expected):
        assert abs(Fraction(expected) - exact) <= abs(Fraction(expected)) / 2**53 + Fraction(1, 2**1074)


def test_numbers_stay_below_512_bits() -> None:
    """Beyond, operations stay unfolded, so no input can make the numbers of a graph explode."""
    graph = Graph()
    large, small = 2**511, Fraction(1, 2**511)
    assert fold_product(large, 1) == large
    assert fold_product(large, 2) is None
    assert fold_sum(large, large) is None
    assert fold_quotient(small, 2) is None
    assert fold_power(2, 511) == large
    assert fold_power(2, 512) is None
    assert fold_power(3, 10**9) is None
    node = graph.constant(3)
    for _ in range(40):
        node = mul(graph, node, node)
    assert max(int(value).bit_length() for value in graph.constants) <= 512
    assert power(graph, graph.constant(10), graph.constant(10**6)) == graph.node(
        op.POW, graph.constant(10), graph.constant(10**6)
    )


def test_overflow_of_floats_is_not_folded() -> None:
    graph = Graph()
    huge = graph.constant(1e308)
    assert graph.number(add(graph, huge, huge)) is None
    assert graph.number(power(graph, huge, TWO)) is None
    assert graph.number(apply(graph, op.EXP, graph.constant(1e4))) is None


@pytest.mark.parametrize(
    ("code", "operands", "expected"),
    [
        (op.SQRT, (Fraction(9, 4),), Fraction(3, 2)),
        (op.SQRT, (2,), None),
        (op.SQRT, (-4,), None),
        (op.SIN, (0,), 0),
        (op.COS, (0,), 1),
        (op.EXP, (0,), 1),
        (op.EXP, (1,), None),
        (op.LOG, (1,), 0),
        (op.LOG, (0,), None),
        (op.ACOS, (1,), 0),
        (op.ABS, (Fraction(-1, 3),), Fraction(1, 3)),
        (op.SIGN, (-7,), -1),
        (op.FLOOR, (Fraction(-1, 2),), -1),
        (op.SIN, (0.5,), math.sin(0.5)),
        (op.LOG, (-0.5,), None),
        (op.ASIN, (1.5,), None),
    ],
)
def test_functions_of_constants_fold_only_where_exact_or_rounded_already(
    code: int, operands: tuple[Constant, ...], expected: Constant | None
) -> None:
    assert fold_function(code, *operands) == expected


@pytest.mark.parametrize("twelfths", range(-30, 31))
def test_circular_functions_of_multiples_of_pi(twelfths: int) -> None:
    """Exact where the value is half a root of 0 to 4, else left alone; never rounded."""
    graph = Graph()
    angle = mul(graph, graph.constant(Fraction(twelfths, 12)), graph.pi())
    for code, function in ((op.SIN, mpmath.sin), (op.COS, mpmath.cos)):
        node = apply(graph, code, angle)
        codes = {graph.ops[k] for k in graph.reachable([node])}
        assert op.FLOAT not in codes
        assert (code in codes) == (twelfths % 2 == 1 and twelfths % 3 != 0)
        with mpmath.workdps(50):
            value = evaluate_sequence(sequence_of(graph, [node]), {}, MPMATH)[0][0]
            # pi, its multiple, the function and half a root round once each, all below 8
            assert abs(value - function(twelfths * mpmath.pi / 12)) < 8 * 10 * mpmath.mpf(10) ** -50
