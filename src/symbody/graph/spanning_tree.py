"""Spanning trees of a linear graph: branches in order outward from the root, chords left over."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import networkx as nx

from symbody.graph.linear_graph import Edge, LinearGraph


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
    net = nx.MultiGraph()
    net.add_nodes_from(graph.nodes)
    # Sorting is stable, so the rank breaks ties by the order of the edges.
    for rank, edge in enumerate(sorted(graph.edges, key=lambda edge: weights.get(edge.name, ()))):
        net.add_edge(edge.start, edge.end, key=edge.name, weight=rank)
    chosen = {key for _, _, key in nx.minimum_spanning_edges(net, keys=True, data=False)}
    return tuple(edge for edge in graph.edges if edge.name in chosen)


def spanning_tree(graph: LinearGraph, names: Collection[str]) -> SpanningTree:
    """Return the tree of the edges `names`, which join every node to the root by one path."""
    tree = nx.Graph()
    tree.add_nodes_from(graph.nodes)
    for edge in graph.edges:
        if edge.name in names:
            tree.add_edge(edge.start, edge.end, edge=edge)
    branches = tuple(
        TreeBranch(edge := tree.edges[parent, child]["edge"], parent, child, edge.start == parent)
        for parent, child in nx.bfs_edges(tree, graph.root)
    )
    return SpanningTree(branches, tuple(edge for edge in graph.edges if edge.name not in names))
