"""Cases along which joints stick and slip and ropes go taut, in the compiled loop."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from symbody.codegen.call_arguments import address
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.simulation.hybrid.mode_record import ModeRecord, held_modes
from symbody.simulation.hybrid.switching import NO_NUMBERS, NO_SAMPLES
from symbody.simulation.native.description import Floats
from symbody.simulation.native.machine import switching_cases
from symbody.simulation.sweeps.records import CaseDetails, CaseModes, Chunk, LoopJob
from symbody.simulation.sweeps.watched_cases import SLICE, WatchedLoop, case_numbers

# Room for the record of the modes of all cases, at first.
_ROWS: Final = 1024


def mode_rows(modes: CaseModes, chunk: Chunk) -> Floats:
    """Return the numbers of what decides about modes for each case."""
    numbers = [case_numbers(each, chunk.parameters) for each in (modes.deciding, modes.projecting)]
    return np.hstack([*numbers[0], *numbers[1], chunk.mode_sizes])


class SwitchingLoop(WatchedLoop):
    """The loop over cases along which modes change, and its room, which grows.

    Parameters
    ----------
    job : LoopJob
        With `modes`, whose numbers stand last in each row.
    """

    _LOOKS = 1  # how many rows of the record of modes there were when a case ended

    def __init__(self, job: LoopJob, *rest: Any) -> None:
        super().__init__(job, *rest)
        assert job.modes is not None
        self._modes = job.modes
        self._fresh_modes = self._modes.block.copy()
        self._mode_state = self._fresh_modes.copy()
        self._behind = self._rows.shape[1] - self._mode_row_size
        switch = self._switch
        self._decisions = np.zeros((_ROWS, 3 + switch.count + switch.states))
        self._own_events = len(self._watch.events) - switch.count
        self._written = 0  # rows of the cases that have been written down
        self._held = NO_SAMPLES.copy()

    @property
    def _switch(self) -> ModeSwitch:
        return ModeSwitch(self._mode_state)

    @property
    def _mode_row_size(self) -> int:
        switch = self._switch
        functions = switch.numbers, switch.projection
        own = sum(each.parameter_count + each.constant_count for each in functions)
        return own + 2 + switch.speeds

    def _advance(self, verdicts: Floats) -> int:
        self._switch.room = len(self._decisions)
        return switching_cases()(
            *self._addresses, self._modes.deciding.address, self._modes.projecting.address,
            address(self._block), address(self._state), self._fresh.size, address(self._fresh),
            address(self._held), address(NO_NUMBERS), address(self._mode_state), self._fresh_modes.size,
            address(self._fresh_modes), *self._rows.shape, self._first, self._behind,
            *self._places(verdicts), address(self._decisions), SLICE,
        )  # fmt: skip

    def _make_room_for_modes(self) -> None:
        self._decisions = np.concatenate([self._decisions, np.zeros_like(self._decisions)])

    def _details(self, k: int, rows: Floats) -> CaseDetails:
        modes, first = self._modes, self._written
        self._written = int(self._looks[k, -1])
        record = ModeRecord(modes.names, modes.joints, modes.ropes, self._watch.state_names, self._switch)
        record.rows = self._decisions[first : self._written]
        details = super()._details(k, rows[rows[:, 0] < self._own_events])
        return replace(
            details, notes="; ".join(filter(None, (details.notes, *record.notes))),
            events=tuple(sorted((*details.events, *record.occurrences), key=lambda event: event.t)),
            modes=held_modes(modes.names, (*modes.joints, *modes.ropes), record.changes),
        )  # fmt: skip
