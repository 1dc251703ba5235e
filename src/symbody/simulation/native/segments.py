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


class Jumps(Protocol):
    """Passes jumps of prescribed rates along a run; see `hybrid.passed_jumps.PassedJumps`."""

    address: int
    array: Floats

    @property
    def t_end(self) -> float:
        """When the motion ends behind all jumps [s]."""
        ...

    @property
    def passed(self) -> tuple[tuple[float, float], ...]:
        """When a speed has jumped [s], and by how much the energy has [J]."""
        ...

    def bound(self, block: Floats) -> None:
        """Let a run end just before the next jump."""
        ...

    def is_due(self, block: Floats) -> bool:
        """Return whether a run that has come to its end goes on behind a jump."""
        ...

    def has_just_passed(self, block: Floats) -> bool:
        """Return whether a run stands just behind a jump."""
        ...

    def show_inputs(self) -> None:
        """Write the values that inputs have at present where speeds are struck."""
        ...

    def strike(self, block: Floats, record: Record) -> None:
        """Strike the state to which a run has come, and store the samples there."""
        ...

    def begin_again(self, rhs: int, block: Floats, record: Record) -> int:
        """Begin anew behind a jump by an explicit method; return a code of `symbody.kernels.block`."""
        ...

    def note_values(self, values: int, block: Floats, watch: Floats) -> None:
        """Note where the values of events stand before a jump."""
        ...

    def watch_behind(self, values: int, block: Floats, watch: Floats, record: Record) -> None:
        """Let a search for events go on behind a jump."""
        ...

    def check(self, code: int, block: Floats) -> None:
        """Raise what a code of the kernels says."""
        ...


class Watch(Protocol):
    """Lets events happen in the compiled loop."""

    def advance(self, call: LoopCall, held: HeldValues | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        ...

    def process(self, block: Floats, record: Record, code: int) -> int:
        """Let events happen in the steps so far, the last of which ended with a code; return the code."""
        ...

    @property
    def hands_over(self) -> bool:
        """Whether the motion ends where modes are to be decided, and goes on outside."""
        ...

    def pass_jump(self, call: LoopCall, jumps: Jumps, held: HeldValues | None) -> int | None:
        """Go on behind a jump in other modes; return a code of `kernels.block`, None without modes."""
        ...

    def note_values(self, block: Floats, jumps: Jumps) -> None:
        """Note where values stand before a jump."""
        ...

    def watch_behind(self, block: Floats, record: Record, jumps: Jumps) -> None:
        """Look for events in the motion behind a jump."""
        ...

    def break_off(self, block: Floats, record: Record) -> None:
        """End an interrupted run at the event that would have changed it, if one was computed."""
        ...


def steps_before(breaks: Floats, steps: int, t: float) -> int:
    """Return how many of the first `steps` steps begin before a time."""
    direction = 1.0 if breaks[steps] >= breaks[0] else -1.0
    return int(np.searchsorted(direction * breaks[: steps + 1], direction * t))
