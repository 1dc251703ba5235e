"""A motion as kernels, a block and times: all that a program of it holds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.function import CompiledFunction
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.sequence_kernel import sequence_kernels
from symbody.codegen.kernels.tree import KernelTree
from symbody.kernels import block as at
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit, check_atol, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT, work_tolerance
from symbody.simulation.methods.integration_problem import IntegrationProblem
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats, RightHandSide

RIGHT_HAND_SIDE: Final = "right_hand_side"
PROJECTION: Final = "projection"


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
        return bool(self.block[at.PROJECTOR])


def prepare_motion(
    integration: IntegrationProblem,
    integrator: Explicit | FixedStep | None,
    constraints: Projection | Baumgarte | None,
) -> PreparedMotion:
    """Return a motion as kernels and numbers; the same steps as `simulate` takes, portable to the bit."""
    problem, eqs = integration.problem, integration.eqs
    method = integrator or DEFAULT
    function = problem.compile_outputs(("xdot", "power"))
    kernels = dict(read_kernels("step_machine", "begin", "advance"))
    rhs, own = _portable(function, RIGHT_HAND_SIDE, integration.n_u)
    kernels |= own
    projector = NOTHING_TO_PROJECT
    closing = (
        None if isinstance(constraints, Baumgarte) else integration.projection(constraints or Projection())
    )
    if closing is not None:
        numbers, own = _portable(closing.function, PROJECTION, integration.n_u)
        kernels |= own
        limit = math.inf if isinstance(method, FixedStep) else closing.projector.limit
        projector = closing.projector._replace(address=1, work_size=numbers.work_size, limit=limit)
    x = integration.x0
    atol = check_atol([*integration.tolerances, work_tolerance(integration)], x.size)
    bounds = NO_BREAKPOINTS if isinstance(method, FixedStep) else integration.breakpoints
    goal = make_goal(integration.span, integration.rtol, atol, method.max_step, bounds)
    goal = goal._replace(max_trials=int(integration.max_steps))
    first_step = float(method.first_step or 0.0)
    block = make_block(rhs, projector, method.tableau, goal, x, integration.span[0], first_step)
    times = np.asarray(integration.times, dtype=np.float64)
    block[at.TIMES] = block[at.SAMPLE_ROOM] = times.size
    names = (*eqs.state_names, "work")
    return PreparedMotion(kernels, block, times, names)


def _portable(
    function: CompiledFunction, name: str, n_u: int
) -> tuple[RightHandSide, Mapping[str, KernelTree]]:
    """Return a function as a kernel, and the numbers it takes; it lies nowhere yet."""
    kernels, work_size = sequence_kernels(function.tail, name)
    empty = np.zeros(0)
    return RightHandSide(1, n_u, empty, empty, function.constants(), work_size), kernels
