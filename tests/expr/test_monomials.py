"""Expressions multiplied out: forms that are equal consist of the same products."""

from __future__ import annotations

from fractions import Fraction

import pytest

from symbody.expr.fingerprints.monomials import MOST, Monomials, monomials
from symbody.expr.graph import Graph, Symbol
from symbody.expr.language.formula import Formula, build


def products(*texts: str) -> list[Monomials]:
    graph = Graph()
    nodes = [
        build(Formula.from_value(text), graph, lambda name, _: graph.symbol(Symbol(name))) for text in texts
    ]
    found = monomials(graph, nodes)
    return [found[node] for node in nodes]


@pytest.mark.parametrize(
    ("left", "right", "count"),
    [
        ("a*(b + c)", "a*b + a*c", 2),
        ("(a + b)^2", "a^2 + 2*a*b + b^2", 3),
        ("(a - b)*(a + b)", "a^2 - b^2", 2),
        ("-(a - b)/2", "b/2 - a/2", 2),
        ("m*(L/2)^2*sin(x - y)", "-sin(y - x)*L^2*m/4", 1),
        ("(a + b)/(c + d)", "a/(d + c) + b/(c + d)", 2),
        ("a - a", "0", 0),
        ("3 + a*0", "3", 1),
    ],
)
def test_equal_expressions_have_equal_products(left: str, right: str, count: int) -> None:
    first, second = products(left, right)
    assert first == second and len(first) == count


def test_factors_are_exact_and_others_differ() -> None:
    first, second, third = products("a*b/3", "a*b/2", "a*c")
    assert list(first.values()) == [Fraction(1, 3)] and first.keys() == second.keys()
    assert not first.keys() & third.keys()


def test_what_has_too_many_products_stays_one() -> None:
    many = "*".join(f"({'+'.join(f'x{j}_{k}' for k in range(10))})" for j in range(6))
    (found,) = products(many)
    assert 0 < len(found) <= MOST
