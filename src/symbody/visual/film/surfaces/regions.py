"""Regions of one colour as polygons: their borders are traced along the samples and made straight again."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
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
    labels = np.zeros(np.array(samples.shape[:2]) + 2, dtype=np.int64)
    labels[1:-1, 1:-1] = samples.astype(np.int64) @ np.array([65536, 256, 1])
    nothing = int(background[1:], 16)
    labels[[0, -1], :] = nothing
    labels[:, [0, -1]] = nothing
    starts, directions, colors = _sides(labels, nothing)
    if not len(starts):
        return ()
    loops = _loops(_successors(starts, directions, colors, labels.shape[1]))
    cuts = _cuts(labels)
    x, y = starts[:, 0], starts[:, 1]
    rings: dict[int, list[Floats]] = {}
    for loop in loops:
        corners = np.stack([x[loop], y[loop]], axis=1)
        ring = _straighten(corners, cuts[corners[:, 1], corners[:, 0]])
        if len(ring) >= 3 and abs(_area(ring)) >= _SMALLEST:
            rings.setdefault(int(colors[loop[0]]), []).append(ring - 1.0)
    return tuple(Region(tuple(each), f"#{color:06x}") for color, each in rings.items())


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


def _loops(following: Ints) -> list[list[int]]:
    successors = following.tolist()
    visited = bytearray(len(successors))
    loops = []
    for start in range(len(successors)):
        if visited[start]:
            continue
        loop, side = [], start
        while not visited[side]:
            visited[side] = 1
            loop.append(side)
            side = successors[side]
        loops.append(loop)
    return loops


def _cuts(labels: Ints) -> Bools:
    """Return for each corner of samples (row, column) whether three regions or more meet there."""
    four = np.stack([labels[:-1, :-1], labels[:-1, 1:], labels[1:, 1:], labels[1:, :-1]])
    borders = (four != np.roll(four, 1, axis=0)).sum(axis=0)
    cuts = np.zeros(labels.shape, dtype=np.bool_)
    cuts[1:, 1:] = borders >= 3
    return cuts


def _straighten(corners: Ints, is_cut: Bools) -> Floats:
    """Return a ring with fewer corners, the same whichever region it is the border of.

    Between cuts it goes through the middles of the sides, which lie nearer to the true border than corners.
    """
    places = np.flatnonzero(is_cut)
    first = int(places[0]) if len(places) else 0
    turned = np.concatenate([corners[first:], corners[: first + 1]]).astype(np.float64)
    middles = (turned[:-1] + turned[1:]) / 2
    if not len(places):
        start = int(np.lexsort((middles[:, 1], middles[:, 0]))[0])
        return _simplify(np.concatenate([middles[start:], middles[: start + 1]]))[:-1]
    ends = [*(places - first).tolist(), len(corners)]
    pieces = [
        _simplify(np.concatenate([turned[k : k + 1], middles[k:last], turned[last : last + 1]]))[:-1]
        for k, last in pairwise(ends)
    ]
    return np.concatenate(pieces)


def _simplify(line: Floats) -> Floats:
    """Return a line without the corners that lie within the tolerance of it, the same from both ends."""
    if len(line) < 3:
        return line
    backwards = tuple(line[0]) > tuple(line[-1])
    if (line[0] == line[-1]).all():  # closed: its sense of turning decides, and the farthest corner cuts it
        backwards = _area(line) < 0.0
    points = line[::-1] if backwards else line
    short = points[corners_to_keep(points, TOLERANCE)]
    return short[::-1] if backwards else short


def _area(ring: Floats) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
