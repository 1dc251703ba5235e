"""`sweep`: the motions of a mechanism for many parameters and initial values."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.analysis.scales import mechanism_scales
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value, form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import SymbodyError
from symbody.simulation.events.events import Event, checked_events
from symbody.simulation.inputs.input_laws import InputLaws, Law, input_laws
from symbody.simulation.methods.change_point import is_overconstrained
from symbody.simulation.methods.explicit import checked_span
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.native import places
from symbody.simulation.native.lanes.arithmetic import WIDTH
from symbody.simulation.native.run import VERDICTS, Progress
from symbody.simulation.progress import show_progress
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulate import simulate
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.simulation.sweeps.case_table import CaseTable, Combine, Varied, case_table
from symbody.simulation.sweeps.evaluation import Evaluation
from symbody.simulation.sweeps.first_states import check_names
from symbody.simulation.sweeps.job import NOT_ENDED, NOT_STARTED, WORKER_LOST, Job, Part, Records
from symbody.simulation.sweeps.plan import Wish, cases_apart, check_memory, planned, state_of
from symbody.simulation.sweeps.result import Sweep
from symbody.simulation.sweeps.single import OTHERS, compute_single, why_single
from symbody.simulation.sweeps.store import Store, digest
from symbody.simulation.sweeps.workers import (
    PATIENCE,
    Crew,
    Listener,
    Tally,
    compute_here,
    compute_there,
    crew,
    parts,
)

# Lanes run empty at the end of a part: the more cases it has, the less that matters.
_LEAST_IN_LANES: Final = 4 * WIDTH


@checked_arguments
def sweep(
    eqs: EquationSet, t_end: float | tuple[float, float], parameters: Mapping[str, Varied] | None = None,
    initial: Mapping[str, Varied] | None = None, guess: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Law] | None = None, times: ArrayLike | None = None,
    integrator: Integrator | None = None, constraints: Constraints | None = None,
    events: Event | Sequence[Event] = (), *, combine: Combine = "product", samples: int | None = None,
    seed: int = 0, executor: Executor | None = None, threads: int | None = None, part: int | None = None,
    lanes: bool | None = None, store: str | os.PathLike[str] | None = None, rtol: float = 1e-8,
    atol: float | None = None, scales: Mapping[str, float] | None = None, max_steps: int = 1_000_000,
    progress: Progress | bool = False, patience: float = PATIENCE,
) -> Sweep:  # fmt: skip
    """Return the motions of a mechanism for many parameters and initial values.

    Results depend on the cases alone, bit for bit: not on threads, workers, parts or lanes. What is not
    listed here is as in `simulate`, the same for all cases.

    Parameters
    ----------
    parameters, initial : mapping of name to number, formula, sequence of numbers, or `Samples`
        Sequences and samples vary from case to case.
    times : array, optional
        Samples to store [s], by default 101 over the span; ``[t_end]`` for final values alone.
    combine : "product" or "list"
        Every combination of all sequences, the last varying fastest; or the first values, the second, ...
    samples, seed : int
        How many values are drawn for each `Samples`, together, for every combination; what they follow from.
    executor : concurrent.futures.Executor, optional
        Whose workers compute, by default threads of this process. What workers lose is given out anew.
    threads : int, optional
        Threads of this process, by default one a processor; with an executor those of each worker, 1.
    part : int, optional
        Cases a worker is given at a time.
    lanes : bool, optional
        Whether each thread computes several cases side by side, by default for 256 or more.
    store : path, optional
        A folder that keeps finished parts; the same call goes on where the last one ended.
    progress : bool or callable
        True shows a bar; a callable is told the share that is done, and ends the sweep by returning False.
    patience : float
        How long to wait until a worker of the executor begins anything [s]; ``math.inf`` for ever.

    Raises
    ------
    CompileError, AssemblyError, UsageError
        Names, values, times or an executor that make no sense, all of them listed.
    SimulationError, EnvironmentFault
        More samples than the memory holds; no worker that begins or can compute, or a store that cannot be
        used.
    """
    span = checked_span(t_end if isinstance(t_end, tuple) else (0.0, t_end))
    laws = input_laws(eqs.input_names, inputs or {}, span)
    wish = Wish.checked(span, times, integrator, constraints, (rtol, atol), max_steps, lanes, scales)
    who = crew(executor, threads, part, patience)
    check = partial(check_memory, samples=wish.times.size, states=len(eqs.state_names))
    table = case_table(parameters or {}, initial or {}, combine, samples, seed, check)
    order = _Order(eqs, table, dict(guess or {}), laws, dict(inputs or {}), wish, checked_events(events, eqs))
    with show_progress(progress, "sweep") as listener:
        return order.carried_out(who, store, listener)


@dataclass(frozen=True, slots=True, eq=False)
class _Order:
    """A sweep that was asked for."""

    eqs: EquationSet
    table: CaseTable
    guess: Mapping[str, Value]
    laws: InputLaws
    inputs: Mapping[str, Law]
    wish: Wish
    events: tuple[Event, ...]

    def carried_out(
        self, who: Crew, store: str | os.PathLike[str] | None, progress: Progress | None
    ) -> Sweep:
        """Return the motions."""
        wish = self.wish
        records = Records.empty(0, self.table.count, wish.times.size, len(self.eqs.state_names))
        reason = why_single(self.eqs, self.laws, wish.integrator, wish.constraints, bool(self.events))
        if reason:
            check_names(self.eqs, self.table, self.guess)
            return self._one_by_one(records, reason, store, progress)
        job, part, case_notes = planned(self.eqs, self.table, self.guess, self.laws, wish)
        if self._is_overconstrained(part):
            reason = "some constraints follow from others only where all loops are closed"
            return self._one_by_one(records, reason, store, progress)
        if self._passes_change_point(part):
            reason = "motions pass change points, where this loop may take another branch"
            return self._one_by_one(records, reason, store, progress)
        apart = cases_apart(self.eqs, self.table)
        part.states[apart] = np.nan
        tally = _computed(job, part, records, who, store, progress)
        case_notes |= {case: f"lost: {why}" for case, why in tally.lost.items()}
        interrupted = tally.interrupted
        if not interrupted:
            again = sorted({*apart, *self._worth_another_try(records)})
            interrupted = self._singly(again, records, case_notes, None, lambda record: None)
        return self._result(records, case_notes, self._notes(case_notes, apart))

    def _one_by_one(
        self, records: Records, reason: str, store: str | os.PathLike[str] | None, progress: Progress | None
    ) -> Sweep:
        """Return motions of which each is computed by `simulate`, in this process."""
        kept = None
        if store is not None:
            kept = Store(store, self._digest())
            for found in kept.finished(records):
                records.put(found)
        case_notes: dict[int, str] = {}
        cases = np.flatnonzero(records.codes == NOT_ENDED).tolist()
        keep = kept.keep if kept is not None else lambda record: None
        self._singly(cases, records, case_notes, progress, keep)
        note = f"cases are computed one after the other in this process: {reason}"
        return self._result(records, case_notes, (note, *self.laws.notes))

    def _singly(
        self,
        cases: Sequence[int],
        records: Records,
        case_notes: dict[int, str],
        progress: Progress | None,
        keep: Callable[[Records], None],
    ) -> bool:
        """Compute cases by `simulate`; return whether Ctrl-C ended it."""
        try:
            for count, case in enumerate(cases):
                if progress is not None and progress(count / len(cases)) is False:
                    return True
                own = records.cut(case, case + 1)
                compute_single(self._simulated, case, own, case_notes)
                if own.codes[0] == OTHERS + list(Status).index(Status.INTERRUPTED):
                    return True
                keep(own)
        except KeyboardInterrupt:
            return True
        return False

    def _simulated(self, case: int) -> Trajectory:
        wish = self.wish
        parameters, initial = self.table.values(case)
        return simulate(
            self.eqs,
            wish.span,
            initial,
            self.guess,
            parameters,
            self.inputs,
            wish.times,
            wish.integrator,
            wish.constraints,
            self.events,
            rtol=wish.rtol,
            atol=wish.atol,
            scales=wish.scales,
            max_steps=wish.max_steps,
        )

    def _is_overconstrained(self, part: Part) -> bool:
        if self.wish.constraints is not None or not self.eqs.multiplier_names:
            return False
        found = state_of(self.eqs, part)
        if found is None:
            return False
        case, first = found
        values, span = self.table.values(case)[0], self.wish.span
        scales = mechanism_scales(self.eqs, values, self.wish.scales, first.q).over(*span)
        problem = SimulationProblem(self.eqs, values, self.laws, scales)
        return is_overconstrained(problem, span[0], part.states[case])

    def _passes_change_point(self, part: Part) -> bool:
        """Return whether the motion of the first case that starts meets a change point."""
        found = state_of(self.eqs, part) if self.eqs.multiplier_names else None
        if found is None:
            return False
        try:
            run = self._simulated(found[0])
        except SymbodyError:
            return False
        return any("(change point)" in note or "is a change point" in note for note in run.notes)

    def _worth_another_try(self, records: Records) -> list[int]:
        """Return cases that `simulate` integrates by another method than the loop over many cases."""
        codes = [places.STIFF]
        if self.eqs.multiplier_names and self.wish.constraints is None:
            codes += [places.COLLAPSED, places.SINGULAR, places.NOT_FINITE]
        return np.flatnonzero(np.isin(records.codes, codes)).tolist()

    def _digest(self) -> str:
        """Return what stands for all that results depend on."""
        eqs, table = self.eqs, self.table
        function = CompiledFunction(
            *form_sequence(eqs, "xdot", table.fixed_parameters, table.parameter_names), quick=True
        )
        about = hashlib.sha256(function.source("c").encode())
        for array in (table.parameters, table.initial, self.wish.times):
            about.update(array.tobytes())
        choices = (
            self.wish.span,
            self.wish.integrator,
            self.wish.constraints,
            self.wish.rtol,
            self.wish.atol,
            sorted(self.wish.scales.items()),
        )
        fixed = (table.fixed_initial, self.guess, self.events, self.wish.max_steps)
        about.update(repr((table.parameter_names, table.initial_names, *choices, *fixed)).encode())
        about.update(repr(sorted(self.laws.formulas.items())).encode())
        about.update(repr(sorted(self.laws.asked)).encode())
        return about.hexdigest()

    def _notes(self, case_notes: Mapping[int, str], apart: Sequence[int]) -> tuple[str, ...]:
        notes = list(self.laws.notes)
        silent = sorted(set(self.eqs.input_names).difference(self.inputs))
        notes += [f"input {name} has no value and is 0" for name in silent]
        if self.eqs.multiplier_names and self.wish.constraints is None:
            notes.append(
                "change points are not looked for in a sweep: where constraints become dependent on the way, "
                "pass constraints=sb.Partition()"
            )
        if apart:
            notes.append(f"{len(apart)} cases, whose values fulfil a constraint, were computed one by one")
        return tuple(notes)

    def _result(self, records: Records, case_notes: Mapping[int, str], notes: tuple[str, ...]) -> Sweep:
        eqs = self.eqs
        codes = records.codes.tolist()
        verdicts = {code: _status(code) for code in {*codes}}
        told = {**_stop_notes(records, eqs.state_names), **case_notes}
        return Sweep(
            self.wish.times,
            np.moveaxis(records.x, 1, 2),
            self.table.columns(),
            tuple(verdicts[code] for code in codes),
            records.counts[:, [places.ACCEPTED, places.REJECTED, places.EVALUATIONS, places.SAMPLES]],
            records.reached,
            Evaluation(eqs, self.table, self.laws),
            eqs.coordinate_names,
            eqs.speed_names,
            dict(sorted(told.items())),
            notes,
            eqs.units,
            eqs.model.name,
        )


def _computed(
    job: Job,
    part: Part,
    records: Records,
    who: Crew,
    store: str | os.PathLike[str] | None,
    progress: Progress | None,
) -> Tally:
    """Compute all cases that are not kept already."""
    kept = None if store is None else Store(store, digest(job, part))
    if kept is not None:
        for found in kept.finished(records):
            records.put(found)
    pieces = parts(part, _missing(records), who.part, _LEAST_IN_LANES if job.lanes else 1)
    listener = Listener(progress, (lambda found: None) if kept is None else kept.keep)
    if who.executor is None:
        return compute_here(job, pieces, records, who.threads, listener)
    return compute_there(job, pieces, records, who, listener)


def _missing(records: Records) -> list[tuple[int, int]]:
    """Return the ends of all runs of cases that have not ended."""
    is_missing = np.concatenate([[False], records.codes == NOT_ENDED, [False]])
    edges = np.flatnonzero(is_missing[1:] != is_missing[:-1]).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def _status(code: int) -> Status:
    """Return the verdict that a code stands for."""
    if code >= OTHERS:
        return list(Status)[code - OTHERS]
    own = {
        NOT_ENDED: Status.INTERRUPTED,
        NOT_STARTED: Status.NOT_STARTED,
        WORKER_LOST: Status.WORKER_LOST,
    }
    return own[code] if code in own else VERDICTS[code]


def _stop_notes(records: Records, names: Sequence[str]) -> dict[int, str]:
    """Return when, and on whose account, motions in the compiled loop ended early."""
    notes = {}
    codes = (places.COLLAPSED, places.NOT_FINITE, places.SINGULAR, places.TOO_MANY)
    for case in np.flatnonzero(np.isin(records.codes, codes)).tolist():
        code = int(records.codes[case])
        note = f"the motion is known up to t = {records.reached[case]:.9g} s"
        if code in (places.COLLAPSED, places.NOT_FINITE):
            verb = "changes too fast" if code == places.COLLAPSED else "has no finite derivative"
            note += f"; there {names[records.counts[case, places.STATE]]} {verb}"
        notes[case] = note
    return notes
