"""The tree as chains of single joints on a frame: what derivatives in closed form are made for.

The frame is ground, or one free body, in whose axes nothing depends on its own position but gravity. Every
other link turns about, or slides along, one direction that is fixed in it, by one coordinate whose rate is
its speed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Final, NamedTuple

from symbody.equations.recursive.item_programs import flatten
from symbody.equations.recursive.links import GROUND, KinematicTree, TreeLink
from symbody.expr.canonical import ZERO
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.rewrite import substitute, symbols_of

# Small branches form one segment until they fill a register; entries of links in different branches are 0.
TOGETHER: Final = 8


class Segment(NamedTuple):
    """Links from ground outward, and the place of the chain that carries them; -1 is the frame.

    They are a chain, or small branches with all that these carry.
    """

    links: tuple[int, ...]
    parent: int


@dataclass(frozen=True, slots=True)
class Chains:
    """A tree of single joints.

    Attributes
    ----------
    base : bool
        Whether link 0 is the free body that is the frame; else the frame is ground.
    segments : tuple of Segment
        Parents before children.
    coordinates : mapping of node to node
        The coordinate of each speed, but for those of the base.
    """

    tree: KinematicTree
    base: bool
    segments: tuple[Segment, ...]
    coordinates: Mapping[int, int]

    @property
    def links(self) -> list[int]:
        """All links but the base, segment by segment."""
        return [k for segment in self.segments for k in segment.links]

    def carriers(self, link: int) -> frozenset[int]:
        """Return a link and those that carry it."""
        carriers = set()
        while link != GROUND:
            carriers.add(link)
            link = self.tree.links[link].parent
        return frozenset(carriers)

    def inward(self, segment: int) -> list[int]:
        """Return the segments that carry a segment, itself first."""
        inward = []
        while segment >= 0:
            inward.append(segment)
            segment = self.segments[segment].parent
        return inward


def chains(graph: Graph, tree: KinematicTree, rates: Mapping[int, int]) -> Chains | None:
    """Return the chains of a tree; None where a link has several joints, is driven, or follows the base.

    Parameters
    ----------
    rates : mapping of node to node
        q' of each q.
    """
    base = bool(tree.links) and len(tree.links[0].motion.columns) > 1
    speeds = {column.speed for link in tree.links for column in link.motion.columns}
    coordinates = {rate: q for q, rate in rates.items() if rate in speeds}
    if base and not _is_free(graph, tree.links[0]):
        return None
    if base and any(column.speed in tree.followers.values() for column in tree.links[0].motion.columns):
        return None
    for link in tree.links[base:]:
        if (base and link.parent == GROUND) or not _is_single(graph, link, coordinates):
            return None
    return Chains(tree, base, tuple(_segments(tree, base)), coordinates)


def _segments(tree: KinematicTree, base: bool) -> list[Segment]:
    children = tree.children
    size = [1] * len(tree.links)
    for k in reversed(range(len(tree.links))):
        size[k] += sum(size[child] for child in children[k])
    roots = children[0] if base else [k for k, link in enumerate(tree.links) if link.parent == GROUND]
    segments: list[Segment] = []
    pending = [(part, -1) for part in reversed(_parts(roots, size))]
    while pending:
        part, parent = pending.pop()
        links = list(part)
        if sum(size[k] for k in part) <= TOGETHER:
            for k in links:  # it grows meanwhile
                links += children[k]
            segments.append(Segment(tuple(sorted(links)), parent))
            continue
        while len(children[links[-1]]) == 1:
            links.append(children[links[-1]][0])
        segments.append(Segment(tuple(links), parent))
        last = len(segments) - 1
        pending += [(part, last) for part in reversed(_parts(children[links[-1]], size))]
    return segments


def _parts(links: Sequence[int], size: Sequence[int]) -> list[list[int]]:
    """Return links in parts of whole branches that fit together; those that do not fit stand alone."""
    parts: list[list[int]] = []
    room = 0
    for k in sorted(links, key=size.__getitem__, reverse=True):
        if size[k] <= room:
            parts[-1].append(k)
            room -= size[k]
        else:
            parts.append([k])
            room = TOGETHER - size[k]
    return parts


def _is_single(graph: Graph, link: TreeLink, coordinates: Mapping[int, int]) -> bool:
    """Return whether a link has one column, fixed in it, and moves by its own coordinate alone."""
    columns = link.motion.columns
    if len(columns) != 1 or columns[0].speed not in coordinates or not _is_steady(graph, link):
        return False
    return _has_only(graph, flatten(link.transform), {coordinates[columns[0].speed]})


def _is_free(graph: Graph, link: TreeLink) -> bool:
    """Return whether a link has six columns of numbers, three of them displacements along its axes."""
    columns = link.motion.columns
    entries = [flatten(column.twist) for column in columns]
    if len(columns) != 6 or link.parent != GROUND or not _is_steady(graph, link):
        return False
    if any(x.number is None for row in entries for x in row):
        return False
    displacements = [tuple(x.number for x in row[:3]) for row in entries if all(x.is_zero for x in row[3:])]
    return sorted(displacements) == [(0, 0, 1), (0, 1, 0), (1, 0, 0)]


def _is_steady(graph: Graph, link: TreeLink) -> bool:
    """Return whether velocities are ``sum of columns times speeds`` with columns fixed in the link."""
    motion = link.motion
    if not _has_only(graph, flatten(tuple(column.twist for column in motion.columns)), set()):
        return False
    still = {column.speed: ZERO for column in motion.columns}
    return not any(substitute(graph, [x.index for x in flatten(motion.velocity)], still))


def _has_only(graph: Graph, values: Iterable[Expr], allowed: Set[int]) -> bool:
    """Return whether expressions hold no symbols but parameters and those allowed."""
    return all(
        node in allowed or graph.symbols[graph.left[node]].kind == SymbolKind.PARAMETER
        for node in symbols_of(graph, [value.index for value in values])
    )
