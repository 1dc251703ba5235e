"""A motion as kernels, a block and times: all that a program of it holds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from symbody.codegen.kernels.featured import without_unused
from symbody.codegen.kernels.tree import KernelTree
from symbody.equations.equation_set import EquationSet
from symbody.kernels.block import Run
from symbody.kernels.record_layout import exists
from symbody.simulation.inputs.breakpoints import Breakpoints
from symbody.simulation.methods.constraints import PROJECTED, ProjectingFunction, make_projector
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, check_atol, make_goal
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha, bounds_of_steps
from symbody.simulation.methods.implicit.state_jacobian import STATE_JACOBIAN, with_state_jacobian
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats, Projector, RightHandSide
from symbody.simulation.native.implicit import METHOD, ImplicitFunctions, make_array
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.programs.happenings import Happenings, make_happenings
from symbody.simulation.programs.motion_request import Method, PosedMotion
from symbody.simulation.programs.program_function import (
    DERIVATIVES,
    PROJECTION,
    RIGHT_HAND_SIDE,
    TURN,
    ProgramFunction,
    program_function,
)


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


class IntegratorFunction(ProjectingFunction, Protocol):
    """A function that the integrator calls, with its numbers."""

    @property
    def numbers(self) -> RightHandSide:
        """What it takes beside time and state."""
        ...


def motion_block(
    motion: PosedMotion, functions: Mapping[str, IntegratorFunction], eqs: EquationSet | None = None
) -> Floats:
    """Return the block of a motion at its first state, see `symbody.kernels.block`.

    Parameters
    ----------
    eqs : EquationSet, optional
        In which states are projected; by default those that are integrated.
    """
    integration, method, start = motion.integration, motion.method, motion.span[0]
    atol = check_atol([*integration.tolerances, work_tolerance(integration)], motion.x0.size)
    tableau, first, longest, bounds = method_bounds(method, motion.breakpoints)
    goal = make_goal((start, motion.last), integration.rtol, atol, longest, bounds)
    goal = goal._replace(max_trials=int(integration.max_steps))
    projector = NOTHING_TO_PROJECT
    if PROJECTION in functions:
        projector = _projector(motion, functions[PROJECTION], eqs or motion.eqs)
    return make_block(
        functions[RIGHT_HAND_SIDE].numbers, projector, tableau, goal, motion.x0, start, first or 0.0
    )


def method_bounds(
    method: Method, bounds: Breakpoints
) -> tuple[Tableau, float | None, float | None, Breakpoints]:
    """Return the numbers of a method, its first and longest step, and what bounds its steps."""
    if isinstance(method, GeneralizedAlpha):
        return METHOD, method.step, method.step or method.max_step, bounds_of_steps(bounds, method)
    return method.tableau, method.first_step, method.max_step, bounds


def implicit_array(motion: PosedMotion, functions: Mapping[str, IntegratorFunction]) -> Floats:
    """Return the array of an `ImplicitStep`; empty for explicit methods."""
    method = motion.method
    if not isinstance(method, GeneralizedAlpha):
        return np.zeros(0)
    numbers = ImplicitFunctions(*(functions[name].numbers for name in (RIGHT_HAND_SIDE, TURN, DERIVATIVES)))
    size, n_q = motion.x0.size, len(motion.eqs.coordinate_names)
    return make_array(numbers, size, n_q, float(method.rho), one_length=motion.has_one_length)


def _projector(motion: PosedMotion, function: IntegratorFunction, eqs: EquationSet) -> Projector:
    scales = motion.integration.problem.scales
    projector = make_projector(function, eqs, scales, motion.projection, motion.request.atol)
    limit = math.inf if motion.has_one_length else projector.limit
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
    happenings : Happenings
        What happens on the way.
    """

    kernels: Mapping[str, KernelTree]
    block: Floats
    times: Floats
    names: tuple[str, ...]
    happenings: Happenings

    @property
    def is_projected(self) -> bool:
        """Whether states are moved onto constraints."""
        return bool(exists(Run(self.block).projection))


def prepare_motion(motion: PosedMotion) -> PreparedMotion:
    """Return a motion as kernels and numbers, portable to the bit."""
    functions = motion_functions(motion)
    block = motion_block(motion, functions)
    happenings = make_happenings(motion, block, implicit_array(motion, functions))
    kernels = without_unused(happenings.kernels)
    for function in (functions | dict(happenings.functions)).values():
        kernels |= function.kernels
    times = np.asarray(motion.integration.times, dtype=np.float64)
    room = Run(block).room
    room.times, room.samples = times.size, times.size + happenings.more_samples
    room.keep_dense, room.steps = float(bool(happenings.steps)), happenings.steps
    return PreparedMotion(kernels, block, times, (*motion.eqs.state_names, "work"), happenings)
