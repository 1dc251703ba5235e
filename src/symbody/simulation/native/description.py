"""What a run of the integrator takes: functions, a goal, and where the results go."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


NO_TABLES: Final = np.zeros(0)


class RightHandSide(NamedTuple):
    """A compiled function and what stays the same for a whole run.

    Attributes
    ----------
    address : int
        Where the function lies.
    n_u : int
        Number of speeds, which come first in the state.
    inputs, parameters, constants : arrays
        The groups r, p and c.
    work_size : int
        How many numbers of scratch it needs.
    tables : array
        The inputs that are tables, see `symbody.kernels.tables`; empty if there are none.
    """

    address: int
    n_u: int
    inputs: Floats
    parameters: Floats
    constants: Floats
    work_size: int
    tables: Floats = NO_TABLES


class Projector(NamedTuple):
    """A function that brings states back onto the constraints; the first fields as in `RightHandSide`.

    It writes position residuals, position moves, velocity residuals, velocity moves.

    Attributes
    ----------
    address : int
        0 where there is nothing to project.
    n_q : int
        Number of coordinates.
    scales : array (n,)
        The largest position residuals that count as closed; velocity residuals have none, being linear.
    limit : float
        Moves above so many tolerated errors, or what rounding makes of the old state, reject the step.
    sizes : array (n_q,)
        What counts as a large coordinate: 1 rad, or the size of the mechanism [m].
    rounding : float
        How exactly residuals are known at coordinates that are not large, over what counts as closed.
    out_size : int
        How many numbers the function writes.
    """

    address: int
    n_u: int
    inputs: Floats
    parameters: Floats
    constants: Floats
    work_size: int
    n_q: int
    scales: Floats
    limit: float
    sizes: Floats
    rounding: float
    out_size: int


class Goal(NamedTuple):
    """What a run is to reach, how carefully, and what bounds its steps.

    Attributes
    ----------
    atol : (n,) array
        Absolute tolerance of each state.
    breaks : (m, 4) array
        Where the pieces of `inputs.breakpoints` meet, in the order of the motion, the last at an infinite
        time: when [s], how long a step may be that enters the piece before [s], whether what depends on time
        jumps there, so that a step has to end before and another begin behind, and within what of its time
        that happens [s].
    """

    t_end: float
    direction: float
    rtol: float
    atol: Floats
    max_step: float
    max_trials: int
    stop_when_stiff: bool
    breaks: Floats


class Record(NamedTuple):
    """Where samples and dense outputs go.

    Attributes
    ----------
    wanted : array
        The times to store, in the order of the motion; every step is stored if `every_step`.
    t, x : arrays (capacity,), (capacity, n)
        The samples.
    breaks, pieces : arrays (capacity + 1,), (capacity, 4 + d, n)
        Ends and dense output of each step, if `keep_dense`.
    """

    wanted: Floats
    t: Floats
    x: Floats
    breaks: Floats
    pieces: Floats
    every_step: bool
    keep_dense: bool

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """The arrays, in the order in which the compiled loop takes them."""
        return self.wanted, self.t, self.x, self.breaks, self.pieces


# What happens on the way of a run.


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
