"""Steps in the compiled loop that are searched for events."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.simulation.events.event_functions import EventFunctions
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.events.events import EventSide
from symbody.simulation.methods.constraints import Projection, residual_share
from symbody.simulation.native.blocks import state_of
from symbody.simulation.native.run import EVENT_SAMPLES, NativeRun, RawRun, drive, fresh_record
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import CompiledSteps, Ending, Steps, python_laws
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.step_problem import StepProblem

Floats = NDArray[np.float64]

# What steps return that did not simply come to their end.
OTHERWISE: Final = -1


def no_sides(problem: StepProblem) -> tuple[EventSide, ...]:
    """Return the sides of events of a motion that begins."""
    return (EventSide(),) * len(problem.settings.events)


def with_sides(kept: Floats, sides: Sequence[EventSide]) -> Floats:
    """Return numbers with those of sides behind them."""
    return np.concatenate([kept, np.ravel(np.array(sides))])


def split_sides(kept: Floats, problem: StepProblem) -> tuple[Floats, tuple[EventSide, ...]]:
    """Return the numbers and the sides that `with_sides` put together."""
    first = kept.size - len(EventSide._fields) * len(problem.settings.events)
    rows = kept[first:].reshape(-1, len(EventSide._fields)).tolist()
    return kept[:first], tuple(EventSide(*row) for row in rows)


class WatchedSteps(CompiledSteps):
    """Steps with events: each is a short run of the compiled loop that an `EventWatch` looks at."""

    def __init__(self, problem: StepProblem, numbers: StepNumbers) -> None:
        super().__init__(problem, numbers)
        constraints = problem.settings.constraints
        method = constraints if isinstance(constraints, Projection) else Projection()
        share = residual_share(method, problem.settings.atol)
        self._functions = EventFunctions(problem.problem, problem.settings.events, share)
        self._sides: tuple[EventSide, ...] = no_sides(problem)
        self._last: RawRun | None = None
        self._ending = ""

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from time and state at present."""
        super().restart(initial)
        self._sides = no_sides(self._problem)

    def snapshot(self) -> Floats:
        """Return the numbers of the block that change, and where the values of events stand."""
        return with_sides(super().snapshot(), self._sides)

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        others, self._sides = split_sides(kept, self._problem)
        super().resume(others)

    def follow(self, others: Steps) -> None:
        """Go on with step lengths and events of others, which computed with other values of parameters."""
        super().follow(others)
        if isinstance(others, WatchedSteps):
            self._sides = others._sides

    def end(self, code: int) -> Ending:
        """Return how the last step ended; `code` says only that it was not as usual."""
        if code >= 0 or self._last is None:
            return super().end(code)
        status = self._last.status
        if status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if self._ending:
            return Ending(status, f"{self._last.reach}; there {self._ending}")
        return Ending(status, "" if status.success else self._last.stop_note(self._state_names))

    def _way(self) -> Callable[[], int]:
        return self._go_on_watched

    def _go_on_watched(self) -> int:
        """Take a step; return `OTHERWISE` where it did not come to its end."""
        numbers = self._numbers
        start = numbers.t
        self.check()
        self._look_ahead()
        end = numbers.next_end()
        watch = EventWatch(self._functions, end - start, self._sides)
        with python_laws(self._laws):
            raw = self._last = self._run(end, watch)
        self.occurrences, self._ending = watch.occurrences, watch.ending
        self._sides = watch.sides_at(raw.reached)
        arrived = raw.status is Status.SUCCESS
        numbers.arrive(raw.reached, state_of(self._block), at_end=arrived)
        return at.FINISHED if arrived else OTHERWISE

    def _run(self, end: float, watch: EventWatch) -> RawRun:
        """Run the loop to a time, beginning with the step that the last run would have taken."""
        block = self._block
        motion = Run(block)
        counts = motion.counts
        counts.accepted = counts.rejected = 0.0
        counts.samples = counts.steps = counts.failed_kernel = 0
        motion.after_rejection, motion.t_end, motion.first_step = (
            0.0,
            end,
            max(motion.step, motion.first_step),
        )
        *_, inputs = self._kept_vectors(block)
        inputs[:] = self._numbers.inputs
        run = NativeRun(self._right_hand_side, self._projector.address, block)
        record = fresh_record(run, np.array([end]), dense=True, more=EVENT_SAMPLES)
        raw = drive(run, record, None, watch)
        was_cut = counts.accepted > 1 or counts.rejected > 0 or raw.status is not Status.SUCCESS
        if was_cut:  # the longer step of before is not a guide any more
            motion.first_step = 0.0
        return raw
