"""The block of a run, which holds all that its kernels read and change; see `symbody.kernels.block`."""

from __future__ import annotations

from collections.abc import Hashable
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
NO_GAPS: Final = np.zeros(0)
_TEMPLATES: Final[SingleFlight[Hashable, tuple[Floats, list[slice]]]] = SingleFlight(64)


def make_block(
    rhs: RightHandSide,
    projector: Projector,
    tableau: Tableau,
    goal: Goal,
    x: Floats,
    t: float,
    first_step: float = 0.0,
    gaps: Floats = NO_GAPS,
) -> Floats:
    """Return the block of a motion at its first time [s] and state x = (u, q).

    Blocks of one size differ in a few numbers, which are written into a copy of the first one. `gaps` is the
    array of an `EventMonitor` of the gaps over which no step may pass.
    """
    sizes = function_sizes(rhs), function_sizes(projector)
    shape = x.size, rhs.n_u, *sizes, projector.n_q, projector.scales.size, projector.out_size
    key = tableau, goal.breaks.tobytes(), shape, gaps.size
    first, places = _TEMPLATES.get(key, lambda: _template(rhs, projector, tableau, goal.breaks, x, gaps))
    block = first.copy()
    groups = [x, goal.atol, *_groups(rhs)]
    run = Run(block)
    run.time, run.t_end, run.first_step, run.cases.start = t, goal.t_end, first_step, t
    aim = run.goal
    aim.direction, aim.rtol, aim.max_step = goal.direction, goal.rtol, goal.max_step
    aim.max_trials, aim.stop_when_stiff = goal.max_trials, goal.stop_when_stiff
    if projector.address:
        projection = run.projection
        projection.limit, projection.rounding = projector.limit, projector.rounding
        groups += [projector.scales, projector.sizes, *_groups(projector)]
    if gaps.size:
        groups.append(gaps)
    for place, values in zip(places, groups, strict=True):
        block[place] = values
    return block


def function_sizes(function: RightHandSide | Projector) -> tuple[int, ...]:
    """Return how many numbers of each kind a function takes."""
    tables = function.tables.size if isinstance(function, RightHandSide) else int(bool(function.address))
    groups = function.inputs.size, function.parameters.size, function.constants.size
    return *groups, function.work_size, tables


def _template(
    rhs: RightHandSide, projector: Projector, tableau: Tableau, breaks: Floats, x: Floats, gaps: Floats
) -> tuple[Floats, list[slice]]:
    """Return the block of motions of these sizes, and where the arrays lie in which such motions differ."""
    n = x.size
    block = pack(
        Run, states=n, speeds=rhs.n_u, goal=pack(RunGoal), cases=pack(CaseCursor),
        breaks=pack(BreakpointTable, count=breaks.size // Breakpoint.size, points=breaks),
        method=method_numbers(tableau, n), state_old=x, tolerances=np.ones(n),
        slopes=np.zeros(len(tableau.A) * n), dense=np.zeros((4 + len(tableau.dense)) * n),
        numbers=function_numbers(rhs), projection=_projection(projector) if projector.address else None,
        gaps=gaps if gaps.size else None,
    )  # fmt: skip
    run = Run(block)
    fields = [np.asarray(run.state_old), np.asarray(run.tolerances), *_fields(run.numbers, rhs)]
    if projector.address:
        projection = run.projection
        fields += [np.asarray(projection.scales), np.asarray(projection.sizes)]
        fields += _fields(projection.numbers, projector)
    if gaps.size:
        fields.append(np.asarray(run.gaps)[: gaps.size])
    begins = [(field.ctypes.data - block.ctypes.data) // block.itemsize for field in fields]
    return block, [slice(k, k + field.size) for k, field in zip(begins, fields, strict=True)]


def _groups(function: RightHandSide | Projector) -> list[Floats]:
    """Return the arguments of a function that are the same for a whole run."""
    groups = [function.inputs, function.parameters, function.constants]
    return [*groups, function.tables] if isinstance(function, RightHandSide) else groups


def _fields(numbers: FunctionNumbers, function: RightHandSide | Projector) -> list[Floats]:
    """Return where these arguments stand, views."""
    fields = [np.asarray(field) for field in (numbers.inputs, numbers.parameters, numbers.constants)]
    if isinstance(function, RightHandSide):
        fields.append(np.asarray(numbers.tables)[: function.tables.size])
    return fields


def write_numbers(numbers: FunctionNumbers, function: RightHandSide | Projector) -> None:
    """Write the arguments of a function over those of another one of the same sizes."""
    for field, values in zip(_fields(numbers, function), _groups(function), strict=True):
        field[:] = values


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
