"""Expressions multiplied out, each product by its fingerprint: what a sum consists of, whatever its form."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Final

from symbody.expr.fingerprints.circle import Pair
from symbody.expr.fingerprints.fingerprint import PRIME, drop_sign, fingerprints
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, DIV, MUL, NEG, POW, SUB

Monomials = dict[Pair, Fraction]

MOST: Final = 4000  # products of one expression; what has more of them stays one
_HIGHEST: Final = 6  # power of a sum that is multiplied out
_ONE: Final[Pair] = (1, 1)


def monomials(graph: Graph, nodes: Sequence[int]) -> dict[int, Monomials]:
    """Return for each node the products it is the sum of: fingerprint of the product, and its factor.

    Factors of 0 are left out. Sums in divisors and in functions are not multiplied out, nor are those of more
    than `MOST` products.
    """
    reached = graph.reachable(nodes)
    values = fingerprints(graph, reached)
    expanded: dict[int, Monomials] = {}
    for node in reached:
        made = _expand(graph, node, values, expanded)
        expanded[node] = made if len(made) <= MOST else _atom(values[node])
    return {node: expanded[node] for node in nodes}


def _expand(graph: Graph, node: int, values: dict[int, Pair], expanded: dict[int, Monomials]) -> Monomials:
    number = graph.number(node)
    if number is not None:
        return {_ONE: Fraction(number)} if number else {}
    op, operands = graph.ops[node], graph.operands(node)
    if op in (ADD, SUB):
        return _add(expanded[operands[0]], expanded[operands[1]], 1 if op == ADD else -1)
    if op == NEG:
        return {pair: -factor for pair, factor in expanded[operands[0]].items()}
    if op == MUL:
        return _product(expanded[operands[0]], expanded[operands[1]]) or _as_monomials(values[node])
    if op == DIV:
        a, b = values[operands[1]]
        if a and b:
            inverse = _atom((pow(a, -1, PRIME), pow(b, -1, PRIME)))
            return _product(expanded[operands[0]], inverse) or _as_monomials(values[node])
    if op == POW:
        return _power(graph, node, values, expanded)
    return _atom(values[node])


def _power(graph: Graph, node: int, values: dict[int, Pair], expanded: dict[int, Monomials]) -> Monomials:
    base, exponent = graph.operands(node)
    times = graph.number(exponent)
    if not isinstance(times, int) or not 2 <= times <= _HIGHEST:
        return _atom(values[node])
    result = expanded[base]
    for _ in range(times - 1):
        result = _product(result, expanded[base])
    return result or _as_monomials(values[node])


def _atom(value: Pair) -> Monomials:
    """Return a node as one factor, not multiplied out, with the same fingerprint for both signs."""
    pair, flipped = drop_sign(value)
    return {pair: Fraction(-1 if flipped else 1)}


def _as_monomials(value: Pair) -> Monomials:
    return _atom(value) if any(value) else {}


def _add(left: Monomials, right: Monomials, sign: int) -> Monomials:
    result = dict(left)
    for pair, factor in right.items():
        total = result.get(pair, Fraction(0)) + sign * factor
        if total:
            result[pair] = total
        else:
            result.pop(pair, None)
    return result


def _product(left: Monomials, right: Monomials) -> Monomials:
    if len(left) * len(right) > MOST:
        return {}
    result: Monomials = {}
    for (a, b), factor in left.items():
        for (c, d), other in right.items():
            pair = (a * c % PRIME, b * d % PRIME)
            total = result.get(pair, Fraction(0)) + factor * other
            if total:
                result[pair] = total
            else:
                result.pop(pair, None)
    return result
