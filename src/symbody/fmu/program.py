"""`FmuProgram`: everything that the C of an FMU computes with, and how it is formed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.analysis.derivatives import with_outputs
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations, modal_equations
from symbody.errors import Problem, UsageError
from symbody.expr.sequences.dependencies import dependencies
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots
from symbody.fmu.conditions import OUTPUT, Branches, Condition, find_conditions
from symbody.fmu.jumps import FmuJumps, find_jumps
from symbody.fmu.parameters import FmuParameters
from symbody.fmu.samples import FmuSamples, fmu_samples
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.simulation.events.event_functions import (
    action_outputs,
    check_action_shapes,
    check_value_shapes,
    gap_events,
    numbers_of_events,
    watch_steps_alone,
)
from symbody.simulation.events.events import Event
from symbody.simulation.events.watch_arrays import WatchNumbers, make_watch_block
from symbody.simulation.hybrid.switching import deciding_outputs, mode_block, mode_ends
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.methods.constraints import PROJECTED, Baumgarte, Projection
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.state_jacobian import STATE_JACOBIAN, with_state_jacobian
from symbody.simulation.native.closing import POSED, closing_of
from symbody.simulation.native.description import Floats
from symbody.simulation.native.strikes import strike_block, strike_equations, strike_outputs
from symbody.simulation.programs.happenings import closing_numbers
from symbody.simulation.programs.motion_request import (
    Method,
    MotionRequest,
    PosedMotion,
    pose_motion,
    reason_for_program,
)
from symbody.simulation.programs.program_function import (
    DERIVATIVES,
    PROJECTION,
    RIGHT_HAND_SIDE,
    TURN,
    ProgramFunction,
    implicit_array,
    make_function,
    method_bounds,
    motion_block,
)
from symbody.simulation.sampling.sampled_loop import check_numbers

STEPS: Final = 24  # of co-simulation that are kept where something is watched
FUNCTION: Final = "mechanism_"  # begins the names of its functions
SPAN: Final = 10.0  # seconds of the default experiment
RTOL: Final = 1e-8
RTOL_2: Final = 1e-5  # of a method of order 2
_POINTS: Final = 3  # at which conditions are recognized


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
    functions : mapping of str to ProgramFunction
        By purpose: motion, slope, output, and where there are any projection, assembly, derivatives,
        sensitivities, indicators, gaps, action, parameters, sides, deciding, ends, samples, periods, strike.
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
    functions: Mapping[str, ProgramFunction]
    conditions: tuple[Condition, ...]
    modal: ModalEquations
    samples: FmuSamples
    jumps: FmuJumps

    @property
    def input_names(self) -> tuple[str, ...]:
        """Inputs that an importer sets."""
        return tuple(name for name in self.eqs.input_names if name not in self.samples.names)

    @property
    def x0(self) -> Floats:
        """The assembled state (u, q)."""
        return self.motion.integration.state

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
    def is_projected(self) -> bool:
        """Whether states fulfil constraints, norms of quaternions among them."""
        return "projection" in self.functions

    @property
    def watched_events(self) -> tuple[Event, ...]:
        """Events, and the ends of modes behind them."""
        return (*self.events, *mode_ends(self.modal))

    def _watched_gaps(self) -> Floats:
        """Return the array of an `EventMonitor` of gaps over which no step may pass; empty without any."""
        if "gaps" not in self.functions:
            return np.zeros(0)
        eqs, function, nothing = self.modal.eqs, self.functions["gaps"], np.zeros(0)
        gaps = gap_events(self.motion.integration.problem, self.motion.method)
        numbers = WatchNumbers(
            len(eqs.state_names) + 1, len(eqs.speed_names), function.array, nothing, nothing
        )
        made = make_watch_block(numbers_of_events(eqs, gaps, lambda: function.sequence), numbers)
        tableau, *_ = method_bounds(self.motion.method, self.motion.breakpoints)
        watch_steps_alone(EventMonitor(made), SPAN, 4 + len(tableau.dense))
        return made

    def watch(self) -> Floats:
        """Return the array of an `EventMonitor`; empty where nothing is watched.

        Its functions, and what closes states, take their numbers from elsewhere in the pool.
        """
        watched, eqs, nothing = self.watched_events, self.modal.eqs, np.zeros(0)
        if not watched:
            return nothing
        n, modes = len(eqs.state_names) + 1, len(self.modal.modes)
        numbers = WatchNumbers(n, len(eqs.speed_names), nothing, nothing, nothing)
        events = numbers_of_events(eqs, watched, lambda: self.functions["indicators"].sequence)
        made = make_watch_block(events, numbers)
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
    def _step_functions(self) -> Mapping[str, ProgramFunction]:
        """The functions that the integrator calls, as programs name them."""
        names = {RIGHT_HAND_SIDE: "motion", PROJECTION: "projection", TURN: "turn", DERIVATIVES: "jacobian"}
        return {name: self.functions[own] for name, own in names.items() if own in self.functions}

    def block(self) -> Floats:
        """Return the block of the integrator at the first state."""
        motion = self.motion
        if self.jumps.are_more:
            motion = replace(motion, breakpoints=motion.breakpoints.truncate(self.jumps.times[-1][0]))
        made = motion_block(motion, self._step_functions, self.modal.eqs, self._watched_gaps())
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
        return closing_numbers(self.motion, self.functions["assembly"])

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


def make_program(
    eqs: EquationSet, outputs: Sequence[str], initial: Mapping[str, Value], parameters: FmuParameters,
    events: tuple[Event, ...], constraints: Projection | Baumgarte | None,
    integrator: Method | None,
) -> FmuProgram:  # fmt: skip
    """Return a mechanism as functions and numbers; raises UsageError if the motion needs Python."""
    samples = fmu_samples(eqs, initial, parameters.given, (0.0, SPAN))
    _check_motion(eqs, integrator, constraints)
    request = MotionRequest(
        initial={name: value for name, value in initial.items() if name not in samples.names},
        parameters=parameters.given, tunable=parameters.arguments, free_inputs=eqs.input_names,
        integrator=integrator, span=(0.0, SPAN), is_pulled=False,
        rtol=RTOL_2 if isinstance(integrator, GeneralizedAlpha) else RTOL,
        constraints=constraints if isinstance(constraints, Projection) else None,
    )  # fmt: skip
    motion = pose_motion(eqs, request, input_laws(eqs.input_names, {}, request.span))
    jumps = find_jumps(motion, parameters)
    parameters = parameters.fix_values(jumps.decisive)
    modal = modal_equations(eqs)
    conditions = find_conditions(modal)
    functions = _Functions(parameters, len(conditions))
    made = functions.of_motion(motion, modal, conditions, outputs, constraints)
    watched, actions = (*events, *mode_ends(modal)), action_outputs(events)
    gaps = gap_events(motion.integration.problem, motion.method)
    periods = [f"({period})" for period in samples.periods]
    deciding: list[str] = []
    for output in deciding_outputs(modal) if modal.modes else ():
        deciding += [output] if isinstance(output, str) else output
    if jumps.times and eqs.speed_names:
        made["strike"] = functions.make(strike_equations(modal.eqs), "strike", strike_outputs(modal.eqs))
    for name, source, own in (
        ("deciding", eqs, deciding),
        ("indicators", modal.eqs, [str(event.expression) for event in watched]),
        ("gaps", modal.eqs, [str(gap.expression) for gap in gaps]),
        ("action", modal.eqs, actions),
        ("samples", modal.eqs, samples.formulas),
        ("periods", modal.eqs, periods),
        ("parameters", modal.eqs, [f"({formula})" for formula in parameters.calculated]),
    ):
        if own:
            made[name] = functions.make(source, name, own)
    if watched:
        check_value_shapes(watched, made["indicators"].outputs)
    if actions:
        check_action_shapes(events, made["action"].outputs[1:-1])
    if periods:
        check_numbers(samples.values, made["samples"].outputs)
        parameters = parameters.with_fixed(made["periods"].sequence)
    return FmuProgram(
        eqs, motion, parameters, tuple(outputs), events, made, conditions, modal, samples, jumps
    )


@dataclass(frozen=True, slots=True)
class _Functions:
    """Makes functions of the same parameters, behind which p holds the sides of conditions."""

    parameters: FmuParameters
    condition_count: int

    def make(
        self, eqs: EquationSet, name: str, outputs: Sequence[str], branches: Branches | None = None
    ) -> ProgramFunction:
        given = self.parameters
        values = np.concatenate([given.values, np.zeros(self.condition_count)])
        return make_function(
            eqs, outputs, f"{FUNCTION}{name}", given.fixed_formulas, given.arguments, values,
            len(eqs.input_names), freeze=None if branches is None else branches.freeze,
        )  # fmt: skip

    def of_motion(
        self, motion: PosedMotion, modal: ModalEquations, conditions: tuple[Condition, ...],
        outputs: Sequence[str], constraints: Projection | Baumgarte | None,
    ) -> dict[str, ProgramFunction]:  # fmt: skip
        """Return what states and outputs follow from, with derivatives by all inputs but modes."""
        eqs, whole = motion.eqs, modal.eqs
        stabilizing = constraints if isinstance(constraints, Baumgarte) else Baumgarte()
        stabilized = stabilizing.applied(whole) if whole.multiplier_names else whole
        sides = with_outputs(whole, [Roots(OUTPUT, (len(conditions),), tuple(x.node for x in conditions))])
        branches = self.branches(motion, sides, conditions, len(modal.modes))
        close = closing_of(eqs, holds=True)
        closing = whole if close.eqs is eqs else modal_equations(close.eqs).eqs
        made = {
            "motion": self.make(whole, "motion", ["xdot", "power"]),
            "slope": self.make(stabilized, "slope", ["xdot"], branches),
            "output": self.make(whole, "output", ["constraints", "energy", *outputs], branches),
        }
        if motion.is_closed or whole.multiplier_names:
            made["projection"] = self.make(whole, "projection", PROJECTED)
        if closing.multiplier_names or closing.quaternions:
            made["assembly"] = self.make(closing, "assembly", close.outputs)
        if isinstance(motion.method, GeneralizedAlpha):
            made["turn"] = self.make(whole, "turn", ["qdot"])
            made["jacobian"] = self.make(with_state_jacobian(whole, {}), "jacobian", [STATE_JACOBIAN])
        if eqs.state_names:
            groups = ("q", "s", "u") if eqs.signal_state_names else ("q", "u")
            by = f"d({', '.join((*groups, *(f'({name})' for name in eqs.input_names)))})"
            slopes = [f"d {name}/{by}" for name in ("constraints", "energy", *outputs)]
            made["derivatives"] = self.make(stabilized, "derivatives", [f"d xdot/{by}"], branches)
            made["sensitivities"] = self.make(whole, "sensitivities", slopes, branches)
        if conditions:
            made["sides"] = self.make(sides, "sides", [OUTPUT], branches)
        return made

    def branches(
        self, motion: PosedMotion, sides: EquationSet, conditions: tuple[Condition, ...], mode_count: int
    ) -> Branches | None:
        """Return the branches with what decides them, at some points about the first state; nothing holds."""
        if not conditions:
            return None
        sequence = self.make(sides, "sides", [OUTPUT]).sequence
        n_u, n_r = len(sides.speed_names), len(sides.input_names) - mode_count
        x, p = motion.integration.state, self.parameters.values.tolist()
        points = []
        for k in range(_POINTS):
            moved = [float(value) + math.sin(1.0 + 7.0 * k + i) for i, value in enumerate(x)]
            r = [*(math.cos(2.0 + 5.0 * k + i) for i in range(n_r)), *[float(LOOSE)] * mode_count]
            points.append({"t": [0.37 + k], "q": moved[n_u:], "u": moved[:n_u], "r": r, "p": p})
        values = tuple(tuple(evaluate_sequence(sequence, point)[0]) for point in points)
        are_floors = tuple(condition.is_floor for condition in conditions)
        return Branches(tuple(points), values, are_floors, len(p))


def _check_motion(eqs: EquationSet, integrator: object, constraints: object) -> None:
    reason = reason_for_program(eqs, input_laws(eqs.input_names, {}, (0.0, SPAN)), integrator, constraints)
    if reason:
        raise UsageError(
            Problem("fmu.motion", eqs.model.name, f"this motion cannot be written as an FMU: {reason}",
                    "an FMU computes without Python",
                    "use sb.Explicit(), sb.FixedStep(..) or sb.GeneralizedAlpha(..); "
                    "and sb.Projection() or sb.Baumgarte()")
        )  # fmt: skip
