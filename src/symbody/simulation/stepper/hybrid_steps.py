"""Steps in the compiled loop on the way of which events happen, values are sampled and modes change."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.errors import UsageError
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.kernels.block import Run
from symbody.kernels.record_layout import exists
from symbody.simulation.events.event_functions import EventFunctions, gap_events
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.events.events import EventSide
from symbody.simulation.hybrid.passed_jumps import PassedJumps
from symbody.simulation.hybrid.rate_jumps import NO_JUMPS, PlannedJumps, jump_times, may_jump
from symbody.simulation.hybrid.switching import DeadEndError, SwitchingModes, check_strike, switching_modes
from symbody.simulation.methods.constraints import Projection, residual_share
from symbody.simulation.native.blocks import state_of
from symbody.simulation.native.run import EVENT_SAMPLES, NativeRun, RawRun, fresh_record, run_loop
from symbody.simulation.sampling.sampled_loop import SampledLoop
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


@contextmanager
def modes_at_present(modes: SwitchingModes | None, numbers: StepNumbers) -> Iterator[None]:
    """Let modes be those of the present state and inputs for a while; if none fit, they stay as they are."""
    if modes is None:
        yield
        return
    kept = modes.snapshot()
    try:
        with suppress(DeadEndError):
            modes.settle(numbers.t, numbers.x[:-1].copy())
        yield
    finally:
        modes.resume(kept)


class HybridSteps(CompiledSteps):
    """Steps each of which is a short run of the compiled loop, with all that happens on its way.

    What goes on from step to step are the block of the motion, the sides of events, what was sampled, and the
    modes of joints, ropes and stops; these are decided anew where a step begins: inputs may have jumped.
    """

    def __init__(self, problem: StepProblem, numbers: StepNumbers) -> None:
        self._sampler = problem.sampler()
        moving = problem.with_samples(self._sampler)
        self._posed = moving
        self._jumps, self._jumps_until = NO_JUMPS, -math.inf
        self._modes = switching_modes(moving)
        self._undecided = None if self._modes is None else self._modes.snapshot()
        super().__init__(problem, numbers, moving if self._modes is None else self._modes.problem)
        self._samples = None if self._sampler is None else SampledLoop(self.motion_problem, self._sampler)
        self._functions = self._event_functions()
        self._sides: tuple[EventSide, ...] = no_sides(problem)
        self._last: RawRun | None = None
        self._ending = ""
        self._dead_end: Ending | None = None

    def _watched_gaps(self) -> None:
        """Return None: gaps are watched beside events."""

    def _event_functions(self) -> EventFunctions | None:
        """Return what watches events and the ends of modes; None without any."""
        settings = self._problem.settings
        ends = () if self._modes is None else self._modes.ends
        watched = (*settings.events, *gap_events(self.motion_problem, settings.method), *ends)
        if not watched:
            return None
        constraints = settings.constraints
        method = constraints if isinstance(constraints, Projection) else Projection()
        return EventFunctions(self.motion_problem, watched, residual_share(method, settings.atol))

    @property
    def modes(self) -> dict[str, str]:
        """The modes of joints, ropes and stops in which the last step ended."""
        return {} if self._modes is None else self._modes.record.present

    def at_present(self) -> AbstractContextManager[None]:
        """Let the modes be those of the present state and inputs, while outputs are computed."""
        return modes_at_present(self._modes, self._numbers)

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from time and state at present, with other held values where `initial` has some."""
        super().restart(initial)
        self._sides = no_sides(self._problem)
        fresh = self._problem.sampler(initial)
        if self._sampler is not None and fresh is not None:
            self._sampler.resume(fresh.block)
        if self._modes is not None and self._undecided is not None:
            self._modes.resume(self._undecided)

    def snapshot(self) -> Floats:
        """Return all on which further steps depend: the block, samples, modes and sides of events."""
        parts = [super().snapshot()]
        if self._sampler is not None:
            parts.append(self._sampler.snapshot())
        if self._modes is not None:
            parts.append(self._modes.snapshot())
        return with_sides(np.concatenate(parts), self._sides)

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        others, self._sides = split_sides(kept, self._problem)
        if self._modes is not None:
            size = self._modes.snapshot().size
            self._modes.resume(others[-size:])
            self._modes.record.begin_anew()
            others = others[:-size]
        if self._sampler is not None:
            size = self._sampler.block.size
            self._sampler.resume(others[-size:])
            others = others[:-size]
        super().resume(others)

    def follow(self, others: Steps) -> None:
        """Go on with what others kept, which computed with other values of parameters."""
        super().follow(others)
        if isinstance(others, HybridSteps):
            self._sides = others._sides
            if self._sampler is not None and others._sampler is not None:
                self._sampler.follow(others._sampler, self._numbers.t)

    def end(self, code: int) -> Ending:
        """Return how the last step ended; `code` says only that it was not as usual."""
        if self._dead_end is not None:
            return self._dead_end
        if code >= 0 or self._last is None:
            return super().end(code)
        status = self._last.status
        if status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if self._ending:
            return Ending(status, f"{self._last.reach}; there {self._ending}")
        return Ending(status, "" if status.success else self._last.stop_note(self._state_names))

    def _way(self) -> Callable[[], int]:
        return self._go_on_its_way

    def _go_on_its_way(self) -> int:
        """Take a step; return `OTHERWISE` where it did not come to its end."""
        numbers, start = self._numbers, self._numbers.t
        self.check()
        self._look_ahead()
        jumps = self._find_jumps(start)
        self._dead_end, self._ending, self.occurrences = None, "", ()
        end = numbers.next_end()
        planned = jumps.part((start, end))
        if planned.times and self._modes is not None:
            check_strike(self._problem.settings.moving.formed, planned.times[0])
        if self._sampler is not None:
            self._sampler.begin_anew()
        if self._modes is not None:
            self._modes.record.begin_anew()
        try:
            self._run_to(end, planned)
        except DeadEndError as dead_end:
            self._dead_end = Ending(dead_end.status, f"at t = {dead_end.t:.9g} s {dead_end.why}")
            numbers.arrive(Run(self._block).time, state_of(self._block), at_end=False)
            return OTHERWISE
        except BaseException:
            numbers.arrive(Run(self._block).time, state_of(self._block), at_end=False)
            raise
        if self._modes is not None:
            happened = (*self.occurrences, *self._modes.record.occurrences)
            self.occurrences = tuple(sorted(happened, key=lambda event: event.t))
        arrived = self._last is not None and self._last.status is Status.SUCCESS
        numbers.arrive(Run(self._block).time, state_of(self._block), at_end=arrived)
        return at.FINISHED if arrived else OTHERWISE

    def _find_jumps(self, t: float) -> PlannedJumps:
        """Return the jumps of prescribed rates in the window, or in this step if a position jumps later."""
        eqs, x = self._problem.settings.moving, self._numbers.x[:-1]
        if not eqs.plans.get("may jump", lambda: may_jump(eqs)):
            return NO_JUMPS
        if self._jumps_until != self._window_end:
            span = t, self._window_end
            with suppress(UsageError):
                self._jumps = jump_times(self._posed.with_other_times(), x, span)
                self._jumps_until = span[1]
            if self._jumps_until != self._window_end:
                span = t, t + float(self._numbers.array[stepping.DURATION])
                return jump_times(self._posed.with_other_times(), x, span)
        return self._jumps

    def _run_to(self, end: float, planned: PlannedJumps) -> None:
        """Run the loop to a time, and take note of what happened."""
        self._begin()
        watch = None
        if self._functions is not None:
            span = float(self._numbers.array[stepping.DURATION])
            watch = EventWatch(self._functions, span, self._sides, self._modes)
        with python_laws(self._laws):
            raw = self._last = self._run(end, watch, planned)
        if watch is not None:
            self.occurrences += watch.occurrences
            self._ending = watch.ending
            self._sides = watch.sides_at(raw.reached)[: len(self._sides)]

    def _begin(self) -> None:
        """Show all functions the present inputs, and the state with which the motion goes on.

        Raises
        ------
        DeadEndError
            If there are no modes, or no speeds.
        """
        run, state = Run(self._block), state_of(self._block)
        if self._samples is not None:
            inputs = self.motion_problem.laws.held_now()
            self._samples.show_inputs(np.arange(inputs.size), inputs)
            if not np.asarray(self._samples.sampler.hold.taken).any():  # modes follow from the first ones
                self._samples.take(run.time, state)
        if self._modes is not None:
            settled = self._modes.settle(run.time, state[:-1])
            state[:-1] = settled.x
            state[-1] += settled.work
        inputs = self.motion_problem.laws.held_now()
        np.asarray(run.numbers.inputs)[:] = inputs
        if exists(run.projection):
            np.asarray(run.projection.numbers.inputs)[:] = inputs

    def _run(self, end: float, watch: EventWatch | None, planned: PlannedJumps) -> RawRun:
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
        jumps = None
        if planned.times:
            jumps = PassedJumps(self.motion_problem, planned, (motion.time, end), self._modes)
        run = NativeRun(self._right_hand_side, self._projector.address, block, self._samples, jumps)
        record = fresh_record(run, np.array([end]), dense=True, more=EVENT_SAMPLES)
        raw = run_loop(run, record, None, watch)
        was_cut = counts.accepted > 1 or counts.rejected > 0 or raw.status is not Status.SUCCESS
        if was_cut:  # the longer step of before is not a guide any more
            motion.first_step = 0.0
        return raw
