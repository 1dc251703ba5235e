"""Derivatives on the graph: forward along a direction, reverse from a root, by time, linear parts.

Derivatives are nodes of the same graph, so they share everything with what they are derivatives of.
Griewank & Walther, Evaluating Derivatives (2008), chapter 3.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet

from symbody.errors import FormulationError, Problem
from symbody.expr.branches import (
    ALWAYS,
    Weights,
    alternatives,
    chosen_tangent,
    hand_on,
    hand_on_within,
    join_branches,
    total,
)
from symbody.expr.canonical import ONE, ZERO, add, mul, sub
from symbody.expr.graph import Graph, KernelNode, SymbolKind
from symbody.expr.opcodes import PICK, SADDLE, SYMBOL
from symbody.expr.partials import partials
from symbody.expr.rewrite import substitute, symbols_of
from symbody.expr.sequences.program import unroll


def forward(graph: Graph, roots: Sequence[int], tangents: Mapping[int, int]) -> list[int]:
    """Return the derivatives of `roots` along a direction.

    Parameters
    ----------
    tangents : mapping of node to node
        Derivative of each seed; every other symbol counts as constant.
    """
    rates = dict(tangents)
    roots = unroll(graph, roots)
    for node in graph.reachable(roots):
        if node in rates:
            continue
        op = graph.ops[node]
        if op == PICK:
            _saddle_tangents(graph, graph.left[node], rates)
            rates.setdefault(node, ZERO)
        elif any(rates.get(k, ZERO) for k in graph.operands(node)) and op != SADDLE:
            rates[node] = _tangent(graph, node, rates)
    return [rates.get(root, ZERO) for root in roots]


def derivative(graph: Graph, roots: Sequence[int], by: int) -> list[int]:
    """Return the partial derivatives of `roots` by one node, usually a symbol."""
    return forward(graph, roots, {by: ONE})


def gradient(graph: Graph, root: int, by: Sequence[int]) -> list[int]:
    """Return the partial derivatives of one `root` by many nodes, each with the others held fixed."""
    (root,) = unroll(graph, [root])
    reached = graph.reachable([root])
    if _holds_saddle(graph, reached):
        return [forward(graph, [root], _one_of(by, node))[0] for node in by]
    relevant = set(by)
    for node in reached:
        if node not in relevant and not relevant.isdisjoint(graph.operands(node)):
            relevant.add(node)
    adjoint: dict[int, Weights] = {root: {ALWAYS: ONE}}
    stops = set(by)
    for node in reversed(reached):
        if node in adjoint and node not in stops:
            _hand_down(graph, node, join_branches(graph, adjoint.pop(node)), relevant, adjoint)
    return [total(graph, join_branches(graph, adjoint.get(node, {}))) for node in by]


def jacobian(graph: Graph, roots: Sequence[int], by: Sequence[int]) -> list[list[int]]:
    """Return the matrix of partial derivatives, one row a root, each with the other nodes held fixed."""
    if not by:
        return [[] for _ in roots]
    ahead = list(range(len(roots)))
    rows: dict[int, list[int]] = {}
    if len(roots) < len(by):
        # A saddle is differentiated forward: once for all roots, not once for each.
        unrolled = unroll(graph, roots)
        ahead = [k for k, root in enumerate(unrolled) if _holds_saddle(graph, graph.reachable([root]))]
        rows = {k: gradient(graph, roots[k], by) for k in set(range(len(roots))).difference(ahead)}
    columns = [forward(graph, [roots[k] for k in ahead], _one_of(by, node)) for node in by]
    rows |= dict(zip(ahead, map(list, zip(*columns, strict=True)), strict=True))
    return [rows[k] for k in range(len(roots))]


def time_derivative(graph: Graph, roots: Sequence[int], rates: Mapping[int, int] | None = None) -> list[int]:
    """Return total time derivatives.

    Parameters
    ----------
    rates : mapping of node to node, optional
        Rate of each symbol, for instance ``q' = N u``. Symbols not named take their own rate:
        time 1, parameters 0, everything else the symbol of one more derivative.
    """
    seeds = dict(rates or {})
    for node in symbols_of(graph, roots):
        if node not in seeds:
            symbol = graph.symbols[graph.left[node]]
            if symbol.kind == SymbolKind.TIME:
                seeds[node] = ONE
            elif symbol.kind != SymbolKind.PARAMETER:
                seeds[node] = graph.symbol(symbol.derivative)
    return forward(graph, roots, seeds)


def linear_coefficients(
    graph: Graph, roots: Sequence[int], unknowns: Sequence[int]
) -> tuple[list[list[int]], list[int]]:
    """Split ``roots = A unknowns + b``.

    Returns
    -------
    (A, b)
        `A` one row a root, free of the unknowns; `b` the roots with all unknowns zero.

    Raises
    ------
    FormulationError
        If a root is not linear in the unknowns, naming the unknown.
    """
    matrix = [gradient(graph, root, unknowns) for root in roots]
    chosen = set(unknowns)
    problems = []
    for i, row in enumerate(matrix):
        for unknown, slope in zip(unknowns, row, strict=True):
            if chosen.intersection(graph.reachable([slope])):
                problems.append(_not_linear(graph, i, unknown))
    if problems:
        raise FormulationError(*problems)
    return matrix, substitute(graph, roots, dict.fromkeys(unknowns, ZERO))


def _not_linear(graph: Graph, row: int, unknown: int) -> Problem:
    name = graph.symbols[graph.left[unknown]].label if graph.ops[unknown] == SYMBOL else f"node {unknown}"
    return Problem(
        "expression.not_linear", f"row {row}", f"the expression is not linear in {name}",
        "linear coefficients were asked for", "solve for quantities that enter linearly",
    )  # fmt: skip


def _holds_saddle(graph: Graph, nodes: Iterable[int]) -> bool:
    return any(graph.ops[node] == SADDLE for node in nodes)


def _one_of(by: Sequence[int], node: int) -> dict[int, int]:
    return {**dict.fromkeys(by, ZERO), node: ONE}


def _hand_down(
    graph: Graph, node: int, weights: Weights, relevant: AbstractSet[int], adjoint: dict[int, Weights]
) -> None:
    """Hand the weights of `node` on to its operands."""
    choices = alternatives(graph, node)
    for conditions, operand in choices:
        given = weights
        if operand is None:
            given = {}
            hand_on(graph, weights, node, given)
        for onto in graph.operands(node) if operand is None else (operand,):
            if onto in relevant:
                hand_on_within(graph, given, conditions, adjoint.setdefault(onto, {}))
    if choices:
        return
    for operand, slope in partials(graph, node):
        if operand in relevant:
            hand_on(graph, weights, slope, adjoint.setdefault(operand, {}))


def _tangent(graph: Graph, node: int, known: Mapping[int, int]) -> int:
    chosen = chosen_tangent(graph, node, known)
    if chosen is not None:
        return chosen
    result = ZERO
    for operand, slope in partials(graph, node):
        weight = known.get(operand, ZERO)
        if weight:
            result = add(graph, result, mul(graph, weight, slope))
    return result


def _saddle_tangents(graph: Graph, node: int, tangents: dict[int, int]) -> None:
    """Differentiate M a = F + J^T lambda, J a = gamma: the same matrix with other right-hand sides."""
    kernel = graph.kernels[graph.right[node]]
    operands = graph.operands(node)
    rates = [tangents.get(k, ZERO) for k in operands]
    n, m = kernel.n, kernel.m
    if not any(rates):
        return
    entry = [graph.node(PICK, node, k) for k in range(n + m)]
    if all(k in tangents for k in entry):
        return
    d_mass, d_jacobian = rates[: n * n], rates[n * n : n * n + m * n]
    d_force, d_gamma = rates[n * n + m * n : n * n + m * n + n], rates[n * n + m * n + n :]
    force = list(d_force)
    gamma = list(d_gamma)
    for i in range(n):
        for j in range(n):
            force[i] = sub(graph, force[i], mul(graph, d_mass[i * n + j], entry[j]))
        for k in range(m):
            force[i] = add(graph, force[i], mul(graph, d_jacobian[k * n + i], entry[n + k]))
    for k in range(m):
        for j in range(n):
            gamma[k] = sub(graph, gamma[k], mul(graph, d_jacobian[k * n + j], entry[j]))
    right = (*operands[: n * n + m * n], *force, *gamma)
    solved = graph.many(SADDLE, right, graph.kernel(KernelNode(n, m)))
    for k in range(n + m):
        tangents[entry[k]] = graph.node(PICK, solved, k)
