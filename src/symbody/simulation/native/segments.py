"""A run that is cut where something happened, and goes on from there in another state."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from symbody.kernels import block as at
from symbody.simulation.native.dense_output import shorten
from symbody.simulation.native.description import Floats, Record
from symbody.simulation.status import Status


class Cut(NamedTuple):
    """Where a run ends, or goes on in another state.

    Attributes
    ----------
    t : float
        When [s].
    before : (n,) array
        The state that was reached.
    after : (n,) array or None
        The state from which the run goes on.
    status : Status
        The verdict, if it does not.
    """

    t: float
    before: Floats
    after: Floats | None
    status: Status = Status.STOPPED


class Watch(Protocol):
    """Looks at the steps of each slice."""

    @property
    def most_steps(self) -> int:
        """How many steps a slice may have."""
        ...

    def look(self, breaks: Floats, pieces: Floats, steps: int, is_over: bool) -> Cut | None:
        """Return where the run has to be cut, if anywhere in its first `steps` steps.

        `breaks` and `pieces` are those of `DenseOutput`, with room for more. After a cut that goes on,
        the next step follows the one that was cut.
        """
        ...


def steps_before(breaks: Floats, steps: int, t: float) -> int:
    """Return how many of the first `steps` steps begin before a time."""
    direction = 1.0 if breaks[steps] >= breaks[0] else -1.0
    return int(np.searchsorted(direction * breaks[: steps + 1], direction * t))


def cut_back(block: Floats, record: Record, cut: Cut) -> Record:
    """Forget what lies beyond a cut; its state is a sample if every step is one, or if it is the end."""
    steps, count = int(block[at.STEPS]), int(block[at.SAMPLES])
    direction = 1.0 if record.breaks[steps] >= record.breaks[0] else -1.0
    end = steps_before(record.breaks, steps, cut.t)
    start = record.breaks[end - 1]
    if cut.t != record.breaks[end]:
        share = (cut.t - start) / (record.breaks[end] - start)
        record.pieces[end - 1] = shorten(record.pieces[end - 1], float(share))
    sample = int(np.searchsorted(direction * record.t[:count], direction * cut.t))
    record.breaks[end] = cut.t
    block[at.STEPS], block[at.SAMPLES] = end, sample
    if record.t.size < sample + 2:
        record = record._replace(t=_longer(record.t), x=_longer(record.x))
    if record.every_step or cut.after is None:
        record.t[sample], record.x[sample] = cut.t, cut.before
        block[at.SAMPLES] = sample + 1
    return record


def go_on(begin: Callable[[], int], block: Floats, record: Record, cut: Cut) -> int:
    """Begin anew at a cut; return the code of `begin`, which stores the state if every step is a sample."""
    for place in (at.KERNEL, at.AFTER_REJECTION, at.STIFF_VOTES, at.OTHER_VOTES):
        block[place] = 0
    first = float(record.breaks[0])
    code = begin()
    record.breaks[0] = first  # it belongs to the first segment
    sample = int(block[at.SAMPLES])
    if code == at.FINISHED and sample < record.wanted.size and cut.after is not None:
        record.t[sample], record.x[sample] = cut.t, cut.after
        block[at.SAMPLES] = sample + 1
    return code


def _longer(array: Floats) -> Floats:
    return np.concatenate([array, np.empty((max(2, array.shape[0]), *array.shape[1:]))])
