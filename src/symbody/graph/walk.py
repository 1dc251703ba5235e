"""Walks over a linear graph: forests of its edges, and what is reached from a node, nearest first.

Written here, for all models need them, and loading a library of graphs takes longer than all that a later
process does to a small mechanism.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Protocol


class Joining(Protocol):
    """What joins two nodes."""

    @property
    def start(self) -> str:
        """One of them."""

    @property
    def end(self) -> str:
        """The other."""


def forest_places(edges: Sequence[Joining]) -> list[int]:
    """Return the places of the edges that join what those before them do not (Kruskal)."""
    parents: dict[str, str] = {}

    def root(node: str) -> str:
        while (above := parents.setdefault(node, node)) != node:
            parents[node] = parents[above]
            node = above
        return node

    places = []
    for place, edge in enumerate(edges):
        start, end = root(edge.start), root(edge.end)
        if start != end:
            parents[start] = end
            places.append(place)
    return places


def neighbours(edges: Iterable[Joining]) -> dict[str, list[str]]:
    """Return the nodes beside each node, in the order of the edges."""
    beside: dict[str, list[str]] = {}
    for edge in edges:
        beside.setdefault(edge.start, []).append(edge.end)
        beside.setdefault(edge.end, []).append(edge.start)
    return beside


def walk(beside: Mapping[str, Sequence[str]], root: str) -> Iterator[tuple[str, str]]:
    """Yield each node that is reached from a root behind the node from which it is, the nearest first."""
    reached, waiting = {root}, deque([root])
    while waiting:
        node = waiting.popleft()
        for other in beside.get(node, ()):
            if other not in reached:
                reached.add(other)
                waiting.append(other)
                yield node, other
