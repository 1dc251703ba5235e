"""Held values as inputs of the equations: what they are at present, and what they were."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.kernels.samples.sampling import ONE_INSTANT
from symbody.model.model import Model

Floats = NDArray[np.float64]


class HeldSource(Protocol):
    """Where held values are kept."""

    def current(self, name: str) -> float:
        """Return a value at present."""
        ...

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at times (N,) that the motion has passed."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class HeldLaw:
    """The law of an input that is held between samples."""

    source: HeldSource
    name: str

    def __call__(self, t: float, q: Floats, u: Floats) -> float:
        """Return the value at present."""
        return self.current()

    def current(self) -> float:
        """Return the value at present."""
        return self.source.current(self.name)

    def values_at(self, t: Floats) -> Floats:
        """Return the values at times (N,) that the motion has passed."""
        return self.source.values_at(self.name, t)


@dataclass(frozen=True, slots=True, eq=False)
class HeldRecord:
    """Held values as they were sampled.

    Attributes
    ----------
    names : tuple of str
        Of the values, in the order of the model.
    t : (K,) array
        When any of them was sampled [s].
    values : (m, K) array
        All of them from then on.
    """

    names: tuple[str, ...]
    t: Floats
    values: Floats

    def current(self, name: str) -> float:
        """Return the last value."""
        return float(self.values[self.names.index(name), -1])

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at times (N,); at a sample it is new already."""
        values: Floats = self.values[self.names.index(name)][places_in(self.t, t)]
        return values


def held_later(eqs: EquationSet, inputs: Collection[str] = ()) -> dict[str, HeldLaw]:
    """Return laws for held values of motions still to be computed, and `inputs` by FMUs: not numbers."""
    signals = eqs.model.held_signals if isinstance(eqs.model, Model) else ()
    names = (*(signal.name for signal in signals), *inputs)
    nothing = HeldRecord(names, np.zeros(1), np.full((len(names), 1), math.nan))
    return {name: HeldLaw(nothing, name) for name in names}


def places_in(samples: Floats, t: Floats) -> NDArray[np.intp]:
    """Return the last of the samples (K,) that lies at each time, up to rounding, or before it; else 0."""
    margin = ONE_INSTANT * np.maximum(np.abs(t), np.abs(samples[0]))
    places: NDArray[np.intp] = np.maximum(np.searchsorted(samples, t + margin, side="right") - 1, 0)
    return places


def join_records(given: Sequence[HeldRecord], order: Sequence[str]) -> HeldRecord | None:
    """Return several records as one, with names in this order; None without any sample."""
    records = [record for record in given if record.t.size]
    if not records:
        return None
    t = np.unique(np.concatenate([record.t for record in records]))
    t = t[np.diff(t, prepend=-np.inf) > 2.0 * ONE_INSTANT * np.maximum(np.abs(t), abs(float(t[0])))]
    by_name: Mapping[str, HeldRecord] = {name: record for record in records for name in record.names}
    names = tuple(name for name in order if name in by_name)
    return HeldRecord(names, t, np.stack([by_name[name].values_at(name, t) for name in names]))
