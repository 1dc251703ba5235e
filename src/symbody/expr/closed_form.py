"""Closed forms of several outputs together, in symbols z1, z2, ... where they would grow too long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from symbody.expr.graph import Graph
from symbody.expr.sequence import Roots
from symbody.expr.sympy_bridge import (
    SympyEquation,
    SympyExpr,
    SympyMatrix,
    to_sympy_with_definitions,
)


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
