"""`Sampler`: values that are held between samples, as `symbody.kernels.samples.sampling` updates them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.pack import pack
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.kernels.samples.sampling import ONE_INSTANT
from symbody.simulation.inputs.held_law import HeldRecord, places_in

Floats = NDArray[np.float64]

_FIRST_ROOM: Final = 256  # samples


@dataclass(frozen=True, slots=True, eq=False)
class HeldValue:
    """A value that is held between samples.

    Attributes
    ----------
    formula : str
        Of its new value: an expression, or the name of an output.
    slot : int
        Its place among the inputs that compiled functions take.
    step : float
        Its sample time [s].
    initial : float
        The value before the first sample.
    """

    name: str
    formula: str
    slot: int
    step: float
    initial: float


class Sampler:
    """Values that are held between samples: what they are, what they were, when the next samples are due.

    Parameters
    ----------
    values : sequence of HeldValue
        In the order in which they are updated.
    start : float
        When samples are counted from [s].
    speeds : int
        How many speeds stand first in states.

    Attributes
    ----------
    block : array
        Of `hold`.
    hold : SampleHold
        The values at present.
    record : (room, 1 + m) array
        When samples were taken, and all values from then on.
    """

    def __init__(self, values: Sequence[HeldValue], start: float, speeds: int) -> None:
        self.values = tuple(values)
        self.names = tuple(value.name for value in values)
        steps = tuple(dict.fromkeys(value.step for value in values))
        groups = [steps.index(value.step) for value in values]
        self.record: Floats = np.empty((_FIRST_ROOM, 1 + len(values)))
        self.block: Floats = pack(
            SampleHold, count=len(values), groups=len(steps), speeds=speeds, start=start, next=start,
            room=len(self.record), values=[value.initial for value in values],
            slots=[value.slot for value in values], group_of=groups, steps=steps,
        )  # fmt: skip
        self._first = self.block.copy()

    @property
    def hold(self) -> SampleHold:
        """What the kernels read and change."""
        return SampleHold(self.block)

    @property
    def formulas(self) -> list[str]:
        """The formulas of all new values."""
        return [value.formula for value in self.values]

    @property
    def samples(self) -> HeldRecord:
        """What was sampled so far."""
        rows = self.record[: self.hold.recorded]
        return HeldRecord(self.names, rows[:, 0].copy(), np.ascontiguousarray(rows[:, 1:].T))

    def current(self, name: str) -> float:
        """Return a value at present."""
        return float(self.hold.values[self.names.index(name)])

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at times (N,) that the motion has passed."""
        rows = self.record[: self.hold.recorded]
        if not len(rows):
            return np.full(np.shape(t), self.current(name))
        k = self.names.index(name)
        values: Floats = rows[places_in(rows[:, 0], np.asarray(t)), 1 + k]
        margin = ONE_INSTANT * np.maximum(np.abs(t), abs(self.hold.start))
        return np.where(np.asarray(t) < rows[0, 0] - margin, SampleHold(self._first).values[k], values)

    def value_before(self, name: str, t: float) -> float:
        """Return a value just before a time that the motion has passed."""
        rows = self.record[: self.hold.recorded]
        margin = ONE_INSTANT * max(abs(t), abs(self.hold.start))
        place = int(np.searchsorted(rows[:, 0], t - margin)) - 1
        k = self.names.index(name)
        return float(SampleHold(self._first).values[k] if place < 0 else rows[place, 1 + k])

    @property
    def next_due(self) -> float:
        """When the next sample is due [s]."""
        return self.hold.next

    def is_due(self, t: float) -> bool:
        """Return whether a sample is due at a time, up to rounding."""
        margin = ONE_INSTANT * max(abs(t), abs(self.next_due), abs(self.hold.start))
        return self.next_due - t <= margin

    def grow(self) -> None:
        """Make room for as many more samples."""
        self.record = np.concatenate([self.record, np.empty_like(self.record)])
        self.hold.room = len(self.record)

    def rewind(self, t: float) -> None:
        """Forget the samples behind a time."""
        hold = self.hold
        kept = self.record[: hold.recorded]
        margin = ONE_INSTANT * max(abs(t), abs(hold.start))
        count = int(np.searchsorted(kept[:, 0], t + margin, side="right"))
        if count == len(kept):
            return
        if count == 0:
            self.block[:] = self._first
            hold.room = len(self.record)
            return
        hold.recorded = count
        np.asarray(hold.values)[:] = kept[count - 1, 1:]
        self._count_samples(float(kept[count - 1, 0]))

    def _count_samples(self, last: float) -> None:
        """Set how many samples each group has taken, where the last of all was taken at a time."""
        hold = self.hold
        start, steps, taken = hold.start, np.asarray(hold.steps), np.asarray(hold.taken)
        margin = ONE_INSTANT * max(abs(last), abs(start))
        taken[:] = np.maximum(np.round((last - start) / steps), 0.0)
        taken[start + taken * steps <= last + margin] += 1.0
        hold.next = (start + taken * steps).min()

    def follow(self, other: Sampler, t: float) -> None:
        """Go on from a time with the values of another sampler, whose sample times may be others."""
        np.asarray(self.hold.values)[:] = other.hold.values
        if np.asarray(other.hold.taken).any():
            self._count_samples(t)

    def save(self) -> tuple[Floats, Floats]:
        """Return all values, present and past."""
        return self.block.copy(), self.record.copy()

    def put_back(self, saved: tuple[Floats, Floats]) -> None:
        """Return to what was saved."""
        self.record = saved[1]
        self.block[:] = saved[0]

    def snapshot(self) -> Floats:
        """Return the block, from which `resume` goes on."""
        return self.block.copy()

    def resume(self, kept: Floats) -> None:
        """Go on from a snapshot; the record begins anew."""
        self.block[:] = kept
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget what was recorded: the values at present are the first."""
        self.hold.recorded, self.hold.room = 0, len(self.record)
        self._first = self.block.copy()
