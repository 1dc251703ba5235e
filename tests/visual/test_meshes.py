"""Meshes that are computed are closed, and their outsides are outside."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from symbody.visual.scene.scene import SceneMesh
from symbody.visual.scene.shapes.gear_profile import gear_outline, ring_outlines
from symbody.visual.scene.shapes.meshes import (
    cone_prism,
    helix,
    hollow_prism,
    join_meshes,
    prism,
    ring,
    spiral,
    tube,
)

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
INNER = 0.5 * (SQUARE - 0.5) + 0.5


def volume(mesh: SceneMesh) -> float:
    corners = mesh.vertices[mesh.triangles]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def is_closed(mesh: SceneMesh) -> bool:
    """Whether every edge has a neighbour that runs along it the other way, vertices in one place being one."""
    _, numbers = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    triangles = numbers.ravel()[mesh.triangles]
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = {tuple(edge) for edge in edges.tolist()}
    return len(forward) == len(edges) and all((b, a) in forward for a, b in forward)


LINE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.5, 0.0], [3.0, 0.5, 1.0]])
SHAPES: dict[str, tuple[Callable[[], SceneMesh], float | None]] = {
    "prism": (lambda: prism(SQUARE, 2.0), 2.0),
    "hollow prism": (lambda: hollow_prism(INNER, SQUARE, 2.0), 1.5),
    "cone upwards": (lambda: cone_prism(SQUARE - 0.5, 3.0, 0.5), (1 - 1 / 8) * 3.0 / 3),
    "cone downwards": (lambda: cone_prism(SQUARE - 0.5, -3.0, 0.5), (1 - 1 / 8) * 3.0 / 3),
    "straight tube": (
        lambda: tube(LINE[:2], 0.1, sides=6),
        6 / 2 * math.sin(2 * math.pi / 6) * 0.01,
    ),
    "bent tube": (lambda: tube(LINE, 0.1), None),
    "ring": (lambda: ring(1.0, 0.1), None),
    "helix": (lambda: tube(helix(1.0, 2.0, 0.5), 0.1), None),
    "spiral": (lambda: tube(spiral(0.5, 1.0, 2.0), 0.05), None),
    "wheel": (lambda: prism(gear_outline(1.0, 20), 0.2), None),
    "toothed ring": (lambda: hollow_prism(*ring_outlines(1.0, 40), 0.2), None),
}


@pytest.mark.parametrize("name", SHAPES)
def test_meshes_are_closed_and_turned_outwards(name: str) -> None:
    make, wanted = SHAPES[name]
    mesh = make()
    assert is_closed(mesh) and volume(mesh) > 0
    assert wanted is None or math.isclose(volume(mesh), wanted, rel_tol=1e-9)


def test_a_tube_has_its_radius_all_along() -> None:
    mesh = tube(LINE, 0.1)
    rings = mesh.vertices[:-2].reshape(len(LINE), -1, 3)
    assert np.allclose(np.linalg.norm(rings - LINE[:, None], axis=-1), 0.1)


def test_joined_meshes_keep_their_volumes() -> None:
    parts = [prism(SQUARE + 3 * k, 1.0) for k in range(3)]
    assert math.isclose(volume(join_meshes(parts)), 3.0)
