"""What happens on the way of a motion that a program computes: events, samples, rates that jump."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.equations.solving.modal_equations import ModalEquations
from symbody.errors import Problem, UsageError
from symbody.kernels.block import FunctionNumbers, Run
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.pack import pack
from symbody.kernels.record_layout import exists
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.events.event_functions import (
    action_outputs,
    check_action_shapes,
    check_value_shapes,
    numbers_of_events,
)
from symbody.simulation.events.events import Event
from symbody.simulation.events.watch_arrays import WatchNumbers, make_watch_block, with_cut_fit
from symbody.simulation.hybrid.rate_jumps import jump_times
from symbody.simulation.hybrid.switching import deciding_outputs, mode_block
from symbody.simulation.methods.constraints import PROJECTED, residual_share
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.closing import CLOSING as CLOSING_OUTPUTS
from symbody.simulation.native.closing import closing_block, closing_of, metric
from symbody.simulation.native.description import Floats
from symbody.simulation.native.run import EVENT_SAMPLES
from symbody.simulation.native.strikes import strike_block, strike_equations, strike_outputs
from symbody.simulation.programs.motion_request import PosedMotion
from symbody.simulation.programs.program_function import ProgramFunction, program_function
from symbody.simulation.sampling.sampled_loop import check_numbers
from symbody.simulation.sampling.sampler import HeldValue, Sampler

EVENTS, ACTIONS, CLOSING, SAMPLES, STRIKE, DECIDING, FITTING = (
    "event_values",
    "event_actions",
    "closing",
    "new_samples",
    "struck",
    "deciding",
    "fitting",
)
# Room for dense output in programs with events, and how much stays where it is full: zeros lie in the last
# steps.
STEPS: Final = 64
LAST_STEPS: Final = 16
_NOTHING: Final = np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class Happenings:
    """What happens on the way of a motion; arrays are empty where nothing of a kind does.

    Attributes
    ----------
    events : tuple of Event
    ends : tuple of Event
        What ends modes; they stand behind the events.
    held : tuple of HeldValue
        What is held between samples.
    functions : mapping of name to ProgramFunction
        Those that are called for all this.
    monitor, hold, sampling, jumps, modes : arrays
        Of an `EventMonitor`, a `SampleHold`, the numbers of what computes new values, a `RateJumps`, a
        `ModeSwitch`.
    implicit : array
        Of an `ImplicitStep`, where the method is one.
    """

    events: tuple[Event, ...]
    ends: tuple[Event, ...]
    held: tuple[HeldValue, ...]
    functions: Mapping[str, ProgramFunction]
    monitor: Floats
    hold: Floats
    sampling: Floats
    jumps: Floats
    modes: Floats
    implicit: Floats

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of events and of ends of modes."""
        return tuple(event.label for event in (*self.events, *self.ends))

    @property
    def kinds(self) -> frozenset[str]:
        """Which of events, samples, jumps and modes there are; with modes there may be events and samples."""
        found = {"events": self.monitor, "samples": self.hold, "jumps": self.jumps, "modes": self.modes}
        return frozenset(kind for kind, array in found.items() if array.size)

    @property
    def kernels(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The kernels that compute such a motion, by their files."""
        kinds = self.kinds
        if "modes" in kinds:
            names = ("begin_switching", "advance_switching", "watch_switching", "pass_switching_jump")
            rows = ("forget_rows", "rewind_modes", "forget_modes")
            return (
                ("switching_motion", names[: 3 + ("jumps" in kinds)]), ("switch_modes", rows),
                ("event_interruptions", ("forget_steps",)),
            )  # fmt: skip
        watched = "watched_motion" if "events" in kinds else "step_machine"
        showing = ["show_watch"] * ({"events", "samples"} <= kinds)
        file = "sampled_motion" if "samples" in kinds else watched
        if self.implicit.size:
            file = "implicit_motion" if {"events", "jumps"} & kinds else "implicit_machine"
        files = [(file, (self.first_kernel, self.loop_kernel, *showing))]
        if "events" in kinds:
            files.append(("event_interruptions", ("forget_steps",)))
        if "jumps" in kinds:
            files.append((file if self.implicit.size else "struck_motion", (self.jump_kernel,)))
        return tuple(files)

    @property
    def first_kernel(self) -> str:
        """The kernel with which a motion begins."""
        if "modes" in self.kinds:
            return "begin_switching"
        if self.implicit.size:
            return "begin_implicit"
        return "begin_sampled" if "samples" in self.kinds else "begin"

    @property
    def loop_kernel(self) -> str:
        """The kernel that tries steps."""
        kinds = self.kinds
        if "modes" in kinds:
            return "advance_switching"
        words = ["advance", *["implicit"] * bool(self.implicit.size)]
        words += [*["sampled"] * ("samples" in kinds), *["watched"] * ("events" in kinds)]
        return "_".join(words)

    @property
    def jump_kernel(self) -> str:
        """The kernel that goes on behind a jump."""
        if "modes" in self.kinds:
            return "pass_switching_jump"
        if self.implicit.size:
            return "pass_implicit_watched_jump" if self.events else "pass_implicit_jump"
        return "pass_watched_jump" if self.events else "pass_jump_of_rates"

    @property
    def steps(self) -> int:
        """Room for the dense output of so many steps."""
        return STEPS if "events" in self.kinds else 0

    @property
    def more_samples(self) -> int:
        """So many samples there may be beside those that are asked for."""
        return EVENT_SAMPLES if "events" in self.kinds else 0


def make_happenings(
    motion: PosedMotion, block: Floats, implicit: Floats, closing: ProgramFunction | None = None
) -> Happenings:
    """Return what happens on the way of a motion with a block; its end is set to the first jump.

    Parameters
    ----------
    implicit : array
        Of an `ImplicitStep`, empty for explicit methods.
    closing : ProgramFunction, optional
        What closes states of the whole mechanism; by default it is made where events act.
    """
    if implicit.size:
        check_implicit(motion)
    functions = _event_functions(motion, closing) if motion.events else {}
    monitor = _monitor(motion, functions, block) if functions else _NOTHING
    hold, sampling = _NOTHING, _NOTHING
    if motion.held:
        functions[SAMPLES] = program_function(motion, [value.formula for value in motion.held], SAMPLES)
        check_numbers(motion.held, functions[SAMPLES].outputs)
        hold = _hold(motion, block, monitor)
        sampling = function_numbers(functions[SAMPLES].numbers)
    modes = _NOTHING
    if motion.modal is not None:
        modes = _modes(motion, motion.modal, functions, monitor)
        if not motion.held:
            hold, sampling = _no_samples(), function_numbers(functions[EVENTS].numbers)
    jumps = _jumps(motion, functions, block)
    events = motion.request.events
    return Happenings(
        events, motion.events[len(events) :], motion.held, functions, monitor, hold, sampling, jumps, modes,
        implicit,
    )  # fmt: skip


def check_implicit(motion: PosedMotion) -> None:
    """Refuse what steps of an implicit method do not stop at in a program.

    Raises
    ------
    UsageError
        If signals are sampled, joints stick, ropes go slack or stops open.
    """
    held = [f"{value.name} is sampled" for value in motion.held]
    modes = [] if motion.modal is None else [f"the mode of {name} changes" for name in motion.modal.names]
    if held or modes:
        raise UsageError(
            Problem("simulation.program", motion.eqs.model.name,
                    f"sb.GeneralizedAlpha(..) does not compute this in a program: {'; '.join(held + modes)}",
                    "its steps do not stop there",
                    "use sb.Explicit() or sb.FixedStep(..), or an FMU, which takes modes")
        )  # fmt: skip


def _modes(
    motion: PosedMotion, modal: ModalEquations, functions: dict[str, ProgramFunction], monitor: Floats
) -> Floats:
    """Return the array of a `ModeSwitch` of a motion, and tell its search for events of the modes."""
    names: list[str] = []
    for output in deciding_outputs(modal):
        names += [output] if isinstance(output, str) else output
    functions[DECIDING] = program_function(motion, names, DECIDING, motion.modeless)
    functions[FITTING] = program_function(motion, PROJECTED, FITTING)
    shapes = [
        (function_numbers(functions[name].numbers), sum(functions[name].sizes))
        for name in (DECIDING, FITTING)
    ]
    first = len(motion.input_names) - len(modal.modes)
    scales, eqs = motion.integration.problem.scales, motion.modeless or motion.eqs
    made = mode_block(modal, eqs, scales, first, *shapes)
    switch, search = ModeSwitch(made), EventMonitor(monitor)
    switch.room = STEPS
    switch.first_event = len(motion.request.events)
    search.mode_count, search.first_mode = switch.count, first
    return made


def _no_samples() -> Floats:
    """Return the array of a `SampleHold` without values."""
    return pack(SampleHold, next=sys.float_info.max, room=STEPS)


def _event_functions(motion: PosedMotion, closing: ProgramFunction | None) -> dict[str, ProgramFunction]:
    events = motion.events
    functions = {EVENTS: program_function(motion, [str(event.expression) for event in events], EVENTS)}
    check_value_shapes(events, functions[EVENTS].outputs)
    if outputs := action_outputs(events):
        functions[ACTIONS] = program_function(motion, outputs, ACTIONS)
        check_action_shapes(events, functions[ACTIONS].outputs[1:-1])
    close = closing_of(motion.eqs, holds=bool(outputs) or closing is not None)
    if close.is_needed and any(event.action != "record" for event in events):
        functions[CLOSING] = closing or program_function(motion, close.outputs, CLOSING, close.eqs)
    return functions


def _monitor(motion: PosedMotion, functions: Mapping[str, ProgramFunction], block: Floats) -> Floats:
    """Return the array of an `EventMonitor` for a run."""
    run, eqs, events = Run(block), motion.eqs, motion.events
    numbers = {name: function_numbers(function.numbers) for name, function in functions.items()}
    watch = WatchNumbers(
        run.states, run.speeds, numbers[EVENTS], numbers.get(ACTIONS, _NOTHING),
        closing_numbers(motion, functions[CLOSING]) if CLOSING in functions else _NOTHING,
    )  # fmt: skip
    watched = numbers_of_events(eqs, events, functions[EVENTS])
    made = with_cut_fit(make_watch_block(watched, watch), run.method.dense_rows)
    monitor = EventMonitor(made)
    monitor.span = abs(motion.span[1] - motion.span[0])
    monitor.direction, monitor.piece_rows = run.goal.direction, run.method.dense_rows
    return made


def closing_numbers(motion: PosedMotion, function: ProgramFunction) -> Floats:
    """Return the array of an `AssemblyProblem` that closes states by a function."""
    sizes, problem = function.sizes, motion.integration.problem
    close = closing_of(motion.eqs, holds=len(sizes) >= len(CLOSING_OUTPUTS))
    share = residual_share(motion.projection, motion.request.atol)
    own = metric(close.eqs, problem.scales)
    return closing_block(close.shape, own, sizes, function_numbers(function.numbers), share)


def _hold(motion: PosedMotion, block: Floats, monitor: Floats) -> Floats:
    """Return the array of a `SampleHold`, whose first values all functions read."""
    sampler = Sampler(motion.held, motion.span[0], len(motion.eqs.speed_names))
    slots = [value.slot for value in motion.held]
    shown = [Run(block).numbers]
    if monitor.size:
        shown += [EventMonitor(monitor).numbers, EventMonitor(monitor).actions]
    for numbers in filter(exists, shown):
        np.asarray(numbers.inputs)[slots] = [value.initial for value in motion.held]
    sampler.hold.room = STEPS
    return sampler.block


def _jumps(motion: PosedMotion, functions: dict[str, ProgramFunction], block: Floats) -> Floats:
    """Return the array of `RateJumps` of a motion, and let it end just before the first one."""
    start, last = motion.span[0], motion.last
    problem = motion.integration.problem
    times, margin = jump_times(problem, motion.integration.state, (start, last))
    if not times:
        return _NOTHING
    eqs = strike_equations(motion.eqs)
    functions[STRIKE] = function = program_function(motion, strike_outputs(eqs), STRIKE, eqs)
    numbers = function_numbers(function.numbers)
    if motion.modal is not None:  # friction is finite, and ropes and stops strike afterwards
        np.asarray(FunctionNumbers(numbers).inputs)[-len(motion.modal.modes) :] = LOOSE
    strikes = strike_block(eqs, problem.scales, function.sizes, numbers)
    way, run = Run(block).goal.direction, Run(block)
    before = [max(t - way * margin, start, key=lambda time: way * time) for t in times]
    behind = [min(t + way * margin, last, key=lambda time: way * time) for t in times]
    run.t_end = before[0]
    return pack(
        RateJumps, count=len(times), t_end=last, times=np.column_stack([before, behind]), problem=strikes
    )
