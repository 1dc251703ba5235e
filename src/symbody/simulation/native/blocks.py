"""The block of a run, which holds all that its kernels read and change; see `symbody.kernels.block`."""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.kernels.block import (
    Breakpoint,
    BreakpointTable,
    CaseCursor,
    FunctionNumbers,
    Method,
    Run,
    RunGoal,
    StateProjection,
)
from symbody.kernels.pack import pack
from symbody.simulation.native.description import Floats, Goal, Projector, RightHandSide
from symbody.simulation.native.runge_kutta import Tableau
from symbody.single_flight import SingleFlight

_METHODS: Final[SingleFlight[tuple[Tableau, int], Floats]] = SingleFlight(64)


def make_block(
    rhs: RightHandSide,
    projector: Projector,
    tableau: Tableau,
    goal: Goal,
    x: Floats,
    t: float,
    first_step: float = 0.0,
) -> Floats:
    """Return the block of a motion at its first time [s] and state x = (u, q)."""
    n = x.size
    aim = pack(
        RunGoal, direction=goal.direction, rtol=goal.rtol, max_step=goal.max_step,
        max_trials=goal.max_trials, stop_when_stiff=goal.stop_when_stiff,
    )  # fmt: skip
    return pack(
        Run, time=t, t_end=goal.t_end, first_step=first_step, states=n, speeds=rhs.n_u, goal=aim,
        cases=pack(CaseCursor, start=t),
        breaks=pack(BreakpointTable, count=goal.breaks.size // Breakpoint.size, points=goal.breaks),
        method=method_numbers(tableau, n), state_old=x, tolerances=goal.atol,
        slopes=np.zeros(len(tableau.A) * n), dense=np.zeros((4 + len(tableau.dense)) * n),
        numbers=function_numbers(rhs), projection=_projection(projector) if projector.address else None,
    )  # fmt: skip


def state_of(block: Floats) -> Floats:
    """Return the state x = (u, q) in a block, a view."""
    return np.asarray(Run(block).state_old)


def method_numbers(tableau: Tableau, n: int) -> Floats:
    """Return a method for n states, not to be changed."""
    return _METHODS.get((tableau, n), lambda: _method_numbers(tableau, n))


def _method_numbers(tableau: Tableau, n: int) -> Floats:
    weights: list[tuple[float, float]] = []
    rows = [0]
    for row in (*tableau.A, *tableau.error, *tableau.dense):
        weights += [(stage * n, weight) for stage, weight in enumerate(row) if weight != 0.0]
        rows.append(len(weights))
    return pack(
        Method, order=tableau.order, stages=tableau.stages, stage_rows=len(tableau.A),
        dense_rows=4 + len(tableau.dense), error_reads_end=tableau.error_reads_end,
        exponent=tableau.exponent, memory=tableau.memory, shrink=tableau.shrink, growth=tableau.growth,
        stiff_bound=tableau.stiff_bound, split=tableau.split, nodes=tableau.c, rows=rows,
        weights=np.ravel(weights),
    )  # fmt: skip


def function_numbers(rhs: RightHandSide | Projector) -> Floats:
    """Return the numbers of a function and room for its scratch."""
    tables = rhs.tables if isinstance(rhs, RightHandSide) else np.zeros(0)
    return pack(
        FunctionNumbers, input_count=rhs.inputs.size, parameter_count=rhs.parameters.size,
        constant_count=rhs.constants.size, work_size=rhs.work_size, inputs=rhs.inputs,
        parameters=rhs.parameters, constants=rhs.constants, tables=tables,
    )  # fmt: skip


def _projection(projector: Projector) -> Floats:
    return pack(
        StateProjection, coordinates=projector.n_q, residuals=projector.scales.size,
        out_size=projector.out_size, limit=projector.limit, rounding=projector.rounding,
        scales=projector.scales, sizes=projector.sizes, numbers=function_numbers(projector),
    )  # fmt: skip
