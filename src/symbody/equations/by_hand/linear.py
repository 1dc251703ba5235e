"""Lists of equations meant = 0: first order, linear about a point, as matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import gradient, linear_coefficients
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import substitute, symbols_of


def first_order_system(
    graph: Graph, equations: Sequence[int], variables: Sequence[Symbol]
) -> tuple[list[Symbol], list[int]]:
    """Return equations of first order, and their variables: the given ones, then their rates.

    A variable x with x'' gets a new one called x_dot for x' (x_ddot for x'' where there is x''', and so on);
    the equations come first, then ``-x_dot + x'``. Variables without second derivative stay.
    """
    orders = dict.fromkeys((v.name for v in variables), 0)
    for symbol in _functions(graph, equations):
        if symbol.name in orders:
            orders[symbol.name] = max(orders[symbol.name], symbol.order)
    replaced: dict[int, int] = {}
    added, closing = [], []
    for variable in variables:
        steps = [Symbol(variable.name, SymbolKind.COORDINATE, k) for k in range(orders[variable.name] + 1)]
        own = [steps[0], *(Symbol(step.label, SymbolKind.COORDINATE) for step in steps[1:-1])]
        if len(steps) < 3:
            continue
        added += own[1:]
        replaced |= {graph.symbol(a): graph.symbol(b) for a, b in zip(steps[1:-1], own[1:], strict=True)}
        replaced[graph.symbol(steps[-1])] = graph.symbol(own[-1].derivative)
        closing += [
            (Expr(graph, graph.symbol(low.derivative)) - Expr(graph, graph.symbol(high))).index
            for low, high in zip(own, own[1:], strict=False)
        ]
    return [*variables, *added], [*substitute(graph, equations, replaced), *closing]


def linearize_at(graph: Graph, equations: Sequence[int], point: Mapping[int, int]) -> list[int]:
    """Return ``f(x0) + sum of df/dx(x0) (x - x0)``.

    Parameters
    ----------
    point : mapping of node to node
        Each variable, or rate of one, and its value. Rates not named are 0 at the point.
    """
    named = {graph.symbols[graph.left[node]].name for node in point}
    at = dict(point)
    for symbol in _functions(graph, equations):
        if symbol.name in named and symbol.order:
            at.setdefault(graph.symbol(symbol), 0)
    values = substitute(graph, equations, at)
    unknowns = list(at)
    found = []
    for equation, value in zip(equations, values, strict=True):
        slopes = substitute(graph, gradient(graph, equation, unknowns), at)
        total = Expr(graph, value)
        for unknown, slope, gone in zip(unknowns, slopes, find_zeros(graph, slopes), strict=True):
            if not gone:
                total = total + Expr(graph, slope) * (Expr(graph, unknown) - Expr(graph, at[unknown]))
        found.append(total.index)
    return found


def coefficient_matrix(
    graph: Graph, equations: Sequence[int], unknowns: Sequence[int]
) -> tuple[list[list[int]], list[int]]:
    """Return A and b of ``A x = b``.

    Raises
    ------
    FormulationError
        If an equation is not linear in the unknowns.
    """
    matrix, rest = linear_coefficients(graph, equations, unknowns)
    return matrix, [(-Expr(graph, node)).index for node in rest]


def state_matrices(
    graph: Graph, equations: Sequence[int], variables: Sequence[Symbol]
) -> tuple[list[list[int]], list[list[int]], list[int]]:
    """Return aa, bb and cc of ``aa x' = bb x - cc``.

    Raises
    ------
    FormulationError
        If an equation is not linear in the variables and their first rates.
    """
    x = [graph.symbol(symbol) for symbol in variables]
    rates = [graph.symbol(symbol.derivative) for symbol in variables]
    high = sorted({s.label for s in _functions(graph, equations) if s.order > 1})
    if high:
        raise FormulationError(
            Problem("by_hand.not_first_order", ", ".join(high), "the equations are not of first order",
                    "in a state, each rate is a separate variable", "call first_order first")
        )  # fmt: skip
    left, rest = coefficient_matrix(graph, equations, rates)
    right, constants = coefficient_matrix(graph, rest, x)
    return left, right, constants


def _functions(graph: Graph, nodes: Sequence[int]) -> list[Symbol]:
    symbols = (graph.symbols[graph.left[node]] for node in symbols_of(graph, nodes))
    return [symbol for symbol in symbols if symbol.kind is SymbolKind.COORDINATE]
