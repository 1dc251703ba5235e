"""Curves on the graph: coefficients of the piece that `x` is in, chosen by halving, then one polynomial."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.expr import canonical
from symbody.expr.expression import Expr, number
from symbody.expr.opcodes import LT
from symbody.model.loads.curve import Curve


def curve_value(curve: Curve, x: Expr) -> Expr:
    """Return the value of a curve at `x`.

    Coefficients are chosen, not values: a derivative then shares the choice and costs next to nothing.
    NaN lies in the last piece and comes out as NaN.
    """
    return piecewise_value(curve.pieces(), x)


def piecewise_value(pieces: Sequence[Sequence[float]], x: Expr) -> Expr:
    """Return the value at `x` of polynomials ``(start, x0, c0, c1, ..)``, from left to right."""
    bounds = [_is_below(x, piece[0]) for piece in pieces[1:]]
    start, *coefficients = (
        _select_entry(bounds, column, x) for column in list(zip(*pieces, strict=True))[1:]
    )
    value = coefficients.pop()
    for coefficient in reversed(coefficients):
        value = coefficient + value * (x - start)
    return value


def _is_below(x: Expr, bound: float) -> int:
    return canonical.apply(x.graph, LT, x.index, x.graph.constant(bound))


def _select_entry(bounds: Sequence[int], column: Sequence[float], x: Expr) -> Expr:
    """Return the entry before whose upper bound `x` lies: neighbours are joined, then pairs of pairs."""
    graph = x.graph
    nodes = [number(graph, entry).index for entry in column]
    while len(nodes) > 1:
        pairs = zip(nodes[::2], bounds[::2], nodes[1::2], strict=False)
        joined = [canonical.select(graph, bound, left, right) for left, bound, right in pairs]
        nodes = joined + nodes[len(nodes) - len(nodes) % 2 :]
        bounds = bounds[1::2]
    return Expr(graph, nodes[0])
