"""Cases with events in the compiled loop: their arrays, the way through the loop, what happened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.kernels import block as at
from symbody.kernels.block import Counts, Run, Verdict
from symbody.kernels.events import watched_cases as loop_at
from symbody.kernels.events.event_monitor import ZEROS_PER_EVENT, EventMonitor
from symbody.simulation.events.event_watch import chattering_note, value_notes
from symbody.simulation.events.events import Occurrence
from symbody.simulation.events.watch_arrays import WatchNumbers, make_watch_block, with_cut_fit
from symbody.simulation.inputs.tables import Table, table_numbers
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.closing import closing_block
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.native.machine import watched_cases
from symbody.simulation.native.run import EVENT_SAMPLES, memory_limit
from symbody.simulation.sweeps.records import NOT_ENDED, CaseDetails, CaseWatch, Chunk, LoopJob, Records

Integers = NDArray[np.int64]

# Room for steps of one case and for what happens in all, at first.
_STEPS: Final = 256
_HAPPENED: Final = 1024
SLICE: Final = 1000
# Codes of cases of which `simulate` says what is wrong.
_FAULTS: Final = (
    at.EVENT_FAULT, at.SPOILED, at.UNMET, at.UNDECIDED, at.UNMOVABLE, at.TOO_LONG, at.MODE_FAULT,
)  # fmt: skip


class WatchedRows(NamedTuple):
    """What the loop needs besides what it needs without events.

    Attributes
    ----------
    fresh : array
        The block of a watch that has not begun.
    rows : (cases, k) array
        Numbers of its functions for each case.
    """

    fresh: Floats
    rows: Floats


def case_numbers(function: CompiledFunction | None, parameters: Floats) -> tuple[Floats, Floats]:
    """Return p and c of a function for each case, without columns if there is none."""
    nothing = np.zeros((parameters.shape[0], 0))
    if function is None:
        return nothing, nothing
    constants = function.constants(parameters)
    return parameters, np.broadcast_to(constants, (parameters.shape[0], constants.shape[-1]))


def case_function(
    function: CompiledFunction, numbers: tuple[Floats, Floats], inputs: int,
    tables: Mapping[int, Table] = MappingProxyType({}),
) -> RightHandSide:  # fmt: skip
    """Return a function with room for the numbers of one case and so many inputs, and with its tables."""
    p, c = (np.zeros(table.shape[1]) for table in numbers)
    n_u, r = len(function.signature.u), np.zeros(inputs)
    return RightHandSide(function.address, n_u, r, p, c, function.work_size, table_numbers(tables))


def watched_rows(job: LoopJob, watch: CaseWatch, chunk: Chunk) -> WatchedRows:
    """Return the block of a watch, and the numbers of its functions for each case."""
    numbers = [case_numbers(function, chunk.parameters) for function in (watch.values, watch.actions)]
    values, actions = (
        np.zeros(0)
        if function is None
        else function_numbers(case_function(function, columns, job.input_count, job.tables))
        for function, columns in zip((watch.values, watch.actions), numbers, strict=True)
    )
    closing, block = case_numbers(watch.closing, chunk.parameters), np.zeros(0)
    if watch.closing is not None:
        outputs = [len(output.values) for output in watch.closing.outputs]
        room = case_function(watch.closing, closing, job.input_count, job.tables)
        own, numbers_of_one = chunk.metric[0], function_numbers(room)
        block = closing_block(watch.shape, own, outputs, numbers_of_one, watch.share)
    speeds = len(job.function.signature.u)
    sizes = WatchNumbers(job.state_size + 1, speeds, values, actions, block)
    dense_rows = 4 + len(job.method.tableau.dense)
    fresh = with_cut_fit(make_watch_block(watch.events, sizes), dense_rows)
    monitor = EventMonitor(fresh)
    monitor.span, monitor.piece_rows = abs(job.span[1] - job.span[0]), dense_rows
    monitor.direction = 1.0 if job.span[1] >= job.span[0] else -1.0
    monitor.first_length = float(job.method.first_step or 0.0)
    if job.modes is not None:
        monitor.mode_count, monitor.first_mode = len(job.modes.names), len(job.tables)
    columns = [*numbers[0], *numbers[1], chunk.metric, *closing]
    return WatchedRows(fresh, np.hstack(columns))


class WatchedLoop:
    """The loop over cases with events, and its room, which grows.

    Parameters
    ----------
    addresses : sequence of int
        Of the derivative and of what projects.
    rows : (cases, size) array
        All numbers of each case, those of the watch from column `first` on.
    fresh : array
        The block of a watch that has not begun.
    """

    _LOOKS = 0  # numbers of a row of looks behind those of the events

    def __init__(
        self, job: LoopJob, watch: CaseWatch, addresses: Sequence[int], block: Floats, rows: Floats,
        first: int, fresh: Floats, records: Records,
    ) -> None:  # fmt: skip
        self._job, self._watch, self._records = job, watch, records
        self._block, self._rows, self._fresh, self._first = block, rows, fresh, first
        n = job.state_size + 1
        acting = 0 if watch.actions is None else watch.actions.address
        closing = 0 if watch.closing is None else watch.closing.address
        self._addresses = (*addresses, watch.values.address, acting, closing)
        self._state = fresh.copy()
        room = job.times.size + EVENT_SAMPLES
        self._t, self._x = np.zeros(room), np.zeros((room, n))
        self._samples = np.full((records.count, job.times.size, n), np.nan)
        self._breaks = np.zeros(_STEPS + 1)
        self._pieces = np.zeros((_STEPS, EventMonitor(fresh).piece_rows, n))
        self._happened = np.zeros((_HAPPENED + ZEROS_PER_EVENT * len(watch.events), n + 2))
        self._looked = loop_at.LOOK_EVENTS + loop_at.LOOK_SIZE * len(watch.events)
        self._looks = np.zeros((records.count, self._looked + self._LOOKS))
        Run(block).room.keep_dense, Run(block).room.samples = 1.0, room

    def run(self, verdicts: Floats, stop: Integers, done: Integers) -> None:
        """Compute the cases that have not ended, and write down what happened."""
        code = at.RUNNING
        while code != at.FINISHED and stop[0] == 0:
            Run(self._block).room.steps = len(self._pieces)
            EventMonitor(self._state).happened_room = len(self._happened)
            code = self._advance(verdicts)
            if code == at.FULL:
                self._make_room_for_steps()
            elif code == at.NO_EVENT_ROOM:
                self._happened = np.concatenate([self._happened, np.zeros_like(self._happened)])
            elif code == at.NO_MODE_ROOM:
                self._make_room_for_modes()
            done[0] = Run(self._block).cases.ended
        codes = verdicts[:, Verdict.layout["code"]]
        is_fault = np.isin(codes, _FAULTS)
        codes[is_fault] = at.STIFF  # `simulate` says what is wrong

    def _advance(self, verdicts: Floats) -> int:
        return watched_cases()(
            *self._addresses, address(self._block), address(self._state), self._fresh.size,
            address(self._fresh), *self._rows.shape, self._first, *self._places(verdicts), SLICE,
        )  # fmt: skip

    def _places(self, verdicts: Floats) -> list[int]:
        """Return where lies what the loop reads and writes of all cases."""
        places = [self._rows, self._job.times, self._t, self._x, self._samples, verdicts]
        places += [self._breaks, self._pieces, self._happened, self._looks]
        return [address(place) for place in places]

    def _make_room_for_modes(self) -> None:
        """Double the room for the record of modes, of which there are none here."""

    def _make_room_for_steps(self) -> None:
        """Double the room for steps.

        Raises
        ------
        MemoryError
            None is left.
        """
        if 2 * self._pieces.nbytes > memory_limit():
            raise MemoryError
        self._breaks = np.concatenate([self._breaks, np.zeros_like(self._breaks)])
        self._pieces = np.concatenate([self._pieces, np.zeros_like(self._pieces)])

    def write_down(self, before: Integers) -> None:
        """Write samples, events, notes and work of the cases that have ended by now into the records."""
        records, happened = self._records, 0
        for k in range(records.count):
            if before[k] != NOT_ENDED:
                continue
            records.x[k] = self._samples[k, :, :-1]
            if records.codes[k] == NOT_ENDED:
                continue
            rows = self._happened[happened : int(self._looks[k, loop_at.LOOK_HAPPENED])]
            happened = int(self._looks[k, loop_at.LOOK_HAPPENED])
            records.details[records.first + k] = self._details(k, rows)

    def _details(self, k: int, rows: Floats) -> CaseDetails:
        watch, records, look = self._watch, self._records, self._looks[k]
        names, labels = watch.state_names, watch.labels
        events = tuple(
            Occurrence(labels[int(row[0])], row[1], dict(zip(names, row[2:], strict=False)))
            for row in rows.tolist()
        )
        seen = look[loop_at.LOOK_EVENTS : self._looked].reshape(-1, loop_at.LOOK_SIZE)
        notes = value_notes(labels, seen) if seen.any() else ()
        if records.codes[k] == at.CHATTERING:
            culprit = labels[int(look[loop_at.LOOK_CULPRIT]) - 1]
            ending = chattering_note(culprit, look[loop_at.LOOK_UNTURNED] != 0.0)
            stop = f"the motion is known up to t = {records.reached[k]:.9g} s"
            notes = (*notes, f"{stop}; there {ending}")
        work = self._samples[k, : records.counts[k, Counts.layout["samples"]], -1].copy()
        return CaseDetails("; ".join(notes), events, work)
