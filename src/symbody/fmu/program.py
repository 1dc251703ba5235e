"""`FmuProgram`: everything that the C of an FMU computes with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.analysis.derivatives import with_outputs
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.sequence import Output
from symbody.fmu.conditions import OUTPUT, Condition, condition_output, find_conditions
from symbody.fmu.freezing import Branches
from symbody.fmu.functions import Floats, ModelFunction, dependencies, make_function
from symbody.fmu.modes import ModalEquations, modal_equations
from symbody.fmu.parameters import FmuParameters
from symbody.fmu.samples import FmuSamples, fmu_samples
from symbody.kernels import assembly as at
from symbody.kernels import block
from symbody.simulation.events.events import Event
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.hybrid.switching import switches
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.methods.constraints import (
    PROJECTED,
    Baumgarte,
    Projection,
    make_projector,
    residual_share,
)
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Projector
from symbody.simulation.programs.motion_request import MotionRequest, PosedMotion, pose_motion
from symbody.simulation.sampling.sampled_loop import check_numbers

ASSEMBLED: Final = ("constraints", "position_jacobian", "velocity_residual", "jacobian")
MOST_TRIALS: Final = 2**52
FUNCTION: Final = "mechanism_"  # begins the names of functions in C
SPAN: Final = 10.0  # seconds of the default experiment
RTOL: Final = 1e-8
_POINTS: Final = 3  # at which conditions are recognized


@dataclass(frozen=True, slots=True, eq=False)
class FmuProgram:
    """A mechanism as functions and numbers.

    Attributes
    ----------
    eqs : EquationSet
        The equations, without stabilizing terms.
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
        sensitivities, indicators, action, parameters, sides, measures, mass, samples, periods.
    conditions : tuple of Condition
        What decides the branches that are frozen between events of model exchange.
    modal : ModalEquations
        The same equations with the modes of joints and ropes as arguments.
    samples : FmuSamples
        What is held between samples.
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
        return scales.constraints(self.eqs)[: len(self.eqs.formed.holonomic)]

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
        return len(self.events) + len(self.conditions) + len(self.modal.elements)

    @property
    def rate_scales(self) -> list[float]:
        """Rates of joints and ropes below which they are at rest, as multiples of rates of angles."""
        length = self.motion.integration.problem.scales.length
        return [1.0 if element.is_angle else length for element in self.modal.elements]

    @property
    def time_scale(self) -> float:
        """In which the mechanism moves by its size [s]."""
        return self.motion.integration.problem.scales.time

    @property
    def mass_scale(self) -> float:
        """The largest mass [kg]."""
        return self.motion.integration.problem.scales.mass

    @property
    def is_projected(self) -> bool:
        """Whether states fulfil constraints, norms of quaternions among them."""
        return "projection" in self.functions

    @property
    def method(self) -> Explicit | FixedStep:
        """The integrator of co-simulation."""
        return self.motion.method

    @property
    def closing_share(self) -> float:
        """By which share of its scale a constraint may be open."""
        return residual_share(self.motion.projection, None)

    @property
    def actions(self) -> tuple[tuple[int, int], ...]:
        """Event and state of each new value that an event sets."""
        places = {name: k for k, name in enumerate(self.eqs.state_names)}
        return tuple((k, places[name]) for k, event in enumerate(self.events) for name in event.mapping)

    def block(self) -> Floats:
        """Return the block of the integrator at the first state."""
        integration, method = self.motion.integration, self.method
        goal = make_goal(
            (0.0, SPAN), integration.rtol, integration.tolerances, method.max_step, self.motion.breakpoints
        )
        goal = goal._replace(max_trials=MOST_TRIALS, stop_when_stiff=False)
        made = make_block(
            self.functions["motion"].arguments, self._projector(), method.tableau, goal, self.x0, 0.0,
            method.first_step or 0.0,
        )  # fmt: skip
        made[block.KEEP_DENSE] = made[block.STEP_ROOM] = 1.0
        return made

    def _projector(self) -> Projector:
        if not self.is_projected:
            return NOTHING_TO_PROJECT
        function = self.functions["projection"]
        scales = self.motion.integration.problem.scales
        made = make_projector(_Projecting(function), self.eqs, scales, self.motion.projection, None)
        ours = function.arguments
        limit = math.inf if isinstance(self.method, FixedStep) else made.limit
        return made._replace(
            address=1, inputs=ours.inputs, parameters=ours.parameters, constants=ours.constants,
            work_size=ours.work_size, limit=limit,
        )  # fmt: skip

    def assembly(self) -> Floats:
        """Return the block of `symbody.kernels.assembly`; empty for open mechanisms."""
        if "assembly" not in self.functions:
            return np.zeros(0)
        eqs, function = self.eqs, self.functions["assembly"]
        scales = self.motion.integration.problem.scales
        n_u, n_q = len(eqs.speed_names), len(eqs.coordinate_names)
        count, rows = function.sizes[0], function.sizes[2]
        four = [float(eqs.coordinate_names.index(name)) for names in eqs.quaternions for name in names]
        parts = [
            np.zeros(at.HEADER), np.zeros(n_u + n_q), scales.displacements(eqs), scales.coordinates(eqs),
            scales.constraints(eqs)[:count], np.zeros(function.size),
            np.zeros(at.matrices_size(max(n_q, n_u))), function.numbers, np.zeros(n_q), np.array(four),
        ]  # fmt: skip
        begins = np.cumsum([part.size for part in parts])
        head = parts[0]
        head[[at.SPEEDS, at.COORDINATES, at.RESIDUALS, at.ROWS]] = n_u, n_q, count, rows
        head[[at.HELD, at.SIZES]] = begins[:2]
        order = (at.SCALES, at.OUT, at.MATRICES, at.NUMBERS, at.OLD, at.QUATERNION_PLACES)
        head[[*order]] = begins[3:-1]
        head[at.QUATERNIONS], head[at.OUT_SIZE] = len(eqs.quaternions), function.size
        head[[at.SHARE, at.ENOUGH]] = math.sqrt(max(count, 1)) * self.closing_share
        return np.concatenate(parts)

    @property
    def closing_parameters(self) -> tuple[bool, ...]:
        """Which of the parameters that are arguments enter the constraints."""
        names = self.parameters.arguments
        if "assembly" not in self.functions:
            return (False,) * len(names)
        read = frozenset().union(*dependencies(self.functions["assembly"].sequence))
        return tuple(("p", k) in read for k in range(len(names)))


def make_program(
    eqs: EquationSet, outputs: Sequence[str], initial: Mapping[str, Value], parameters: FmuParameters,
    events: tuple[Event, ...], constraints: Projection | Baumgarte | None,
    integrator: Explicit | FixedStep | None,
) -> FmuProgram:  # fmt: skip
    """Return a mechanism as functions and numbers.

    Raises
    ------
    UsageError
        If the motion needs Python.
    """
    _check_motion(eqs, integrator, constraints, events)
    samples = fmu_samples(eqs, initial, parameters.given, (0.0, SPAN))
    request = MotionRequest(
        initial={name: value for name, value in initial.items() if name not in samples.names},
        parameters=parameters.given, tunable=parameters.arguments, free_inputs=eqs.input_names,
        integrator=integrator, rtol=RTOL, span=(0.0, SPAN), is_pulled=False,
        constraints=constraints if isinstance(constraints, Projection) else None,
    )  # fmt: skip
    motion = pose_motion(eqs, request, input_laws(eqs.input_names, {}, request.span))
    modal = modal_equations(eqs)
    eqs = modal.eqs
    stabilizing = constraints if isinstance(constraints, Baumgarte) else Baumgarte()
    stabilized = stabilizing.applied(eqs) if eqs.multiplier_names else eqs
    conditions = find_conditions(eqs)
    functions = _Functions(parameters, modal.arguments, len(conditions))
    sides = with_outputs(eqs, [condition_output(conditions)])
    branches = functions.branches(motion, sides, conditions)
    shown = modal.outputs(outputs)
    made = {
        "motion": functions.make(eqs, "motion", ["xdot"]),
        "slope": functions.make(stabilized, "slope", ["xdot"], branches),
        "output": functions.make(eqs, "output", ["constraints", "energy", *shown], branches),
    }
    if motion.is_closed or eqs.multiplier_names:
        made["projection"] = functions.make(eqs, "projection", PROJECTED)
        made["assembly"] = functions.make(eqs, "assembly", ASSEMBLED)
    if eqs.state_names:
        by = "d(q, s, u, r)" if eqs.signal_state_names else "d(q, u, r)"
        made["derivatives"] = functions.make(stabilized, "derivatives", [f"d xdot/{by}"], branches)
        slopes = [f"d {name}/{by}" for name in ("constraints", "energy", *shown)]
        made["sensitivities"] = functions.make(eqs, "sensitivities", slopes, branches)
    if conditions:
        made["sides"] = functions.make(sides, "sides", [OUTPUT], branches)
    if modal.elements:
        made["measures"] = functions.make(eqs, "measures", modal.measures)
    if any(element.is_rope for element in modal.elements):
        made["mass"] = functions.make(eqs, "mass", ["mass_matrix"])
    if events:
        watched = modal.outputs(str(event.expression) for event in events)
        made["indicators"] = functions.make(eqs, "indicators", watched)
    actions = [str(value) for event in events for value in event.mapping.values()]
    if actions:
        made["action"] = functions.make(eqs, "action", actions)
    if samples.values:
        made["samples"] = functions.make(eqs, "samples", modal.outputs(samples.formulas))
        check_numbers(samples.values, made["samples"].sequence.outputs)
        made["periods"] = functions.make(eqs, "periods", [f"({period})" for period in samples.periods])
        parameters = parameters.with_fixed(made["periods"].sequence)
    if parameters.calculated:
        made["parameters"] = functions.make(
            eqs, "parameters", [f"({name})" for name in parameters.calculated]
        )
    return FmuProgram(eqs, motion, parameters, tuple(outputs), events, made, conditions, modal, samples)


@dataclass(frozen=True, slots=True)
class _Functions:
    """Makes functions of the same parameters, behind which p holds modes and the sides of conditions."""

    parameters: FmuParameters
    modes: tuple[str, ...]
    condition_count: int

    def make(
        self, eqs: EquationSet, name: str, outputs: Sequence[str], branches: Branches | None = None
    ) -> ModelFunction:
        given = self.parameters
        arguments = (*given.arguments, *self.modes)
        values = np.concatenate([given.values, np.zeros(len(self.modes) + self.condition_count)])
        return make_function(
            eqs, f"{FUNCTION}{name}", outputs, given.fixed_formulas, arguments, values, branches
        )

    def branches(
        self, motion: PosedMotion, sides: EquationSet, conditions: tuple[Condition, ...]
    ) -> Branches | None:
        """Return the branches with what decides them, at some points about the first state."""
        if not conditions:
            return None
        sequence = self.make(sides, "sides", [OUTPUT]).sequence
        n_u, n_r = len(sides.speed_names), len(sides.input_names)
        x, p = motion.integration.state, [*self.parameters.values.tolist(), *[0.0] * len(self.modes)]
        points = []
        for k in range(_POINTS):
            moved = [float(value) + math.sin(1.0 + 7.0 * k + i) for i, value in enumerate(x)]
            r = [math.cos(2.0 + 5.0 * k + i) for i in range(n_r)]
            points.append({"t": [0.37 + k], "q": moved[n_u:], "u": moved[:n_u], "r": r, "p": p})
        values = tuple(tuple(evaluate_sequence(sequence, point)[0]) for point in points)
        are_floors = tuple(condition.is_floor for condition in conditions)
        return Branches(tuple(points), values, are_floors, len(p))


@dataclass(frozen=True, slots=True)
class _Projecting:
    """The sizes of a function that projects."""

    function: ModelFunction
    address: int = 1

    @property
    def work_size(self) -> int:
        """Doubles of scratch that it needs."""
        return self.function.arguments.work_size

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it computes."""
        return self.function.sequence.outputs

    def constants(self) -> Floats:
        """Return the numbers c that it takes."""
        return self.function.arguments.constants


def _check_motion(
    eqs: EquationSet, integrator: object, constraints: object, events: tuple[Event, ...]
) -> None:
    reasons = {
        f"{type(integrator).__name__} is no explicit method": not isinstance(
            integrator, Explicit | FixedStep | None
        ),
        f"{type(constraints).__name__} takes its steps in Python": not isinstance(
            constraints, Projection | Baumgarte | None
        ),
        "prescribed rates may jump": may_jump(eqs),
        "dependent speeds are watched": bool(
            eqs.formed.elimination is not None and eqs.formed.elimination.pivots
        ),
        "an event sets new values where joints stick and slip, or ropes slacken": switches(eqs.formed)
        and any(event.mapping for event in events),
    }
    reason = "; ".join(reason for reason, holds in reasons.items() if holds)
    if reason:
        raise UsageError(
            Problem("fmu.motion", eqs.model.name, f"this motion cannot be written as an FMU: {reason}",
                    "an FMU computes without Python",
                    "prescribe motions without corners; give sb.Explicit() or sb.FixedStep(..), "
                    "sb.Projection() or sb.Baumgarte()")
        )  # fmt: skip
