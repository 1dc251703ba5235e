"""`Facets`: triangles with normals, colours and edges, whatever they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Faces that meet at a smaller angle are parts of one curved surface, which has no edge there.
CREASE: Final = np.cos(np.radians(38.0))


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles, counter-clockwise from outside, and the edges between them.

    Attributes
    ----------
    vertices : (V, 3) array
        Where they are [m].
    carriers : (V,) array
        The body of the scene that each is fixed on.
    triangles : (T, 3) array
        Places of vertices.
    normals : (T, 3, 3) array
        Unit normals of the surface at the corners of each triangle.
    colors : (T, 3) array
        From 0 to 1.
    closed : (T,) array
        Whether the triangle belongs to a closed surface, whose inside is never seen.
    parts : (T,) array
        The number of the solid or connector that it belongs to.
    edges : (E, 2) array
        Places of vertices.
    neighbours : (E, 2) array
        Triangles beside an edge; -1 where there is none.
    creases : (E,) array
        Whether the surface has an edge there, from wherever one looks.
    """

    vertices: Floats
    carriers: Ints
    triangles: Ints
    normals: Floats
    colors: Floats
    closed: Bools
    parts: Ints
    edges: Ints
    neighbours: Ints
    creases: Bools

    def in_color(self, color: Floats, part: int, carrier: int) -> Facets:
        """Return them in one colour, as one part on one body."""
        count = len(self.triangles)
        return replace(
            self,
            colors=np.tile(color, (count, 1)),
            parts=np.full(count, part),
            carriers=np.full(len(self.vertices), carrier),
        )

    def rotate(self, rotation: Floats, position: Floats) -> Facets:
        """Return them turned by one rotation matrix and then moved [m]."""
        return replace(
            self, vertices=self.vertices @ rotation.T + position, normals=self.normals @ rotation.T
        )

    def to_ground(self, rotations: Floats, positions: Floats) -> Facets:
        """Return them in ground's axes, by rotations (B, 3, 3) and positions (B, 3) [m] of bodies."""
        if not len(self.triangles):
            return self
        carriers = self.carriers
        vertices = np.einsum("vij,vj->vi", rotations[carriers], self.vertices) + positions[carriers]
        normals = np.einsum("tij,tkj->tki", rotations[carriers[self.triangles[:, 0]]], self.normals)
        return replace(self, vertices=vertices, normals=normals)


NOTHING: Final = Facets(
    vertices=np.zeros((0, 3)),
    carriers=np.zeros(0, dtype=np.int64),
    triangles=np.zeros((0, 3), dtype=np.int64),
    normals=np.zeros((0, 3, 3)),
    colors=np.zeros((0, 3)),
    closed=np.zeros(0, dtype=np.bool_),
    parts=np.zeros(0, dtype=np.int64),
    edges=np.zeros((0, 2), dtype=np.int64),
    neighbours=np.zeros((0, 2), dtype=np.int64),
    creases=np.zeros(0, dtype=np.bool_),
)


def facets_of(
    vertices: Floats, triangles: Ints, closed: bool = True, normals: Floats | None = None
) -> Facets:
    """Return the facets of a surface whose neighbours share vertices.

    Parameters
    ----------
    closed : bool
        Whether it has an inside.
    normals : (T, 3, 3) array, optional
        At the corners; by default those of smooth surfaces between creases.
    """
    triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    flat = face_normals(vertices, triangles)
    edges, neighbours, creases = _edges(triangles, flat)
    count = len(triangles)
    return Facets(
        vertices=np.asarray(vertices, dtype=np.float64),
        carriers=np.zeros(len(vertices), dtype=np.int64),
        triangles=triangles,
        normals=_corner_normals(vertices, triangles, flat) if normals is None else normals,
        colors=np.full((count, 3), 0.5),
        closed=np.full(count, closed),
        parts=np.zeros(count, dtype=np.int64),
        edges=edges,
        neighbours=neighbours,
        creases=creases,
    )


def weld(vertices: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """Return a mesh whose vertices of equal place are one, without triangles that have no area."""
    span = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    grid = np.round((vertices - vertices.min(axis=0, initial=np.inf)) * (1e6 / (span or 1.0))).astype(
        np.int64
    )
    keys = (grid[:, 0] << 42) | (grid[:, 1] << 21) | grid[:, 2]  # 20 bits each
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    corners = place.reshape(-1)[triangles].astype(np.int64).reshape(-1, 3)
    proper = (
        (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    )
    return vertices[first], corners[proper]


def join_facets(pieces: Sequence[Facets]) -> Facets:
    """Return all facets in one."""
    pieces = [piece for piece in pieces if len(piece.triangles)]
    if len(pieces) <= 1:
        return pieces[0] if pieces else NOTHING
    vertex_counts = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    counts = np.cumsum([0, *(len(piece.triangles) for piece in pieces[:-1])])
    beside = [
        np.where(piece.neighbours < 0, -1, piece.neighbours + n)
        for piece, n in zip(pieces, counts, strict=True)
    ]
    return Facets(
        vertices=np.concatenate([piece.vertices for piece in pieces]),
        carriers=np.concatenate([piece.carriers for piece in pieces]),
        triangles=np.concatenate([p.triangles + n for p, n in zip(pieces, vertex_counts, strict=True)]),
        normals=np.concatenate([piece.normals for piece in pieces]),
        colors=np.concatenate([piece.colors for piece in pieces]),
        closed=np.concatenate([piece.closed for piece in pieces]),
        parts=np.concatenate([piece.parts for piece in pieces]),
        edges=np.concatenate([p.edges + n for p, n in zip(pieces, vertex_counts, strict=True)]),
        neighbours=np.concatenate(beside),
        creases=np.concatenate([piece.creases for piece in pieces]),
    )


def face_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Return the unit normals (T, 3) of triangles; zero for those without area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return unit(np.asarray(np.cross(b - a, c - a), dtype=np.float64))


def unit(vectors: Floats) -> Floats:
    """Return vectors (..., 3) of length one in the same directions; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0), dtype=np.float64)


def _edges(triangles: Ints, flat: Floats) -> tuple[Ints, Ints, Bools]:
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys, place, counts = np.unique(
        (sides[:, 0] << 32) | sides[:, 1], return_inverse=True, return_counts=True
    )
    edges = np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=1)
    order = np.argsort(place.reshape(-1), kind="stable")
    first = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    faces = order // 3
    neighbours = np.full((len(edges), 2), -1, dtype=np.int64)
    neighbours[:, 0] = faces[first]
    paired = counts >= 2
    neighbours[paired, 1] = faces[first[paired] + 1]
    creases = counts != 2
    cosines = np.einsum("ij,ij->i", flat[neighbours[paired, 0]], flat[neighbours[paired, 1]])
    creases[paired] |= cosines < CREASE
    return edges, neighbours, creases


def _corner_normals(vertices: Floats, triangles: Ints, flat: Floats) -> Floats:
    """Average at each corner the normals of those faces around its vertex that continue its own."""
    corners = triangles.reshape(-1)
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(vertices))
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    around = counts[corners]  # of each corner: how many corners share its vertex
    mine = np.repeat(np.arange(len(corners)), around)
    step = np.arange(len(mine)) - np.repeat(np.cumsum(around) - around, around)
    other = order[starts[corners[mine]] + step]
    joined = np.einsum("ij,ij->i", flat[mine // 3], flat[other // 3]) > CREASE
    mine, other = mine[joined], other[joined]
    weights = _corner_angles(vertices, triangles).reshape(-1)[other]
    sums = np.stack(
        [np.bincount(mine, flat[other // 3, k] * weights, minlength=len(corners)) for k in range(3)], axis=1
    )
    return unit(np.asarray(sums, dtype=np.float64)).reshape(-1, 3, 3)


def _corner_angles(vertices: Floats, triangles: Ints) -> Floats:
    corners: Floats = vertices[triangles]
    ahead, behind = (unit(corners[:, order] - corners) for order in ([1, 2, 0], [2, 0, 1]))
    return np.asarray(np.arccos(np.clip(np.sum(ahead * behind, axis=2), -1.0, 1.0)), dtype=np.float64)
