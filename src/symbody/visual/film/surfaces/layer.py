"""`Layer`: facets as they are seen by themselves, with colours of samples; and which edges they have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.film.camera import Camera
from symbody.visual.film.facets import Bools, Facets, Floats, Ints, unit
from symbody.visual.film.surfaces.item_buffer import ItemBuffer, rasterize

Bytes = NDArray[np.uint8]

LIGHT_FROM: Final = unit(np.array([-0.45, 0.65, 0.75]))  # right, up, towards the eye
AMBIENT: Final = 0.52
DIFFUSE: Final = 0.56
_APART: Final = 2e-7  # of the depth of a scene, between parts of equal depth: the later lies in front

_STEEP: Final = 0.45  # cosine to the line of sight: how far a tone bends around an outline
_LEAST_STEP: Final = 1 / 22  # between tones


@dataclass(frozen=True, slots=True)
class Grid:
    """Samples of a picture: how many in height and width, and how many in a point."""

    shape: tuple[int, int]
    per_point: float


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """Facets as they are seen by themselves.

    Attributes
    ----------
    points : (V, 3) array
        Vertices: x and y in samples, depth [m].
    buffer : ItemBuffer
        What is seen at each sample.
    colors : (N, 3) array of bytes
        At the places of the buffer.
    edges : (E, 2) array
        Those that are drawn where they are visible: creases and outlines.
    outlines : (E,) array
        Whether an edge is an outline, beyond which the surface turns away.
    edge_triangles : (E,) array
        A triangle beside each edge.
    """

    points: Floats
    buffer: ItemBuffer
    colors: Bytes
    edges: Ints
    outlines: Bools
    edge_triangles: Ints


def make_layer(facets: Facets, camera: Camera, grid: Grid, tone_width: float = 0.0) -> Layer:
    """Return facets as a camera sees them.

    Parameters
    ----------
    tone_width : float
        How many samples wide tones of curved surfaces are on the average, where these are painted in a few
        tones, which a vector format can say in few words; 0: they are painted smoothly.
    """
    points = camera.project(facets.vertices) * np.array([grid.per_point, grid.per_point, 1.0])
    parts = np.zeros(len(points))
    parts[facets.triangles.reshape(-1)] = np.repeat(facets.parts, 3)
    points[:, 2] -= _APART * _depth_range(points) * parts
    corners = points[facets.triangles]
    is_front = _signed_areas(corners) < 0.0
    drawn = np.flatnonzero(is_front | ~facets.closed)
    buffer = rasterize(points, facets.triangles[drawn], grid.shape)
    buffer = ItemBuffer(buffer.depth, buffer.places, drawn[buffer.items])
    lit = _corner_brightness(facets, camera, is_front, tone_width > 0.0)
    shade = _brightness(lit, corners, buffer, grid)
    if tone_width:
        shade = _tones(shade, lit, corners, facets.parts, buffer, tone_width)
    shade = shade[:, np.newaxis]
    base = facets.colors[buffer.items]
    tint = np.where(shade <= 1.0, base * shade, base + (1.0 - base) * (shade - 1.0))
    edges, outlines, beside = _select_edges(facets, is_front)
    return Layer(points, buffer, (255.0 * tint + 0.5).astype(np.uint8), edges, outlines, beside)


def _corner_brightness(facets: Facets, camera: Camera, is_front: Bools, in_tones: bool) -> Floats:
    """Return the brightness at the corners (T, 3) of triangles."""
    if not in_tones:
        sides = np.where(is_front, 1.0, -1.0)[:, np.newaxis]
        light = sides * (facets.normals @ (LIGHT_FROM @ camera.axes))
        return np.asarray(AMBIENT + DIFFUSE * np.maximum(light, 0.0), dtype=np.float64)
    normals = np.where(is_front, 1.0, -1.0)[:, np.newaxis, np.newaxis] * (facets.normals @ camera.axes.T)
    curved = np.ptp(normals, axis=1).max(axis=1) > 1e-6
    # Towards an outline brightness would change within a sample: it keeps the tone that it has before.
    steep = curved[:, np.newaxis] & (normals[..., 2] < _STEEP)
    flat = unit(normals[..., :2]) * np.sqrt(1.0 - _STEEP**2)
    normals = np.where(steep[..., np.newaxis], np.dstack([flat, np.full(steep.shape, _STEEP)]), normals)
    return np.asarray(AMBIENT + DIFFUSE * np.maximum(normals @ LIGHT_FROM, 0.0), dtype=np.float64)


def _depth_range(points: Floats) -> float:
    return float(np.ptp(points[:, 2])) if len(points) else 0.0


def _signed_areas(corners: Floats) -> Floats:
    """Return twice the areas of triangles in the picture: negative for those that face the eye."""
    a, b = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)


def _brightness(lit: Floats, corners: Floats, buffer: ItemBuffer, grid: Grid) -> Floats:
    """Return the brightness at each place that is seen, from that at corners (T, 3) of triangles."""
    shade: Floats = lit[buffer.items, 0]
    curved = _uneven_places(lit, buffer)
    items = buffer.items[curved]
    row, column = np.divmod(buffer.places[curved], grid.shape[1])
    across, down = (slope[items] for slope in _slopes(lit, corners))
    right, below = column + 0.5 - corners[items, 0, 0], row + 0.5 - corners[items, 0, 1]
    values = lit[items, 0] + across * right + down * below
    shade[curved] = np.clip(values, lit.min(axis=1)[items], lit.max(axis=1)[items])
    return shade


def _tones(
    shade: Floats, lit: Floats, corners: Floats, parts: Ints, buffer: ItemBuffer, width: float
) -> Floats:
    """Return brightnesses in so few steps for each part that tones have a width [samples] on the average."""
    curved = _uneven_places(lit, buffer)
    if not len(curved):
        return shade
    items = buffer.items[curved]
    across, down = (slope[items] for slope in _slopes(lit, corners))
    _, part = np.unique(parts[items], return_inverse=True)
    part = part.reshape(-1)
    mean_slopes = np.bincount(part, np.hypot(across, down)) / np.bincount(part)
    step = np.clip(width * mean_slopes, _LEAST_STEP, 2.0)[part]
    toned = shade.copy()
    toned[curved] = AMBIENT + step * np.round((shade[curved] - AMBIENT) / step)
    return toned


def _uneven_places(lit: Floats, buffer: ItemBuffer) -> Ints:
    """Return at which places a triangle is seen that is not equally bright all over."""
    return np.flatnonzero(np.ptp(lit, axis=1)[buffer.items] > 1e-9)


def _slopes(values: Floats, corners: Floats) -> tuple[Floats, Floats]:
    """Return how fast values at corners (T, 3) of triangles change to the right and downwards."""
    dx, dy = (corners[:, 1:, k] - corners[:, :1, k] for k in (0, 1))
    dv = values[:, 1:] - values[:, :1]
    area = _signed_areas(corners)
    area = np.where(np.abs(area) > 1e-12, area, np.inf)
    across = (dv[:, 0] * dy[:, 1] - dv[:, 1] * dy[:, 0]) / area
    return across, (dx[:, 0] * dv[:, 1] - dx[:, 1] * dv[:, 0]) / area


def _select_edges(facets: Facets, is_front: Bools) -> tuple[Ints, Bools, Ints]:
    first, second = facets.neighbours[:, 0], facets.neighbours[:, 1]
    front_first = is_front[first] if len(first) else np.zeros(0, dtype=np.bool_)
    front_second = np.where(second >= 0, is_front[second], False) if len(second) else front_first
    outlines = (front_first != front_second) | (second < 0)
    sides_seen = front_first | front_second | ~facets.closed[first] if len(first) else front_first
    drawn = np.flatnonzero(outlines | (facets.creases & sides_seen))
    beside = np.where(front_first, first, np.where(second >= 0, second, first))
    return facets.edges[drawn], outlines[drawn], beside[drawn]
