"""Which coordinates enter constraints linearly: Newton's method goes any distance along these.

A row is linear in the coordinates that may move where none of its derivatives by these depends on one of
these. Sets of coordinates are whole numbers here: bit k stands for coordinate k.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.expr.calculus import jacobian
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, ARITY, CALL, COS, FLOOR, MAP, MUL, NEG, SIGN, SIN, SUB

Flags = NDArray[np.bool_]

# Functions whose derivative says nothing of how they change over a finite distance.
_STEPS: Final = frozenset({SIGN, FLOOR, CALL, MAP})


class RowCurvature(NamedTuple):
    """Where a row is not linear.

    Attributes
    ----------
    slopes : tuple of (column, set)
        The coordinates on which the derivative by a coordinate depends, where it depends on any.
    stepped : set
        The coordinates inside functions that derivatives do not tell of, such as steps.
    inside : set
        All coordinates that the row depends on.
    """

    slopes: tuple[tuple[int, int], ...]
    stepped: int
    inside: int


def row_curvatures(eqs: EquationSet) -> tuple[RowCurvature, ...]:
    """Return the curvature of each constraint on positions."""

    def make() -> tuple[RowCurvature, ...]:
        return _row_curvatures(eqs, eqs.roots("constraints").nodes, eqs.roots("position_jacobian").nodes)

    rows: tuple[RowCurvature, ...] = eqs.plans.get("curvatures", make)
    return rows


def output_curvature(eqs: EquationSet, name: str) -> RowCurvature:
    """Return the curvature of an output that is one number."""

    def make() -> RowCurvature:
        nodes = eqs.roots(name).nodes
        slopes = jacobian(eqs.formed.graph, nodes, _coordinates(eqs))
        return _row_curvatures(eqs, nodes, slopes[0])[0]

    row: RowCurvature = eqs.plans.get(("curvature", name), make)
    return row


def _row_curvatures(
    eqs: EquationSet, values: Sequence[int], slopes: Sequence[int]
) -> tuple[RowCurvature, ...]:
    n = len(eqs.coordinate_names)
    inside, stepped = _dependence(eqs.formed.graph, _coordinates(eqs), [*values, *slopes])
    return tuple(
        RowCurvature(
            tuple((j, inside[slope]) for j, slope in enumerate(slopes[i * n : (i + 1) * n]) if inside[slope]),
            stepped[value],
            inside[value],
        )
        for i, value in enumerate(values)
    )


def _coordinates(eqs: EquationSet) -> list[int]:
    return [eqs.formed.graph.symbol(symbol) for symbol in eqs.formed.q]


def curved_coordinates(rows: Sequence[RowCurvature], free: Flags) -> tuple[Flags, Flags]:
    """Return which coordinates enter rows in any other way than linearly, and which rows are linear.

    Parameters
    ----------
    free : (n,) array of bool
        Mask of the coordinates that may move.
    """
    may_move = sum(1 << k for k in np.flatnonzero(free).tolist())
    curved, linear = 0, np.ones(len(rows), dtype=np.bool_)
    for i, row in enumerate(rows):
        own = row.stepped & may_move
        for j, inside in row.slopes:
            if free[j] and inside & may_move:
                own |= inside & may_move | 1 << j
        curved |= own
        linear[i] = not own
    return _mask(curved, free.size), linear


def limited_coordinates(eqs: EquationSet) -> Flags:
    """Return a mask of the coordinates (n_q,) in which constraints are not linear, whatever is held."""
    curved, _ = curved_coordinates(row_curvatures(eqs), np.ones(len(eqs.coordinate_names), dtype=np.bool_))
    for four in eqs.quaternions:
        curved[[eqs.coordinate_names.index(name) for name in four]] = True
    return curved


def curved_places(eqs: EquationSet, values: Iterable[int], slopes: Iterable[int]) -> Flags:
    """Return a mask of the coordinates (n_q,) in which nodes with these derivatives are not linear."""
    values, slopes = list(values), list(slopes)
    inside, stepped = _dependence(eqs.formed.graph, _coordinates(eqs), values + slopes)
    curved = 0
    for node in slopes:
        curved |= inside[node]
    for node in values:
        curved |= stepped[node]
    return _mask(curved, len(eqs.coordinate_names))


def cyclic_coordinates(eqs: EquationSet) -> Flags:
    """Return a mask of the coordinates (n_q,) after a whole turn of which all constraints are the same.

    They stand in sines and cosines of whole multiples alone.
    """

    def make() -> Flags:
        graph = eqs.formed.graph
        place = {node: k for k, node in enumerate(_coordinates(eqs))}
        roots = eqs.roots("constraints").nodes
        turning: dict[
            int, dict[int, int] | None
        ] = {}  # whole multiples of coordinates that a node is the sum of
        bare: dict[int, int] = {}
        for node in graph.reachable(roots):
            op, operands = graph.ops[node], _operands(graph, node)
            turning[node] = {place[node]: 1} if node in place else _whole_sum(graph, node, turning)
            bare[node] = 1 << place[node] if node in place else 0
            for operand in operands:
                bare[node] |= bare[operand]
            if op in (SIN, COS) and turning[operands[0]] is not None:
                bare[node] = 0
        everything = 0
        for root in roots:
            everything |= bare[root]
        return ~_mask(everything, len(place))

    mask: Flags = eqs.plans.get("cyclic coordinates", make)
    return mask


def _whole_sum(
    graph: Graph, node: int, turning: Mapping[int, dict[int, int] | None]
) -> dict[int, int] | None:
    """Return the whole multiples of coordinates that a node is the sum of, with what none of them is in."""
    op, operands = graph.ops[node], _operands(graph, node)
    parts = [turning[operand] for operand in operands]
    if not any(part is None or part for part in parts):
        return {}  # no coordinate
    if op == MUL:
        factors = [graph.number(operand) for operand in operands]
        for factor, part in zip(factors, reversed(parts), strict=True):
            if isinstance(factor, int) and part is not None:
                return {k: factor * count for k, count in part.items()}
        return None
    if op not in (NEG, ADD, SUB) or None in parts:
        return None
    total: dict[int, int] = {}
    for sign, part in zip((-1,) if op == NEG else (1, -1 if op == SUB else 1), parts, strict=True):
        for k, count in (part or {}).items():
            total[k] = total.get(k, 0) + sign * count
    return total


def _operands(graph: Graph, node: int) -> tuple[int, ...]:
    arity = ARITY[graph.ops[node]]
    if arity < 0:
        return graph.operand_tuples[graph.left[node]]
    return (graph.left[node], graph.right[node])[:arity]


def _mask(places: int, size: int) -> Flags:
    return np.array([places >> k & 1 for k in range(size)], dtype=np.bool_)


def _dependence(
    graph: Graph, symbols: Sequence[int], roots: Sequence[int]
) -> tuple[dict[int, int], dict[int, int]]:
    """Return the symbols each node depends on, and those of them inside functions with steps."""
    place = {node: 1 << k for k, node in enumerate(symbols)}
    inside: dict[int, int] = {}
    stepped: dict[int, int] = {}
    for node in graph.reachable(roots):
        op = graph.ops[node]
        all_inside, in_steps = place.get(node, 0), 0
        for operand in _operands(graph, node):
            all_inside |= inside[operand]
            in_steps |= stepped[operand]
        inside[node], stepped[node] = all_inside, all_inside if op in _STEPS else in_steps
    return inside, stepped
