"""The linear graph of a mechanism: nodes and edges, without any mechanics.

Words after Koenig, Tokad & Kesavan (1967) and McPhee (1998).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import networkx as nx


@dataclass(frozen=True, slots=True)
class Edge:
    """A directed edge; several may join the same two nodes."""

    name: str
    start: str
    end: str


@dataclass(frozen=True, slots=True)
class LinearGraph:
    """Nodes and edges; the first node is the root."""

    nodes: tuple[str, ...]
    edges: tuple[Edge, ...]

    @property
    def root(self) -> str:
        """The node that everything is reached from."""
        return self.nodes[0]

    def edge(self, name: str) -> Edge:
        """Return the edge called `name`."""
        return next(edge for edge in self.edges if edge.name == name)

    def unreached_nodes(
        self, names: Iterable[str] | None = None, from_nodes: Iterable[str] = ()
    ) -> tuple[str, ...]:
        """Return the nodes that the edges `names`, or all, do not join to the root or to `from_nodes`."""
        net = self._net(names)
        reached = nx.node_connected_component(net, self.root)
        for node in from_nodes:
            reached |= nx.node_connected_component(net, node)
        return tuple(node for node in self.nodes if node not in reached)

    def distances(self) -> dict[str, int]:
        """Return the number of edges from the root to each node that it reaches."""
        return dict(nx.single_source_shortest_path_length(self._net(None), self.root))

    def _net(self, names: Iterable[str] | None) -> nx.MultiGraph:
        chosen = {edge.name for edge in self.edges} if names is None else set(names)
        net = nx.MultiGraph()
        net.add_nodes_from(self.nodes)
        net.add_edges_from((edge.start, edge.end) for edge in self.edges if edge.name in chosen)
        return net
