"""Spanning trees of a linear graph: branches in order outward from the root, chords left over."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from symbody.graph.linear_graph import Edge, LinearGraph, breadth_first, closing_edges


@dataclass(frozen=True, slots=True)
class TreeBranch:
    """A tree edge, walked from the side of the root.

    Attributes
    ----------
    forward : bool
        True if the edge points away from the root.
    """

    edge: Edge
    parent: str
    child: str
    forward: bool


@dataclass(frozen=True, slots=True)
class SpanningTree:
    """Branches ordered so that every parent comes before its children, and the chords."""

    branches: tuple[TreeBranch, ...]
    chords: tuple[Edge, ...]


def least_forest(graph: LinearGraph, weights: Mapping[str, tuple[float, ...]]) -> tuple[Edge, ...]:
    """Return the edges of the spanning forest of least weight, ties broken by the order of the edges.

    Parameters
    ----------
    weights : mapping of edge name to tuple of float
        Reluctance to take the edge, compared entry by entry; edges not named come first.
    """
    # Sorting is stable: the order of the edges breaks ties.
    by_weight = sorted(graph.edges, key=lambda edge: weights.get(edge.name, ()))
    left_out = {edge.name for edge in closing_edges(by_weight)}
    return tuple(edge for edge in graph.edges if edge.name not in left_out)


def spanning_tree(graph: LinearGraph, names: Collection[str]) -> SpanningTree:
    """Return the tree of the edges `names`, which join every node to the root by one path."""
    branches = tuple(
        TreeBranch(edge, parent, child, edge.start == parent)
        for parent, edge, child in breadth_first((e for e in graph.edges if e.name in names), graph.root)
    )
    return SpanningTree(branches, tuple(edge for edge in graph.edges if edge.name not in names))
