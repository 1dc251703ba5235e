"""The linear graph of a mechanism: nodes and edges, without any mechanics.

Words after Koenig, Tokad & Kesavan (1967) and McPhee (1998).
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass


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
        allowed = {edge.name for edge in self.edges} if names is None else set(names)
        chosen = [edge for edge in self.edges if edge.name in allowed]
        reached = {self.root, *from_nodes}
        for start in (self.root, *from_nodes):
            reached.update(node for _, _, node in breadth_first(chosen, start))
        return tuple(node for node in self.nodes if node not in reached)

    def distances(self) -> dict[str, int]:
        """Return the number of edges from the root to each node that it reaches."""
        numbers = {self.root: 0}
        for parent, _, node in breadth_first(self.edges, self.root):
            numbers[node] = numbers[parent] + 1
        return numbers


def breadth_first(edges: Iterable[Edge], start: str) -> Iterator[tuple[str, Edge, str]]:
    """Yield the nodes that edges join to `start`, nearest first: the node before, the edge, the node."""
    ways: defaultdict[str, list[tuple[Edge, str]]] = defaultdict(list)
    for edge in edges:
        ways[edge.start].append((edge, edge.end))
        ways[edge.end].append((edge, edge.start))
    reached, waiting = {start}, deque([start])
    while waiting:
        node = waiting.popleft()
        for edge, other in ways[node]:
            if other not in reached:
                reached.add(other)
                waiting.append(other)
                yield node, edge, other


def closing_edges(edges: Iterable[Edge]) -> Iterator[Edge]:
    """Yield the edges whose ends are joined by edges before them [Kruskal 1956]."""
    parts: dict[str, set[str]] = {}
    for edge in edges:
        small, large = sorted((parts.setdefault(end, {end}) for end in (edge.start, edge.end)), key=len)
        if small is large:
            yield edge
            continue
        large |= small
        parts.update(dict.fromkeys(small, large))
