"""`sweep`: the motions of a mechanism for many parameters and initial values."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.analysis.scales import Scales, mechanism_scales, scales_by_name
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.llvm import machine
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import modal_equations, permanent_equations
from symbody.errors import SymbodyError
from symbody.model.first_values import FirstValue, Initial, by_priority
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.inputs.fmu_input import FmuInput, check_fmu_inputs
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.inputs.input_laws import Law, input_laws, laws_of_tables, silent_input_note
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.explicit import check_span
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.motion import NOTHING, Motion
from symbody.simulation.native.run import Progress
from symbody.simulation.progress import show_progress
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.simulation.sweeps.case_table import Combine, Varied, case_table
from symbody.simulation.sweeps.first_states import check_names
from symbody.simulation.sweeps.loop_job import LoopJob, prepare_loop, serial_cases
from symbody.simulation.sweeps.records import CODES, NOT_ENDED, CaseDetails, Chunk, Records, Store
from symbody.simulation.sweeps.result import Sweep, sweep_result
from symbody.simulation.sweeps.sweep_job import (
    SweepJob,
    check_lanes,
    check_memory,
    compute_case,
    reason_for_simulate,
    sample_times,
)
from symbody.simulation.sweeps.workers import (
    PATIENCE,
    Listener,
    Workers,
    check_workers,
    compute_here,
    compute_there,
    cut_chunks,
)

# Lanes run empty at the end of a part: the more cases it has, the less that matters.
_LEAST_IN_LANES: Final = 4 * machine.lanes()


@named_after(3)
@checked_arguments
def sweep(
    eqs: EquationSet, t_end: float | tuple[float, float], parameters: Mapping[str, Varied] | None = None,
    initial: Mapping[str, Varied | Initial] | None = None, guess: Mapping[str, FirstValue] | None = None,
    inputs: Mapping[str, Law] | None = None, times: ArrayLike | None = None,
    integrator: Integrator | None = None, constraints: Constraints | None = None,
    events: Event | Sequence[Event] = (), *, combine: Combine = "product", samples: int | None = None,
    seed: int = 0, executor: Executor | None = None, threads: int | None = None, part: int | None = None,
    lanes: bool | None = None, store: str | os.PathLike[str] | None = None, key: str | None = None,
    rtol: float = 1e-8, atol: float | None = None, scales: Mapping[str, float] | None = None,
    max_steps: int = 1_000_000, progress: Progress | bool = False, patience: float = PATIENCE,
) -> Sweep:  # fmt: skip
    """Return the motions of a mechanism for many parameters and initial values.

    Results depend on the cases alone, bit for bit: not on threads, workers, parts or lanes. What is not
    listed here is as in `simulate`, the same for all cases.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    t_end : float or (t0, t_end)
        End time [s], or both ends.
    parameters, initial : mapping of name to number, formula, sequence of numbers, or `Samples`
        Sequences and samples vary from case to case; an `Initial` is the same in all cases.
    times : array, optional
        Samples to store [s], by default 101 over the span; ``[t_end]`` for final values alone.
    guess, inputs, integrator, constraints, events : optional
        As for `simulate`, the same for all cases.
    combine : "product" or "list"
        Every combination of all sequences, the last varying fastest; or the first values, the second, ...
    samples, seed : int
        How many values are drawn for each `Samples`, together, for every combination; and their seed.
    executor : concurrent.futures.Executor, optional
        Whose workers compute, by default threads of this process. Parts that workers lose are computed again.
    threads, part : int, optional
        Threads of this process, by default one a processor, with an executor of each worker, 1; cases a
        worker is given at a time.
    lanes : bool, optional
        Whether each thread computes several cases side by side, by default for 256 or more.
    store, key : path and str, optional
        A folder that keeps finished parts; the same call continues where the last one ended. `key` is a
        text for inputs that have no content to compare, such as objects of your classes.
    rtol, atol, scales, max_steps : optional
        As for `simulate`, the same for all cases.
    progress : bool or callable
        True shows a bar; a callable takes the share that is done, and ends the sweep by returning False.
    patience : float
        How long to wait until a worker of the executor begins anything [s]; ``math.inf`` for ever.

    Returns
    -------
    Sweep
        The motions: ``result["x"]`` are samples (cases, N) of an output, of vectors (cases, 3, N), in
        ``result.units["x"]`` and NaN where a motion did not get that far; ``result.t`` the times [s];
        ``result.cases`` the values that vary, (cases,) each; ``result.status`` how each ended,
        ``result.trajectory(3)`` one of them.

    Raises
    ------
    CompileError, AssemblyError, UsageError
        Names, values, times or an executor that make no sense, all of them listed.
    SimulationError, EnvironmentFault
        More samples than the memory holds; no worker that begins or can compute; a store that cannot be used.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> result = sb.sweep(eqs, 1.0, initial={"x": [0.1, 0.2, 0.3]}, times=[0, 1])
    >>> result["x"].shape, result.cases["x"]
    ((3, 2), array([0.1, 0.2, 0.3]))
    """
    span = check_span(t_end if isinstance(t_end, tuple) else (0.0, t_end))
    inputs = {**laws_of_tables(eqs), **(inputs or {})}
    check_fmu_inputs(inputs, eqs.input_names)
    fmus = [name for name, law in inputs.items() if isinstance(law, FmuInput)]
    sampled = held_later(eqs, fmus)  # by each case for itself
    laws = input_laws(eqs.input_names, {**inputs, **sampled}, span, len(eqs.coordinate_names))
    stored, wants_lanes, sizes = sample_times(times, span), check_lanes(lanes), scales_by_name(eqs, scales)
    workers = check_workers(executor, threads, part, patience)
    first = initial or {}
    own = {name: value for name, value in first.items() if isinstance(value, Initial)}
    varied = {name: value for name, value in first.items() if not isinstance(value, Initial)}
    fixed, near = by_priority(own, guess or {})
    fits = partial(check_memory, samples=stored.size, states=len(eqs.state_names))
    table = case_table(parameters or {}, {**varied, **fixed}, combine, samples, seed, fits)
    problem = SimulationProblem(eqs, table.fixed_parameters, laws, Scales(), free=table.parameter_names)
    rest = None, check_events(events, eqs), integrator, constraints
    motion = Motion(problem, NOTHING, span, stored, rtol, atol, int(max_steps), *rest)
    job = SweepJob(motion, table, near, inputs, wants_lanes, sizes)
    kept = None if store is None else Store(store, job.digest(key))
    with show_progress(progress, "sweep") as report:
        return _compute_sweep(job, workers, kept, report)


def _compute_sweep(job: SweepJob, workers: Workers, store: Store | None, progress: Progress | None) -> Sweep:
    """Return all motions: by the loop over many cases if it can compute them, else by `simulate`."""
    eqs, table = job.eqs, job.table
    records = Records.empty(0, table.count, job.times.size, job.state_size)
    keep = _ignore if store is None else store.keep
    reason = reason_for_simulate(eqs, job.laws, job.motion.integrator, job.motion.constraints)
    if reason:
        check_names(eqs, table, job.guess)
    else:
        loop, chunk, first_notes = prepare_loop(job)
        reason = _reason_of_branch(job, chunk)
    for finished in () if store is None else store.read_finished(records):
        records.put(finished)
    if reason:
        listener = Listener(progress, keep)
        cases = np.flatnonzero(records.codes == NOT_ENDED).tolist()
        where = _compute_by_simulate(job, cases, records, workers, listener)
        note = f"cases are computed one after the other {where}: {reason}"
        return sweep_result(job, records, (note, *job.laws.notes, *listener.notes))
    records.details.update({case: CaseDetails(note) for case, note in first_notes.items()})
    serial = serial_cases(eqs, table)
    chunk.states[serial] = np.nan

    def again() -> list[int]:
        return sorted({*serial, *_worth_another_try(job, records)})

    def share_of_loop(share: float) -> float:
        """Return the share of all cases: those that are computed again come behind the loop."""
        more = len(again())
        if share >= 1.0 and (records.codes == NOT_ENDED).any():
            more = max(more, 1)  # how the last one ended shows at the next look
        return share * records.count / (records.count + more)

    listener = Listener(_rescale_progress(progress, share_of_loop), keep)
    if not _compute_in_loop(loop, chunk, records, workers, listener):
        cases = again()
        done = table.count / (table.count + len(cases))
        report = _rescale_progress(progress, lambda share: done + share * (1.0 - done))
        second = Listener(report, _ignore, listener.notes)
        _compute_by_simulate(job, cases, records, workers, second, has_results=True)
        if progress is not None:
            progress(1.0)
    return sweep_result(job, records, (*_notes(job, serial), *listener.notes))


def _rescale_progress(progress: Progress | None, scale: Callable[[float], float]) -> Progress | None:
    """Return what reports shares of a part of the work as shares of all."""
    return None if progress is None else lambda share: progress(scale(share))


def _compute_by_simulate(
    job: SweepJob, cases: Sequence[int], records: Records, workers: Workers, listener: Listener,
    *, has_results: bool = False,
) -> str:  # fmt: skip
    """Compute cases by `simulate`, by the workers of an executor if there are any; return where."""
    if workers.executor is not None and cases and _is_portable(job):
        chunks = cut_chunks(Chunk.blank(records.count), _runs(cases), workers.part)
        compute_there(job, chunks, records, workers, listener, has_results=has_results)
        return "by the workers"
    try:
        for count, case in enumerate(cases):
            if listener.progress is not None and listener.progress(count / len(cases)) is False:
                break
            row = records.cut(case, case + 1)
            compute_case(job, case, row)
            if row.codes[0] == CODES[Status.INTERRUPTED]:
                break
            listener.on_chunk(row)
    except KeyboardInterrupt:
        pass
    return "in this process"


def _is_portable(job: SweepJob) -> bool:
    """Return whether workers can receive a sweep: functions of a script, as inputs, they cannot."""
    try:
        return bool(pickle.dumps(job))
    except (AttributeError, TypeError, pickle.PicklingError):
        return False


def _compute_in_loop(
    loop: LoopJob, chunk: Chunk, records: Records, workers: Workers, listener: Listener
) -> bool:
    """Compute all cases that have not ended; return whether it was interrupted."""
    missing = _runs(np.flatnonzero(records.codes == NOT_ENDED).tolist())
    chunks = cut_chunks(chunk, missing, workers.part, _LEAST_IN_LANES if loop.lanes else 1)
    if workers.executor is None:
        return compute_here(loop, chunks, records, workers.threads, listener)
    return compute_there(loop, chunks, records, workers, listener)


def _ignore(records: Records) -> None:
    """Keep nothing."""


def _runs(cases: Sequence[int]) -> list[tuple[int, int]]:
    """Return the ends of all runs of consecutive cases."""
    numbers = np.array(cases, dtype=np.int64)
    groups = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return [(int(group[0]), int(group[-1]) + 1) for group in groups if group.size]


def _reason_of_branch(job: SweepJob, chunk: Chunk) -> str:
    """Return why the loop over many cases may leave the branches of motions, empty if it does not."""
    eqs = permanent_equations(job.eqs)
    started = np.flatnonzero(np.isfinite(chunk.states).all(axis=1)).tolist()
    if not eqs.multiplier_names or not started:
        return ""
    case, x = started[0], chunk.states[started[0]]
    values = job.table.values(case)[0]
    q = dict(zip(eqs.coordinate_names, x[len(eqs.speed_names) :].tolist(), strict=False))
    scales = mechanism_scales(job.eqs, values, job.scales, q).fit_span(*job.motion.span)
    problem = SimulationProblem(eqs, values, job.laws, scales)
    try:
        if is_overconstrained(problem, job.motion.span[0], x):
            return "some constraints are redundant only where all loops are closed"
        notes = job.simulate_case(case).notes
    except SymbodyError:
        return ""
    if any("(change point)" in note or "is a change point" in note for note in notes):
        return "motions pass change points, where the shared loop may continue on another branch"
    return ""


def _worth_another_try(job: SweepJob, records: Records) -> list[int]:
    """Return cases that `simulate` integrates by another method than the loop over many cases."""
    failed = [Status.STIFF]
    if modal_equations(job.eqs).eqs.multiplier_names and job.motion.constraints is None:
        failed += [Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE]
    return np.flatnonzero(np.isin(records.codes, [CODES[status] for status in failed])).tolist()


def _notes(job: SweepJob, serial: Sequence[int]) -> tuple[str, ...]:
    silent = sorted(set(job.eqs.input_names).difference(job.inputs, job.laws.callbacks))
    notes = [*job.laws.notes, *(silent_input_note(job.eqs.units, name) for name in silent)]
    if permanent_equations(job.eqs).multiplier_names and job.motion.constraints is None:
        notes.append(
            "sweeps do not search for change points: if constraints become dependent during the motion, "
            "pass constraints=sb.Partition()"
        )
    if serial:
        notes.append(
            f"{len(serial)} cases, whose values satisfy a constraint identically, were computed one by one"
        )
    return tuple(notes)
