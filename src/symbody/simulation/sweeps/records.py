"""What a worker receives, what it computes, and what it returns: code and numbers, or a sweep to simulate.

A case comes out the same whatever else is computed beside it, so results do not depend on how cases are cut
into parts, nor on who computes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.block import Counts
from symbody.simulation.events.events import Occurrence
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.status import Status

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The code of a case that has no verdict yet.
NOT_ENDED: Final = -1
# Codes of the others. Stores keep them: a number is never given to another status.
CODES: Final[Mapping[Status, int]] = MappingProxyType(
    {
        Status.SUCCESS: 100,
        Status.STOPPED: 101,
        Status.STEP_COLLAPSE: 102,
        Status.NOT_FINITE: 103,
        Status.SINGULAR: 104,
        Status.FRICTION: 105,
        Status.DEPENDENT_SPEEDS: 106,
        Status.TOO_MANY_STEPS: 107,
        Status.STIFF: 108,
        Status.CHATTERING: 109,
        Status.NOT_STARTED: 110,
        Status.WORKER_LOST: 111,
        Status.INTERRUPTED: 112,
        Status.OUT_OF_MEMORY: 113,
        Status.UNMET_ACTION: 114,
    }
)
STATUSES: Final[Mapping[int, Status]] = MappingProxyType(
    {NOT_ENDED: Status.INTERRUPTED} | {code: status for status, code in CODES.items()}
)


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Some cases to compute; one row each.

    Attributes
    ----------
    first : int
        The number of the first.
    states : (cases, n) array
        First states x = (u, q, s); a row that is not finite is left out.
    parameters : (cases, n_p) array
        What varies.
    sizes : tuple of (cases, k) arrays
        What counts as large: tolerances as in `Goal`, that of the work last where events are watched; scales
        and sizes as in `Projector`; what `native.closing.metric` returns; length, time and displacements
        where modes are decided. Without columns where a case has no use for them.
    """

    first: int
    states: Floats
    parameters: Floats
    sizes: tuple[Floats, ...]

    @classmethod
    def blank(cls, count: int) -> Chunk:
        """Return cases that are found by their numbers alone."""
        return cls(0, np.zeros((count, 0)), np.zeros((count, 0)), ())

    @property
    def count(self) -> int:
        """How many cases."""
        return len(self.states)

    def cut(self, start: int, stop: int) -> Chunk:
        """Return some of the cases."""
        sizes = tuple(array[start:stop] for array in self.sizes)
        return Chunk(self.first + start, self.states[start:stop], self.parameters[start:stop], sizes)


@dataclass(frozen=True, slots=True, eq=False)
class CaseDetails:
    """What is known of a case besides its samples.

    Attributes
    ----------
    notes : str
        What there is to say of it.
    names : tuple of str
        Names of what may have happened.
    happened : (k, 2 + n) array
        What did: the place of its name, when [s], the state then.
    work : (N,) array, optional
        The work done until each sample [J].
    modes : HeldRecord, optional
        Which joints stuck and which ropes were taut; see `hybrid.mode_record`.
    held : HeldRecord, optional
        Values that were held between samples.
    """

    notes: str
    names: tuple[str, ...] = ()
    happened: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    work: Floats | None = None
    modes: HeldRecord | None = None
    held: HeldRecord | None = None

    def events(self, state_names: Sequence[str]) -> tuple[Occurrence, ...]:
        """Return what happened."""
        return tuple(
            Occurrence(self.names[int(place)], t, dict(zip(state_names, state, strict=True)))
            for place, t, *state in self.happened.tolist()
        )


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What is known of some cases; one row each.

    Attributes
    ----------
    x : (cases, N, n) array
        The samples, NaN where a motion did not get that far.
    codes : (cases,) array of int
        How each ended, see `CODES`.
    counts : (cases, `Counts.size`) array of int
        What each cost, and what is to blame.
    reached : (cases,) array
        Time up to which each is known [s].
    details : dict of case to CaseDetails
        Of those of which more is known.
    """

    first: int
    x: Floats
    codes: Integers
    counts: Integers
    reached: Floats
    details: dict[int, CaseDetails] = field(default_factory=dict)

    @classmethod
    def empty(cls, first: int, count: int, samples: int, states: int) -> Records:
        """Return records of cases that nothing is known of."""
        return cls(
            first,
            np.full((count, samples, states), np.nan),
            np.full(count, NOT_ENDED, dtype=np.int64),
            np.zeros((count, Counts.size), dtype=np.int64),
            np.full(count, np.nan),
        )

    @property
    def count(self) -> int:
        """How many cases."""
        return len(self.codes)

    def cut(self, start: int, stop: int) -> Records:
        """Return some of the cases, the same memory."""
        rows = slice(start, stop)
        arrays = self.x[rows], self.codes[rows], self.counts[rows], self.reached[rows]
        return Records(self.first + start, *arrays, self.details)

    def has_room_for(self, other: Records) -> bool:
        """Return whether others are of some of these cases, in arrays of the same kinds."""
        start, count = other.first - self.first, other.codes.size
        pairs = [(self.x, other.x), (self.codes, other.codes), (self.counts, other.counts)]
        return 0 <= start <= start + count <= self.count and all(
            theirs.shape == (count, *ours.shape[1:]) and theirs.dtype == ours.dtype
            for ours, theirs in (*pairs, (self.reached, other.reached))
        )

    def put(self, other: Records) -> None:
        """Take over what others know of some of these cases."""
        rows = slice(other.first - self.first, other.first - self.first + other.count)
        self.x[rows], self.codes[rows] = other.x, other.codes
        self.counts[rows], self.reached[rows] = other.counts, other.reached
        self.details.update(other.details)


def blocks(count: int, size: int) -> Iterator[tuple[int, int]]:
    """Yield the ends of blocks of a size; the last may be shorter."""
    for start in range(0, count, size):
        yield start, min(start + size, count)
