"""Closed forms of several outputs together, in symbols z1, z2, ... where they would grow too long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import symbody.expr.sympy as border
from symbody.expr.fingerprints.merging import merge_equal
from symbody.expr.graph import Graph, copy_nodes
from symbody.expr.rewrite import tree_sizes
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
    they may have `_READABLE_TOGETHER` operations written out, which bounds the time to a few seconds.

    Parameters
    ----------
    quaternions : sequence of four nodes
        Symbols whose squares add up to 1.
    """
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
        (forms[node],) = trigonometric_form(graph, [node], quaternions)
    return [forms.get(result[node], result[node]) for node in nodes]


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
