"""Which symbols may grow by whole turns: against shifting them."""

from __future__ import annotations

import math

import pytest
import sympy as sp

from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.expr.sympy.sympy_reader import nodes_from_sympy
from symbody.expr.trigonometry.whole_turns import turning_symbols

a, b, x = sp.symbols("a b x")
CASES = {
    sp.sin(a) * x + sp.cos(a + 2 * b): {"a", "b"},
    sp.cos(a / 2) + sp.sin(b): {"b"},
    sp.sin(a) + a * sp.cos(b): {"b"},
    sp.sin(a * b): set(),
    sp.sin(3 * a - b) ** 2 / (2 + sp.cos(b)) + sp.sqrt(3 + sp.sin(a)): {"a", "b"},
    sp.atan2(sp.sin(a), sp.cos(a)) + x: {"a"},
    sp.sin(a * sp.sin(b)): {"b"},
    sp.sin(-a / sp.Rational(1, 2)) + sp.cos(b * sp.Rational(3, 2)): {"a"},
    sp.sin(sp.sin(a)) + sp.exp(b): {"a"},
    x**2 + 1: set(),
}


@pytest.mark.parametrize("formula", CASES, ids=str)
def test_symbols_that_turn(formula: sp.Expr) -> None:
    graph = Graph()
    roots = nodes_from_sympy([formula], graph, lambda name, of_time: Symbol(name, SymbolKind.PARAMETER))
    nodes = {graph.symbols[graph.left[node]].name: node for node in symbols_of(graph, roots)}
    found = turning_symbols(graph, roots, list(nodes.values()))
    assert {name for name, node in nodes.items() if node in found} == CASES[formula]
    at = {a: 0.3, b: 0.7, x: 1.1}
    for name in nodes:
        turned = at | {sp.Symbol(name): at[sp.Symbol(name)] + 2 * math.pi}
        # 1e-12 is 1e3 roundings of numbers of order 1; what changes, changes by more than 1e-3.
        same = abs(float(formula.subs(turned)) - float(formula.subs(at))) < 1e-12
        assert same == (name in CASES[formula])
