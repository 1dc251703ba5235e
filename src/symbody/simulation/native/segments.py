"""A run that is cut where something happened, and goes on from there in another state."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from symbody.simulation.native.description import Floats, LoopCall, Record


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

    def process(self, block: Floats, record: Record, code: int) -> int:
        """Let events happen in the steps so far, the last of which ended with a code; return the code."""
        ...

    def break_off(self, block: Floats, record: Record) -> None:
        """End an interrupted run at the event that would have changed it, if one was computed."""
        ...


def steps_before(breaks: Floats, steps: int, t: float) -> int:
    """Return how many of the first `steps` steps begin before a time."""
    direction = 1.0 if breaks[steps] >= breaks[0] else -1.0
    return int(np.searchsorted(direction * breaks[: steps + 1], direction * t))
