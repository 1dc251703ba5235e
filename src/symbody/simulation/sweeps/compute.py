"""Computes the cases of a chunk: the arrays of the compiled loops, and the way to them in another process."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.machine import lanes
from symbody.kernels import block as at
from symbody.kernels.block import Breakpoint, Run, Verdict
from symbody.kernels.lanes.lane_block import LaneGroup
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, search_ahead
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Floats, Projector, RightHandSide
from symbody.simulation.native.lane_blocks import make_lane_block
from symbody.simulation.native.machine import lane_motions, many_motions
from symbody.simulation.sweeps.case_by_case import compute_case
from symbody.simulation.sweeps.records import NOT_STARTED, Chunk, LoopJob, Records, blocks
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.simulation.sweeps.switching_cases import SwitchingLoop, mode_rows
from symbody.simulation.sweeps.watched_cases import (
    WatchedLoop,
    case_function,
    case_numbers,
    watched_rows,
)
from symbody.single_flight import SingleFlight

Integers = NDArray[np.int64]

# Steps between two looks at whether the work is to stop.
_SLICE: Final = 1000


def compute_in_loop(job: LoopJob, chunk: Chunk, records: Records, stop: Integers, done: Integers) -> None:
    """Compute the cases of a chunk that have not ended, in one thread, without the interpreter's lock.

    Parameters
    ----------
    stop, done : arrays of one int
        Anything but 0 ends the loop; how many cases have ended.
    """
    records.codes[~np.isfinite(chunk.states).all(axis=1)] = NOT_STARTED
    direction = 1.0 if job.span[1] >= job.span[0] else -1.0
    breaks = _break_rows(_breakpoints(job, chunk), direction)
    numbers, closing = (case_numbers(function, chunk.parameters) for function in (job.function, job.closing))
    rhs = case_function(job.function, numbers, job.input_count, job.tables)
    projection = _projector(job, chunk, closing)
    block = _block(job, rhs, projection, breaks[0])
    every = np.broadcast_to(breaks, (chunk.count, breaks.shape[1]))
    work = np.zeros((chunk.count, chunk.atol.shape[1] - chunk.states.shape[1]))
    parts = [chunk.states, work, chunk.atol, every, *numbers, *closing]
    parts += [] if job.closing is None else [chunk.scales, chunk.sizes]
    projector = 0 if job.closing is None else job.closing.address
    if job.watch is not None:
        watched = watched_rows(job, job.watch, chunk)
        first, parts = sum(part.shape[1] for part in parts), [*parts, watched.rows]
        parts += [] if job.modes is None else [mode_rows(job.modes, chunk)]
        rows, before = np.ascontiguousarray(np.hstack(parts)), records.codes.copy()
        kind = WatchedLoop if job.modes is None else SwitchingLoop
        addresses = rhs.address, projector
        loop = kind(job, job.watch, addresses, block, rows, first, watched.fresh, records)
        verdicts = _verdicts(records)
        loop.run(verdicts, stop, done)
        _keep_verdicts(records, verdicts)
        loop.write_down(before)
        return
    rows = np.ascontiguousarray(np.hstack(parts))
    in_lanes = bool(job.lanes and chunk.count >= lanes() and job.state_size)
    if in_lanes:
        wide = job.function.in_lanes()
        block = make_lane_block(block, rhs, wide.work_size, job.method.tableau)
        run = partial(lane_motions(), rhs.address, wide.address, projector, address(block))
    else:
        run = partial(many_motions(), rhs.address, projector, address(block))
    verdicts = _verdicts(records)
    x, scratch = np.ascontiguousarray(records.x), np.zeros(job.times.size)
    arrays = [*map(address, (rows, job.times, scratch, x, verdicts))]
    code = at.RUNNING
    while code == at.RUNNING and stop[0] == 0:
        code = run(*rows.shape, *arrays, _SLICE)
        done[0] = LaneGroup(block).cases_ended if in_lanes else Run(block).cases.ended
    records.x[:] = x
    _keep_verdicts(records, verdicts)


def _keep_verdicts(records: Records, verdicts: Floats) -> None:
    places = Verdict.layout
    records.codes[:], records.reached[:] = verdicts[:, places["code"]], verdicts[:, places["reached"]]
    records.counts[:] = verdicts[:, Verdict.fields["counts"].place :]


def _block(job: LoopJob, rhs: RightHandSide, projector: Projector, breaks: Floats) -> Floats:
    """Return the block of one motion, with room for the numbers of a case."""
    method, n = job.method, job.state_size + (job.watch is not None)
    goal = make_goal(job.span, job.rtol, np.ones(n), method.max_step, NO_BREAKPOINTS)
    goal = goal._replace(
        max_trials=job.max_steps,
        stop_when_stiff=job.stop_when_stiff,
        breaks=breaks.reshape(-1, Breakpoint.size),
    )
    first_step = 0.0 if method.first_step is None else float(method.first_step)
    block = make_block(rhs, projector, method.tableau, goal, np.zeros(n), job.span[0], first_step)
    room = Run(block).room
    room.times = room.samples = job.times.size
    return block


def _verdicts(records: Records) -> Floats:
    """Return what is known of the cases so far."""
    return np.column_stack([records.codes, records.reached, records.counts]).astype(np.float64)


def _breakpoints(job: LoopJob, chunk: Chunk) -> Sequence[Breakpoints]:
    """Return the breakpoints of all cases, or one for all."""
    if job.breakpoints is not None:
        return job.breakpoints
    found = search_ahead(job.functions_of_time(with_parameters=True), job.span, chunk.parameters)
    return [own.jumps_alone() if isinstance(job.method, FixedStep) else own for own in found]


def _break_rows(breakpoints: Sequence[Breakpoints], direction: float) -> Floats:
    """Return the breakpoints of each case as a row, the last one repeated where others have more."""
    tables = [np.column_stack(own.order_along(direction)).astype(np.float64) for own in breakpoints]
    most = max(len(table) for table in tables)
    return np.stack([table[np.minimum(np.arange(most), len(table) - 1)].ravel() for table in tables])


def _projector(job: LoopJob, chunk: Chunk, numbers: tuple[Floats, Floats]) -> Projector:
    """Return what projects, with room for the numbers of one case."""
    closing = job.closing
    if closing is None:
        return NOTHING_TO_PROJECT
    return Projector(
        *case_function(closing, numbers, job.input_count, job.tables)[:-1],
        len(closing.signature.q),
        np.zeros(chunk.scales.shape[1]),
        job.limit,
        np.zeros(chunk.sizes.shape[1]),
        job.rounding,
        sum(len(output.values) for output in closing.outputs),
    )


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
