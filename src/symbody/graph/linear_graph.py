"""The linear graph of a mechanism: nodes and edges, without any mechanics.

Words after Koenig, Tokad & Kesavan (1967) and McPhee (1998).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from symbody.graph.walk import neighbours, walk


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
        chosen = {edge.name for edge in self.edges} if names is None else set(names)
        beside = neighbours(edge for edge in self.edges if edge.name in chosen)
        starts = (self.root, *from_nodes)
        reached = {*starts, *(node for start in starts for _, node in walk(beside, start))}
        return tuple(node for node in self.nodes if node not in reached)

    def distances(self) -> dict[str, int]:
        """Return the number of edges from the root to each node that it reaches."""
        distances = {self.root: 0}
        for node, other in walk(neighbours(self.edges), self.root):
            distances[other] = distances[node] + 1
        return distances
