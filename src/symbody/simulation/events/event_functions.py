"""`EventFunctions`: values and actions of events, compiled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.native_call import check_status
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.sequences.dependencies import dependencies
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Output
from symbody.expr.sequences.sequence import Sequence as Operations
from symbody.kernels.events.event_monitor import (
    RECORDS,
    SETS,
    SHORTENS,
    STOPS,
    SWITCHES,
    ZEROS_PER_EVENT,
    EventMonitor,
)
from symbody.kernels.modes.mode_state import AT_LENGTH
from symbody.kernels.record_layout import exists
from symbody.simulation.events.events import Event, GapEvent, LevelEvent, ModeEnd
from symbody.simulation.events.watch_arrays import WatchedEvent, WatchNumbers, make_watch_block
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.native.blocks import function_numbers, function_sizes, write_numbers
from symbody.simulation.native.closing import Closing, closing_block, closing_of, metric, place_sizes
from symbody.simulation.native.description import RightHandSide
from symbody.simulation.simulation_problem import OutputName, SimulationProblem

Floats = NDArray[np.float64]


class EventFunctions:
    """Values and actions of events, compiled.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.
    events : sequence of Event
        At least one, in the order in which simultaneous ones happen.
    share : float
        Constraints that are open by this share of their sizes count as closed after an action.
    hands_over : bool
        Whether a motion ends where an event acts or a mode ends, to go on outside.

    Attributes
    ----------
    functions : tuple of CompiledFunction or None
        Those of `kernels.event_watch.look`: values, actions, what closes; None for none.
    addresses : tuple of int
        Where they lie; 0 for none.

    Raises
    ------
    FormulationError
        If an expression has no meaning.
    UsageError
        If it is not a number but a vector or matrix.
    """

    def __init__(
        self, problem: SimulationProblem, events: Sequence[Event], share: float,
        *, hands_over: bool = False,
    ) -> None:  # fmt: skip
        self.events = tuple(events)
        self.state_names = problem.eqs.state_names
        self._problem = problem
        self._share = share
        self._hands_over = hands_over
        names = watched_outputs(self.events)
        self._values = problem.compile_outputs(names)
        own = [isinstance(name, str) for name in names].count(True)
        check_value_shapes(self.events[:own], self._values.outputs[:own])
        outputs = action_outputs(self.events)
        self._actions = problem.compile_outputs(outputs) if outputs else None
        check_action_shapes(self.events, self._actions.outputs[1:-1] if self._actions else ())
        changes = any(event.action != "record" for event in self.events)
        close = closing_of(problem.eqs, holds=bool(outputs)) if changes else None
        self._closing = None
        if close is not None and close.is_needed:
            self._closing = replace(problem, eqs=close.eqs).compile_outputs(close.outputs)
        self.functions = self._values, self._actions, self._closing
        functions = [function for function in (self._values, self._actions) if function is not None]
        self._callbacks = [
            CallbackFunction(function, problem.laws) for function in functions if problem.laws.need_python
        ]
        addresses = [function.address for function in self._callbacks or functions]
        self.addresses = (*addresses, 0)[:2] + (0 if self._closing is None else self._closing.address,)

    def with_problem(self, problem: SimulationProblem) -> EventFunctions:
        """Return the same functions with the inputs of a problem of the same equations."""
        if problem is self._problem:
            return self
        other = copy(self)
        other._problem = problem
        vars(other).pop("_first_block", None)
        return other

    def make_block(self, span: float) -> Floats:
        """Return the block of a watch over a run of some length [s]."""
        block = self._first_block.copy()
        monitor = EventMonitor(block)
        monitor.span, monitor.hands_over = span, float(self._hands_over)
        inputs = self._problem.laws.held_now()
        closing = (monitor.closing.numbers,) if exists(monitor.closing) else ()
        for numbers in (monitor.numbers, monitor.actions, *closing):
            if exists(numbers):
                np.asarray(numbers.inputs)[:] = inputs
        return block

    def make_gap_block(self, span: float, rows: int) -> Floats:
        """Return the block of a watch that looks at each step by itself, for gaps over which none may pass.

        `rows` is how many the dense output of a step has, `span` what counts as long [s].
        """
        block = self.make_block(span)
        watch_steps_alone(EventMonitor(block), span, rows)
        return block

    @cached_property
    def _first_block(self) -> Floats:
        """The block of functions with these values: a copy of one for any values, with their numbers."""
        given = [None if function is None else self._problem.numbers(function) for function in self.functions]
        sizes = [None if each is None else function_sizes(each) for each in given]
        key = "monitor", repr(self.events), *sizes
        block: Floats = self._values.kept_with_code(key, partial(self._block_of_any, given)).copy()
        monitor = EventMonitor(block)
        if exists(monitor.closing):
            place_sizes(monitor.closing, self._sizes_of_states, self._share)
        for name, numbers in zip(("numbers", "actions", "closing"), given, strict=True):
            if numbers is not None:
                record = getattr(monitor, name)
                write_numbers(record.numbers if name == "closing" else record, numbers)
        return block

    def _block_of_any(self, given: Sequence[RightHandSide | None]) -> Floats:
        """Return a block for functions that take as many numbers."""
        eqs, empty = self._problem.eqs, np.zeros(0)
        values, actions, closing = (empty if each is None else function_numbers(each) for each in given)
        if self._closing is not None:
            sizes = [len(output.values) for output in self._closing.outputs]
            closing = closing_block(self._close.shape, self._sizes_of_states, sizes, closing, self._share)
        numbers = WatchNumbers(len(eqs.state_names) + 1, len(eqs.speed_names), values, actions, closing)
        sequence = self._values.shared_sequence
        return make_watch_block(numbers_of_events(eqs, self.events, lambda: sequence), numbers)

    @property
    def _close(self) -> Closing:
        return closing_of(self._problem.eqs, holds=self._actions is not None)

    @property
    def metric(self) -> Floats:
        """What counts as large where states are closed, see `native.closing.metric`; of N motions (N, n)."""
        return metric(self._close.eqs, self._problem.scales)

    @property
    def _sizes_of_states(self) -> Floats:
        sizes: Floats = self.metric.reshape(-1, self.metric.shape[-1])[0]
        return sizes

    def raise_fault(self, status: int) -> None:
        """Raise what a law of an input raised, or what the status of a function means.

        Raises
        ------
        SimulationError
            See above.
        """
        for function in self._callbacks:
            if function.error is not None:
                raise function.error
        check_status(status)


def watch_steps_alone(monitor: EventMonitor, span: float, rows: int) -> None:
    """Let a watch look at each step by itself, as `kernels.events.passed_gaps` does; see `make_gap_block`."""
    monitor.direction, monitor.span, monitor.piece_rows = 1.0, span, rows
    monitor.happened_room = ZEROS_PER_EVENT * monitor.event_count


def watched_outputs(events: Sequence[Event]) -> tuple[OutputName, ...]:
    """Return the values of events; those of levels, which stand last and are no results, are combined."""
    names = [str(event.expression) for event in events]
    levels = [isinstance(event, LevelEvent) for event in events]
    if not any(levels) or any(event.mapping for event in events):
        return tuple(names)
    count = levels.index(True)
    return (*names[:count], tuple(names[count:]))


def action_outputs(events: Sequence[Event]) -> list[str]:
    """Return what the function of actions writes: energy, new values, rates; nothing if no event acts."""
    formulas = [str(value) for event in events for value in event.mapping.values()]
    return ["energy", *formulas, "xdot"] if formulas else []


def check_value_shapes(events: Sequence[Event], outputs: Sequence[Output]) -> None:
    """Check that values of events are numbers.

    Raises
    ------
    UsageError
        If one is a vector or a matrix.
    """
    problems = [
        Problem("simulation.event_shape", f"event {event.label!r}", f"its value has shape {output.shape}",
                "an event needs a single number", "name one component, such as 'reaction J Fx'")
        for event, output in zip(events, outputs, strict=True) if output.shape
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def check_action_shapes(events: Sequence[Event], outputs: Sequence[Output]) -> None:
    """Check that what actions set are numbers.

    Raises
    ------
    UsageError
        If one is a vector or a matrix.
    """
    named = [(event.label, name) for event in events for name in event.mapping]
    problems = [
        Problem("simulation.event_shape", f"event {label!r}",
                f"the new value of {name} has shape {output.shape}",
                "a coordinate or speed is a single number", "name one component, such as 'reaction J Fx'")
        for (label, name), output in zip(named, outputs, strict=True) if output.shape
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def event_numbers(eqs: EquationSet, event: Event, of_time: bool) -> WatchedEvent:
    """Return an event as numbers; `of_time` if its value reads no state."""
    action = STOPS if event.action == "stop" else SETS if event.mapping else RECORDS
    action = SWITCHES if isinstance(event, ModeEnd) else SHORTENS if isinstance(event, GapEvent) else action
    wraps = _reads_wrapped_angle(eqs, str(event.expression))
    targets = tuple(eqs.state_names.index(name) for name in event.mapping)
    level = event.level if isinstance(event, LevelEvent) else 0.0
    return WatchedEvent(event.direction, action, wraps, targets, level, of_time)


def _reads_wrapped_angle(eqs: EquationSet, expression: str) -> bool:
    """Return whether the angle of a cut joint stands in an expression, which then jumps by a turn."""
    if not eqs.wrapped_angles:
        return False
    names = eqs.formed.readable_names
    angles = {names.value(name).index for name in eqs.wrapped_angles}
    return not angles.isdisjoint(eqs.formed.graph.reachable(eqs.roots(expression).nodes))


def numbers_of_events(
    eqs: EquationSet, events: Sequence[Event], sequence: Callable[[], Operations]
) -> tuple[WatchedEvent, ...]:
    """Return events as numbers; `sequence` forms that of their values, which matters where one acts."""
    if not any(event.mapping for event in events):
        return tuple(event_numbers(eqs, event, False) for event in events)
    reads = dependencies(written_out(sequence()))
    of_time = [{group for group, _ in read}.isdisjoint(("q", "u", "s")) for read in reads]
    return tuple(event_numbers(eqs, event, alone) for event, alone in zip(events, of_time, strict=True))


def gap_events(problem: SimulationProblem, integrator: object) -> tuple[GapEvent, ...]:
    """Return what watches compliant gaps; nothing for methods whose steps have one length."""
    eqs = problem.eqs
    gaps: Mapping[str, bool] = eqs.plans.get("compliant gaps", partial(_compliant_gaps, eqs))
    if not gaps or getattr(integrator, "step", None) is not None:
        return ()
    # Gaps of bodies in balance may be 0 up to rounding, which is no passage.
    length = float(np.min(problem.scales.length))
    return tuple(
        GapEvent(gap, -1, name=f"closing of {gap}", level=-AT_LENGTH * (1.0 if turns else length))
        for gap, turns in gaps.items()
    )


def _compliant_gaps(eqs: EquationSet) -> Mapping[str, bool]:
    return {gap: turns for part in eqs.model.elements for gap, turns in part.compliant_gaps.items()}
