"""Computes the cases of a chunk: the arrays of the compiled loops, and the way to them in another process."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.machine import lanes
from symbody.kernels import block as at
from symbody.kernels import many_motions as loop_at
from symbody.kernels.block import Breakpoint, Counts, Run, Verdict
from symbody.kernels.events.event_monitor import ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.lanes.lane_block import LaneGroup
from symbody.kernels.modes.mode_switch import DECIDED, SHOCK, ModeSwitch
from symbody.simulation.events.event_watch import chattering_note, value_notes
from symbody.simulation.hybrid.mode_record import mode_changes, shock_notes
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, search_ahead
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.methods.explicit import make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats
from symbody.simulation.native.lane_blocks import make_lane_block
from symbody.simulation.native.machine import lane_motions, many_motions
from symbody.simulation.native.run import EVENT_SAMPLES, VERDICTS, memory_limit, stop_words
from symbody.simulation.status import Status
from symbody.simulation.sweeps.loop_job import LoopJob
from symbody.simulation.sweeps.records import (
    CODES,
    NOT_ENDED,
    STATUSES,
    CaseDetails,
    Chunk,
    Records,
    blocks,
)
from symbody.simulation.sweeps.sweep_job import SweepJob, compute_case
from symbody.single_flight import SingleFlight

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Steps between two looks at whether the work is to stop.
_SLICE: Final = 1000
# Room at first: for steps of one case, for what happens in all, for the record of their modes.
_STEPS: Final = 256
_HAPPENED: Final = 1024
_ROWS: Final = 1024
# Of such cases `simulate` says what is wrong, as of those that are stiff.
_FAULTS: Final = (
    at.EVENT_FAULT, at.SPOILED, at.UNMET, at.UNDECIDED, at.UNMOVABLE, at.TOO_LONG, at.MODE_FAULT,
)  # fmt: skip
# From codes of the loop to those of records; where there is none of the loop it stays.
_CODES: Final = MappingProxyType(
    {code: CODES[status] for code, status in VERDICTS.items()} | dict.fromkeys(_FAULTS, CODES[Status.STIFF])
)
_EARLY: Final = (Status.STEP_COLLAPSE, Status.NOT_FINITE, Status.SINGULAR, Status.TOO_MANY_STEPS)


def compute_in_loop(job: LoopJob, chunk: Chunk, records: Records, stop: Integers, done: Integers) -> None:
    """Compute the cases of a chunk that have not ended, in one thread, without the interpreter's lock.

    Parameters
    ----------
    stop, done : arrays of one int
        Anything but 0 ends the loop; how many cases have ended.
    """
    records.codes[~np.isfinite(chunk.states).all(axis=1)] = CODES[Status.NOT_STARTED]
    before = records.codes.copy()
    loop = _CaseLoop(job, chunk, records)
    code = at.RUNNING
    while code != at.FINISHED and stop[0] == 0:
        code = loop.advance()
        done[0] = loop.end_count
    loop.write_down(before == NOT_ENDED)


class _CaseLoop:
    """The compiled loop over the cases of a chunk, and its room, which grows."""

    def __init__(self, job: LoopJob, chunk: Chunk, records: Records) -> None:
        self._job, self._records = job, records
        self._rows, breaks = _case_rows(job, chunk)
        happens = job.happens
        self._watch, self._modes = happens.watch.copy(), happens.modes.copy()
        self._is_watched = bool(happens.labels)
        n = job.state_size + self._is_watched  # the work is the last state
        self._block = _block(job, n, breaks)
        self._in_lanes = bool(job.lanes and not self._is_watched and chunk.count >= lanes() and n)
        count, room = records.count, job.times.size + EVENT_SAMPLES
        self._t, self._x = np.zeros(room), np.zeros((room, n))
        self._samples = np.ascontiguousarray(records.x)
        steps = 0
        if self._is_watched:
            self._samples = np.full((count, job.times.size, n), np.nan)
            steps, Run(self._block).room.keep_dense = _STEPS, 1.0
        Run(self._block).room.samples = room
        monitor, switch = EventMonitor(self._watch), ModeSwitch(self._modes)
        self._breaks, self._pieces = np.zeros(steps + 1), np.zeros((steps, monitor.piece_rows, n))
        happened = _HAPPENED + ZEROS_PER_EVENT * monitor.event_count if self._is_watched else 0
        self._happened = np.zeros((happened, n + 2))
        self._decisions = np.zeros((_ROWS if switch.count else 0, 3 + switch.count + n))
        self._looks = np.zeros((count, loop_at.LOOK_EVENTS + loop_at.LOOK_SIZE * monitor.event_count))
        known = [records.codes, records.reached, records.counts]
        self._verdicts = np.column_stack(known).astype(np.float64)
        self._addresses = [0 if function is None else function.address for function in job.functions]
        self._wide = job.derivative.in_lanes() if self._in_lanes else None
        if self._wide is not None:
            self._block = make_lane_block(self._block, job.rhs, self._wide.work_size, job.method.tableau)

    @property
    def end_count(self) -> int:
        """How many cases have ended."""
        return LaneGroup(self._block).cases_ended if self._in_lanes else Run(self._block).cases.ended

    @cached_property
    def _call(self) -> Callable[[int], int]:
        """The loop with all its arguments but the number of steps, for the room there is."""
        job, places = self._job, [self._rows, self._job.times, self._t]
        if self._wide is not None:
            functions = self._addresses[0], self._wide.address, self._addresses[1], address(self._block)
            places += [self._samples, self._verdicts]
            return partial(lane_motions(), *functions, *self._rows.shape, *map(address, places))
        Run(self._block).room.steps = len(self._pieces)
        EventMonitor(self._watch).happened_room = len(self._happened)
        ModeSwitch(self._modes).room = len(self._decisions)
        watch, modes = job.happens.watch, job.happens.modes
        kinds = ["EVENTS"] * self._is_watched + ["MODES"] * bool(ModeSwitch(modes).count)
        places += [self._x, self._samples, self._verdicts, self._breaks, self._pieces, self._happened]
        places += [self._looks, self._decisions]
        return partial(
            many_motions(frozenset(kinds)), *self._addresses, address(self._block), address(self._watch),
            watch.size, address(watch), address(self._modes), modes.size, address(modes), *self._rows.shape,
            *map(address, places),
        )  # fmt: skip

    def advance(self) -> int:
        """Try some steps; return a code of `kernels.block`."""
        code = self._call(_SLICE)
        if code == at.FULL:
            self._make_room_for_steps()
        elif code == at.NO_EVENT_ROOM:
            self._happened = _double(self._happened)
        elif code == at.NO_MODE_ROOM:
            self._decisions = _double(self._decisions)
        if code in (at.FULL, at.NO_EVENT_ROOM, at.NO_MODE_ROOM):
            del self._call
        return code

    def _make_room_for_steps(self) -> None:
        """Double the room for steps; raises MemoryError if none is left."""
        if 2 * self._pieces.nbytes > memory_limit():
            raise MemoryError
        self._breaks, self._pieces = _double(self._breaks), _double(self._pieces)

    def write_down(self, is_new: Flags) -> None:
        """Write what is known of the cases into the records; the new ones had not ended before."""
        records, places = self._records, Verdict.layout
        codes = self._verdicts[:, places["code"]].astype(np.int64).tolist()
        records.codes[:] = [_CODES.get(code, code) for code in codes]
        records.reached[:] = self._verdicts[:, places["reached"]]
        records.counts[:] = self._verdicts[:, Verdict.fields["counts"].place :]
        records.x[is_new] = self._samples[is_new][..., : self._job.state_size]
        ended = np.flatnonzero(is_new & (records.codes != NOT_ENDED))
        if self._is_watched and ended.size:
            self._write_details(ended)
        early = is_new & np.isin(records.codes, [CODES[status] for status in _EARLY])
        for k in np.flatnonzero(early).tolist():
            self._note_early_end(k)

    def _note_early_end(self, k: int) -> None:
        """Note up to when a case is known, and which state is to blame."""
        records, status = self._records, STATUSES[int(self._records.codes[k])]
        names, blamed = self._job.state_names, int(records.counts[k, Counts.layout["blamed_state"]])
        has_culprit = status in (Status.STEP_COLLAPSE, Status.NOT_FINITE)
        why = stop_words(status, float(records.reached[k]), (*names, "work")[blamed] if has_culprit else "")
        known = records.details.get(records.first + k, CaseDetails(""))
        notes = "; ".join(filter(None, (known.notes, why)))
        records.details[records.first + k] = replace(known, notes=notes)

    def _write_details(self, cases: Integers) -> None:
        """Write down what happened in cases that have ended, the work, and their modes."""
        records, happens = self._records, self._job.happens
        happened, decisions, notes = self._occurrences(cases), self._own_modes(cases), self._notes(cases)
        names = (*happens.labels[: happens.events], *happens.words)
        work, samples = self._samples[..., -1].copy(), records.counts[:, Counts.layout["samples"]].tolist()
        for k, rows, modes in zip(cases.tolist(), happened, decisions, strict=True):
            own = work[k, : samples[k]]
            details = CaseDetails(notes.get(k, ""), names, rows, own, modes)
            records.details[records.first + k] = details

    def _ends(self, cases: Integers, place: int) -> Integers:
        """Return how many rows of a record there were when each case ended."""
        ends: Integers = self._looks[cases, place].astype(np.int64)
        return ends

    def _occurrences(self, cases: Integers) -> list[Floats]:
        """Return the occurrences of each case in order, changes of modes behind events at one time."""
        happens, ends = self._job.happens, self._ends(cases, loop_at.LOOK_HAPPENED)
        rows = self._happened[: ends[-1]]
        owner = np.searchsorted(ends, np.arange(len(rows)), side="right")
        is_event = rows[:, 0] < happens.events
        rows, owner = rows[is_event, :-1], owner[is_event]
        count = len(happens.inputs)
        if count:
            stops = self._ends(cases, loop_at.LOOK_MODES)
            written = self._decisions[: stops[-1]]
            first = [0, *stops[:-1].tolist()]
            changed, _, words, are_first = mode_changes(written, happens.elements, first)
            changed, words = changed[~are_first], words[~are_first]
            states = written[changed, 3 + count : -1]
            rows = np.vstack([rows, np.column_stack([happens.events + words, written[changed, 1], states])])
            owner = np.append(owner, np.searchsorted(stops, changed, side="right"))
            direction = 1.0 if self._job.span[1] >= self._job.span[0] else -1.0
            order = np.lexsort((direction * rows[:, 1], owner))
            rows, owner = rows[order], owner[order]
        return np.split(rows, np.searchsorted(owner, np.arange(1, len(cases))))

    def _own_modes(self, cases: Integers) -> list[HeldRecord | None]:
        names = self._job.happens.inputs
        if not names:
            return [None] * len(cases)
        found: list[HeldRecord | None] = []
        for rows in np.split(self._decisions, self._ends(cases, loop_at.LOOK_MODES))[: len(cases)]:
            own = rows[rows[:, 0] == DECIDED]
            record = HeldRecord(names, own[:, 1], own[:, 3 : 3 + len(names)].T)
            found.append(record if len(own) else None)
        return found

    def _notes(self, cases: Integers) -> dict[int, str]:
        """Return what there is to say of cases in which it is not only that something happened."""
        happens, records, looks = self._job.happens, self._records, self._looks
        stops = self._ends(cases, loop_at.LOOK_MODES)
        are_shocks = self._decisions[: stops[-1], 0] == SHOCK
        struck = {*np.searchsorted(stops, np.flatnonzero(are_shocks), side="right").tolist()}
        is_seen = looks[:, loop_at.LOOK_EVENTS :].any(axis=1) | (records.codes == CODES[Status.CHATTERING])
        texts = {}
        for place in sorted({*np.flatnonzero(is_seen[cases]).tolist(), *struck}):
            k = int(cases[place])
            seen = looks[k, loop_at.LOOK_EVENTS :].reshape(-1, loop_at.LOOK_SIZE)
            notes = [*value_notes(happens.labels, seen)]
            if records.codes[k] == CODES[Status.CHATTERING]:
                culprit = happens.labels[int(looks[k, loop_at.LOOK_CULPRIT]) - 1]
                ending = chattering_note(culprit, looks[k, loop_at.LOOK_UNTURNED] != 0.0)
                reach = stop_words(Status.CHATTERING, float(records.reached[k]))
                notes.append(f"{reach}; there {ending}")
            if place in struck:
                rows = self._decisions[stops[place - 1] if place else 0 : stops[place]]
                notes += shock_notes(rows, happens.elements)
            texts[k] = "; ".join(notes)
        return texts


def _double(array: Floats) -> Floats:
    return np.concatenate([array, np.zeros_like(array)])


def _case_rows(job: LoopJob, chunk: Chunk) -> tuple[Floats, Floats]:
    """Return all numbers of each case as `kernels.many_motions` reads them, and the breakpoints of one."""
    breaks = _break_rows(_breakpoints(job, chunk), 1.0 if job.span[1] >= job.span[0] else -1.0)
    derivative, projecting, values, actions, closing, deciding, moves = (
        _case_numbers(function, chunk.parameters) for function in job.functions
    )
    tolerances, scales, coordinates, metric, large = chunk.sizes
    work = np.zeros((chunk.count, tolerances.shape[1] - chunk.states.shape[1]))
    rows = np.hstack([
        chunk.states, work, tolerances, np.broadcast_to(breaks, (chunk.count, breaks.shape[1])), *derivative,
        *projecting, scales, coordinates, *values, *actions, metric, *closing, *deciding, *moves, large,
    ])  # fmt: skip
    return np.ascontiguousarray(rows), breaks[0]


def _case_numbers(function: CompiledFunction | None, parameters: Floats) -> tuple[Floats, Floats]:
    """Return p and c of a function for each case, without columns if there is none."""
    nothing = np.zeros((parameters.shape[0], 0))
    if function is None:
        return nothing, nothing
    constants = function.constants(parameters)
    return parameters, np.broadcast_to(constants, (parameters.shape[0], constants.shape[-1]))


def _block(job: LoopJob, n: int, breaks: Floats) -> Floats:
    """Return the block of one motion with n states, with room for the numbers of a case."""
    goal = make_goal(job.span, job.rtol, np.ones(n), job.method.max_step, NO_BREAKPOINTS)
    goal = goal._replace(
        max_trials=job.max_steps,
        stop_when_stiff=job.stop_when_stiff,
        breaks=breaks.reshape(-1, Breakpoint.size),
    )
    first_step = float(job.method.first_step or 0.0)
    start = np.zeros(n), job.span[0], first_step
    block = make_block(job.rhs, job.projector, job.method.tableau, goal, *start)
    Run(block).room.times = job.times.size
    return block


def _breakpoints(job: LoopJob, chunk: Chunk) -> Sequence[Breakpoints]:
    """Return the breakpoints of all cases, or one for all."""
    if job.breakpoints is not None:
        return job.breakpoints
    found = search_ahead(job.functions_of_time(with_parameters=True), job.span, chunk.parameters)
    return [own.jumps_alone() if isinstance(job.method, FixedStep) else own for own in found]


def _break_rows(breakpoints: Sequence[Breakpoints], direction: float) -> Floats:
    """Return the breakpoints of each case as a row, the last one repeated where others have more."""
    tables = [own.rows_along(direction) for own in breakpoints]
    most = max(len(table) for table in tables)
    return np.stack([table[np.minimum(np.arange(most), len(table) - 1)].ravel() for table in tables])


def compute_chunk(payload: bytes, chunk: Chunk, threads: int) -> Records | str:
    """Compute a chunk in another process; return why it cannot be done there rather than raise.

    Whatever else comes back in place of records then comes from the executor itself.
    """
    try:
        job = _JOBS.get(payload, partial(_unpack, payload))
        records = Records.empty(chunk.first, chunk.count, job.times.size, job.state_size)
        if isinstance(job, SweepJob):
            for case in range(chunk.first, chunk.first + chunk.count):
                compute_case(job, case, records)
        else:
            _compute_in_threads(job, chunk, records, threads)
    except Exception as error:  # it may not be known where the answer is read
        return f"{type(error).__name__}: {error}"
    return records


def _compute_in_threads(job: LoopJob, chunk: Chunk, records: Records, threads: int) -> None:
    stop = np.zeros(1, dtype=np.int64)
    ends = list(blocks(chunk.count, -(-chunk.count // max(threads, 1))))
    parts = [(chunk.cut(*both), records.cut(*both), stop, stop.copy()) for both in ends]
    if len(parts) == 1:
        compute_in_loop(job, *parts[0])
        return
    with ThreadPoolExecutor(len(parts)) as pool:
        for future in [pool.submit(compute_in_loop, job, *part) for part in parts]:
            future.result()


# A chunk may be computed in several threads of a worker; its functions are compiled once in a process.
_JOBS: Final[SingleFlight[bytes, LoopJob | SweepJob]] = SingleFlight(4)


def _unpack(payload: bytes) -> LoopJob | SweepJob:
    job = pickle.loads(payload)
    if not isinstance(job, LoopJob | SweepJob):
        raise TypeError(f"{type(job).__name__} is not a job")
    return job
