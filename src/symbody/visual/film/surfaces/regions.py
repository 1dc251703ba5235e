"""Regions of one colour as polygons: their borders are traced along the samples and made straight again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.visual.film.drawing import Bytes
from symbody.visual.film.facets import Bools, Floats, Ints
from symbody.visual.film.surfaces.polylines import corners_to_keep

# Samples. Middles of sides lie within half of one from a straight border, so within one from any chord.
TOLERANCE: Final = 1.05
_SMALLEST: Final = 2.0  # square samples
_STEPS: Final = ((1, 0), (0, 1), (-1, 0), (0, -1))  # steps (x, y) along the sides of a sample, clockwise


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Where a picture has one colour: rings of corners (N, 2) in samples, also of holes."""

    rings: tuple[Floats, ...]
    color: str


def trace_regions(samples: Bytes, background: str) -> tuple[Region, ...]:
    """Return the regions of all colours but the background.

    Borders between two regions are the same for both: each is cut where three regions meet, and what is
    between two cuts is made straight by itself.
    """
    red, green, blue = (samples[..., k].astype(np.int32) for k in range(3))
    labels = (red << 16) | (green << 8) | blue
    nothing = int(background[1:], 16)
    labels, corner = _frame(labels, nothing)
    starts, directions, colors = _sides(labels, nothing)
    if not len(starts):
        return ()
    order, counts = _loops(_successors(starts, directions, colors, labels.shape[1]))
    corners = starts[order]
    rings = _straighten(corners, counts, _cuts(labels)[corners[:, 1], corners[:, 0]])
    loop_colors = colors[order[np.cumsum(counts) - counts]].tolist()
    by_color: dict[int, list[Floats]] = {}
    for ring, color in zip(rings, loop_colors, strict=True):
        if len(ring):
            by_color.setdefault(color, []).append(ring + corner)
    return tuple(Region(tuple(each), f"#{color:06x}") for color, each in by_color.items())


def _frame(labels: Ints, nothing: int) -> tuple[Ints, Floats]:
    """Return what is not background, with background all around, and where (x, y) its first sample lies."""
    seen = labels != nothing
    row, column = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
    if not len(row):
        return np.full((2, 2), nothing, dtype=labels.dtype), np.zeros(2)
    top, left = int(row[0]), int(column[0])
    inner = labels[top : int(row[-1]) + 1, left : int(column[-1]) + 1]
    return np.pad(inner, 1, constant_values=nothing), np.array([left, top]) - 1.0


def _sides(labels: Ints, nothing: int) -> tuple[Ints, Ints, Ints]:
    """Return the sides of samples that are borders, clockwise around their own: start, direction, colour."""
    starts, directions, colors = [], [], []
    inner = labels[1:-1, 1:-1]
    beyond = (labels[:-2, 1:-1], labels[1:-1, 2:], labels[2:, 1:-1], labels[1:-1, :-2])  # above, right, ...
    corner = ((0, 0), (1, 0), (1, 1), (0, 1))  # where the side starts
    for direction, (other, (dx, dy)) in enumerate(zip(beyond, corner, strict=True)):
        row, column = np.nonzero((inner != other) & (inner != nothing))
        starts.append(np.stack([column + 1 + dx, row + 1 + dy], axis=1))
        directions.append(np.full(len(row), direction))
        colors.append(inner[row, column])
    return np.concatenate(starts), np.concatenate(directions), np.concatenate(colors)


def _successors(starts: Ints, directions: Ints, colors: Ints, width: int) -> Ints:
    """Return for each side the next around the same region; where two offer themselves, the sharper right."""
    ends = starts + np.array(_STEPS)[directions]
    row_length = width + 1
    _, color = np.unique(colors, return_inverse=True)
    size = int(starts[:, 1].max() + 2) * row_length

    def key(points: Ints, turn: Ints) -> Ints:
        return ((color.reshape(-1) * size + points[:, 1] * row_length + points[:, 0]) << 2) | turn

    keys = key(starts, directions)
    order = np.argsort(keys)
    sorted_keys = keys[order]
    following = np.full(len(starts), -1, dtype=np.int64)
    for turn in (1, 0, 3):  # to the right, straight on, to the left
        goal = key(ends, (directions + turn) % 4)
        place = np.minimum(np.searchsorted(sorted_keys, goal), len(keys) - 1)
        fits = (following < 0) & (sorted_keys[place] == goal)
        following[fits] = order[place[fits]]
    return following


def _loops(following: Ints) -> tuple[Ints, Ints]:
    """Return sides loop by loop, and how many each loop has."""
    successors = following.tolist()
    visited = bytearray(len(successors))
    order: list[int] = []
    counts: list[int] = []
    for start in range(len(successors)):
        if visited[start]:
            continue
        side, before = start, len(order)
        while not visited[side]:
            visited[side] = 1
            order.append(side)
            side = successors[side]
        counts.append(len(order) - before)
    return np.array(order, dtype=np.int64), np.array(counts, dtype=np.int64)


def _cuts(labels: Ints) -> Bools:
    """Return for each corner of samples (row, column) whether three regions or more meet there."""
    a, b, c, d = labels[:-1, :-1], labels[:-1, 1:], labels[1:, 1:], labels[1:, :-1]
    borders = sum(
        np.not_equal(one, other, dtype=np.bool_).view(np.int8)
        for one, other in ((a, b), (b, c), (c, d), (d, a))
    )
    cuts = np.zeros(labels.shape, dtype=np.bool_)
    cuts[1:, 1:] = borders >= 3
    return cuts


def _straighten(corners: Ints, counts: Ints, is_cut: Bools) -> list[Floats]:
    """Return rings with fewer corners, the same whichever region they are the border of.

    Between cuts a ring goes through the middles of its sides, which lie nearer to the true border than
    corners.

    Parameters
    ----------
    corners : (N, 2) array
        Of all rings, one behind the other.
    counts : (R,) array
        How many each ring has.
    is_cut : (N,) array
        Whether a corner stays where it is.

    Returns
    -------
    list of (M, 2) arrays
        Empty for rings that are too small to be seen.
    """
    begins = np.cumsum(counts) - counts
    ring = np.repeat(np.arange(len(counts)), counts)
    after = np.arange(1, len(ring) + 1)
    after[begins + counts - 1] = begins
    middles = (corners + corners[after]) / 2.0
    first = _first_sides(ring, begins, is_cut, middles)
    # All sides again, each ring from its first cut on.
    side = begins[ring] + (np.arange(len(ring)) + (first - 2 * begins)[ring]) % counts[ring]
    is_start = is_cut[side]
    is_start[begins] = True
    points, sizes = _lines(corners, middles, after, side, is_start, is_cut)
    points, sizes = _simplify(points, sizes)
    points = np.delete(points, np.cumsum(sizes) - 1, axis=0)  # where the next line of the ring begins
    kept = np.bincount(ring[is_start], sizes - 1, len(counts)).astype(np.int64)
    areas = _areas(points, kept)
    nothing = np.zeros((0, 2))
    rings = np.split(points, np.cumsum(kept)[:-1])
    return [
        each if len(each) >= 3 and area >= _SMALLEST else nothing
        for each, area in zip(rings, np.abs(areas), strict=True)
    ]


def _first_sides(ring: Ints, begins: Ints, is_cut: Bools, middles: Floats) -> Ints:
    """Return for each ring its first cut; of one without cuts the side that is farthest to the left."""
    order = np.lexsort((middles[:, 1], middles[:, 0], ~is_cut, ring))
    first: Ints = order[begins]
    cuts = np.flatnonzero(is_cut)
    with_cuts, places = np.unique(ring[cuts], return_index=True)
    first[with_cuts] = cuts[places]
    return first


def _lines(
    corners: Ints, middles: Floats, after: Ints, side: Ints, is_start: Bools, is_cut: Bools
) -> tuple[Floats, Ints]:
    """Return the points of all lines between cuts, and how many each line has.

    Lines of rings without cuts end where they begin: in the middle of a side.
    """
    starts = np.flatnonzero(is_start)
    lengths = np.diff(np.append(starts, len(side)))
    cut = is_cut[side[starts]]
    counts = lengths + 1 + cut
    offsets = np.cumsum(counts) - counts
    points = np.empty((int(counts.sum()), 2))
    line = np.repeat(np.arange(len(starts)), lengths)
    points[(offsets + cut - starts)[line] + np.arange(len(side))] = middles[side]
    points[offsets[cut]] = corners[side[starts[cut]]]
    last = side[starts + lengths - 1]
    points[offsets + counts - 1] = np.where(cut[:, np.newaxis], corners[after[last]], middles[side[starts]])
    return points, counts


def _simplify(points: Floats, counts: Ints) -> tuple[Floats, Ints]:
    """Return lines without the corners that lie within the tolerance of them, the same from both ends."""
    starts = np.cumsum(counts) - counts
    ends = starts + counts - 1
    first, last = points[starts], points[ends]
    is_closed = (first == last).all(axis=1)
    backwards = (first[:, 0] > last[:, 0]) | ((first[:, 0] == last[:, 0]) & (first[:, 1] > last[:, 1]))
    # A closed line: its sense of turning decides, and the farthest corner cuts it.
    backwards = np.where(is_closed, _areas(points, counts) < 0.0, backwards)
    line = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(points))
    order = np.where(backwards[line], (starts + ends)[line] - place, place)
    kept = np.empty(len(points), dtype=np.bool_)
    kept[order] = corners_to_keep(points[order], starts, TOLERANCE)
    return points[kept], np.bincount(line[kept], minlength=len(counts))


def _areas(points: Floats, counts: Ints) -> Floats:
    """Return the areas of rings, one behind the other, with signs for their sense of turning."""
    starts = np.cumsum(counts) - counts
    after = np.arange(1, len(points) + 1)
    after[starts + counts - 1] = starts
    x, y = points[:, 0], points[:, 1]
    ring = np.repeat(np.arange(len(counts)), counts)
    return np.asarray(0.5 * np.bincount(ring, x * y[after] - x[after] * y, len(counts)), dtype=np.float64)
