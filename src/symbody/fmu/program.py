"""`FmuProgram`: everything that the C of an FMU computes with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations
from symbody.expr.sequences.dependencies import dependencies
from symbody.fmu.conditions import Condition
from symbody.fmu.functions import Floats, ModelFunction
from symbody.fmu.jumps import FmuJumps
from symbody.fmu.parameters import FmuParameters
from symbody.fmu.samples import FmuSamples
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.simulation.events.event_functions import numbers_of_events
from symbody.simulation.events.events import Event
from symbody.simulation.events.watch_arrays import WatchNumbers, make_watch_block
from symbody.simulation.hybrid.switching import mode_block, mode_ends
from symbody.simulation.methods.constraints import residual_share
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.native.closing import POSED, closing_block, closing_of, metric
from symbody.simulation.native.strikes import strike_block
from symbody.simulation.programs.motion_request import PosedMotion
from symbody.simulation.programs.prepared_motion import implicit_array, motion_block
from symbody.simulation.programs.program_function import DERIVATIVES, PROJECTION, RIGHT_HAND_SIDE, TURN

STEPS: Final = 24  # of co-simulation that are kept where something is watched
FUNCTION: Final = "mechanism_"  # begins the names of functions in C
SPAN: Final = 10.0  # seconds of the default experiment


@dataclass(frozen=True, slots=True, eq=False)
class FmuProgram:
    """A mechanism as functions and numbers.

    Attributes
    ----------
    eqs : EquationSet
        The equations, without stabilizing terms, their modes left open.
    motion : PosedMotion
        The motion that co-simulation integrates.
    parameters : FmuParameters
        Which are arguments, and their values.
    outputs : tuple of str
        What is shown beside energy and violation.
    events : tuple of Event
        What is watched.
    functions : mapping of str to ModelFunction
        By purpose: motion, slope, output, and where there are any projection, assembly, derivatives,
        sensitivities, indicators, action, parameters, sides, deciding, ends, samples, periods, strike.
    conditions : tuple of Condition
        What decides the branches that are frozen between events of model exchange.
    modal : ModalEquations
        The same equations with the modes of joints, ropes and stops as inputs, of which functions are made.
    samples : FmuSamples
        What is held between samples.
    jumps : FmuJumps
        Of prescribed rates.
    """

    eqs: EquationSet
    motion: PosedMotion
    parameters: FmuParameters
    outputs: tuple[str, ...]
    events: tuple[Event, ...]
    functions: Mapping[str, ModelFunction]
    conditions: tuple[Condition, ...]
    modal: ModalEquations
    samples: FmuSamples
    jumps: FmuJumps

    @property
    def rtol(self) -> float:
        """The tolerance of the default experiment."""
        return self.motion.integration.rtol

    @property
    def is_implicit(self) -> bool:
        """Whether co-simulation solves for its steps."""
        return isinstance(self.motion.method, GeneralizedAlpha)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Inputs that an importer sets."""
        return tuple(name for name in self.eqs.input_names if name not in self.samples.names)

    @property
    def x0(self) -> Floats:
        """The assembled state (u, q)."""
        return self.motion.integration.state

    @property
    def constraint_scales(self) -> Floats:
        """The sizes of the position constraints."""
        scales = self.motion.integration.problem.scales
        return scales.constraints(self.modal.eqs)[: len(self.modal.eqs.formed.holonomic)]

    @property
    def nominal(self) -> Floats:
        """What counts as large of each state (u, q, s)."""
        scales = self.motion.integration.problem.scales
        speeds = scales.displacements(self.eqs) / scales.time
        signals = np.ones(len(self.eqs.signal_state_names))
        return np.concatenate([speeds, scales.coordinates(self.eqs), signals])

    @property
    def indicator_count(self) -> int:
        """How many numbers are watched in model exchange."""
        return len(self.events) + len(self.conditions) + len(self.modal.modes)

    @property
    def time_scale(self) -> float:
        """In which the mechanism moves by its size [s]."""
        return self.motion.integration.problem.scales.time

    @property
    def is_projected(self) -> bool:
        """Whether states fulfil constraints, norms of quaternions among them."""
        return "projection" in self.functions

    @property
    def closing_share(self) -> float:
        """By which share of its scale a constraint may be open."""
        return residual_share(self.motion.projection, None)

    @property
    def watched_events(self) -> tuple[Event, ...]:
        """Events, and the ends of modes behind them."""
        return (*self.events, *mode_ends(self.modal))

    def watch(self) -> Floats:
        """Return the array of an `EventMonitor`; empty where nothing is watched.

        Its functions, and what closes states, take their numbers from elsewhere in the pool.
        """
        watched, eqs, nothing = self.watched_events, self.modal.eqs, np.zeros(0)
        if not watched:
            return nothing
        n, modes = len(eqs.state_names) + 1, len(self.modal.modes)
        numbers = WatchNumbers(n, len(eqs.speed_names), nothing, nothing, nothing)
        made = make_watch_block(numbers_of_events(eqs, watched, self.functions["indicators"]), numbers)
        monitor = EventMonitor(made)
        monitor.direction, monitor.span, monitor.happened_room = 1.0, SPAN, self.happened_room
        monitor.piece_rows = Run(self.block()).method.dense_rows
        monitor.mode_count, monitor.first_mode = modes, len(self.eqs.input_names)
        return made

    @property
    def happened_room(self) -> int:
        """Room for so many events that are not logged yet."""
        return (ZEROS_PER_EVENT + 1) * len(self.watched_events) + 1

    @property
    def steps(self) -> int:
        """So many steps of co-simulation are at hand: zeros lie in the last ones."""
        return STEPS if self.watched_events else 1

    @property
    def _step_functions(self) -> Mapping[str, ModelFunction]:
        """The functions that the integrator calls, as programs name them."""
        names = {RIGHT_HAND_SIDE: "motion", PROJECTION: "projection", TURN: "turn", DERIVATIVES: "jacobian"}
        return {name: self.functions[own] for name, own in names.items() if own in self.functions}

    def block(self) -> Floats:
        """Return the block of the integrator at the first state."""
        motion = self.motion
        if self.jumps.are_more:
            motion = replace(motion, breakpoints=motion.breakpoints.truncate(self.jumps.times[-1][0]))
        made = motion_block(motion, self._step_functions, self.modal.eqs)
        room = Run(made).room
        room.keep_dense, room.steps = 1.0, self.steps
        return made

    def implicit(self) -> Floats:
        """Return the array of an `ImplicitStep`; empty for explicit methods."""
        return implicit_array(self.motion, self._step_functions)

    def assembly(self) -> Floats:
        """Return the block of `symbody.kernels.configurations.closing`; empty for open mechanisms."""
        if "assembly" not in self.functions:
            return np.zeros(0)
        close, function = closing_of(self.motion.eqs, holds=True), self.functions["assembly"]
        own = metric(close.eqs, self.motion.integration.problem.scales)
        return closing_block(close.shape, own, function.sizes, function.array, self.closing_share)

    def strike(self) -> Floats:
        """Return the array of a `StrikeProblem`; empty where no rates jump."""
        if "strike" not in self.functions:
            return np.zeros(0)
        function, scales = self.functions["strike"], self.motion.integration.problem.scales
        return strike_block(self.modal.eqs, scales, function.sizes, function.array)

    def switch(self) -> Floats:
        """Return the array of a `ModeSwitch`; empty where nothing switches."""
        if not self.modal.modes:
            return np.zeros(0)
        deciding, projecting = self.functions["deciding"], self.functions["projection"]
        made = mode_block(
            self.modal, self.eqs, self.motion.integration.problem.scales, len(self.eqs.input_names),
            (deciding.array, deciding.size), (np.zeros(0), projecting.size),
        )  # fmt: skip
        ModeSwitch(made).first_event = len(self.events)
        return made

    @property
    def closing_parameters(self) -> tuple[bool, ...]:
        """Which of the parameters that are arguments enter the constraints."""
        names = self.parameters.arguments
        if "assembly" not in self.functions:
            return (False,) * len(names)
        function = self.functions["assembly"]
        results = dependencies(function.sequence)[: sum(function.sizes[: len(POSED)])]
        read = frozenset().union(*results)
        return tuple(("p", k) in read for k in range(len(names)))
