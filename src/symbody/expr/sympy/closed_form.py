"""Closed forms of several outputs together, in symbols z1, z2, ... where they would grow too long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

import symbody.expr.sympy as border
from symbody.expr.arithmetic import ZERO, neg
from symbody.expr.canonical import make
from symbody.expr.fingerprints.merging import merge_equal
from symbody.expr.graph import Graph, copy_nodes
from symbody.expr.language.literals import EXACT_DIGITS
from symbody.expr.opcodes import ADD, FLOAT, MUL, NEG, RATIONAL, SUB
from symbody.expr.rewrite import substitute, tree_sizes
from symbody.expr.sequences.sequence import Roots
from symbody.expr.sympy.sympy_bridge import (
    SympyEquation,
    SympyExpr,
    SympyMatrix,
    to_sympy_with_definitions,
)
from symbody.expr.trigonometry.normal_form import trigonometric_form

# Operations of a formula that somebody will read, and of all such formulas together.
_READABLE: Final = 1_000
_READABLE_TOGETHER: Final = 2_000
_MERGED: Final = 5_000
# Smaller constants stay rounded ones; their reciprocals bound large ones: exact decimals have few digits.
_LEAST: Final = 1e-30
# Beside the largest term of a sum: products of a few constants of 17 digits are wrong by some 1e-16 each.
_NOISE: Final = 1e-14


@dataclass(frozen=True, slots=True)
class ClosedForms:
    """Outputs as SymPy matrices that share one list of definitions.

    Attributes
    ----------
    matrices : mapping of output name to matrix
        Scalars are 1 x 1, vectors are columns.
    definitions : tuple of (symbol, expression)
        z1, z2, ..., each in terms of earlier ones; empty while every entry can be written out.
    """

    matrices: Mapping[str, SympyMatrix]
    definitions: tuple[tuple[SympyExpr, SympyExpr], ...]


def equations_between(left: SympyMatrix, right: SympyMatrix) -> list[SympyEquation]:
    """Return ``left = right``, entry by entry, unevaluated."""
    return border.sympy_writer.equations_between(left, right)


def readable(graph: Graph, nodes: Sequence[int], quaternions: Sequence[tuple[int, ...]] = ()) -> list[int]:
    """Return nodes in the trigonometric normal form, as far as they are short enough to be read.

    What is equal is merged first, so that nothing that is zero is printed. Shorter nodes come first; together
    they may have `_READABLE_TOGETHER` operations written out, which bounds the time to a few seconds. Rounded
    constants count as the decimals that they are printed as, so that ``2.5*(sin(x)^2 + cos(x)^2)`` is one
    number whatever its digits; constants that come out with more digits than a double has are rounded again.

    Parameters
    ----------
    quaternions : sequence of four nodes
        Symbols whose squares add up to 1.
    """
    given, nodes = nodes, _with_decimals(graph, nodes)
    is_rounded = nodes != list(given)
    result = dict(zip(nodes, nodes, strict=True))
    short = [node for node, size in zip(nodes, tree_sizes(graph, nodes), strict=True) if size <= _MERGED]
    apart = Graph()
    merged = copy_nodes(apart, graph, merge_equal(graph, short, apart), {})
    result.update(zip(short, merged, strict=True))
    left = _READABLE_TOGETHER
    distinct = sorted(set(merged))
    forms: dict[int, int] = {}
    for size, node in sorted(zip(tree_sizes(graph, distinct), distinct, strict=True)):
        left -= size
        if size > _READABLE or left < 0:
            break
        (forms[node],) = trigonometric_form(graph, [node], quaternions, _NOISE if is_rounded else 0.0)
    shown = [forms.get(result[node], result[node]) for node in nodes]
    return _with_rounded(graph, shown, given) if is_rounded else shown


def _with_decimals(graph: Graph, nodes: Sequence[int]) -> list[int]:
    """Return nodes with each rounded constant as the exact decimal that it is printed as.

    Constants fold while they are put in. What is left of two that cancel but for their last digits is 0, as
    in sums of polynomials: ``0.3333333333333333 - 2*0.16666666666666666`` is no 2e-17.
    """
    constants = {node: graph.number(node) for node in graph.reachable(nodes) if graph.ops[node] == FLOAT}
    decimals = {
        node: graph.constant(Fraction(repr(value)))
        for node, value in constants.items()
        if isinstance(value, float) and (value == 0.0 or _LEAST < abs(value) < 1.0 / _LEAST)
    }
    return substitute(graph, nodes, decimals, _without_noise) if decimals else list(nodes)


def _without_noise(graph: Graph, op: int, operands: tuple[int, ...], datum: int) -> int:
    """Return a node; of a sum without what is left of constants, or multiples of one node, that cancel."""
    made = make(graph, op, operands, datum)
    if op not in (ADD, SUB):
        return made
    for split in (_addend, _factor):
        (left, rest), *terms = (split(graph, node) for node in (made, *operands))
        sizes = [abs(term) for term, _ in terms]
        is_one = split is _addend or all(node == rest for _, node in terms)
        is_rounded = max(size.numerator for size in sizes) >= 10**EXACT_DIGITS
        if left and is_one and is_rounded and abs(left) < _NOISE * min(sizes):
            return rest if split is _addend else ZERO
    return made


def _addend(graph: Graph, node: int) -> tuple[Fraction, int]:
    """Return the constant in a sum, and the sum without it."""
    ops, number = graph.ops, _fraction(graph, node)
    if number is not None:
        return number, ZERO
    if ops[node] == NEG:
        found, rest = _addend(graph, graph.left[node])
        return -found, neg(graph, rest)
    if ops[node] in (ADD, SUB):
        a, b = graph.operands(node)
        if (number := _fraction(graph, a)) is not None:
            return number, b if ops[node] == ADD else neg(graph, b)
        if (number := _fraction(graph, b)) is not None:
            return number if ops[node] == ADD else -number, a
    return Fraction(0), node


def _factor(graph: Graph, node: int) -> tuple[Fraction, int]:
    """Return the constant factor of a product, and the product without it."""
    if graph.ops[node] == NEG:
        found, rest = _factor(graph, graph.left[node])
        return -found, rest
    if graph.ops[node] == MUL:
        a, b = graph.operands(node)
        for number, rest in ((_fraction(graph, a), b), (_fraction(graph, b), a)):
            if number is not None:
                return number, rest
    return Fraction(1), node


def _fraction(graph: Graph, node: int) -> Fraction | None:
    number = graph.number(node) if graph.ops[node] == RATIONAL else None
    return None if number is None else Fraction(number)


def _with_rounded(graph: Graph, nodes: Sequence[int], given: Sequence[int]) -> list[int]:
    """Return nodes with exact constants of more digits than a double has as doubles."""
    return [_round_constants(graph, node, origin) for node, origin in zip(nodes, given, strict=True)]


def _round_constants(graph: Graph, node: int, origin: int) -> int:
    written = set(graph.reachable([origin]))
    numbers = {k: graph.number(k) for k in graph.reachable([node]) if graph.ops[k] == RATIONAL}
    exact = {k: Fraction(value) for k, value in numbers.items() if value is not None}
    rounded: dict[int, int] = {}
    for k, value in exact.items():
        if k not in written and max(abs(value.numerator), value.denominator) >= 10**EXACT_DIGITS:
            rounded[k] = graph.constant(_as_double(value))
    return substitute(graph, [node], rounded)[0] if rounded else node


def _as_double(value: Fraction) -> float | Fraction:
    """Return a number as a double; as a decimal where that has few digits."""
    text = repr(float(value))
    digits = text.partition("e")[0].replace(".", "").replace("-", "").strip("0")
    return Fraction(text) if len(digits) <= EXACT_DIGITS else float(value)


def closed_forms(graph: Graph, outputs: Sequence[Roots], limit: int) -> ClosedForms:
    """Return `outputs` as matrices; definitions are named if an entry exceeds `limit` operations."""
    nodes = [node for output in outputs for node in output.nodes]
    expressions, definitions = to_sympy_with_definitions(graph, nodes, limit)
    matrices = {}
    start = 0
    for output in outputs:
        stop = start + len(output.nodes)
        rows, columns = (*output.shape, 1, 1)[:2]
        matrices[output.name] = border.sympy_writer.filled_matrix(rows, columns, expressions[start:stop])
        start = stop
    return ClosedForms(matrices, tuple(definitions))
