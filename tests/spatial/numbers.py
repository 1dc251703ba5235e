"""Numbers of expressions at one state, for comparison with other people's mathematics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.spatial.matrix import Matrix, Triple


def named(graph: Graph, names: str) -> tuple[Expr, ...]:
    return tuple(symbol(graph, Symbol(name, SymbolKind.COORDINATE)) for name in names.split())


def triple(graph: Graph, x: float, y: float, z: float) -> Triple:
    return (number(graph, x), number(graph, y), number(graph, z))


def matrix_of(graph: Graph, rows: Sequence[Sequence[float]]) -> Matrix:
    x, y, z = (triple(graph, *(float(entry) for entry in row)) for row in rows)
    return (x, y, z)


def values(graph: Graph, expressions: Sequence[Expr], at: Mapping[str, float]) -> np.ndarray:
    inputs = {
        graph.symbol(Symbol(name, SymbolKind.COORDINATE)): Input(name, "q", k) for k, name in enumerate(at)
    }
    roots = Roots("out", (len(expressions),), tuple(e.index for e in expressions))
    return np.array(evaluate_sequence(build_sequence(graph, [roots], inputs), {"q": list(at.values())})[0])


def matrix_values(graph: Graph, matrix: Matrix, at: Mapping[str, float]) -> np.ndarray:
    return values(graph, [entry for row in matrix for entry in row], at).reshape(3, 3)


def names_in(*expressions: Expr) -> set[str]:
    graph = expressions[0].graph
    return {graph.symbols[graph.left[k]].name for k in symbols_of(graph, [e.index for e in expressions])}
