"""What a worker receives, what it computes, and what it returns: code and numbers, or a sweep to simulate.

A case comes out the same whatever else is computed beside it, so results do not depend on how cases are cut
into parts, nor on who computes them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.kernels.block import Counts
from symbody.simulation.events.events import Occurrence
from symbody.simulation.events.watch_arrays import WatchedEvent
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inputs.time_functions import TimeFunctions, time_functions
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native.closing import StateShape

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Codes of cases besides those of the compiled loop.
NOT_ENDED: Final = -1
NOT_STARTED: Final = -2
WORKER_LOST: Final = -3


@dataclass(frozen=True, slots=True, eq=False)
class CaseWatch:
    """What is watched in all cases.

    Attributes
    ----------
    values, actions : CompiledFunction
        The values of all events; the energy, what actions set, and the derivative xdot; None where none acts.
    labels, events : tuples
        Names of the events, and these as numbers.
    state_names : tuple of str
        Speeds, coordinates, states of signals.
    closing : CompiledFunction or None
        Computes `native.closing.CLOSING` or `POSED`; None where no event changes what has to be closed.
    shape, share
        As `native.closing.closing_block` takes them.
    """

    values: CompiledFunction
    actions: CompiledFunction | None
    labels: tuple[str, ...]
    events: tuple[WatchedEvent, ...]
    state_names: tuple[str, ...]
    closing: CompiledFunction | None
    shape: StateShape
    share: float


@dataclass(frozen=True, slots=True, eq=False)
class CaseModes:
    """What decides in all cases which joints stick and which ropes are taut.

    Attributes
    ----------
    deciding, projecting : CompiledFunction
        Compute `hybrid.switching.deciding_outputs`, and `constraints.PROJECTED` with modes as last inputs.
    block : array
        The `ModeSwitch` of a motion that has not begun.
    names, joints, ropes : tuples of str
        The inputs that are modes, and the elements in their order.
    """

    deciding: CompiledFunction
    projecting: CompiledFunction
    block: Floats
    names: tuple[str, ...]
    joints: tuple[str, ...]
    ropes: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class LoopJob:
    """A sweep for the compiled loop over many cases.

    Attributes
    ----------
    function : CompiledFunction
        The derivative xdot, with what varies as its arguments p.
    closing : CompiledFunction or None
        Computes `constraints.PROJECTED`.
    times : (N,) array
        The samples to store.
    lanes : bool
        Whether several cases are computed side by side; results do not depend on it.
    breakpoints : tuple of Breakpoints or None
        Of all cases the same, or to be found for each from its parameters.
    rounding, limit : float
        As in `Projector`.
    tables : mapping of place to Table
        The inputs r of the derivative that are tables: all of them, but for modes behind them.
    watch : CaseWatch or None
        The events. Where there are any, `function` gives the power behind xdot.
    modes : CaseModes or None
        Where joints stick and slip or ropes go taut; their ends are the last events.
    """

    function: CompiledFunction
    closing: CompiledFunction | None
    span: tuple[float, float]
    times: Floats
    method: Explicit | FixedStep
    rtol: float
    max_steps: int
    stop_when_stiff: bool
    lanes: bool
    breakpoints: tuple[Breakpoints, ...] | None = None
    rounding: float = 0.0
    limit: float = math.inf
    tables: Mapping[int, Table] = field(default_factory=dict)
    watch: CaseWatch | None = None
    modes: CaseModes | None = None

    @property
    def input_count(self) -> int:
        """Number of inputs r of the derivative, the modes among them."""
        return len(self.tables) + (0 if self.modes is None else len(self.modes.names))

    @property
    def state_size(self) -> int:
        """Number of speeds, coordinates and states of signals."""
        return len(self.function.signature.states)

    def functions_of_time(self, *, with_parameters: bool) -> list[TimeFunctions | None]:
        """Return what the derivative and the values of events compute from time, and perhaps what varies."""
        sequences = [self.function.sequence, *([] if self.watch is None else [self.watch.values.sequence])]
        return [time_functions(each, self.tables, with_parameters=with_parameters) for each in sequences]


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Some cases to compute; one row each.

    Attributes
    ----------
    first : int
        The number of the first.
    states : (cases, n) array
        First states x = (u, q); a row that is not finite is left out.
    parameters : (cases, n_p) array
        What varies.
    scales, sizes : (cases, constraints), (cases, n_q) arrays
        As in `Projector`.
    atol : (cases, n) array
        As in `Goal`, the work last where events are watched.
    metric : (cases, n_u + n_q + n_h) array
        As `native.closing.metric` returns it; without columns where nothing is closed after events.
    mode_sizes : (cases, 2 + n_u) array
        Length, time and displacements that count as large; without columns where no modes change.
    """

    first: int
    states: Floats
    parameters: Floats
    scales: Floats
    sizes: Floats
    atol: Floats
    metric: Floats
    mode_sizes: Floats

    @classmethod
    def blank(cls, count: int) -> Chunk:
        """Return cases that are found by their numbers alone."""
        return cls(0, *[np.zeros((count, 0))] * 7)

    @property
    def count(self) -> int:
        """How many cases."""
        return len(self.states)

    def cut(self, start: int, stop: int) -> Chunk:
        """Return some of the cases."""
        arrays = (
            self.states, self.parameters, self.scales, self.sizes, self.atol, self.metric, self.mode_sizes,
        )  # fmt: skip
        return Chunk(self.first + start, *(array[start:stop] for array in arrays))


@dataclass(frozen=True, slots=True, eq=False)
class CaseDetails:
    """What `simulate` returns of a case besides its samples.

    Attributes
    ----------
    notes : str
        What there is to say of it.
    events : tuple of Occurrence
        What happened.
    work : (N,) array, optional
        The work done until each sample [J].
    modes : HeldRecord, optional
        Which joints stuck and which ropes were taut; see `hybrid.mode_record`.
    held : HeldRecord, optional
        Values that were held between samples.
    """

    notes: str
    events: tuple[Occurrence, ...] = ()
    work: Floats | None = None
    modes: HeldRecord | None = None
    held: HeldRecord | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What is known of some cases; one row each.

    Attributes
    ----------
    x : (cases, N, n) array
        The samples, NaN where a motion did not get that far.
    codes : (cases,) array of int
        How each ended.
    counts : (cases, `Counts.size`) array of int
        What each cost, and what is to blame.
    reached : (cases,) array
        Time up to which each is known [s].
    details : dict of case to CaseDetails
        Of cases computed by `simulate`.
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
