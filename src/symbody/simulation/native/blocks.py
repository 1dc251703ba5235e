"""The block of a run, which holds all that its kernels read and change; see `symbody.kernels.block`."""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.kernels import block as at
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
    size = at.VECTORS + (at.VECTOR_ROWS + len(tableau.A) + 4 + len(tableau.dense)) * n
    breaks, function = goal.breaks.ravel(), function_numbers(rhs)
    projection = _projection(projector) if projector.address else np.zeros(0)
    block = np.concatenate([np.zeros(size), breaks, function, projection])
    block[at.METHOD : at.METHOD + at.METHOD_SIZE] = method_numbers(tableau, n)
    block[at.N], block[at.N_U] = n, rhs.n_u
    block[at.BREAKS] = block[at.FIRST_BREAK] = block[at.NEXT_BREAK] = size
    block[at.FUNCTION] = size + breaks.size
    block[at.PROJECTOR] = size + breaks.size + function.size if projector.address else 0
    vectors = block[at.VECTORS :][: at.VECTOR_ROWS * n].reshape(at.VECTOR_ROWS, n)
    vectors[at.STATE_OLD], vectors[at.TOLERANCES] = x, goal.atol
    block[at.TIME] = block[at.T_START] = t
    block[at.T_END], block[at.DIRECTION], block[at.RTOL] = goal.t_end, goal.direction, goal.rtol
    block[at.MAX_STEP], block[at.MAX_TRIALS] = goal.max_step, goal.max_trials
    block[at.STOP_WHEN_STIFF], block[at.FIRST_STEP] = goal.stop_when_stiff, first_step
    return block


def state_of(block: Floats) -> Floats:
    """Return the state x = (u, q) in a block, a view."""
    n = int(block[at.N])
    return block[at.VECTORS + at.STATE_OLD * n :][:n]


def method_numbers(tableau: Tableau, n: int) -> Floats:
    """Return a method for n states, not to be changed."""
    return _METHODS.get((tableau, n), lambda: _method_numbers(tableau, n))


def _method_numbers(tableau: Tableau, n: int) -> Floats:
    numbers = np.zeros(at.METHOD_SIZE)
    numbers[at.ORDER], numbers[at.STAGES] = tableau.order, tableau.stages
    numbers[at.STAGE_ROWS], numbers[at.DENSE_ROWS] = len(tableau.A), 4 + len(tableau.dense)
    numbers[at.ERROR_READS_END], numbers[at.SPLIT] = tableau.error_reads_end, tableau.split
    numbers[at.EXPONENT], numbers[at.MEMORY] = tableau.exponent, tableau.memory
    numbers[at.SHRINK], numbers[at.GROWTH] = tableau.shrink, tableau.growth
    numbers[at.STIFF_BOUND] = tableau.stiff_bound
    numbers[at.NODES : at.NODES + len(tableau.c)] = tableau.c
    entry = 0
    for row, weights in enumerate((*tableau.A, *tableau.error, *tableau.dense)):
        for stage, weight in enumerate(weights):
            if weight != 0.0:
                numbers[at.ENTRIES + 2 * entry :][:2] = stage * n, weight
                entry += 1
        numbers[at.ROWS + row + 1] = entry
    return numbers


def function_numbers(rhs: RightHandSide | Projector) -> Floats:
    """Return the numbers of a function and room for its scratch."""
    places = at.R_PLACE + np.cumsum([rhs.inputs.size, rhs.parameters.size, rhs.constants.size])
    head = np.zeros(at.R_PLACE)
    head[[at.P_PLACE, at.C_PLACE, at.WORK_PLACE]] = places
    parts = [head, rhs.inputs, rhs.parameters, rhs.constants, np.zeros(rhs.work_size)]
    if isinstance(rhs, RightHandSide) and rhs.tables.size:
        head[at.TABLES_PLACE] = places[-1] + rhs.work_size
        parts.append(rhs.tables)
    return np.concatenate(parts)


def _projection(projector: Projector) -> Floats:
    head, function = np.zeros(at.P_SCALES), function_numbers(projector)
    out = at.P_SCALES + projector.scales.size + projector.sizes.size
    head[[at.P_COORDINATES, at.P_RESIDUALS]] = projector.n_q, projector.scales.size
    head[[at.P_OUT, at.P_OUT_SIZE, at.P_FUNCTION]] = out, projector.out_size, out + projector.out_size
    head[[at.P_LIMIT, at.P_ROUNDING]] = projector.limit, projector.rounding
    return np.concatenate([head, projector.scales, projector.sizes, np.zeros(projector.out_size), function])
