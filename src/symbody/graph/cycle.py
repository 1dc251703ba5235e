"""The cycle that a message shows; loaded when there is one."""

from __future__ import annotations

from collections.abc import Iterable

import networkx as nx

from symbody.graph.linear_graph import Edge


def find_cycle(edges: Iterable[Edge]) -> list[tuple[str, str, str]]:
    """Return a cycle of edges as nodes and names: start, end, name.

    Raises
    ------
    networkx.NetworkXNoCycle
        If there is none.
    """
    net = nx.MultiGraph()
    net.add_edges_from((edge.start, edge.end, edge.name) for edge in edges)
    return list(nx.find_cycle(net))
