"""Meshes that are computed: tubes, rings, prisms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.scene.poses import axes_along
from symbody.visual.scene.scene import Floats, SceneMesh

Triangles = NDArray[np.int32]

_SIDES: Final = 10


def tube(points: Floats, radius: float, is_closed: bool = False, sides: int = _SIDES) -> SceneMesh:
    """Return a tube along a line.

    Parameters
    ----------
    points : (N, 3) array
        Of its centre line [m]; of a closed line without the first one again.
    """
    count = len(points)
    before = np.roll(points, 1, axis=0) if is_closed else np.vstack([points[:1], points[:-1]])
    after = np.roll(points, -1, axis=0) if is_closed else np.vstack([points[1:], points[-1:]])
    directions = after - before
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    directions = np.where(lengths > 0.0, directions / np.where(lengths > 0.0, lengths, 1.0), [0.0, 0.0, 1.0])
    angles = np.linspace(0.0, 2.0 * math.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) * radius
    sideways = None
    rings = []
    for point, direction in zip(points, directions, strict=True):
        axes = axes_along(direction, sideways)
        sideways = axes[:, 0]  # carried along, so that the tube is not twisted
        rings.append(point + circle @ axes[:, :2].T)
    vertices = np.vstack(rings)
    parts = [_ring_band(k * sides, ((k + 1) % count) * sides, sides) for k in range(count - (not is_closed))]
    if not is_closed:
        vertices = np.vstack([vertices, points[0], points[-1]])
        last, end = (count - 1) * sides, count * sides
        around = np.arange(sides)
        nxt = (around + 1) % sides
        parts.append(np.stack([np.full(sides, end), nxt, around], axis=1))
        parts.append(np.stack([np.full(sides, end + 1), last + around, last + nxt], axis=1))
    return SceneMesh(vertices, np.vstack(parts).astype(np.int32))


def ring(radius: float, thickness: float, segments: int = 48) -> SceneMesh:
    """Return a torus about z, by the radii of its centre line and of its tube."""
    angles = np.linspace(0.0, 2.0 * math.pi, segments, endpoint=False)
    line = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(segments)], axis=1)
    return tube(line, thickness, is_closed=True, sides=12)


def prism(outline: Floats, thickness: float) -> SceneMesh:
    """Return an outline in the plane z = 0, star-shaped about its mean, with a thickness about that plane.

    Parameters
    ----------
    outline : (N, 2) array
        Counter-clockwise, without the first point again.
    """
    count = len(outline)
    centre = outline.mean(axis=0)
    half = 0.5 * thickness
    lower = np.column_stack([outline, np.full(count, -half)])
    upper = np.column_stack([outline, np.full(count, half)])
    vertices = np.vstack([lower, upper, [*centre, -half], [*centre, half]])
    around = np.arange(count)
    nxt = (around + 1) % count
    caps = [
        np.stack([np.full(count, 2 * count), nxt, around], axis=1),
        np.stack([np.full(count, 2 * count + 1), count + around, count + nxt], axis=1),
    ]
    return split_faces(vertices, [cap.astype(np.int32) for cap in caps] + [_ring_band(0, count, count)])


def cone_prism(outline: Floats, height: float, share: float) -> SceneMesh:
    """Return the solid between an outline (N, 2) in the plane z = 0 and a tip, truncated at a share.

    Parameters
    ----------
    height : float
        Of the tip.
    share : float
        How much of the way to the tip is there, below 1.
    """
    count = len(outline)
    base = np.column_stack([outline, np.zeros(count)])
    vertices = np.vstack([base, base * (1.0 - share) + np.array([0.0, 0.0, share * height])])
    centres = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, share * height]])
    around = np.arange(count)
    nxt = (around + 1) % count
    caps = [
        np.stack([np.full(count, 2 * count), nxt, around], axis=1).astype(np.int32),
        np.stack([np.full(count, 2 * count + 1), count + around, count + nxt], axis=1).astype(np.int32),
    ]
    parts = [*caps, _ring_band(0, count, count)]
    if height < 0.0:
        parts = [part[:, ::-1] for part in parts]
    return split_faces(np.vstack([vertices, centres]), parts)


def hollow_prism(inner: Floats, outer: Floats, thickness: float) -> SceneMesh:
    """Return the plate between two outlines (N, 2) of equally many points in the plane z = 0."""
    count = len(inner)
    half = 0.5 * thickness
    levels = [np.column_stack([each, np.full(count, z)]) for z in (-half, half) for each in (inner, outer)]
    inner_low, outer_low, inner_high, outer_high = (k * count for k in range(4))
    bands = [
        _ring_band(outer_low, inner_low, count), _ring_band(inner_high, outer_high, count),
        _ring_band(inner_low, inner_high, count)[:, ::-1], _ring_band(outer_low, outer_high, count),
    ]  # fmt: skip
    bands[0], bands[1] = bands[0][:, ::-1], bands[1][:, ::-1]
    return split_faces(np.vstack(levels), bands)


def split_faces(vertices: Floats, parts: Sequence[Triangles]) -> SceneMesh:
    """Return a mesh in which parts share no vertices, so that edges between them stay sharp."""
    blocks, triangles, count = [], [], 0
    for part in parts:
        places, numbers = np.unique(part, return_inverse=True)
        blocks.append(vertices[places])
        triangles.append(numbers.reshape(part.shape) + count)
        count += len(places)
    return SceneMesh(np.vstack(blocks), np.vstack(triangles).astype(np.int32))


def join_meshes(meshes: Sequence[SceneMesh]) -> SceneMesh:
    """Return several meshes as one."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    triangles = [mesh.triangles + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return SceneMesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(triangles).astype(np.int32))


def helix(radius: float, length: float, pitch: float, points_of_turn: int = 16) -> Floats:
    """Return points (N, 3) of a helix about z, centred at the origin."""
    turns = length / pitch
    angles = np.linspace(0.0, 2.0 * math.pi * turns, max(3, round(points_of_turn * turns)))
    z = pitch * angles / (2.0 * math.pi) - 0.5 * length
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), z], axis=1)


def spiral(inner: float, outer: float, turns: float, points_of_turn: int = 20) -> Floats:
    """Return points (N, 3) of a flat spiral about z."""
    angles = np.linspace(0.0, 2.0 * math.pi * turns, round(points_of_turn * turns))
    radii = np.linspace(inner, outer, angles.size)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(angles.size)], axis=1)


def _ring_band(first: int, second: int, count: int) -> Triangles:
    """Return triangles between two rings of vertices; outwards if the second is further along the axis."""
    around = np.arange(count)
    nxt = (around + 1) % count
    a, b, c, d = first + around, first + nxt, second + nxt, second + around
    return np.vstack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)
