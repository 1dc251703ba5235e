"""Closed forms of several outputs together, in symbols z1, z2, ... where they would grow too long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import sympy as sp

from symbody.expr.graph import Graph
from symbody.expr.rewrite import tree_size
from symbody.expr.sequence import Roots
from symbody.expr.sympy_bridge import (
    SympyEquation,
    SympyExpr,
    SympyMatrix,
    to_sympy_with_definitions,
)
from symbody.expr.trigonometry.normal_form import trigonometric_form

# Operations of a formula that somebody will read, and of all such formulas together.
_READABLE: Final = 500
_READABLE_TOGETHER: Final = 4_000


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

    def equations(self, left: str, right: str) -> list[SympyEquation]:
        """Return ``left = right``, entry by entry, unevaluated."""
        pairs = zip(self.matrices[left], self.matrices[right], strict=True)
        return [sp.Eq(a, b, evaluate=False) for a, b in pairs]


def readable(graph: Graph, nodes: Sequence[int]) -> list[int]:
    """Return nodes in the trigonometric normal form, as far as they are short enough to be read.

    Shorter ones come first; together they may have `_READABLE_TOGETHER` operations written out, which
    bounds the time to about a second.
    """
    result = list(nodes)
    left = _READABLE_TOGETHER
    for size, node in sorted({(tree_size(graph, node), node) for node in nodes}):
        left -= size
        if size > _READABLE or left < 0:
            break
        (form,) = trigonometric_form(graph, [node])
        result = [form if old == node else new for old, new in zip(nodes, result, strict=True)]
    return result


def closed_forms(graph: Graph, outputs: Sequence[Roots], limit: int) -> ClosedForms:
    """Return `outputs` as matrices; definitions are named if an entry exceeds `limit` operations."""
    nodes = [node for output in outputs for node in output.nodes]
    expressions, definitions = to_sympy_with_definitions(graph, nodes, limit)
    matrices = {}
    start = 0
    for output in outputs:
        stop = start + len(output.nodes)
        rows, columns = (*output.shape, 1, 1)[:2]
        matrices[output.name] = sp.Matrix(rows, columns, expressions[start:stop])
        start = stop
    return ClosedForms(matrices, tuple(definitions))
