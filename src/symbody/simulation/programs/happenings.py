"""What happens on the way of a motion that a program computes, and the calls of kernels that follow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.kernels.dialect import PREFIX
from symbody.codegen.kernels.featured import without_unused
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import KernelTree, Type
from symbody.equations.solving.modal_equations import ModalEquations
from symbody.kernels.block import FunctionNumbers, Run
from symbody.kernels.configurations.strike_problem import RateJump, RateJumps
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.pack import pack
from symbody.kernels.record_layout import exists
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
from symbody.simulation.native.closing import CLOSING as CLOSING_OUTPUTS
from symbody.simulation.native.closing import closing_block, closing_of, metric
from symbody.simulation.native.description import Floats
from symbody.simulation.native.run import EVENT_SAMPLES
from symbody.simulation.native.strikes import strike_block, strike_equations, strike_outputs
from symbody.simulation.programs.motion_request import PosedMotion
from symbody.simulation.programs.program_function import (
    DERIVATIVES,
    RIGHT_HAND_SIDE,
    TURN,
    ProgramFunction,
    program_function,
)
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
    others : tuple of Event
        What closes gaps and ends modes; they stand behind the events.
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
    others: tuple[Event, ...]
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
        """The names of all that is watched."""
        return tuple(event.label for event in (*self.events, *self.others))

    @property
    def arrays(self) -> dict[str, Floats]:
        """All arrays, by what programs call them."""
        return {
            "monitor": self.monitor, "held": self.hold, "sampling": self.sampling, "jumps": self.jumps,
            "modes": self.modes, "implicit": self.implicit,
        }  # fmt: skip

    @property
    def kinds(self) -> frozenset[str]:
        """Which of events, samples, jumps and modes there are; with modes there are events."""
        found = {"events": self.monitor, "samples": self.hold, "jumps": self.jumps, "modes": self.modes}
        return frozenset(kind for kind, array in found.items() if array.size)

    @property
    def features(self) -> frozenset[str]:
        """What the motion has, see `symbody.kernels.features`."""
        implicit = ("IMPLICIT",) if self.implicit.size else ()
        return frozenset((*map(str.upper, self.kinds), *implicit))

    @property
    def kernels(self) -> Mapping[str, KernelTree]:
        """The kernels that compute such a motion."""
        kinds, found = self.kinds, dict(self.loop_kernels("begin_motion", "advance_motion"))
        if "events" in kinds:
            found |= read_kernels("event_interruptions", "forget_steps")
        if "modes" in kinds:
            found |= read_kernels("mode_state", "forget_rows", "rewind_modes", "forget_modes")
        return found

    def loop_kernels(self, *names: str) -> Mapping[str, KernelTree]:
        """Return kernels of `motion_loop` for what the motion has, with those that they call."""
        return read_kernels("motion_loop", *names, features=self.features)

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
    functions = _event_functions(motion, closing) if motion.events else {}
    monitor = _monitor(motion, functions, block) if functions else _NOTHING
    hold, sampling = _NOTHING, _NOTHING
    if motion.held:
        functions[SAMPLES] = program_function(motion, [value.formula for value in motion.held], SAMPLES)
        check_numbers(motion.held, functions[SAMPLES].outputs)
        hold = _hold(motion, block, monitor)
        sampling = functions[SAMPLES].array
    modes = _NOTHING
    if motion.modal is not None:
        modes = _modes(motion, motion.modal, functions, monitor)
    jumps = _jumps(motion, functions, block)
    events = motion.request.events
    return Happenings(
        events, motion.events[len(events) :], motion.held, functions, monitor, hold, sampling, jumps, modes,
        implicit,
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
    shapes = [(functions[name].array, functions[name].size) for name in (DECIDING, FITTING)]
    first = len(motion.input_names) - len(modal.modes)
    scales, eqs = motion.integration.problem.scales, motion.modeless or motion.eqs
    made = mode_block(modal, eqs, scales, first, *shapes)
    switch, search = ModeSwitch(made), EventMonitor(monitor)
    switch.room = STEPS
    switch.first_event = len(motion.events) - switch.count
    search.mode_count, search.first_mode = switch.count, first
    return made


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
    numbers = {name: function.array for name, function in functions.items()}
    watch = WatchNumbers(
        run.states, run.speeds, numbers[EVENTS], numbers.get(ACTIONS, _NOTHING),
        closing_numbers(motion, functions[CLOSING]) if CLOSING in functions else _NOTHING,
    )  # fmt: skip
    watched = numbers_of_events(eqs, events, lambda: functions[EVENTS].sequence)
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
    return closing_block(close.shape, own, sizes, function.array, share)


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
    jumps = jump_times(problem, motion.integration.state, (start, last))
    if not jumps.times:
        return _NOTHING
    eqs = strike_equations(motion.eqs)
    functions[STRIKE] = function = program_function(motion, strike_outputs(eqs), STRIKE, eqs)
    numbers = function.array
    if motion.modal is not None:  # friction is finite, and ropes and stops strike afterwards
        np.asarray(FunctionNumbers(numbers).inputs)[-len(motion.modal.modes) :] = LOOSE
    strikes = strike_block(eqs, problem.scales, function.sizes, numbers)
    rows = jumps.rows((start, last))
    Run(block).t_end = RateJump(rows.ravel()).before
    return pack(RateJumps, count=len(rows), t_end=last, jumps=rows, problem=strikes)


def kernel_calls(
    happens: Happenings, projection: str, closing: str, argument: str, trials: int
) -> dict[str, str]:
    """Return the calls of the kernels of a motion by what they do.

    Parameters
    ----------
    projection, closing : str
        The functions that project, and that close states where events act.
    argument : str
        Format of an array as an argument.
    """
    made = happens.functions
    functions = {
        "f": RIGHT_HAND_SIDE, "k": TURN, "j": DERIVATIVES, "g": projection, "e": EVENTS,
        "a": ACTIONS if ACTIONS in made else EVENTS, "c": closing if CLOSING in made else EVENTS,
        "h": SAMPLES, "s": STRIKE, "d": DECIDING, "w": FITTING,
    }  # fmt: skip
    arrays = {"run": "block", "Q": "sampling", "H": "happened", "Y": "recorded", "Z": "decided"}

    def call(kernel: str, arguments: Iterable[str], *numbers: object) -> str:
        words = [
            f"{PREFIX}{functions[name]}" if name in functions else argument.format(arrays.get(name, name))
            for name in arguments
        ]
        return f"{PREFIX}{kernel}({', '.join([*words, *map(str, numbers)])})"

    def whole(kernel: str, *numbers: object) -> str:
        parameters = without_unused(happens.loop_kernels(kernel))[kernel].parameters
        return call(kernel, [p.name for p in parameters if p.type != Type.INTEGER], *numbers)

    calls = {
        "BEGIN": whole("begin_motion"),
        "ADVANCE": whole("advance_motion", trials),
        "FORGET": call("forget_steps", ["run", "monitor", "breaks", "pieces"], LAST_STEPS),
        "NOTE": call("values_before", ["e", "run", "monitor"]),
        "REWIND_EVENTS": call("rewind_events", ["monitor", "H"], "time"),
        "REWIND_SAMPLES": call("rewind_samples", ["held", "Y"], "time"),
        "BOUND": call("end_before_jump", ["run", "jumps"]),
        "FORGET_ROWS": call("forget_rows", ["modes", "Z"]),
        "REWIND_MODES": call("rewind_modes", ["modes", "Z"], "time"),
        "FORGET_MODES": call("forget_modes", ["modes"]),
    }
    return calls | ({"WATCH": whole("watch_anew")} if "events" in happens.kinds else {})
