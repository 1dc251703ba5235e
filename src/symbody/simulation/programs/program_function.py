"""What the integrator of a program calls, functions as kernels, and the block that it begins with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.kernels.sequence_kernel import sequence_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.equations.equation_set import EquationSet
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Output, Sequence
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.methods.constraints import PROJECTED, make_projector
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, check_atol, make_goal
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha, bounds_of_steps
from symbody.simulation.methods.implicit.state_jacobian import STATE_JACOBIAN, with_state_jacobian
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.native.blocks import NO_GAPS, function_numbers, make_block
from symbody.simulation.native.description import Floats, Projector, RightHandSide
from symbody.simulation.native.implicit import METHOD, ImplicitFunctions, make_array
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.programs.motion_request import Method, PosedMotion

RIGHT_HAND_SIDE: Final = "right_hand_side"
PROJECTION: Final = "projection"
# What implicit methods call, too: rates of coordinates, and derivatives of all rates by states.
TURN: Final = "coordinate_rates"
DERIVATIVES: Final = "rate_derivatives"
_NOWHERE: Final = 1  # the address of a function that lies nowhere yet


@dataclass(frozen=True, slots=True, eq=False)
class ProgramFunction:
    """A function of a program as kernels, with the numbers that it takes.

    Attributes
    ----------
    kernels : mapping of name to KernelTree
        The function, what computes its numbers c from parameters that may change, and those that they call.
    outputs : tuple of Output
    numbers : RightHandSide
        Inputs, parameters that may change, and c at their first values.
    values : str
        Name of the kernel that computes c, empty where none does.
    values_size : int
        Doubles of scratch that it needs.
    sequence : Sequence
        What is computed.
    """

    kernels: Mapping[str, KernelTree]
    outputs: tuple[Output, ...]
    numbers: RightHandSide
    values: str
    values_size: int
    sequence: Sequence

    @property
    def address(self) -> int:
        """A place that is not 0."""
        return _NOWHERE

    @property
    def work_size(self) -> int:
        """Doubles of scratch that it needs."""
        return self.numbers.work_size

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many numbers each output has."""
        return tuple(len(output.values) for output in self.outputs)

    @property
    def size(self) -> int:
        """How many numbers it computes."""
        return sum(self.sizes)

    @property
    def array(self) -> Floats:
        """The numbers of a call, as a block holds them."""
        return function_numbers(self.numbers)

    def constants(self) -> Floats:
        """Return the numbers c."""
        return self.numbers.constants


def program_function(
    motion: PosedMotion, outputs: Iterable[str], name: str, closing: EquationSet | None = None
) -> ProgramFunction:
    """Return a function of a motion, whose parameters are numbers unless they may change.

    Its equations are those of the motion, or those in which its states are closed.
    """
    eqs = motion.eqs if closing is None else closing
    return make_function(
        eqs, outputs, name, motion.fixed_values, motion.request.tunable,
        np.array(motion.tunable_values, dtype=np.float64), len(motion.input_names), motion.formulas,
    )  # fmt: skip


def make_function(
    eqs: EquationSet, outputs: Iterable[str], name: str, parameters: Mapping[str, Value],
    tunable: tuple[str, ...], values: Floats, input_count: int, formulas: Mapping[str, Value] | None = None,
    freeze: Callable[[Sequence], Sequence] | None = None,
) -> ProgramFunction:  # fmt: skip
    """Return a function of outputs.

    Parameters
    ----------
    parameters : mapping
        What is given for parameters that are no arguments.
    tunable : tuple of str
        Parameters that are arguments.
    values : (n,) array
        Their first values, and those of what follows them in p.
    input_count : int
        How many inputs are arguments.
    formulas : mapping, optional
        Laws of other inputs.
    freeze : callable, optional
        Makes of a sequence what is written; which arguments results depend on is asked before.
    """
    sequence, _ = form_sequence(eqs, tuple(outputs), parameters, tunable, formulas or {})
    sequence = fold_constants(written_out(sequence))
    head, tail = (sequence if freeze is None else freeze(sequence)).split("p")
    kernels, work_size = sequence_kernels(tail, name)
    values_name, values_size, constants = "", 0, np.zeros(0)
    if head.output_size:
        values_name = f"{name}_values"
        more, values_size = sequence_kernels(head, values_name)
        kernels = {**kernels, **more}
        parts = evaluate_sequence(head, {"p": values.tolist()})
        constants = np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in parts])
    numbers = RightHandSide(
        _NOWHERE, len(eqs.speed_names), np.zeros(input_count), values, constants, work_size
    )
    return ProgramFunction(kernels, sequence.outputs, numbers, values_name, values_size, sequence)


def motion_functions(motion: PosedMotion) -> dict[str, ProgramFunction]:
    """Return the functions that the integrator calls, by name."""
    functions = {RIGHT_HAND_SIDE: program_function(motion, ("xdot", "power"), RIGHT_HAND_SIDE)}
    if isinstance(motion.method, GeneralizedAlpha):
        wider = with_state_jacobian(motion.eqs, motion.formulas)
        functions[TURN] = program_function(motion, ["qdot"], TURN)
        functions[DERIVATIVES] = program_function(motion, [STATE_JACOBIAN], DERIVATIVES, wider)
    if motion.is_projected:
        functions[PROJECTION] = program_function(motion, PROJECTED, PROJECTION)
    return functions


def motion_block(
    motion: PosedMotion, functions: Mapping[str, ProgramFunction], eqs: EquationSet | None = None,
    gaps: Floats = NO_GAPS,
) -> Floats:  # fmt: skip
    """Return the block of a motion at its first state, see `symbody.kernels.block`.

    Parameters
    ----------
    eqs : EquationSet, optional
        In which states are projected; by default those that are integrated.
    gaps : array, optional
        Of an `EventMonitor` of gaps over which no step may pass.
    """
    integration, method, start = motion.integration, motion.method, motion.span[0]
    atol = check_atol([*integration.tolerances, work_tolerance(integration)], motion.integration.x0.size)
    tableau, first, longest, bounds = method_bounds(method, motion.breakpoints)
    goal = make_goal((start, motion.last), integration.rtol, atol, longest, bounds)
    goal = goal._replace(max_trials=int(integration.max_steps))
    projector = NOTHING_TO_PROJECT
    if PROJECTION in functions:
        projector = _projector(motion, functions[PROJECTION], eqs or motion.eqs)
    return make_block(
        functions[RIGHT_HAND_SIDE].numbers,
        projector,
        tableau,
        goal,
        motion.integration.x0,
        start,
        first or 0.0,
        gaps,
    )


def method_bounds(
    method: Method, bounds: Breakpoints
) -> tuple[Tableau, float | None, float | None, Breakpoints]:
    """Return the numbers of a method, its first and longest step, and what bounds its steps."""
    if isinstance(method, GeneralizedAlpha):
        return METHOD, method.step, method.step or method.max_step, bounds_of_steps(bounds, method)
    return method.tableau, method.first_step, method.max_step, bounds


def implicit_array(motion: PosedMotion, functions: Mapping[str, ProgramFunction]) -> Floats:
    """Return the array of an `ImplicitStep`; empty for explicit methods."""
    method = motion.method
    if not isinstance(method, GeneralizedAlpha):
        return np.zeros(0)
    numbers = ImplicitFunctions(*(functions[name].numbers for name in (RIGHT_HAND_SIDE, TURN, DERIVATIVES)))
    size, n_q = motion.integration.x0.size, len(motion.eqs.coordinate_names)
    return make_array(numbers, size, n_q, float(method.rho), one_length=motion.has_one_length)


def _projector(motion: PosedMotion, function: ProgramFunction, eqs: EquationSet) -> Projector:
    scales = motion.integration.problem.scales
    projector = make_projector(function, eqs, scales, motion.projection, motion.request.atol)
    limit = math.inf if motion.has_one_length else projector.limit
    numbers = function.numbers
    return projector._replace(inputs=numbers.inputs, parameters=numbers.parameters, limit=limit)
