"""Runs of integrators that take one step at a call: `march` collects their steps into a `RawRun`.

Each step is handed over as the states at `SHARES` of it. The polynomial through them is the dense output, and
the integral of the power over it is the work.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.simulation.native.dense_output import DenseOutput, shorten
from symbody.simulation.native.machine import step_machine
from symbody.simulation.native.run import SLICE_SECONDS, Progress, RawRun, Statistics, memory_limit
from symbody.simulation.native.segments import Cut, StepWatch, steps_before
from symbody.simulation.status import Status

Floats = NDArray[np.float64]
Power = Callable[[Floats, Floats], Floats]

# Where a step is sampled: the ends and the extrema of a Chebyshev polynomial, as many as a polynomial of
# degree 7 needs, which follows order 8.
NODES: Final = 8
SHARES: Final[Floats] = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))


_CAPACITY: Final = 256


def _nested_polynomials() -> Floats:
    """Return the values at `SHARES` of the polynomials that rows of `DenseOutput` multiply."""
    columns = [np.ones(NODES)]
    for row in range(1, NODES):
        columns.append(columns[-1] * (SHARES if row % 2 == 1 else 1.0 - SHARES))
    return np.stack(columns, axis=1)


def _integration() -> Floats:
    """Return A with A @ f the integrals from 0 to each share of the polynomial through f."""
    powers = np.vander(SHARES, NODES, increasing=True)
    degrees = np.arange(1, NODES + 1)
    integrals = np.vander(SHARES, NODES + 1, increasing=True)[:, 1:] / degrees
    return np.asarray(np.linalg.solve(powers.T, integrals.T).T, dtype=np.float64)


_TO_PIECE: Final = np.linalg.inv(_nested_polynomials())
_INTEGRALS: Final = _integration()


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One accepted step.

    Attributes
    ----------
    t : float
        Its end [s].
    nodes : (NODES, n) array
        States x = (u, q) at `SHARES` of it.
    """

    t: float
    nodes: Floats


@dataclass(frozen=True, slots=True)
class Failure:
    """Why there is no further step; `state` is to blame, or the linear system number `kernel`."""

    status: Status
    state: int | None = None
    kernel: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class StepEnds:
    """How far steps may lead, by the breakpoints in a block."""

    block: Floats

    def __call__(self, t: float) -> tuple[float, float, float]:
        """Return from where to where the longest step at a time leads, and at which time it counts as ended.

        A step begins behind a jump that lies at its time, and ends before one.
        """
        ends = np.zeros(3)
        step_machine().longest_step(address(self.block), t, address(ends))
        start, stop, end = ends.tolist()
        return start, stop, end


class StepwiseIntegrator(Protocol):
    """An integrator under way."""

    @property
    def evaluations(self) -> int:
        """How often the right-hand side was computed so far."""
        ...

    @property
    def rejections(self) -> int | None:
        """How many steps were tried in vain; None if that is not known."""
        ...

    def advance(self) -> Step | Failure:
        """Take one step, not beyond the end."""
        ...

    def restart(self, t: float, x: Floats) -> None:
        """Go on from another state x = (u, q) at a time that has been passed."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """From where to where a motion runs, and what is kept of it.

    Attributes
    ----------
    x0 : (n + 1,) array
        The first state (u, q), and the work done before.
    times : array or None
        Samples to store; None stores every step.
    power : callable
        From times (N,) and states (N, n) to the power (N,) [W].
    closed : callable
        Brings states (N, n) at times (N,) back onto the constraints.
    watch : StepWatch or None
        Looks at the steps now and then, and may cut the run.
    before : RawRun or None
        A run that was broken off where this one starts; the result contains it.
    """

    x0: Floats
    start: float
    end: float
    times: Floats | None
    max_steps: int
    progress: Progress | None
    power: Power
    closed: Callable[[Floats, Floats], Floats]
    watch: StepWatch | None = None
    before: RawRun | None = None


def march(stepper: StepwiseIntegrator, course: Course) -> RawRun:
    """Take steps to the end, until one fails, a watch cuts the run, or the caller interrupts."""
    log = _Log(course)
    began = time.perf_counter()
    try:
        failure = _march(stepper, course, log)
    except KeyboardInterrupt:
        failure = Failure(Status.INTERRUPTED)
    except MemoryError:
        failure = Failure(Status.OUT_OF_MEMORY)
    spent = Statistics(log.taken, stepper.rejections, stepper.evaluations, time.perf_counter() - began)
    return log.raw_run(failure, spent)


def _march(stepper: StepwiseIntegrator, course: Course, log: _Log) -> Failure:
    """Take steps, with a look at them after every so many; return how it ended."""
    reported, seen, failure = time.perf_counter(), log.steps, None
    while True:
        if log.t == course.end:
            failure = Failure(Status.SUCCESS)
        elif log.taken >= course.max_steps:
            failure = Failure(Status.TOO_MANY_STEPS)
        else:
            failure = _take_step(stepper, log)
        if course.watch is not None and (failure or log.steps - seen >= course.watch.most_steps):
            cut = course.watch.look(log.breaks, log.pieces, log.steps, failure is not None)
            seen = log.steps
            if cut is not None:
                log.cut(cut)
                if cut.after is None:
                    return Failure(cut.status)
                stepper.restart(cut.t, cut.after[:-1].copy())
                seen, failure = log.steps, None
                continue
        if failure is not None:
            return failure
        if course.progress is not None and time.perf_counter() - reported > SLICE_SECONDS:
            reported = time.perf_counter()
            if course.progress((log.t - course.start) / (course.end - course.start)) is False:
                return Failure(Status.INTERRUPTED)


def _take_step(stepper: StepwiseIntegrator, log: _Log) -> Failure | None:
    """Take one step and write it down; return why there is none."""
    found = stepper.advance()
    if isinstance(found, Failure):
        return found
    if not np.isfinite(found.nodes).all():
        return Failure(Status.NOT_FINITE, int(np.flatnonzero(~np.isfinite(found.nodes).all(axis=0))[0]))
    log.append(found)
    return None


class _Log:
    """The steps so far, as polynomials with the work as last state.

    Attributes
    ----------
    breaks, pieces : arrays
        As in `DenseOutput`, with room for more.
    steps, taken : int
        Steps written down, and steps of this run among them that were taken, kept or not.
    t : float
        Where the motion has come to [s].
    """

    def __init__(self, course: Course) -> None:
        self._course = course
        before = None if course.before is None else course.before.dense_output
        self._first = 0 if before is None else before.pieces.shape[0]
        self.steps = self._first
        self.taken = 0
        self.t = course.start
        self.breaks = np.empty(_CAPACITY + self._first)
        self.pieces = np.empty((_CAPACITY + self._first, NODES, course.x0.size))
        self.breaks[self._first] = course.start
        if before is not None:
            self.breaks[: self._first + 1] = before.breaks
            self.pieces[: self._first] = np.pad(
                before.pieces, ((0, 0), (0, NODES - before.pieces.shape[1]), (0, 0))
            )
        self._work = float(course.x0[-1])
        self._is_stopped = False
        # Where an event changed the state: the number of steps before, and the new state.
        self._jumps: list[tuple[int, Floats]] = []

    def append(self, step: Step) -> None:
        """Write down a step."""
        if self.steps + 1 == self.breaks.size:
            self._grow()
        length = step.t - self.t
        power = self._course.power(self.t + length * SHARES, step.nodes)
        work = self._work + length * (_INTEGRALS @ power)
        self.pieces[self.steps] = _TO_PIECE @ np.column_stack([step.nodes, work])
        self.breaks[self.steps + 1] = self.t = step.t
        self._work = float(work[-1])
        self.steps += 1
        self.taken += 1

    def _grow(self) -> None:
        """Double the room.

        Raises
        ------
        MemoryError
            None is left.
        """
        if 2 * self.pieces.nbytes > memory_limit():
            raise MemoryError
        self.breaks = np.concatenate([self.breaks, np.empty_like(self.breaks)])
        self.pieces = np.concatenate([self.pieces, np.empty_like(self.pieces)])

    def cut(self, cut: Cut) -> None:
        """Forget what lies beyond a cut, and go on from its state if it has one."""
        end = steps_before(self.breaks, self.steps, cut.t)
        start, stop = self.breaks[end - 1], self.breaks[end]
        if cut.t != stop:
            self.pieces[end - 1] = shorten(self.pieces[end - 1], float((cut.t - start) / (stop - start)))
        self.breaks[end] = self.t = cut.t
        self.steps = end
        self._is_stopped = cut.after is None
        if cut.after is not None:
            self._work = float(cut.after[-1])
            self._jumps.append((end, cut.after))

    def dense_output(self) -> DenseOutput:
        """Return the motion of all steps."""
        if self.steps:
            return DenseOutput(self.breaks[: self.steps + 1].copy(), self.pieces[: self.steps].copy())
        piece = np.zeros((1, NODES, self._course.x0.size))
        piece[0, 0] = self._course.x0
        return DenseOutput(np.full(2, self._course.start), piece)

    def raw_run(self, failure: Failure, spent: Statistics) -> RawRun:
        """Return the run with its samples, after the one before."""
        course, dense = self._course, self.dense_output()
        t, x = self._samples(dense)
        n = course.x0.size - 1
        x[:n] = course.closed(t, x[:n].T).T
        if course.before is not None:
            repeated = int(bool(t.size and course.before.t.size and t[0] == course.before.t[-1]))
            t = np.concatenate([course.before.t, t[repeated:]])
            x = np.concatenate([course.before.x, x[:, repeated:]], axis=1)
            spent = _sum(course.before.statistics, spent)
        return RawRun(t, x, failure.status, spent, self.t, failure.state, failure.kernel, dense)

    def _samples(self, dense: DenseOutput) -> tuple[Floats, Floats]:
        """Return the times that are wanted as far as they were reached, and the states there."""
        wanted = self._course.times
        if wanted is not None:
            direction = 1.0 if self._course.end >= self._course.start else -1.0
            times = wanted[direction * (wanted - self.t) <= 0.0]
            if self._is_stopped and not (times.size and times[-1] == self.t):
                times = np.append(times, self.t)  # the end at an event is a sample in any case
            states = dense(times)
            if self._jumps and self._jumps[-1][0] == self.steps:  # an event at the end: the state after it
                states[:, times == self.t] = self._jumps[-1][1][:, np.newaxis]
            return times.copy(), states
        ends = [float(self.breaks[self._first])], [self._course.x0]
        jumps = dict(self._jumps)
        for k in range(self._first, self.steps):
            ends[0].append(float(self.breaks[k + 1]))
            ends[1].append(self.pieces[k, 0] + self.pieces[k, 1])
            if k + 1 in jumps:
                ends[0].append(float(self.breaks[k + 1]))
                ends[1].append(jumps[k + 1])
        return np.array(ends[0]), np.array(ends[1]).T


def _sum(first: Statistics, second: Statistics) -> Statistics:
    return Statistics(
        first.accepted + second.accepted,
        None if first.rejected is None or second.rejected is None else first.rejected + second.rejected,
        first.evaluations + second.evaluations,
        first.loop_seconds + second.loop_seconds,
    )
