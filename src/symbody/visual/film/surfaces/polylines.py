"""Straight pieces joined to long lines: fewer to write, and their corners are round."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from symbody.visual.film.facets import Floats

_GRID: Final = 50.0  # places in a point: ends nearer to each other are one
_STRAIGHT: Final = 0.03  # points: corners this near to a line are left out


def join_lines(lines: Iterable[Floats]) -> tuple[Floats, ...]:
    """Return lines (N, 2) [pt] joined end to end where exactly two meet, without needless corners."""
    pieces = list(_drop_copies(lines))
    ends: dict[tuple[int, int], list[int]] = defaultdict(list)
    for k, piece in enumerate(pieces):
        ends[_place(piece[0])].append(k)
        ends[_place(piece[-1])].append(k)
    unused = set(range(len(pieces)))
    chains = []
    # Chains begin where they end anyway; what is left then are rings.
    loose = [
        k for k, piece in enumerate(pieces) if any(len(ends[_place(piece[end])]) != 2 for end in (0, -1))
    ]
    for start in (*loose, *range(len(pieces))):
        if start not in unused:
            continue
        unused.discard(start)
        chain = [pieces[start]]
        if len(ends[_place(chain[0][0])]) == 2 and len(ends[_place(chain[0][-1])]) != 2:
            chain = [chain[0][::-1]]
        while (following := _next(chain[-1], pieces, ends, unused)) is not None:
            chain.append(following)
        points = np.concatenate([chain[0], *(each[1:] for each in chain[1:])])
        chains.append(points[corners_to_keep(points, _STRAIGHT)])
    return tuple(chains)


def _drop_copies(lines: Iterable[Floats]) -> Iterable[Floats]:
    seen: set[tuple[tuple[int, int], ...]] = set()
    for line in lines:
        places = tuple(_place(point) for point in line)
        key = min(places, places[::-1])
        if key not in seen and (len(line) > 2 or places[0] != places[1]):
            seen.add(key)
            yield line


def _next(
    last: Floats, pieces: Sequence[Floats], ends: dict[tuple[int, int], list[int]], unused: set[int]
) -> Floats | None:
    end = _place(last[-1])
    if len(ends[end]) != 2:
        return None
    for k in ends[end]:
        if k in unused:
            unused.discard(k)
            piece = pieces[k]
            return piece if _place(piece[0]) == end else piece[::-1]
    return None


def _place(point: Floats) -> tuple[int, int]:
    return round(float(point[0]) * _GRID), round(float(point[1]) * _GRID)


def corners_to_keep(points: Floats, tolerance: float) -> list[int]:
    """Return the corners by which a line (N, 2) stays within a tolerance, by Douglas and Peucker's rule."""
    kept = [0, len(points) - 1]
    waiting = [(0, len(points) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        along, away = points[last] - points[first], points[first + 1 : last] - points[first]
        length = float(np.hypot(*along))
        if length > 0.0:
            # Beyond the ends of the chord the nearer end counts: a line may come back on itself.
            share = np.clip(away @ along / length**2, 0.0, 1.0)
            away = away - share[:, np.newaxis] * along
        distances = np.hypot(away[:, 0], away[:, 1])
        farthest = int(np.argmax(distances))
        if distances[farthest] > tolerance:
            middle = first + 1 + farthest
            kept.append(middle)
            waiting += [(first, middle), (middle, last)]
    return sorted(kept)
