"""Formulas as they are read: what rounded constants leave of terms that cancel is not shown, all else is."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from random import Random

import pytest

from symbody.expr.expression import Expr, cos, number, sin, symbol
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.opcodes import FLOAT, RATIONAL
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.sympy.closed_form import readable

C, S = 28.485710879997153, 58.463839414299457  # products with them differ in the last digit where C, S do
C2, S2 = 28.48571087999715, 58.46383941429945


def angles(names: str) -> tuple[Expr, ...]:
    graph = Graph()
    return tuple(symbol(graph, Symbol(name, SymbolKind.COORDINATE)) for name in names)


def values(graph: Graph, nodes: list[int]) -> list[float]:
    symbols = symbols_of(graph, nodes)
    places = {node: Input(str(k), "x", k) for k, node in enumerate(symbols)}
    program = build_sequence(graph, [Roots("", (len(nodes),), tuple(nodes))], places)
    (numbers,) = evaluate_sequence(program, {"x": [0.7 + 0.4 * k for k in range(len(symbols))]})
    return [float(each) for each in numbers]


def test_what_rounding_leaves_of_a_sum_is_no_factor_of_what_is_shown() -> None:
    x, y, z, v = angles("xyzv")
    rate = 7.219690490340161e-05 * sin(y) + 0.12003690082949512 * v**2
    turned = (C * sin(x) + S * cos(x)) * rate - C2 * rate * sin(x) - S2 * rate * cos(x)
    formula = turned + (2.335958067607967 * sin(z) + 62.48687830851311 * cos(z)) * rate
    (shown,) = readable(x.graph, [formula.index])
    given, written = values(x.graph, [formula.index, shown])
    assert abs(given - written) < 1e-11  # sums below 10 of products of constants that differ by 1e-15 of 58
    assert len(symbols_of(x.graph, [shown])) == 3  # x has cancelled
    constants = [x.graph.number(k) for k in x.graph.reachable([shown]) if x.graph.ops[k] in (FLOAT, RATIONAL)]
    assert min(abs(float(each)) for each in constants if each is not None) > 1e-5


def test_what_halves_of_a_length_leave_of_it_is_not_shown() -> None:
    x, y = angles("xy")
    length, half = 0.3333333333333333, 0.16666666666666666  # as decimals 2e-17 are between them
    for factor in (x, cos(x)):
        formula = (length + cos(y)) * factor - (half + sin(y)) * factor - (half - sin(y)) * factor
        (shown,) = readable(x.graph, [formula.index])
        given, written = values(x.graph, [formula.index, shown])
        assert abs(given - written) < 1e-14  # some rounding of sums below 10
        assert shown == (factor * cos(y)).index
    exact = (0.6 + cos(y)) * x - (0.3 + sin(y)) * x - (0.299999999999999 - sin(y)) * x
    (kept,) = readable(x.graph, [exact.index])
    numbers = [x.graph.number(k) for k in x.graph.reachable([kept])]
    assert Fraction(1, 10**15) in numbers  # both were written with digits that a double keeps


@pytest.mark.parametrize("seed", range(40))
def test_what_constants_leave_while_they_fold_is_not_shown(seed: int) -> None:
    """Parts of a number, given as doubles, put into a sum in any order beside what stays."""
    random = Random(seed)
    x, y = angles("xy")
    factor = random.choice([None, x, cos(x)])
    whole = random.uniform(0.1, 10.0)
    # Parts of a tenth or more: what is left, some 2e-16 of the whole, is below 1e-14 of each.
    cut = [whole * random.uniform(low, low + 0.2) for low in random.choice([(0.4,), (0.2, 0.6)])]
    parts = [whole, *(-(b - a) for a, b in pairwise([0.0, *cut, whole]))]
    terms = [number(x.graph, part) if factor is None else part * factor for part in parts]
    random.shuffle(terms)
    terms.insert(random.randrange(len(terms)), cos(y))
    formula = terms[0]
    for term in terms[1:]:
        formula = formula + term
    assert readable(x.graph, [formula.index]) == [cos(y).index]
    argument = y + whole
    for part in parts[1:]:
        argument = argument + part
    assert readable(x.graph, [sin(argument).index]) == [sin(y).index]


def test_small_constants_of_few_digits_stay() -> None:
    x, y = angles("xy")
    formula = C * S * sin(x) ** 2 + C * S * cos(x) ** 2 + 1e-20 * y * C * (sin(x) ** 2 + cos(x) ** 2) / C
    (shown,) = readable(x.graph, [formula.index])
    assert len(symbols_of(x.graph, [shown])) == 1  # of y, however small its factor is
