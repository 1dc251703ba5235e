"""Code and first states for the loop over many cases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.rounding_rows import RoundingRows
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, find_breakpoints
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.methods.constraints import (
    PROJECTED,
    ROUNDED_PER_COORDINATE,
    Baumgarte,
    Projection,
    residual_share,
)
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT
from symbody.simulation.sweeps.case_scales import case_values
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.first_states import first_states
from symbody.simulation.sweeps.records import Chunk, LoopJob
from symbody.simulation.sweeps.sweep_job import MotionOptions

Floats = NDArray[np.float64]

# Cases from which on several are computed side by side.
CASES_THAT_PAY: Final = 256


def prepare_loop(
    eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value], laws: InputLaws, options: MotionOptions
) -> tuple[LoopJob, Chunk, dict[int, str]]:
    """Return code and numbers for the loop over many cases, and why some cannot start.

    Raises
    ------
    CompileError, AssemblyError
        If parameters have no value, or names are unknown.
    """
    constraints = options.constraints
    first = first_states(eqs, table, guess, laws.formulas, options.span, options.scales)
    stabilized = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
    values = table.fixed_parameters, table.parameter_names, laws.formulas
    function = bound_function(stabilized, "xdot", *values)
    method = options.integrator if isinstance(options.integrator, Explicit | FixedStep) else DEFAULT
    closing, scales, sizes = None, np.zeros((table.count, 0)), np.zeros((table.count, 0))
    rounding, limit = 0.0, np.inf
    if (eqs.multiplier_names or eqs.quaternions) and not isinstance(constraints, Baumgarte):
        projection = constraints if isinstance(constraints, Projection) else Projection()
        tolerance = residual_share(projection, options.atol)
        closing = bound_function(eqs, PROJECTED, *values)
        own_scales = first.scales.constraints()
        scales = np.ones((table.count, closing.outputs[0].shape[0]))  # norms of quaternions come last
        scales[:, : own_scales.shape[1]] = own_scales
        scales, sizes = tolerance * scales, first.scales.coordinates()
        rounding = ROUNDED_PER_COORDINATE * len(eqs.coordinate_names) * EPSILON / tolerance
        limit = np.inf if isinstance(method, FixedStep) else projection.limit
    job = LoopJob(
        function,
        closing,
        options.span,
        options.times,
        method,
        options.rtol,
        options.max_steps,
        stop_when_stiff=options.integrator is None,
        lanes=table.count >= CASES_THAT_PAY if options.lanes is None else options.lanes,
        breakpoints=_breakpoints(function, method, options.span, laws.tables),
        rounding=rounding,
        limit=limit,
        tables=laws.tables,
    )
    tolerances = first.scales.tolerances(first.states, options.atol)
    chunk = Chunk(0, first.states, table.parameters, scales, sizes, tolerances)
    return job, chunk, dict(first.notes)


def _breakpoints(
    function: CompiledFunction,
    method: Explicit | FixedStep,
    span: tuple[float, float],
    tables: Mapping[int, Table],
) -> tuple[Breakpoints, ...] | None:
    """Return the breakpoints of all cases, None if they follow from what varies; see `LoopJob`."""
    varied = time_functions(function.sequence, tables, with_parameters=True)
    if varied is not None and varied.needs_parameters():
        return None
    functions = time_functions(function.sequence, tables)
    if functions is None:
        return (NO_BREAKPOINTS,)
    pieces = find_breakpoints(functions, span)
    return tuple(own.jumps_alone() if isinstance(method, FixedStep) else own for own in pieces)


def cases_apart(eqs: EquationSet, table: CaseTable) -> list[int]:
    """Return the cases whose values fulfil constraints that others do not; `simulate` treats these.

    A constraint that is zero but for rounding at some values of the parameters would be taken for one.
    """
    if not (eqs.multiplier_names and table.parameter_names):
        return []
    names = eqs.parameter_names
    columns = case_values(eqs, table, {name: name for name in names})
    rows = np.stack([columns[name] for name in names], axis=1)
    varied = {name for k, name in enumerate(names) if (rows[:, k] != rows[0, k]).any()}
    known = {name: float(rows[0, k]) for k, name in enumerate(names) if name not in varied}
    check_parameter_constraints(eqs.formed, known)
    rounding: RoundingRows = eqs.plans.get("rounding rows", lambda: RoundingRows(eqs))
    usual = rounding(known)
    different, place = np.unique(rows, axis=0, return_inverse=True)
    is_apart = []
    for row in different.tolist():
        values = dict(zip(names, row, strict=True))
        check_parameter_constraints(eqs.formed, values)
        is_apart.append(rounding(values) != usual)
    return np.flatnonzero(np.array(is_apart)[np.ravel(place)]).tolist()
