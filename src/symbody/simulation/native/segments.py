"""A run that is cut where something happened, and goes on from there in another state."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from symbody.simulation.native.description import Floats, LoopCall, Record
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


class HeldValues(Protocol):
    """Takes the samples of values that are held in between, in the compiled loop."""

    @property
    def address(self) -> int:
        """Where the function of new values lies."""
        ...

    @property
    def arrays(self) -> tuple[Floats, Floats]:
        """The block of the held values, and the numbers of their function."""
        ...

    @property
    def rows(self) -> Floats:
        """Where samples are written down."""
        ...

    def show_watch(self, watch: Floats) -> None:
        """Show the functions of events all values."""
        ...

    def make_room(self, code: int) -> None:
        """Make room for as many more samples, or raise a fault, if the code of a loop asks for it."""
        ...

    def begin(self, block: Floats) -> None:
        """Go back to where a motion begins, and show the right-hand side all values."""
        ...

    def advance(self, call: LoopCall) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        ...

    def advance_watched(
        self, call: LoopCall, functions: tuple[int, ...], watch: Floats, happened: Floats
    ) -> int:
        """Try up to so many steps, and let events happen; return a code of `symbody.kernels.block`."""
        ...


class Watch(Protocol):
    """Lets events happen in the compiled loop."""

    def advance(self, call: LoopCall, held: HeldValues | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        ...

    def break_off(self, block: Floats, record: Record) -> None:
        """End an interrupted run at the event that would have changed it, if one was computed."""
        ...


class StepWatch(Protocol):
    """Looks at the steps of integrators that take theirs in Python."""

    @property
    def most_steps(self) -> int:
        """How many steps may be taken between two looks."""
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
