"""Nested sums and products as one."""

from __future__ import annotations

from fractions import Fraction

import pytest

from symbody.expr.canonical import add, apply, div, mul, neg, power, sub
from symbody.expr.graph import Graph, Symbol
from symbody.expr.opcodes import MAX, MIN
from symbody.expr.printing.flattening import linear_terms, nested_operands, power_factors


@pytest.fixture
def graph() -> Graph:
    return Graph()


def symbols(graph: Graph, names: str) -> list[int]:
    return [graph.symbol(Symbol(name)) for name in names]


def test_terms_of_nested_sums_carry_their_signs(graph: Graph) -> None:
    a, b, c, d = symbols(graph, "abcd")
    total = sub(graph, a, sub(graph, add(graph, b, c), mul(graph, graph.constant(3), d)))
    assert linear_terms(graph, total) == {a: 1, b: -1, c: -1, d: 3}
    assert linear_terms(graph, neg(graph, total)) == {a: -1, b: 1, c: 1, d: -3}


def test_terms_that_meet_are_added_and_may_vanish(graph: Graph) -> None:
    a, b, c = symbols(graph, "abc")
    total = add(graph, sub(graph, a, b), add(graph, add(graph, a, c), sub(graph, b, c)))
    assert linear_terms(graph, total) == {a: 2}
    assert linear_terms(graph, sub(graph, total, add(graph, c, sub(graph, add(graph, a, a), c)))) == {}


def test_numbers_are_multiplied_out_only_on_request(graph: Graph) -> None:
    a, b, c = symbols(graph, "abc")
    half = mul(graph, graph.constant(Fraction(1, 2)), add(graph, a, b))
    total = add(graph, c, half)
    assert linear_terms(graph, total) == {c: 1, half: 1}
    assert linear_terms(graph, total, distribute=True) == {c: 1, a: Fraction(1, 2), b: Fraction(1, 2)}


def test_kept_nodes_are_terms_and_factors_but_not_at_the_top(graph: Graph) -> None:
    a, b, c = symbols(graph, "abc")
    inner = add(graph, a, b)
    assert linear_terms(graph, sub(graph, inner, c), {inner}) == {inner: 1, c: -1}
    assert linear_terms(graph, inner, {inner}) == {a: 1, b: 1}
    product = mul(graph, a, b)
    assert power_factors(graph, div(graph, c, product), {product}) == ({c: 1}, {product: 1})
    assert power_factors(graph, product, {product}) == ({a: 1, b: 1}, {})


def test_factors_of_quotients_and_powers(graph: Graph) -> None:
    a, b, c, d = symbols(graph, "abcd")
    # (a b^2)^3 / (c / (d a))
    cube = power(graph, mul(graph, a, mul(graph, b, b)), graph.constant(3))
    node = div(graph, cube, div(graph, c, mul(graph, d, a)))
    assert power_factors(graph, node) == ({a: 4, b: 6, d: 1}, {c: 1})


def test_a_factor_is_not_cancelled_against_the_divisor(graph: Graph) -> None:
    a, b = symbols(graph, "ab")
    assert power_factors(graph, div(graph, mul(graph, a, b), a)) == ({a: 1, b: 1}, {a: 1})


def test_other_nodes_are_their_own_only_part(graph: Graph) -> None:
    (a,) = symbols(graph, "a")
    root = power(graph, a, graph.constant(Fraction(1, 3)))
    assert linear_terms(graph, root) == {root: 1}
    assert power_factors(graph, root) == ({root: 1}, {})


def test_nested_minima_give_each_operand_once_in_an_order_of_structure() -> None:
    found = []
    for names in ("abc", "cba"):
        graph = Graph()
        symbols(graph, names)
        a, b, c = symbols(graph, "abc")
        largest = apply(graph, MAX, a, b)
        node = apply(graph, MIN, apply(graph, MIN, a, largest), apply(graph, MIN, c, a))
        operands = nested_operands(graph, node)
        assert set(operands) == {a, c, largest}
        found.append([graph.hashes[k] for k in operands])
    assert found[0] == found[1]


def test_a_sum_that_doubles_a_thousand_times_takes_one_pass(graph: Graph) -> None:
    a, b = symbols(graph, "ab")
    node = add(graph, a, b)
    for _ in range(1000):
        node = add(graph, node, sub(graph, node, b))
    assert linear_terms(graph, node)[a] == 2**1000
