"""Which stretches of lines are in front of everything: each is compared with the depth along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.film.facets import Bools, Floats, Ints

_TOLERANCE: Final = 2.0  # samples: how far a line may lie behind the surface that it is on
_SHORTEST: Final = 1.5  # samples: shorter stretches of longer lines are noise


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """Straight stretches that are visible: (M, 2, 2) points in samples, and the line that each belongs to."""

    points: Floats
    lines: Ints


def visible_stretches(lines: Floats, depth: NDArray[np.float32], sample: float) -> Stretches:
    """Return the stretches of straight lines that no surface hides.

    Parameters
    ----------
    lines : (E, 2, 3) array
        Ends: x and y in samples, depth [m].
    depth : (height, width) array
        Of the nearest surface at each sample [m].
    sample : float
        The distance of two samples [m].

    Notes
    -----
    A line is visible where the surface just to its left, just to its right or under it is not in front of it.
    At an outline the one beside lies far behind, so outlines show although the surface they bound bulges
    towards the eye.
    """
    across = lines[:, 1, :2] - lines[:, 0, :2]
    lengths = np.linalg.norm(across, axis=1)
    inside = _touches(lines, depth.shape)
    counts = np.where(inside, np.minimum(np.ceil(lengths), 4 * sum(depth.shape)).astype(np.int64) + 1, 0)
    owner = np.repeat(np.arange(len(lines)), counts)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (step + 0.5) / counts[owner]
    places = lines[owner, 0] + share[:, np.newaxis] * (lines[owner, 1] - lines[owner, 0])
    sideways = np.stack([-across[:, 1], across[:, 0]], axis=1) / np.maximum(lengths, 1e-12)[:, np.newaxis]
    seen = np.zeros(len(owner), dtype=np.bool_)
    limit = places[:, 2] - _TOLERANCE * sample
    for offset in (0.0, 1.2, -1.2):
        seen |= limit <= _lookup(depth, places[:, :2] + offset * sideways[owner])
    return _runs(lines, lengths, owner, step, counts, seen)


def _touches(lines: Floats, shape: tuple[int, int]) -> Bools:
    """Return whether each line may cross the picture."""
    low, high = lines[:, :, :2].min(axis=1), lines[:, :, :2].max(axis=1)
    return np.asarray((high >= 0.0).all(axis=1) & (low <= np.array(shape[::-1])).all(axis=1))


def _lookup(depth: NDArray[np.float32], places: Floats) -> Floats:
    """Return depths at places (N, 2); outside of the picture nothing is visible."""
    height, width = depth.shape
    column, row = np.floor(places).astype(np.int64).T
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    values = depth[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    return np.where(inside, values, -np.inf)


def _runs(lines: Floats, lengths: Floats, owner: Ints, step: Ints, counts: Ints, seen: Bools) -> Stretches:
    if not len(owner):
        return Stretches(np.zeros((0, 2, 2)), np.zeros(0, dtype=np.int64))
    begins = seen & np.concatenate([[True], ~seen[:-1] | (owner[1:] != owner[:-1])])
    ends = seen & np.concatenate([~seen[1:] | (owner[1:] != owner[:-1]), [True]])
    owners = owner[begins]
    first, last = step[begins] / counts[owners], (step[ends] + 1) / counts[owners]
    proper = ((last - first) * lengths[owners] >= _SHORTEST) | (last - first >= 1.0)
    owners, shares = owners[proper], np.stack([first, last], axis=1)[proper]
    start, along = lines[owners, 0, :2], lines[owners, 1, :2] - lines[owners, 0, :2]
    return Stretches(start[:, np.newaxis] + shares[:, :, np.newaxis] * along[:, np.newaxis], owners)
