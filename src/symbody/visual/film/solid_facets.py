"""Triangles of solids: boxes, cylinders, cones, spheres, capsules and meshes."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from symbody.visual.film.facets import NOTHING, Facets, Floats, Ints, facets_of, weld
from symbody.visual.scene.scene import Quaternion, SceneMesh, Solid

ROUND: Final = 64  # sides of a circle
RINGS: Final = 16  # of half a sphere


def rotation_of(quaternion: Floats | Quaternion) -> Floats:
    """Return the rotation matrices (..., 3, 3) of quaternions (..., 4), scalar first."""
    q = np.asarray(quaternion, dtype=np.float64)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def facets_of_solid(solid: Solid, meshes: tuple[SceneMesh, ...]) -> Facets:
    """Return the facets of a solid in the axes of its body; of a line there are none."""
    if solid.kind == "line":
        return NOTHING
    if solid.kind == "mesh":
        facets = _mesh(solid, meshes)
    else:
        facets = _primitive(solid.kind, solid.size)
    return facets.rotate(rotation_of(solid.quaternion), np.array(solid.at))


def line_of_solid(solid: Solid, meshes: tuple[SceneMesh, ...]) -> Floats:
    """Return the points (N, 3) of a line in the axes of its body [m]."""
    points = meshes[solid.mesh].vertices if solid.mesh is not None else np.zeros((0, 3))
    return np.asarray(points @ rotation_of(solid.quaternion).T + np.array(solid.at), dtype=np.float64)


def _mesh(solid: Solid, meshes: tuple[SceneMesh, ...]) -> Facets:
    if solid.mesh is None:
        return NOTHING
    mesh = meshes[solid.mesh]
    factors = np.array(solid.size if len(solid.size) == 3 else (1.0, 1.0, 1.0))
    triangles = mesh.triangles.astype(np.int64)
    if np.prod(factors) < 0.0:  # a mirror turns them round
        triangles = triangles[:, ::-1]
    vertices, corners = weld(mesh.vertices * factors, triangles)
    # Whether a file's mesh is closed and turned the right way nobody vouches for: both sides are drawn.
    return facets_of(vertices, corners, closed=False) if len(corners) else NOTHING


@lru_cache(maxsize=512)
def _primitive(kind: str, size: tuple[float, ...]) -> Facets:
    if kind == "box":
        return _box(np.array(size))
    if kind == "sphere":
        angles = np.linspace(0.0, np.pi, 2 * RINGS + 1)
        return _revolve(size[0] * np.sin(angles), -size[0] * np.cos(angles))
    radius, length = size[0], size[1]
    half = length / 2
    if kind == "cylinder":
        return _revolve(np.array([0.0, radius, radius, 0.0]), np.array([-half, -half, half, half]))
    if kind == "cone":
        return _revolve(np.array([0.0, radius, 0.0]), np.array([-half, -half, half]))
    angles = np.linspace(0.0, np.pi / 2, RINGS + 1)
    below, above = -half - radius * np.cos(angles), half + radius * np.sin(angles)
    radii = radius * np.concatenate([np.sin(angles), np.cos(angles)])
    return _revolve(radii, np.concatenate([below, above]))


def _box(size: Floats) -> Facets:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([[q[0], q[k], q[k + 1]] for q in quads for k in (1, 2)], dtype=np.int64)
    return facets_of(signs * size / 2, triangles)


def _revolve(radii: Floats, heights: Floats) -> Facets:
    """Return the surface that a profile makes about z, from the bottom upwards; both ends are on the axis."""
    turn = 2 * np.pi * np.arange(ROUND) / ROUND
    rings = np.stack(
        [np.outer(radii, np.cos(turn)), np.outer(radii, np.sin(turn)), np.outer(heights, np.ones(ROUND))],
        axis=-1,
    )
    vertices, triangles = weld(rings.reshape(-1, 3), grid_triangles(len(radii), ROUND))
    return facets_of(vertices, triangles)


@lru_cache(maxsize=256)
def grid_triangles(rows: int, columns: int) -> Ints:
    """Return triangles between rings of vertices, row by row; outside is to the right of a ring."""
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    ahead = (column + 1) % columns
    a, b = row * columns + column, row * columns + ahead
    c, d = (row + 1) * columns + ahead, (row + 1) * columns + column
    lower, upper = np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)
    return np.stack([lower, upper], axis=2).reshape(-1, 3)
