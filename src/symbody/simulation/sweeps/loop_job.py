"""Code and first states for the loop over many cases."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.rounding_rows import RoundingRows
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import modal_equations
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.simulation.events.event_functions import EventFunctions, gap_events
from symbody.simulation.events.events import GapEvent, ModeEnd
from symbody.simulation.events.watch_arrays import with_cut_fit
from symbody.simulation.hybrid.mode_record import ModalElements, modal_elements, mode_words
from symbody.simulation.hybrid.switching import SwitchingModes, check_backwards, loose_modes
from symbody.simulation.inputs.breakpoints import Breakpoints, search_ahead
from symbody.simulation.inputs.tables import Table
from symbody.simulation.inputs.time_functions import TimeFunctions, time_functions
from symbody.simulation.methods.constraints import (
    PROJECTED,
    Baumgarte,
    Projection,
    make_projector,
    residual_share,
)
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT
from symbody.simulation.native.description import Projector, RightHandSide
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.simulation.sweeps.first_states import case_values, first_states
from symbody.simulation.sweeps.records import Chunk
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]

# Cases from which on several are computed side by side.
CASES_THAT_PAY: Final = 256


@dataclass(frozen=True, slots=True, eq=False)
class CaseHappenings:
    """What may happen in a case beside smooth motion.

    Attributes
    ----------
    watch, modes : arrays
        The `EventMonitor` and the `ModeSwitch` of a motion that has not begun; zeros where there is none.
    labels : tuple of str
        Names of the events, those that end modes last.
    events : int
        How many are the caller's.
    elements : ModalElements
        What has modes.
    inputs : tuple of str
        The inputs that are modes.
    words : tuple of str
        What a change of a mode is called, as `mode_words` lists them.
    """

    watch: Floats = field(default_factory=lambda: np.zeros(EventMonitor.size))
    modes: Floats = field(default_factory=lambda: np.zeros(ModeSwitch.size))
    labels: tuple[str, ...] = ()
    events: int = 0
    elements: ModalElements = ModalElements()
    inputs: tuple[str, ...] = ()
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class LoopJob:
    """A sweep for the compiled loop over many cases.

    Attributes
    ----------
    functions : tuple of CompiledFunction or None
        With what varies as their arguments p: the derivative, with the power behind it where anything may
        happen; what projects; the values of events, their actions and what closes states; what decides about
        modes, and what projects speeds there.
    rhs, projector : RightHandSide and Projector
        The first two with the numbers of the first case.
    times : (N,) array
        The samples to store.
    lanes : bool
        Whether several cases are computed side by side; results do not depend on it.
    tables : mapping of place to Table
        The inputs r of the derivative that are tables: all of them, but for modes behind them.
    happens : CaseHappenings
        Events and modes.
    state_names : tuple of str
        Speeds, coordinates, states of signals.
    breakpoints : tuple of Breakpoints or None
        Of all cases the same, or to be found for each from its parameters.
    """

    functions: tuple[CompiledFunction | None, ...]
    rhs: RightHandSide
    projector: Projector
    span: tuple[float, float]
    times: Floats
    method: Explicit | FixedStep
    rtol: float
    max_steps: int
    stop_when_stiff: bool
    lanes: bool
    tables: Mapping[int, Table]
    happens: CaseHappenings
    state_names: tuple[str, ...]
    breakpoints: tuple[Breakpoints, ...] | None = None

    @property
    def state_size(self) -> int:
        """Number of speeds, coordinates and states of signals."""
        return len(self.state_names)

    @property
    def derivative(self) -> CompiledFunction:
        """The first of the functions."""
        assert self.functions[0] is not None
        return self.functions[0]

    def functions_of_time(self, *, with_parameters: bool) -> list[TimeFunctions | None]:
        """Return what the derivative and the values of events compute from time, and perhaps what varies."""
        read = [function.sequence for function in self.functions[:3:2] if function is not None]
        return [time_functions(each, self.tables, with_parameters=with_parameters) for each in read]


def prepare_loop(sweep: SweepJob) -> tuple[LoopJob, Chunk, dict[int, str]]:
    """Return code and numbers for the loop over many cases, and why some cannot start.

    All of it is that of one motion whose numbers are those of many: `simulate` makes the same. Raises
    CompileError, AssemblyError if parameters have no value, or names are unknown; UsageError if an event does
    not watch a number.
    """
    table, motion, modal = sweep.table, sweep.motion, modal_equations(sweep.eqs)
    constraints, span = motion.constraints, motion.span
    first = first_states(sweep.eqs, table, sweep.guess, sweep.laws.formulas, span, sweep.scales)
    source = replace(motion.problem, scales=first.scales, p=table.parameters)
    laws = sweep.laws.with_held(loose_modes(modal))
    problem = moving = replace(source, eqs=modal.eqs, laws=laws)
    if isinstance(constraints, Baumgarte):
        moving = replace(problem, eqs=constraints.applied(modal.eqs))
    modes, events = None, (*motion.events, *gap_events(source, motion.integrator))
    if modal.modes:
        check_backwards(span)
        modes = SwitchingModes(replace(source, scales=first.scales.of_motion(0)))
        events = (*events, *modes.ends)
    projection = constraints if isinstance(constraints, Projection) else Projection()
    watch = EventFunctions(moving, events, residual_share(projection, motion.atol)) if events else None
    method = motion.integrator if isinstance(motion.integrator, Explicit | FixedStep) else DEFAULT
    derivative = moving.compile_outputs(("xdot", "power") if events else "xdot")
    nothing = np.zeros((table.count, 0))
    projecting, projector, closed = None, NOTHING_TO_PROJECT, (nothing, nothing)
    if problem.is_closed and not isinstance(constraints, Baumgarte):
        projecting, made = _projection(problem, projection, motion.atol)
        closed = made.scales, made.sizes
        projector = made._replace(scales=made.scales[0], sizes=made.sizes[0])
    if isinstance(method, FixedStep):
        projector = projector._replace(limit=math.inf)
    states = np.nan_to_num(first.states)
    tolerances = first.scales.tolerances(modal.eqs, states, motion.atol)
    if events:
        tolerances = np.column_stack([tolerances, _work_tolerances(source, sweep, states)])
    sizes = (tolerances, *closed, nothing, nothing)
    if watch is not None and watch.functions[-1] is not None:
        sizes = (*sizes[:3], watch.metric, nothing)
    if modes is not None:  # lengths, times, displacements that count as large
        large: Any = first.scales.length, first.scales.time, first.scales.displacements(sweep.eqs)
        sizes = (*sizes[:4], np.column_stack(large))
    job = LoopJob(
        (
            derivative,
            projecting,
            *((None, None, None) if watch is None else watch.functions),
            *((None, None) if modes is None else modes.functions),
        ),
        moving.numbers(derivative),
        projector,
        span,
        sweep.times,
        method,
        motion.rtol,
        motion.max_steps,
        stop_when_stiff=motion.integrator is None,
        lanes=table.count >= CASES_THAT_PAY if sweep.lanes is None else sweep.lanes,
        tables=sweep.laws.tables,
        happens=_happenings(watch, modes, method, span),
        state_names=sweep.eqs.state_names,
    )
    job = replace(job, breakpoints=_breakpoints(job))
    return job, Chunk(0, first.states, table.parameters, sizes), dict(first.notes)


def _projection(
    problem: SimulationProblem, method: Projection, atol: float | None
) -> tuple[CompiledFunction, Projector]:
    """Return what projects, with the scales and sizes of all cases."""
    function = problem.compile_outputs(PROJECTED)
    numbers = problem.numbers(function)
    made = make_projector(function, problem.eqs, problem.scales, method, atol, numbers.constants)
    return function, made._replace(inputs=numbers.inputs, parameters=numbers.parameters)


def _happenings(
    watch: EventFunctions | None, modes: SwitchingModes | None, method: Explicit | FixedStep,
    span: tuple[float, float],
) -> CaseHappenings:  # fmt: skip
    if watch is None:
        return CaseHappenings()
    rows = 4 + len(method.tableau.dense)
    block = with_cut_fit(watch.make_block(abs(span[1] - span[0])), rows)
    monitor = EventMonitor(block)
    monitor.piece_rows, monitor.direction = rows, 1.0 if span[1] >= span[0] else -1.0
    monitor.first_length = float(method.first_step or 0.0)
    labels, own = tuple(event.label for event in watch.events), watch.events
    events = sum(not isinstance(event, ModeEnd | GapEvent) for event in own)
    if modes is None:
        return CaseHappenings(block, labels=labels, events=events)
    modes.prepare(block)
    elements = modal_elements(modes.modal)
    words = mode_words(elements)
    return CaseHappenings(block, modes.snapshot(), labels, events, elements, modes.modal.modes, words)


def _work_tolerances(problem: SimulationProblem, sweep: SweepJob, x: Floats) -> Floats:
    """Return how large a local error of the work may be in each case, as `integration.work_tolerance`."""
    n_u, start = len(sweep.eqs.speed_names), np.full(len(x), sweep.motion.span[0])
    energies = problem.compile_outputs("kinetic_energy", quick=True)
    kinetic = problem.evaluate(energies, start, x[:, n_u:].T, x[:, :n_u].T)
    usual = CLOSED * problem.scales.energy if sweep.motion.atol is None else sweep.motion.atol
    largest = np.maximum(usual, sweep.motion.rtol * np.broadcast_to(kinetic, start.shape))
    return np.minimum(largest, sys.float_info.max)


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
