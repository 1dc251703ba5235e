"""A motion as kernels, a block and times: all that a program of it holds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.sequence_kernel import sequence_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.equations.equation_set import EquationSet
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Output
from symbody.kernels.block import Run
from symbody.kernels.record_layout import exists
from symbody.simulation.methods.constraints import PROJECTED, make_projector
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, check_atol, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats, Projector, RightHandSide
from symbody.simulation.programs.motion_request import PosedMotion

RIGHT_HAND_SIDE: Final = "right_hand_side"
PROJECTION: Final = "projection"
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
    """

    kernels: Mapping[str, KernelTree]
    outputs: tuple[Output, ...]
    numbers: RightHandSide
    values: str
    values_size: int

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

    def constants(self) -> Floats:
        """Return the numbers c."""
        return self.numbers.constants


def program_function(
    motion: PosedMotion, outputs: Sequence[str], name: str, closing: EquationSet | None = None
) -> ProgramFunction:
    """Return a function of a motion, whose parameters are numbers unless they may change.

    Its equations are those of the motion, or those in which its states are closed.
    """
    eqs = motion.eqs if closing is None else closing
    sequence, _ = form_sequence(eqs, tuple(outputs), motion.fixed_values, motion.tunable, motion.formulas)
    head, tail = fold_constants(written_out(sequence)).split("p")
    kernels, work_size = sequence_kernels(tail, name)
    parameters = np.array(motion.tunable_values, dtype=np.float64)
    values, values_size, constants = "", 0, np.zeros(0)
    if head.output_size:
        values = f"{name}_values"
        more, values_size = sequence_kernels(head, values)
        kernels = {**kernels, **more}
        parts = evaluate_sequence(head, {"p": parameters.tolist()})
        constants = np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in parts])
    inputs = np.zeros(len(motion.input_names))
    n_u = len(eqs.speed_names)
    numbers = RightHandSide(_NOWHERE, n_u, inputs, parameters, constants, work_size)
    return ProgramFunction(kernels, sequence.outputs, numbers, values, values_size)


def motion_functions(motion: PosedMotion) -> dict[str, ProgramFunction]:
    """Return the functions that the integrator calls, by name."""
    functions = {RIGHT_HAND_SIDE: program_function(motion, ("xdot", "power"), RIGHT_HAND_SIDE)}
    if motion.is_projected:
        functions[PROJECTION] = program_function(motion, PROJECTED, PROJECTION)
    return functions


def motion_block(motion: PosedMotion, functions: Mapping[str, ProgramFunction]) -> Floats:
    """Return the block of a motion at its first state, see `symbody.kernels.block`."""
    integration, method, start = motion.integration, motion.method, motion.span[0]
    atol = check_atol([*integration.tolerances, work_tolerance(integration)], motion.x0.size)
    goal = make_goal((start, motion.last), integration.rtol, atol, method.max_step, motion.breakpoints)
    goal = goal._replace(max_trials=int(integration.max_steps))
    projector = _projector(motion, functions[PROJECTION]) if motion.is_projected else NOTHING_TO_PROJECT
    rhs, first_step = functions[RIGHT_HAND_SIDE].numbers, float(method.first_step or 0.0)
    return make_block(rhs, projector, method.tableau, goal, motion.x0, start, first_step)


def _projector(motion: PosedMotion, function: ProgramFunction) -> Projector:
    scales = motion.integration.problem.scales
    projector = make_projector(function, motion.eqs, scales, motion.projection, motion.request.atol)
    limit = math.inf if isinstance(motion.method, FixedStep) else projector.limit
    numbers = function.numbers
    return projector._replace(inputs=numbers.inputs, parameters=numbers.parameters, limit=limit)


@dataclass(frozen=True, slots=True, eq=False)
class PreparedMotion:
    """A motion that can be computed without symbody.

    Attributes
    ----------
    kernels : mapping of name to KernelTree
        The integrator, the right-hand side and what projects, each behind those that it calls.
    block : array
        The run at its beginning, see `symbody.kernels.block`.
    times : array
        The samples [s].
    names : tuple of str
        Of the states; the last one is the work.
    """

    kernels: Mapping[str, KernelTree]
    block: Floats
    times: Floats
    names: tuple[str, ...]

    @property
    def is_projected(self) -> bool:
        """Whether states are moved onto constraints."""
        return bool(exists(Run(self.block).projection))


def prepare_motion(motion: PosedMotion) -> PreparedMotion:
    """Return a motion as kernels and numbers, portable to the bit."""
    functions = motion_functions(motion)
    kernels = dict(read_kernels("step_machine", "begin", "advance"))
    for function in functions.values():
        kernels |= function.kernels
    block = motion_block(motion, functions)
    times = np.asarray(motion.integration.times, dtype=np.float64)
    room = Run(block).room
    room.times = room.samples = times.size
    return PreparedMotion(kernels, block, times, (*motion.eqs.state_names, "work"))
