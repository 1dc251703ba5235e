"""Straight pieces joined to long lines: fewer to write, and their corners are round."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from symbody.visual.film.facets import Bools, Floats, Ints

_GRID: Final = 50.0  # places in a point: ends nearer to each other are one
_STRAIGHT: Final = 0.03  # points: corners this near to a line are left out


Place: TypeAlias = tuple[int, int]


class _Piece(NamedTuple):
    """A line and the places of its ends."""

    points: Floats
    start: Place
    end: Place

    def reverse(self) -> _Piece:
        """Return it the other way round."""
        return _Piece(self.points[::-1], self.end, self.start)


def join_lines(lines: Iterable[Floats]) -> tuple[Floats, ...]:
    """Return lines (N, 2) [pt] joined end to end where exactly two meet, without needless corners."""
    pieces = _distinct_pieces(list(lines))
    meeting: dict[Place, list[int]] = defaultdict(list)
    for k, piece in enumerate(pieces):
        meeting[piece.start].append(k)
        meeting[piece.end].append(k)
    unused = set(range(len(pieces)))
    chains = []
    # Chains begin where they end anyway; what is left then are rings.
    loose = [
        k for k, each in enumerate(pieces) if any(len(meeting[at]) != 2 for at in (each.start, each.end))
    ]
    for start in (*loose, *range(len(pieces))):
        if start not in unused:
            continue
        unused.discard(start)
        first = pieces[start]
        if len(meeting[first.start]) == 2 and len(meeting[first.end]) != 2:
            first = first.reverse()
        chain = [first]
        while (following := _next(chain[-1].end, pieces, meeting, unused)) is not None:
            chain.append(following)
        chains.append(np.concatenate([first.points, *(each.points[1:] for each in chain[1:])]))
    return _straighten(chains)


def _distinct_pieces(lines: Sequence[Floats]) -> list[_Piece]:
    """Return lines with the places of their ends, without copies and without points."""
    if not lines:
        return []
    places = [(x, y) for x, y in np.rint(np.concatenate(lines) * _GRID).astype(np.int64).tolist()]
    pieces: dict[tuple[Place, ...], _Piece] = {}
    first = 0
    for line in lines:
        own = tuple(places[first : first + len(line)])
        first += len(line)
        if len(line) > 2 or own[0] != own[1]:
            pieces.setdefault(min(own, own[::-1]), _Piece(line, own[0], own[-1]))
    return list(pieces.values())


def _next(
    end: Place, pieces: Sequence[_Piece], meeting: dict[Place, list[int]], unused: set[int]
) -> _Piece | None:
    if len(meeting[end]) != 2:
        return None
    for k in meeting[end]:
        if k in unused:
            unused.discard(k)
            return pieces[k] if pieces[k].start == end else pieces[k].reverse()
    return None


def _straighten(lines: Sequence[Floats]) -> tuple[Floats, ...]:
    """Return lines without the corners that lie on them anyway."""
    if not lines:
        return ()
    counts = np.array([len(line) for line in lines])
    starts = np.cumsum(counts) - counts
    points = np.concatenate(lines)
    kept = corners_to_keep(points, starts, _STRAIGHT)
    return tuple(np.split(points[kept], np.cumsum(np.add.reduceat(kept, starts, dtype=np.int64))[:-1]))


def corners_to_keep(points: Floats, starts: Ints, tolerance: float) -> Bools:
    """Return the corners by which lines stay within a tolerance, by Douglas and Peucker's rule.

    Parameters
    ----------
    points : (N, 2) array
        All lines, one behind the other.
    starts : (L,) array
        Where each begins; lines have two points at least.

    Returns
    -------
    (N,) array of bool
        Both ends of each line are among them.
    """
    kept = np.zeros(len(points), dtype=np.bool_)
    first, last = starts, np.append(starts[1:], len(points)) - 1
    kept[first] = kept[last] = True
    while len(first):  # all chords of all lines at once
        has_corners = last - first >= 2
        first, last = first[has_corners], last[has_corners]
        if not len(first):
            break
        counts = last - first - 1
        begins = np.cumsum(counts) - counts
        chord = np.repeat(np.arange(len(first)), counts)
        corner = np.arange(len(chord)) + np.repeat(first + 1 - begins, counts)
        distances = _distances(points[corner] - points[first][chord], (points[last] - points[first])[chord])
        farthest = np.maximum.reduceat(distances, begins)
        at_farthest = np.flatnonzero(distances == farthest[chord])
        _, earliest = np.unique(chord[at_farthest], return_index=True)
        middle = corner[at_farthest[earliest]]
        is_far = farthest > tolerance
        first, middle, last = first[is_far], middle[is_far], last[is_far]
        kept[middle] = True
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    return kept


def _distances(away: Floats, along: Floats) -> Floats:
    """Return how far corners (N, 2) are from chords (N, 2), both from where the chord starts."""
    squares = np.einsum("ij,ij->i", along, along)
    # Beyond the ends of the chord the nearer end counts: a line may come back on itself.
    share = np.einsum("ij,ij->i", away, along) / np.where(squares > 0.0, squares, 1.0)
    rest = away - np.clip(share, 0.0, 1.0)[:, np.newaxis] * along
    return np.asarray(np.hypot(rest[:, 0], rest[:, 1]), dtype=np.float64)
