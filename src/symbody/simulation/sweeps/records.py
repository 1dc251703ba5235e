"""What is known of the cases of a sweep, and a folder that keeps it.

A case comes out the same whatever else is computed beside it, so results do not depend on how cases are cut
into parts, nor on who computes them.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.kernels.block import Counts
from symbody.simulation.events.events import Occurrence
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.results.archive import read_arrays
from symbody.simulation.status import Status
from symbody.storage import move_into_place

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


_FORMAT: Final = "symbody sweep 6"
_ABOUT: Final = "sweep.json"
_NAME: Final = re.compile(r"cases_(\d+)_(\d+)\.npz")


class Store:
    """A folder with the finished chunks of one sweep.

    Parameters
    ----------
    path : path
        The folder, made where it does not exist.
    digest : str
        Stands for all that results depend on.

    Raises
    ------
    UsageError
        If the folder belongs to another sweep, or to something else.
    EnvironmentFault
        If it cannot be made or read.
    """

    def __init__(self, path: str | os.PathLike[str], digest: str) -> None:
        self._folder = Path(path)
        about = {"format": _FORMAT, "digest": digest}
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            found = self._read_about()
            if found is None:
                _write(self._folder / _ABOUT, json.dumps(about).encode())
        except OSError as error:
            raise self._unwritable(error) from error
        if found is not None and found != about:
            raise UsageError(
                Problem("sweep.store", str(path), "the folder holds parts of another sweep",
                        "its model, cases, times, method or tolerances differ, or the release of symbody",
                        "give another folder, or delete this one")
            )  # fmt: skip

    def read_finished(self, whole: Records) -> Iterable[Records]:
        """Yield what was kept of all cases; what cannot be read, or does not fit, is computed anew."""
        for path in sorted(self._folder.glob("cases_*.npz")):
            name = _NAME.fullmatch(path.name)
            try:
                with open(path, "rb") as file:
                    arrays = read_arrays(file)
                records = Records(
                    int(name[1]) if name else -1,
                    arrays["x"], arrays["codes"], arrays["counts"], arrays["reached"],
                    _read_details(str(arrays["details"])),
                )  # fmt: skip
            except Exception:  # a damaged file breaks zipfile in every way there is
                continue
            if whole.has_room_for(records):
                yield records

    def keep(self, records: Records) -> None:
        """Keep a chunk that is complete; raises EnvironmentFault if it cannot be written."""
        name = f"cases_{records.first:09d}_{records.first + records.count:09d}.npz"
        own = self._folder / f"{name}.{os.getpid()}.part"
        try:
            with open(own, "wb") as file:
                np.savez(
                    file, x=records.x, codes=records.codes, counts=records.counts, reached=records.reached,
                    details=np.array(_details_text(records)),
                )  # fmt: skip
            move_into_place(own, self._folder / name)
        except OSError as error:
            raise self._unwritable(error) from error

    def _read_about(self) -> object:
        path = self._folder / _ABOUT
        if not path.exists():
            return None
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError):
            return {}

    def _unwritable(self, error: OSError) -> EnvironmentFault:
        what = f"the folder cannot be used: {error.strerror or error}"
        return EnvironmentFault(
            Problem(
                "sweep.store_folder", str(self._folder), what, fix="choose a folder with write permission"
            )
        )


def _details_text(records: Records) -> str:
    cases = range(records.first, records.first + records.count)
    return json.dumps(
        {case: asdict(records.details[case]) for case in cases if case in records.details},
        default=np.ndarray.tolist,
    )


def _read_details(text: str) -> dict[int, CaseDetails]:
    return {
        int(case): CaseDetails(
            str(about["notes"]),
            tuple(about["names"]),
            np.array(about["happened"], dtype=np.float64),
            None if about["work"] is None else np.array(about["work"], dtype=np.float64),
            _held_record(about["modes"]),
            _held_record(about.get("held")),
        )
        for case, about in json.loads(text).items()
    }


def _held_record(about: Mapping[str, Any] | None) -> HeldRecord | None:
    if about is None:
        return None
    values = np.array(about["values"], dtype=np.float64)
    return HeldRecord(tuple(about["names"]), np.array(about["t"], dtype=np.float64), values)


def _write(path: Path, content: bytes) -> None:
    own = path.with_suffix(f".{os.getpid()}.part")
    own.write_bytes(content)
    move_into_place(own, path)
