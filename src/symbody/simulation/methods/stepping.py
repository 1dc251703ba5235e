"""Runs of integrators that take one step at a call, as SUNDIALS: `SteppedRun` brings them into the loop.

Each step is handed over as the states at `SHARES` of it. The polynomial through them is the dense output, and
the integral of the power over it is the work. Samples and events are those of the compiled loop.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.simulation.hybrid.passed_jumps import PassedJumps
from symbody.simulation.native.blocks import state_of
from symbody.simulation.native.description import Record, Watch
from symbody.simulation.native.machine import given_steps, step_machine
from symbody.simulation.native.run import (
    EVENT_SAMPLES,
    VERDICTS,
    Progress,
    RawRun,
    begin_again,
    fresh_record,
    run_loop,
    show_room,
)
from symbody.simulation.status import Status

Floats = NDArray[np.float64]
Power = Callable[[Floats, Floats], Floats]

# Where a step is sampled: the ends and the extrema of a Chebyshev polynomial, as many as a polynomial of
# degree 7 needs, which follows order 8.
NODES: Final = 8
SHARES: Final[Floats] = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
_CODES: Final = {status: code for code, status in VERDICTS.items() if code != at.SPOILED}


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
    """Why there is no further step; `state` is to blame, if one is."""

    status: Status
    state: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class StepEnds:
    """How far steps may lead, by the breakpoints in a block."""

    block: Floats

    def __call__(self, t: float, end: float) -> tuple[float, float, float]:
        """Return from where to where the longest step to an end leads, and at which time it counts as ended.

        A step begins behind a jump that lies at its time, and ends before one.
        """
        ends = np.zeros(3)
        Run(self.block).t_end = end
        step_machine().longest_step(address(self.block), t, address(ends))
        start, stop, said = ends.tolist()
        return start, stop, said


class StepwiseIntegrator(Protocol):
    """An integrator under way."""

    @property
    def evaluations(self) -> int:
        """How often the right-hand side was computed so far."""
        ...

    def advance(self, end: float) -> Step | Failure:
        """Take one step, not beyond an end."""
        ...

    def restart(self, t: float, x: Floats) -> None:
        """Go on from another state x = (u, q) at a time that has been passed."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """From where to where a motion runs, and what is kept of it.

    Attributes
    ----------
    block : array
        See `symbody.kernels.block`: at the start, with the work as last state.
    projector : int
        The address of what brings samples onto the constraints; 0 if nothing does.
    times : array or None
        Samples to store; None stores every step.
    power : callable
        From times (N,) and states (N, n) to the power (N,) [W].
    before : RawRun or None
        A run that was broken off where this one starts; the result contains it.
    jumps : PassedJumps or None
        Passes jumps of prescribed rates.
    """

    block: Floats
    projector: int
    times: Floats | None
    progress: Progress | None
    power: Power
    before: RawRun | None = None
    jumps: PassedJumps | None = None


def march(stepper: StepwiseIntegrator, course: Course, watch: Watch | None) -> RawRun:
    """Take steps to the end, until one fails, an event ends the run, or the caller interrupts."""
    run = SteppedRun(stepper, course)
    record = fresh_record(run, course.times, True, 0 if watch is None else EVENT_SAMPLES)
    raw = run_loop(
        run, record if course.before is None else _continue_record(course, record), course.progress, watch
    )  # fmt: skip
    spent = replace(raw.statistics, rejected=None, evaluations=stepper.evaluations)
    if course.before is not None:
        first = course.before.statistics
        spent = replace(
            spent,
            evaluations=first.evaluations + spent.evaluations,
            loop_seconds=first.loop_seconds + spent.loop_seconds,
        )
    return replace(raw, statistics=spent)


def _continue_record(course: Course, record: Record) -> Record:
    """Return a record that begins with a run before, and note in the block what that stored."""
    before, run = course.before, Run(course.block)
    dense = None if before is None else before.dense_output
    if before is None or dense is None:
        return record
    samples, steps = before.t.size, len(dense.pieces)
    run.counts.samples, run.counts.steps = samples, steps
    run.counts.accepted = before.statistics.accepted
    run.goal.max_trials += before.statistics.accepted
    pieces = np.pad(dense.pieces, ((0, 0), (0, NODES - dense.pieces.shape[1]), (0, 0)))
    return record._replace(
        wanted=record.wanted if record.every_step else np.concatenate([before.t, record.wanted]),
        t=np.concatenate([before.t, record.t]), x=np.concatenate([before.x.T, record.x]),
        breaks=np.concatenate([dense.breaks, record.breaks]),
        pieces=np.concatenate([pieces, record.pieces]),
    )  # fmt: skip


class SteppedRun:
    """The run of an integrator that takes one step at a call; see `native.run.CompiledRun`."""

    def __init__(self, stepper: StepwiseIntegrator, course: Course) -> None:
        self.block, self.jumps = course.block, course.jumps
        self._stepper, self._course = stepper, course
        self._is_continued = course.before is not None
        self._longest = 0.0  # next step, 0 where any may be

    def begin(self, record: Record) -> int:
        """Store the first sample; return a code of `symbody.kernels.block`."""
        if self._is_continued:  # what it begins with is stored
            self._is_continued = False
            return at.RUNNING
        show_room(self.block, record)
        places = (self.block, record.wanted, record.t, record.x, record.breaks)
        return given_steps().begin_given(*map(address, places))

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        code = at.RUNNING
        for _ in range(trials):
            code = self._take_step(record)
            if watch is not None:
                code = watch.process(self.block, record, code)
            if code == at.RESTARTED:
                code = self._begin_anew(record)
                self._longest = 0.0 if watch is None else watch.longest_step
            if code == at.FINISHED and self.jumps is not None and self.jumps.is_due:
                code = self._pass_jump(record, watch, self.jumps)
            if code != at.RUNNING:
                break
        return code

    def _pass_jump(self, record: Record, watch: Watch | None, jumps: PassedJumps) -> int:
        """Go on behind a jump of prescribed rates; return a code of `symbody.kernels.block`."""
        if Run(self.block).counts.steps == len(record.pieces):
            return at.FULL  # behind the steps there has to be room for one more
        if watch is not None:
            jumps.note_values(watch, self.block)
        jumps.strike(self.block, record)
        code = self._begin_anew(record)
        if watch is not None:
            jumps.watch_behind(watch, self.block, record)
        return at.RUNNING if code == at.FINISHED else code  # events may be due there

    def _begin_anew(self, record: Record) -> int:
        """Go on from another state; return a code of `symbody.kernels.block`."""
        self._stepper.restart(Run(self.block).time, state_of(self.block)[:-1].copy())
        return begin_again(self, record)

    def _take_step(self, record: Record) -> int:
        """Take one step and write it down; return a code of `symbody.kernels.block`."""
        run = Run(self.block)
        counts = run.counts
        if run.time == run.t_end:
            return at.FINISHED
        is_full = record.every_step and counts.samples + EVENT_SAMPLES > record.t.size
        if is_full or counts.steps == len(record.pieces):
            return at.FULL
        if counts.accepted >= run.goal.max_trials:
            return at.TOO_MANY
        step = self._stepper.advance(self._next_end(run))
        if isinstance(step, Failure):
            return self._fail(step)
        if not np.isfinite(step.nodes).all():
            blamed = int(np.flatnonzero(~np.isfinite(step.nodes).all(axis=0))[0])
            return self._fail(Failure(Status.NOT_FINITE, blamed))
        length = step.t - run.time
        power = self._course.power(run.time + length * SHARES, step.nodes)
        work = state_of(self.block)[-1] + length * (_INTEGRALS @ power)
        record.pieces[counts.steps] = _TO_PIECE @ np.column_stack([step.nodes, work])
        places = map(address, (self.block, *record.arrays))
        given_steps().keep_given(self._course.projector, *places, step.t)
        return at.RUNNING

    def _next_end(self, run: Run) -> float:
        """Return beyond which time the next step may not go."""
        longest, self._longest = self._longest, 0.0
        end = run.time + run.goal.direction * longest
        return end if longest and (run.t_end - end) * run.goal.direction > 0.0 else run.t_end

    def _fail(self, failure: Failure) -> int:
        counts = Run(self.block).counts
        counts.failed_kernel = at.OUT_OF_REACH if failure.state is None else 0
        counts.blamed_state = failure.state or 0
        return _CODES[failure.status]
