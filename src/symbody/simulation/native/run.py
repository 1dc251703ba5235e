"""One run of the integrator: its record, its growth, and the slices between which Python acts."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

import numpy as np

from symbody.codegen.call_arguments import address
from symbody.errors import Problem, SimulationError
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.memory import memory_size
from symbody.simulation.native.blocks import state_of
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.description import Floats, HeldValues, Record, Watch
from symbody.simulation.native.machine import LOOP, advance_motion, step_machine
from symbody.simulation.status import Status

if TYPE_CHECKING:
    from symbody.simulation.hybrid.passed_jumps import PassedJumps
    from symbody.simulation.native.implicit import ImplicitPart

Progress = Callable[[float], bool | None]

# Steps of the first slice, and what a slice should last [s]: between slices Python sees Ctrl-C.
FIRST_SLICE: Final = 64
SLICE_SECONDS: Final = 0.05
FIRST_CAPACITY: Final = 256
# Samples that an event may add to those of given times: the states before and after.
EVENT_SAMPLES: Final = 2
_NO_ROOM: Final = (at.NO_EVENT_ROOM, at.NO_SAMPLE_ROOM, at.NO_MODE_ROOM)
# Where the system does not tell its memory [bytes].
ASSUMED_MEMORY: Final = 8 * 2**30

VERDICTS: Final[Mapping[int, Status]] = {
    at.FINISHED: Status.SUCCESS,
    at.COLLAPSED: Status.STEP_COLLAPSE,
    at.NOT_FINITE: Status.NOT_FINITE,
    at.SINGULAR: Status.SINGULAR,
    at.TOO_MANY: Status.TOO_MANY_STEPS,
    at.STIFF: Status.STIFF,
    at.STOPPED: Status.STOPPED,
    at.CHATTERING: Status.CHATTERING,
    at.SPOILED: Status.NOT_FINITE,
    at.UNMET: Status.UNMET_ACTION,
    at.UNDECIDED: Status.FRICTION,
    at.UNMOVABLE: Status.SINGULAR,
    at.TOO_LONG: Status.UNMET_ACTION,
}


@dataclass(frozen=True, slots=True)
class Statistics:
    """What a run cost.

    Attributes
    ----------
    accepted : int
        Steps taken.
    rejected : int or None
        Steps tried in vain; None if the integrator does not tell, as SUNDIALS.
    evaluations : int
        Calls of the right-hand side.
    loop_seconds : float
        Time inside the compiled loop [s].
    residual : float or None
        By how much impulses missed their laws at most, as a share of the fastest rate; of `MoreauJean`.
    """

    accepted: int
    rejected: int | None
    evaluations: int
    loop_seconds: float
    residual: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RawRun:
    """What `integrate` returns: arrays and a verdict, without names.

    Attributes
    ----------
    t : (N,) array
        Times of the samples [s].
    x : (n, N) array
        States x = (u, q).
    reached : float
        Time up to which the motion is known [s].
    state : int or None
        After a collapse or a derivative that is not finite: which state is to blame.
    kernel : int or None
        After `Status.SINGULAR`: which kernel of the right-hand side failed, from 0.
    dense_output : DenseOutput or None
        The motion between the samples.
    jumps : tuple
        When prescribed rates have changed speeds [s], and by how much the energy [J].
    """

    t: Floats
    x: Floats
    status: Status
    statistics: Statistics
    reached: float
    state: int | None
    kernel: int | None
    dense_output: DenseOutput | None
    jumps: tuple[tuple[float, float], ...] = ()

    @property
    def reach(self) -> str:
        """How far the motion is known, in words."""
        return stop_words(self.status, self.reached)

    def stop_note(self, state_names: Sequence[str]) -> str:
        """Return where and on whose account the run ended early, empty if it did not."""
        if self.status.success:
            return ""
        blamed = "" if self.state is None else state_names[self.state]
        note = stop_words(self.status, self.reached, blamed)
        if self.kernel is not None:
            note += f"; there linear system {self.kernel + 1} of the accelerations is singular"
        return note


def stop_words(status: Status, reached: float, blamed: str = "") -> str:
    """Return up to when a motion is known, and which state is to blame if one is."""
    words = f"the motion is known up to t = {reached:.9g} s"
    verb = "changes too fast" if status is Status.STEP_COLLAPSE else "has no finite derivative"
    return f"{words}; there {blamed} {verb}" if blamed else words


class NativeRun(NamedTuple):
    """All arguments of the integrator but the record, which grows.

    Attributes
    ----------
    rhs, projector : int
        The addresses of the functions; 0 if nothing is projected.
    block : array
        See `symbody.kernels.block`.
    held : HeldValues or None
        Takes samples on the way.
    jumps : PassedJumps or None
        Passes jumps of prescribed rates.
    implicit : ImplicitPart or None
        Takes implicit steps.
    """

    rhs: int
    projector: int
    block: Floats
    held: HeldValues | None = None
    jumps: PassedJumps | None = None
    implicit: ImplicitPart | None = None

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        if self.held is not None:
            self.held.begin(self.block)
        places = (record.wanted, record.t, record.x, record.breaks)
        if self.implicit is None:
            code = step_machine().begin(self.rhs, address(self.block), *map(address, places))
        else:
            code = self.implicit.begin(self.rhs, self.block, places)
        if code == at.FINISHED and self.held is not None:  # a sample may still be due
            return at.RUNNING
        return int(code)

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        modes = None if watch is None else watch.modes
        parts = [part for part in (watch, modes, self.held, self.jumps, self.implicit) if part is not None]
        if not parts:
            return step_machine().advance(
                self.rhs, self.projector, self.rhs, address(self.block), *map(address, record.arrays), trials
            )
        if watch is not None and self.held is not None:
            self.held.show_watch(watch.array)
        loop = advance_motion(frozenset(part.feature for part in parts))
        own: dict[str, int | Floats] = {"f": self.rhs, "g": self.projector, "run": self.block}
        own |= dict(zip(("times", "t", "x", "breaks", "pieces"), record.arrays, strict=True))
        code = at.NO_EVENT_ROOM
        while code in _NO_ROOM:
            for part in parts:
                own |= part.arguments(self.block)
            code = loop(*[_place(own.get(name, 0)) for name in LOOP], trials)
            for part in parts:
                part.answer(code)
        return code


def _place(argument: int | Floats) -> int:
    """Return where a function or an array lies."""
    return argument if isinstance(argument, int) else address(argument)


class CompiledRun(Protocol):
    """A run of the compiled loop, by whatever method."""

    @property
    def block(self) -> Floats:
        """See `symbody.kernels.block`."""
        ...

    @property
    def jumps(self) -> PassedJumps | None:
        """Passes jumps of prescribed rates."""
        ...

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        ...

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        ...


def show_room(block: Floats, record: Record) -> None:
    """Write into a block what is stored of its run, and how much room there is."""
    room = Run(block).room
    room.every_step, room.keep_dense = record.every_step, record.keep_dense
    room.times, room.samples, room.steps = record.wanted.size, record.t.size, record.pieces.shape[0]


def fresh_record(run: CompiledRun, times: Floats | None, dense: bool, more: int = 0) -> Record:
    """Return empty storage for the samples at `times` and so many more, or for every step.

    Raises
    ------
    SimulationError
        More samples than the memory holds.
    """
    n, rows = Run(run.block).states, Run(run.block).method.dense_rows
    if times is not None:
        check_memory(times.size, n)
    capacity = FIRST_CAPACITY if times is None else times.size + more
    pieces = FIRST_CAPACITY if dense else 0
    return Record(
        np.zeros(0) if times is None else times,
        np.empty(capacity),
        np.empty((capacity, n)),
        np.empty(pieces + 1),
        np.empty((pieces, rows, n)),
        times is None,
        dense,
    )


def check_memory(samples: int, n: int) -> None:
    """Check that so many samples of n states fit into the memory.

    Raises
    ------
    SimulationError
        They take more than `memory_limit`.
    """
    if 8 * samples * (n + 1) <= memory_limit():
        return
    size = 8e-9 * samples * (n + 1)
    what = f"{samples} samples of {n} states take {size:.3g} GB, more than half of the memory here"
    fix = f"store at most {memory_limit() // (8 * (n + 1))} times, or simulate in parts"
    raise SimulationError(Problem("simulation.memory", "times", what, fix=fix))


def memory_limit() -> int:
    """Return how many bytes the samples of a run may take: half of the memory of computer or container."""
    return (memory_size() or ASSUMED_MEMORY) // 2


def run_loop(
    run: CompiledRun, record: Record, progress: Progress | None, watch: Watch | None = None
) -> RawRun:
    """Run the loop to its end, in slices; Ctrl-C ends it between two of them and keeps what there is."""
    status: Status | None = None
    clock = [0.0]
    span = _limit_run(run)
    budget = FIRST_SLICE
    code = at.RUNNING
    try:
        code = run.begin(record)
        if code == at.FINISHED and (watch is not None or run.jumps is not None):  # more may be due there
            code = at.RUNNING
        while code in (at.RUNNING, at.FULL):
            if code == at.FULL:
                record = _grow(record, run.block)
            code, budget = _slice(run, record, budget, watch, clock)
            if code in (at.RUNNING, at.FULL):
                status = None if _report_progress(run, span, progress) else Status.INTERRUPTED
            if status is not None:
                break
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    except MemoryError:
        status = Status.OUT_OF_MEMORY
    if watch is not None and status in (Status.INTERRUPTED, Status.OUT_OF_MEMORY):
        watch.break_off(run.block, record)
    return _raw_run(run, record, VERDICTS[code] if status is None else status, clock[0])


def _limit_run(run: CompiledRun) -> tuple[float, float]:
    """Let a run end just before the first jump; return when the whole motion begins and ends [s]."""
    own = Run(run.block)
    if run.jumps is None:
        return own.time, own.t_end
    run.jumps.limit_run(run.block)
    return own.time, run.jumps.t_end


def begin_again(run: CompiledRun, record: Record) -> int:
    """Begin anew from the state at present, behind the steps that are stored; return a code."""
    first, counts = record.breaks[0], Run(run.block).counts
    code = run.begin(record)
    if counts.steps:
        record.breaks[0] = first  # it belongs to the first stretch
    if code == at.FINISHED and counts.samples < record.wanted.size:
        record.t[counts.samples], record.x[counts.samples] = Run(run.block).time, state_of(run.block)
        counts.samples += 1
    return code


def _slice(
    run: CompiledRun, record: Record, budget: int, watch: Watch | None, clock: list[float]
) -> tuple[int, int]:
    """Run one slice and add its time; return the loop's code and the budget of the next slice."""
    began = time.perf_counter()
    code = run.advance(record, budget, watch)
    spent = time.perf_counter() - began
    clock[0] += spent
    return code, _next_budget(budget, spent)


def _next_budget(budget: int, spent: float) -> int:
    """Return how many steps the next slice may try so that it lasts about `SLICE_SECONDS`."""
    if spent > 2.0 * SLICE_SECONDS:
        return max(1, budget // 2)
    return 4 * budget if spent < 0.25 * SLICE_SECONDS else budget


def _report_progress(run: CompiledRun, span: tuple[float, float], progress: Progress | None) -> bool:
    share = (Run(run.block).time - span[0]) / (span[1] - span[0])
    return progress is None or progress(share) is not False


def _grow(record: Record, block: Floats) -> Record:
    """Return a record with room for twice as many samples and steps.

    Raises
    ------
    MemoryError
        No room is left.
    """
    counts = Run(block).counts
    samples, steps = counts.samples, counts.steps
    if 2 * (record.x.nbytes + record.pieces.nbytes) > memory_limit():
        raise MemoryError
    if record.every_step and samples + EVENT_SAMPLES >= record.t.size:
        record = record._replace(t=_double(record.t), x=_double(record.x))
    if record.keep_dense and steps == record.pieces.shape[0]:
        record = record._replace(breaks=_double(record.breaks), pieces=_double(record.pieces))
    return record


def _double(array: Floats) -> Floats:
    size = array.shape[0]
    larger = np.empty((2 * size, *array.shape[1:]))
    larger[:size] = array
    return larger


def _raw_run(run: CompiledRun, record: Record, status: Status, seconds: float) -> RawRun:
    """Cut the record to what was written, and turn it so that time comes last."""
    counts = Run(run.block).counts
    samples, steps = counts.samples, counts.steps
    statistics = Statistics(int(counts.accepted), int(counts.rejected), int(counts.evaluations), seconds)
    blamed = status in (Status.STEP_COLLAPSE, Status.NOT_FINITE) and counts.failed_kernel == 0
    is_singular = status is Status.SINGULAR and counts.failed_kernel > 0
    return RawRun(
        record.t[:samples].copy(),
        np.ascontiguousarray(record.x[:samples].T),
        status,
        statistics,
        Run(run.block).time,
        counts.blamed_state if blamed else None,
        counts.failed_kernel - 1 if is_singular else None,
        _dense_output(run, record, steps) if record.keep_dense else None,
        () if run.jumps is None else run.jumps.impulses,
    )


def _dense_output(run: CompiledRun, record: Record, steps: int) -> DenseOutput:
    breaks, pieces = record.breaks[: steps + 1].copy(), record.pieces[:steps].copy()
    if steps and not (run.jumps is not None and run.jumps.has_just_passed(run.block)):
        return DenseOutput(breaks, pieces)
    piece = np.zeros((1, *record.pieces.shape[1:]))  # no step: the state stays what it was at this one time
    piece[0, 0], t = state_of(run.block), Run(run.block).time
    return DenseOutput(np.append(breaks if steps else t, t), np.concatenate([pieces, piece]))
