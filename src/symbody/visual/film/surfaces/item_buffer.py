"""`ItemBuffer`: which triangle is in front at each sample of a picture, and how deep it lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.film.facets import Bools, Floats, Ints

FAR: Final = np.float32(np.inf)
_LEVELS: Final = float(2**31 - 2)
_EMPTY: Final = np.int64(2**63 - 1)


@dataclass(frozen=True, slots=True, eq=False)
class ItemBuffer:
    """What is seen at the samples of a picture.

    Attributes
    ----------
    depth : (height, width) array
        Away from the eye [m]; infinite where nothing is seen.
    places : (N,) array
        The samples where something is seen, row by row.
    items : (N,) array
        The triangle that is seen there.
    """

    depth: NDArray[np.float32]
    places: Ints
    items: Ints


def rasterize(points: Floats, triangles: Ints, shape: tuple[int, int]) -> ItemBuffer:
    """Return the visible parts of triangles, of equally deep ones the first.

    Parameters
    ----------
    points : (V, 3) array
        x to the right and y downwards in samples, the first sample being centred on 0.5; depth [m].
    triangles : (T, 3) array
        Places of points, in any sense of turning.
    shape : (height, width)
        How many samples.
    """
    depth = np.full(shape, FAR, dtype=np.float32)
    if not len(triangles):
        return ItemBuffer(depth, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    corners = points[triangles]
    places, items, depths = _fragments(corners, shape)
    low = float(corners[..., 2].min())
    step = max(float(corners[..., 2].max()) - low, 1e-12) / _LEVELS
    # One number for depth and triangle: the least at each sample wins, without any order of drawing.
    keys = (np.clip((depths - low) / step, 0.0, _LEVELS).astype(np.int64) << 32) | items
    if not len(places):
        return ItemBuffer(depth, places, items)
    offset = int(places.min())
    buffer = np.full(int(places.max()) + 1 - offset, _EMPTY)  # only the rows that are needed
    np.minimum.at(buffer, places - offset, keys)
    seen = np.flatnonzero(buffer != _EMPTY)
    winners = buffer[seen]
    seen += offset
    depth.reshape(-1)[seen] = low + step * (winners >> 32)
    return ItemBuffer(depth, seen, winners & 0xFFFFFFFF)


def _fragments(corners: Floats, shape: tuple[int, int]) -> tuple[Ints, Ints, Floats]:
    """Return each sample that each triangle covers: its place, the triangle, and the depth there."""
    order = np.argsort(corners[:, :, 1], axis=1)
    x, y, z = (np.take_along_axis(corners[:, :, k], order, axis=1) for k in range(3))
    first = np.clip(np.ceil(y[:, 0] - 0.5), 0, shape[0]).astype(np.int64)
    last = np.clip(np.ceil(y[:, 2] - 0.5), 0, shape[0]).astype(np.int64)
    slope_x, slope_y = _depth_slopes(x, y, z)
    owner, rows = _number_runs(first, np.maximum(last - first, 0))
    middle = rows + 0.5
    left, right = _span(x[owner], y[owner], np.asarray(middle, dtype=np.float64))
    start = np.clip(np.ceil(left - 0.5), 0, shape[1]).astype(np.int64)
    end = np.clip(np.ceil(right - 0.5), 0, shape[1]).astype(np.int64)
    base = z[owner, 0] + slope_y[owner] * (middle - y[owner, 0]) + slope_x[owner] * (0.5 - x[owner, 0])
    span, columns = _number_runs(start, np.maximum(end - start, 0))
    items = owner[span]
    return rows[span] * shape[1] + columns, items, base[span] + slope_x[items] * columns


def _number_runs(starts: Ints, counts: Ints) -> tuple[Ints, Ints]:
    """Return for runs of whole numbers the run that each belongs to, and the numbers."""
    runs = np.repeat(np.arange(len(starts)), counts)
    return runs, np.arange(len(runs)) - np.repeat(np.cumsum(counts) - counts - starts, counts)


def _depth_slopes(x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    dx, dy, dz = (values[:, 1:] - values[:, :1] for values in (x, y, z))
    area = dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]
    proper = np.abs(area) > 1e-12
    area = np.where(proper, area, 1.0)
    across = np.where(proper, (dz[:, 0] * dy[:, 1] - dz[:, 1] * dy[:, 0]) / area, 0.0)
    down = np.where(proper, (dx[:, 0] * dz[:, 1] - dx[:, 1] * dz[:, 0]) / area, 0.0)
    return across, down


def _span(x: Floats, y: Floats, middle: Floats) -> tuple[Floats, Floats]:
    """Return where rows cut triangles whose corners are in the order of y."""
    is_upper: Bools = middle < y[:, 1]
    along = x[:, 0] + (middle - y[:, 0]) * _ratio(x[:, 2] - x[:, 0], y[:, 2] - y[:, 0])
    upper = x[:, 0] + (middle - y[:, 0]) * _ratio(x[:, 1] - x[:, 0], y[:, 1] - y[:, 0])
    lower = x[:, 1] + (middle - y[:, 1]) * _ratio(x[:, 2] - x[:, 1], y[:, 2] - y[:, 1])
    other = np.where(is_upper, upper, lower)
    return np.minimum(along, other), np.maximum(along, other)


def _ratio(over: Floats, under: Floats) -> Floats:
    return np.asarray(over / np.where(under == 0.0, 1.0, under), dtype=np.float64)
