"""Code and first states for the loop over many cases."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.rounding_rows import RoundingRows
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations, modal_equations
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.events.event_functions import (
    action_outputs,
    check_action_shapes,
    check_value_shapes,
    numbers_of_events,
)
from symbody.simulation.events.events import Event
from symbody.simulation.hybrid.switching import (
    check_backwards,
    deciding_outputs,
    mode_block,
    mode_ends,
)
from symbody.simulation.inputs.breakpoints import Breakpoints, search_ahead
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
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.closing import closing_of, metric
from symbody.simulation.simulation_problem import OutputName
from symbody.simulation.sweeps.case_scales import case_values
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.first_states import first_states
from symbody.simulation.sweeps.records import CaseModes, CaseWatch, Chunk, LoopJob
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.simulation.sweeps.watched_cases import case_function, case_numbers
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]

# Cases from which on several are computed side by side.
CASES_THAT_PAY: Final = 256


def prepare_loop(sweep: SweepJob) -> tuple[LoopJob, Chunk, dict[int, str]]:
    """Return code and numbers for the loop over many cases, and why some cannot start.

    Raises
    ------
    CompileError, AssemblyError
        If parameters have no value, or names are unknown.
    UsageError
        If an event does not watch a number.
    """
    table, laws, motion, modal = sweep.table, sweep.laws, sweep.motion, modal_equations(sweep.eqs)
    constraints, span, eqs = motion.constraints, motion.span, modal.eqs
    first = first_states(sweep.eqs, table, sweep.guess, laws.formulas, span, sweep.scales)
    stabilized = constraints.applied(eqs) if isinstance(constraints, Baumgarte) else eqs
    values = table.fixed_parameters, table.parameter_names, laws.formulas
    events = (*motion.events, *mode_ends(modal))
    function = bound_function(stabilized, ("xdot", "power") if events else "xdot", *values)
    projection = constraints if isinstance(constraints, Projection) else Projection()
    tolerance = residual_share(projection, motion.atol)
    watch = case_watch(stabilized, events, tolerance, *values) if events else None
    method = motion.integrator if isinstance(motion.integrator, Explicit | FixedStep) else DEFAULT
    closing, scales, sizes = None, np.zeros((table.count, 0)), np.zeros((table.count, 0))
    rounding, limit = 0.0, np.inf
    if (eqs.multiplier_names or eqs.quaternions) and not isinstance(constraints, Baumgarte):
        closing = bound_function(eqs, PROJECTED, *values)
        scales = np.ones((table.count, closing.outputs[0].shape[0]))  # norms of quaternions come last
        scales[:, : len(eqs.formed.holonomic)] = first.scales.constraints(eqs)[:, : len(eqs.formed.holonomic)]
        scales, sizes = tolerance * scales, first.scales.coordinates(eqs)
        rounding = ROUNDED_PER_COORDINATE * len(eqs.coordinate_names) * EPSILON / tolerance
        limit = np.inf if isinstance(method, FixedStep) else projection.limit
    modes, mode_sizes = None, np.zeros((table.count, 0))
    if modal.modes:
        check_backwards(span)
        modes, mode_sizes = _case_modes(sweep, modal, first.scales), _mode_sizes(sweep.eqs, first.scales)
    job = LoopJob(
        function,
        closing,
        span,
        sweep.times,
        method,
        motion.rtol,
        motion.max_steps,
        stop_when_stiff=motion.integrator is None and modes is None,
        lanes=table.count >= CASES_THAT_PAY if sweep.lanes is None else sweep.lanes,
        rounding=rounding,
        limit=limit,
        tables=laws.tables,
        watch=watch,
        modes=modes,
    )
    job = replace(job, breakpoints=_breakpoints(job))
    states = np.nan_to_num(first.states)
    tolerances, own_metric = first.scales.tolerances(eqs, states, motion.atol), np.zeros((table.count, 0))
    if watch is not None:
        energies = bound_function(sweep.eqs, "kinetic_energy", *values, quick=True)
        tolerances = np.column_stack([tolerances, _work_tolerances(energies, sweep, states, first.scales)])
    if watch is not None and watch.closing is not None:
        own_metric = metric(closing_of(stabilized, holds=watch.actions is not None).eqs, first.scales)
    chunk = Chunk(0, first.states, table.parameters, scales, sizes, tolerances, own_metric, mode_sizes)
    return job, chunk, dict(first.notes)


def case_watch(
    eqs: EquationSet,
    events: Sequence[Event],
    share: float,
    parameters: Mapping[str, Value],
    free: Sequence[str],
    inputs: Mapping[str, Value],
) -> CaseWatch:
    """Return what is watched in all cases; constraints that are open by a share are closed after actions.

    Raises
    ------
    UsageError
        If a value is not a number.
    """
    values = bound_function(eqs, [str(event.expression) for event in events], parameters, free, inputs)
    outputs = action_outputs(events)
    actions = bound_function(eqs, outputs, parameters, free, inputs) if outputs else None
    check_value_shapes(events, values.outputs)
    check_action_shapes(events, actions.outputs[1:-1] if actions else ())
    labels = tuple(event.label for event in events)
    closing, close = None, closing_of(eqs, holds=bool(outputs))
    if close.is_needed and any(event.action != "record" for event in events):
        closing = bound_function(close.eqs, close.outputs, parameters, free, inputs)
    return CaseWatch(
        values, actions, labels, numbers_of_events(eqs, events, values), eqs.state_names,
        closing, close.shape, share,
    )  # fmt: skip


def _case_modes(sweep: SweepJob, modal: ModalEquations, scales: Scales) -> CaseModes:
    """Return what decides about modes; sizes in its block are those of the first case."""
    table, laws = sweep.table, sweep.laws
    values = table.fixed_parameters, table.parameter_names, laws.formulas
    deciding = bound_function(sweep.eqs, _flat(deciding_outputs(modal)), *values)
    projecting = bound_function(modal.eqs, PROJECTED, *values)
    sized = [
        (case_numbers(function, table.parameters[:1]), sum(len(output.values) for output in function.outputs))
        for function in (deciding, projecting)
    ]
    count = len(laws.tables)
    block = mode_block(
        modal, sweep.eqs, scales.of_motion(0), count,
        (function_numbers(case_function(deciding, sized[0][0], count, laws.tables)), sized[0][1]),
        (function_numbers(case_function(projecting, sized[1][0], count + len(modal.modes))), sized[1][1]),
    )  # fmt: skip
    ModeSwitch(block).first_event = len(sweep.motion.events)
    return CaseModes(deciding, projecting, block, modal.modes, modal.joints, modal.ropes)


def _flat(outputs: Sequence[OutputName]) -> list[str]:
    """Return all names of outputs: one function computes them, in this order, combined or not."""
    return [name for each in outputs for name in ((each,) if isinstance(each, str) else each)]


def _mode_sizes(eqs: EquationSet, scales: Scales) -> Floats:
    """Return what counts as large where modes are decided: lengths, times, displacements of all cases."""
    return np.column_stack([scales.length, scales.time, scales.displacements(eqs)])


def _work_tolerances(energies: CompiledFunction, sweep: SweepJob, x: Floats, scales: Scales) -> Floats:
    """Return how large a local error of the work may be in each case, as `integration.work_tolerance`."""
    n_u, start = len(sweep.eqs.speed_names), np.full(len(x), sweep.motion.span[0])
    q, u = x[:, n_u:], x[:, :n_u]
    inputs = sweep.laws.values(start, q.T, u.T)
    kinetic = np.broadcast_to(energies(start, q, u, inputs, sweep.table.parameters), start.shape)
    usual = CLOSED * scales.energy if sweep.motion.atol is None else sweep.motion.atol
    return np.minimum(np.maximum(usual, sweep.motion.rtol * kinetic), sys.float_info.max)


def _breakpoints(job: LoopJob) -> tuple[Breakpoints, ...] | None:
    """Return the breakpoints of all cases, None if they follow from what varies; see `LoopJob`."""
    every = job.functions_of_time(with_parameters=True)
    if any(functions is not None and functions.needs_parameters() for functions in every):
        return None
    pieces = search_ahead(job.functions_of_time(with_parameters=False), job.span)[0]
    return (pieces.jumps_alone() if isinstance(job.method, FixedStep) else pieces,)


def _no_rows(values: Mapping[str, float]) -> tuple[bool, ...]:
    return ()


def serial_cases(eqs: EquationSet, table: CaseTable) -> list[int]:
    """Return the cases whose values fulfil constraints that others do not; `simulate` treats these.

    A constraint that is zero but for rounding at some values of the parameters would be taken for one.
    """
    has_divisors = bool(eqs.formed.coupled.divisors)
    if not table.parameter_names or not (eqs.multiplier_names or has_divisors):
        return []
    names = eqs.parameter_names
    columns = case_values(eqs, table, {name: name for name in names})
    rows = np.stack([columns[name] for name in names], axis=1)
    varied = {name for k, name in enumerate(names) if (rows[:, k] != rows[0, k]).any()}
    known = {name: float(rows[0, k]) for k, name in enumerate(names) if name not in varied}
    check_parameter_constraints(eqs.formed, known)
    rounding = _no_rows
    if eqs.multiplier_names:
        rounding = eqs.plans.get("rounding rows", lambda: RoundingRows(eqs))
    usual = rounding(known)
    different, place = np.unique(rows, axis=0, return_inverse=True)
    is_apart = []
    for row in different.tolist():
        values = dict(zip(names, row, strict=True))
        check_parameter_constraints(eqs.formed, values)
        is_apart.append(rounding(values) != usual)
    return np.flatnonzero(np.array(is_apart)[np.ravel(place)]).tolist()
