"""A run that is cut where something happened, and goes on from there in another state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from symbody.simulation.native.description import Floats, Record


class LoopPart(Protocol):
    """Something that happens on the way of a motion in the compiled loop.

    Attributes
    ----------
    feature : str
        Its name in `symbody.kernels.features`.
    """

    feature: str

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return addresses of functions, and arrays, by the names of `kernels.motion_loop.advance_motion`."""
        ...

    def answer(self, code: int) -> None:
        """Make room, or raise a fault, if the code of a loop asks for it."""
        ...


class HeldValues(LoopPart, Protocol):
    """Takes the samples of values that are held in between."""

    def show_watch(self, watch: Floats) -> None:
        """Show the functions of events all values."""
        ...

    def begin(self, block: Floats) -> None:
        """Go back to where a motion begins, and show the right-hand side all values."""
        ...


class Watch(LoopPart, Protocol):
    """Lets events happen."""

    @property
    def array(self) -> Floats:
        """See `symbody.kernels.events.event_monitor`."""
        ...

    @property
    def modes(self) -> LoopPart | None:
        """Decides the modes that some events end."""
        ...

    @property
    def longest_step(self) -> float:
        """How long the next step may be; 0 where any may be."""
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
