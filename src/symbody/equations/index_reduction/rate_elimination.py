"""Rates eliminated from equations linear in them: which equations hold rates, and what the others say.

Rows are reduced one after another by the rows before them. A pivot that is a number or made of parameters
divides; any other multiplies, and what two rows owe to the same earlier pivot is divided out again: Bareiss
(1968), Sylvester's identity and multistep integer-preserving Gaussian elimination, for sparse rows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Final

from symbody.expr.canonical import ZERO, div, mul, sub
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.rewrite import dependence, symbols_of, tree_size
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence

# Points at which a pivot is looked at, to see how far from zero it stays.
_POINTS: Final = 12


@dataclass(frozen=True, slots=True)
class RateElimination:
    """What is left of ``A x' + b = 0`` when each row has lost what rows before it determine.

    Attributes
    ----------
    pivots : mapping of row to node
        What was divided or multiplied by in rows that determine a rate.
    left : mapping of row to node
        The value of every row without a rate of its own; 0 where it follows from the others.
    """

    pivots: Mapping[int, int]
    left: Mapping[int, int]


@dataclass(frozen=True, slots=True)
class _Reduced:
    """A row with a rate of its own."""

    row: int
    entries: Mapping[int, int]
    rest: int
    column: int
    pivot: int
    # The last row that multiplied this one; None where all were divided by.
    level: int | None
    is_safe: bool


def eliminate_rates(graph: Graph, matrix: Sequence[Sequence[int]], rest: Sequence[int]) -> RateElimination:
    """Reduce the rows of ``matrix x' + rest``, whose coefficients hold no rate.

    Earlier rows determine rates first. Whether a coefficient is zero is decided by its fingerprint; of those
    that are not, a number is taken before a parameter, and that before the one that stays farthest from zero.
    """
    done: list[_Reduced] = []
    left = {}
    for i, row in enumerate(matrix):
        entries = {j: node for j, node in enumerate(row) if node != ZERO}
        entries, value, level = _subtract_earlier_rows(graph, entries, rest[i], done)
        if entries:
            column, is_safe = _choose_pivot(graph, entries)
            done.append(_Reduced(i, entries, value, column, entries[column], level, is_safe))
        else:
            left[i] = ZERO if find_zeros(graph, [value])[0] else value
    return RateElimination({reduced.row: reduced.pivot for reduced in done}, left)


def _subtract_earlier_rows(
    graph: Graph, entries: dict[int, int], constant: int, done: Sequence[_Reduced]
) -> tuple[dict[int, int], int, int | None]:
    """Return a row reduced by those before it, without coefficients that vanish identically."""
    level: int | None = None
    for k, earlier in enumerate(done):
        factor = entries.get(earlier.column, ZERO)
        if factor == ZERO:
            continue
        columns = entries.keys() | earlier.entries.keys()
        if earlier.is_safe:
            share = div(graph, factor, earlier.pivot)
            entries = {
                j: sub(graph, entries.get(j, ZERO), mul(graph, share, earlier.entries.get(j, ZERO)))
                for j in columns
            }
            constant = sub(graph, constant, mul(graph, share, earlier.rest))
        else:
            common = None if level is None or level != earlier.level else done[level].pivot
            entries = {
                j: _cross_multiply(
                    graph, earlier, factor, entries.get(j, ZERO), earlier.entries.get(j, ZERO), common
                )
                for j in columns
            }
            constant = _cross_multiply(graph, earlier, factor, constant, earlier.rest, common)
            level = k
        del entries[earlier.column]
        entries = {j: entries[j] for j in sorted(entries) if entries[j] != ZERO}
    zero = find_zeros(graph, list(entries.values()))
    return (
        {j: node for (j, node), gone in zip(entries.items(), zero, strict=True) if not gone},
        constant,
        level,
    )


def _cross_multiply(
    graph: Graph, earlier: _Reduced, factor: int, own: int, other: int, common: int | None
) -> int:
    """Return ``(pivot own - factor other) / common``, where the division leaves no fraction."""
    result = sub(graph, mul(graph, earlier.pivot, own), mul(graph, factor, other))
    return result if common is None else div(graph, result, common)


def _choose_pivot(graph: Graph, entries: Mapping[int, int]) -> tuple[int, bool]:
    """Return the column of the best pivot, and whether it is a number or made of parameters."""
    kinds = dependence(graph, entries.values())
    numbers = [j for j, node in entries.items() if graph.number(node) is not None]
    if numbers:
        return numbers[0], True
    safe = [j for j, node in entries.items() if kinds[node] <= {SymbolKind.PARAMETER}]
    if safe:
        return min(safe, key=lambda j: (tree_size(graph, entries[j]), j)), True
    far = _farness(graph, list(entries.values()))
    best = max(zip(entries, far, strict=True), key=lambda pair: (pair[1], -pair[0]))
    return best[0], False


def _farness(graph: Graph, nodes: Sequence[int]) -> list[float]:
    """Return for each node its least over its largest magnitude at some points; 0 where the sign changes."""
    symbols = symbols_of(graph, nodes)
    places = {node: Input(f"{k}", "q", k) for k, node in enumerate(symbols)}
    sequence = build_sequence(graph, [Roots("values", (len(nodes),), tuple(nodes))], places)
    positive = [graph.symbols[graph.left[node]].kind == SymbolKind.PARAMETER for node in symbols]
    values = [
        evaluate_sequence(sequence, {"q": _point(start, positive)})[0] for start in range(1, _POINTS + 1)
    ]
    return [_margin(column) for column in zip(*values, strict=True)]


def _point(start: int, positive: Sequence[bool]) -> list[float]:
    """Return values of symbols, spread by the golden ratio: parameters positive, the others up to pi."""
    turns = ((start * (k + 1) * 0.6180339887498949) % 1.0 for k in count())
    return [
        0.5 + turn if above else math.pi * (2.0 * turn - 1.0)
        for turn, above in zip(turns, positive, strict=False)
    ]


def _margin(values: Sequence[float]) -> float:
    if not all(map(math.isfinite, values)) or min(values) < 0.0 < max(values):
        return 0.0
    sizes = list(map(abs, values))
    return min(sizes) / max(sizes) if max(sizes) > 0.0 else 0.0
