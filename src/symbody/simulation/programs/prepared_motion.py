"""A motion as kernels, a block and times: all that a program of it holds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.kernels.block import Run
from symbody.kernels.record_layout import exists
from symbody.simulation.methods.constraints import PROJECTED, make_projector
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, check_atol, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import work_tolerance
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats, Projector
from symbody.simulation.programs.happenings import Happenings, make_happenings
from symbody.simulation.programs.motion_request import PosedMotion
from symbody.simulation.programs.program_function import (
    PROJECTION,
    RIGHT_HAND_SIDE,
    ProgramFunction,
    program_function,
)


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
    happenings = make_happenings(motion, block)
    kernels: dict[str, KernelTree] = {}
    for file, names in happenings.kernels:
        kernels |= read_kernels(file, *names)
    for function in (functions | dict(happenings.functions)).values():
        kernels |= function.kernels
    times = np.asarray(motion.integration.times, dtype=np.float64)
    room = Run(block).room
    room.times, room.samples = times.size, times.size + happenings.more_samples
    room.keep_dense, room.steps = float(bool(happenings.steps)), happenings.steps
    return PreparedMotion(kernels, block, times, (*motion.eqs.state_names, "work"), happenings)
