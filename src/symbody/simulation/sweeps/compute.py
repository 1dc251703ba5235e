"""Computes the cases of a chunk: the arrays of the compiled loops, and the way to them in another process."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.kernels import block as at
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, find_breakpoints
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.cases import Cases, Outcome
from symbody.simulation.native.description import Goal, Memory, Projector, Record, RightHandSide
from symbody.simulation.native.interface import fresh_memory, method_arrays
from symbody.simulation.native.lanes.arithmetic import WIDTH
from symbody.simulation.native.lanes.lane_cases import Single, run_cases_in_lanes
from symbody.simulation.native.lanes.lane_steps import ONE, TRIALS, Bundle
from symbody.simulation.native.layout import COUNTS
from symbody.simulation.native.machine import address, step_machine
from symbody.simulation.sweeps.case_by_case import compute_case
from symbody.simulation.sweeps.records import NOT_STARTED, Chunk, LoopJob, Records, Signal, blocks
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# A register, and a line of the processor's cache, has so many bytes at most: what begins at a multiple of it
# is loaded by one access.
_LINE: Final = 64
# Steps between two looks at whether the work is to stop.
_SLICE: Final = 1000
# Cases whose breakpoints are looked for at once.
_TOGETHER: Final = 256


def compute_in_loop(job: LoopJob, chunk: Chunk, records: Records, stop: Integers, done: Integers) -> None:
    """Compute the cases of a chunk that have not ended, in one thread, without the interpreter's lock."""
    records.codes[~np.isfinite(chunk.states).all(axis=1)] = NOT_STARTED
    method = job.method
    breakpoints = _breakpoints(job, chunk)
    cases = _cases(job, chunk, breakpoints)
    single = _single(job, cases, breakpoints)
    outcome = Outcome(records.x, records.codes, records.counts, records.reached, stop, done)
    first_step = 0.0 if method.first_step is None else float(method.first_step)
    if job.lanes and chunk.count >= WIDTH and job.state_size:
        function = job.function.in_lanes()
        wide = single.rhs._replace(
            address=function.address,
            n_u=single.rhs.n_u * WIDTH,
            parameters=_aligned_zeros(single.rhs.parameters.size * WIDTH),
            constants=_aligned_zeros(single.rhs.constants.size * WIDTH),
            work=_aligned_zeros(function.work_size),
            clock=_aligned_zeros(WIDTH),
        )
        run_cases_in_lanes(single, wide, _bundle(single.memory), job.span[0], first_step, cases, outcome)
    else:
        _run_one_by_one(job, single.rhs, single.projector, single.goal, cases, outcome, first_step)


def _run_one_by_one(
    job: LoopJob,
    rhs: RightHandSide,
    projector: Projector,
    goal: Goal,
    cases: Cases,
    outcome: Outcome,
    first_step: float,
) -> None:
    """Compute cases one after the other, with a look at the signal now and then."""
    count, samples, n = outcome.x.shape
    block = make_block(rhs, projector, job.method.tableau, goal, np.zeros(n), job.span[0], first_step)
    block[at.TIMES] = block[at.SAMPLE_ROOM] = samples
    firsts = block[at.BREAKS] + at.BREAK_SIZE * cases.first_breaks[:, np.newaxis]
    rows = np.hstack([
        cases.states, cases.atol, firsts, cases.parameters, cases.constants, cases.projector_parameters,
        cases.projector_constants, cases.scales, cases.sizes,
    ])  # fmt: skip
    verdicts = np.zeros((count, at.VERDICT_SIZE))
    verdicts[:, at.CODE], verdicts[:, at.REACHED] = outcome.codes, outcome.reached
    verdicts[:, at.VERDICT_COUNTS :][:, :COUNTS] = outcome.counts
    x, scratch = np.ascontiguousarray(outcome.x), np.zeros(samples)
    arrays = [*map(address, (job.times, scratch, x, verdicts))]
    functions = rhs.address, projector.address, address(block)
    code = at.RUNNING
    while code == at.RUNNING and outcome.stop[0] == 0:
        code = step_machine().run_cases(*functions, *rows.shape, address(rows), *arrays, _SLICE)
        outcome.done[0] = block[at.CASES_ENDED]
    outcome.x[:] = x
    outcome.codes[:], outcome.reached[:] = verdicts[:, at.CODE], verdicts[:, at.REACHED]
    outcome.counts[:] = verdicts[:, at.VERDICT_COUNTS :][:, :COUNTS]


def _breakpoints(job: LoopJob, chunk: Chunk) -> Sequence[Breakpoints]:
    """Return the breakpoints of all cases, or one for all."""
    if job.breakpoints is not None:
        return job.breakpoints
    functions = time_functions(job.function.sequence, {}, with_parameters=True)
    if functions is None:
        return [NO_BREAKPOINTS]
    found: list[Breakpoints] = []
    for first, last in blocks(chunk.count, _TOGETHER):
        found += find_breakpoints(functions, job.span, chunk.parameters[first:last])
    return found


def _cases(job: LoopJob, chunk: Chunk, breakpoints: Sequence[Breakpoints]) -> Cases:
    sizes = [own.longest.size for own in breakpoints]
    firsts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    nothing = np.zeros((chunk.count, 0))
    closing = job.closing
    return Cases(
        _copy(chunk.states),
        _copy(chunk.parameters),
        _constants(job.function, chunk.parameters),
        nothing if closing is None else _copy(chunk.parameters),
        nothing if closing is None else _constants(closing, chunk.parameters),
        _copy(chunk.scales),
        _copy(chunk.sizes),
        _copy(chunk.atol),
        firsts if firsts.size == chunk.count else np.zeros(chunk.count, dtype=np.int64),
    )


def _copy(array: Floats) -> Floats:
    """Return an array that can be written to: those of a message cannot, and numba would compile anew."""
    return np.array(array, dtype=np.float64, order="C")


def _single(job: LoopJob, cases: Cases, breakpoints: Sequence[Breakpoints]) -> Single:
    """Return the loop for one motion, with room for the numbers of one case."""
    function, tableau, n = job.function, job.method.tableau, job.state_size
    rhs = RightHandSide(
        function.address,
        len(function.signature.u),
        np.zeros(0),
        np.zeros(cases.parameters.shape[1]),
        np.zeros(cases.constants.shape[1]),
        np.zeros(function.work_size),
        np.zeros(1),
    )
    longest = math.inf if job.method.max_step is None else float(job.method.max_step)
    goal = make_goal(job.span, job.rtol, np.ones(n), longest, breakpoints)
    goal = goal._replace(max_trials=job.max_steps, stop_when_stiff=job.stop_when_stiff)
    memory = fresh_memory(tableau, np.zeros(n), job.span[0])
    scratch = np.zeros((0, n)), np.zeros(1), np.zeros((0, memory.F.shape[1], n))
    record = Record(job.times, np.zeros(job.times.size), *scratch, False, False)
    return Single(rhs, _projector(job, cases), method_arrays(tableau), goal, memory, record)


def _bundle(memory: Memory) -> Bundle:
    """Return what all lanes need, in which nothing is computed yet."""
    n = memory.K.shape[1] * WIDTH
    trial, minus_zero = _aligned_zeros(TRIALS, WIDTH), _aligned_zeros(1, n)
    trial[ONE] = 1.0
    minus_zero[:] = -0.0
    tolerances = _aligned_zeros(1, n)
    tolerances[:] = 1.0
    return Bundle(
        _aligned_zeros(memory.vectors.shape[0], n),
        _aligned_zeros(memory.K.shape[0], n),
        _aligned_zeros(memory.F.shape[1], n),
        _aligned_zeros(1, n),
        _aligned_zeros(1, n),
        minus_zero,
        tolerances,
        trial,
        np.zeros((WIDTH, memory.real.size)),
        np.zeros((WIDTH, memory.counts.size), dtype=np.int64),
        np.full(WIDTH, -1, dtype=np.int64),
        np.zeros(WIDTH, dtype=np.int64),
    )


def _aligned_zeros(*shape: int) -> Floats:
    """Return zeros that begin where registers are loaded by one access."""
    size = math.prod(shape)
    room = np.zeros(size + _LINE // 8)
    first = -room.ctypes.data % _LINE // 8
    return room[first : first + size].reshape(shape)


def _constants(function: CompiledFunction, parameters: Floats) -> Floats:
    found = function.constants(parameters)
    if found.ndim == 1:  # nothing to compute beforehand
        return np.zeros((parameters.shape[0], 0))
    return _copy(np.broadcast_to(found, (parameters.shape[0], found.shape[1])))


def _projector(job: LoopJob, cases: Cases) -> Projector:
    """Return what projects, with room for the numbers of one case."""
    closing = job.closing
    if closing is None:
        return NOTHING_TO_PROJECT
    return Projector(
        closing.address,
        len(closing.signature.u),
        np.zeros(0),
        np.zeros(cases.projector_parameters.shape[1]),
        np.zeros(cases.projector_constants.shape[1]),
        np.zeros(closing.work_size),
        np.zeros(1),
        len(closing.signature.q),
        np.zeros(cases.scales.shape[1]),
        job.limit,
        np.zeros(cases.sizes.shape[1]),
        job.rounding,
        np.zeros((1, closing.sequence.output_size)),
    )


def compute_chunk(payload: bytes, chunk: Chunk, threads: int) -> Records | str:
    """Compute a chunk in another process; return why it cannot be done there rather than raise.

    Whatever else comes back in place of records then comes from the executor itself.
    """
    try:
        job = _JOBS.get(payload, partial(_unpack, payload))
        options = job.options if isinstance(job, SweepJob) else job
        states = len(job.eqs.state_names) if isinstance(job, SweepJob) else job.state_size
        records = Records.empty(chunk.first, chunk.count, options.times.size, states)
        if isinstance(job, SweepJob):
            for case in range(chunk.first, chunk.first + chunk.count):
                compute_case(job, case, records)
        else:
            _compute_in_threads(job, chunk, records, threads)
    except Exception as error:  # it may not be known where the answer is read
        return f"{type(error).__name__}: {error}"
    return records


def _compute_in_threads(job: LoopJob, chunk: Chunk, records: Records, threads: int) -> None:
    signal = Signal.new()
    ends = list(blocks(chunk.count, -(-chunk.count // max(threads, 1))))
    if len(ends) == 1:
        compute_in_loop(job, chunk, records, signal.stop, signal.done)
        return
    with ThreadPoolExecutor(len(ends)) as pool:
        futures = [
            pool.submit(
                compute_in_loop, job, chunk.cut(*both), records.cut(*both), signal.stop, Signal.new().done
            )
            for both in ends
        ]
        for future in futures:
            future.result()


# A chunk may be computed in several threads of a worker; its functions are compiled once in a process.
_JOBS: Final[SingleFlight[bytes, LoopJob | SweepJob]] = SingleFlight(4)


def _unpack(payload: bytes) -> LoopJob | SweepJob:
    job = pickle.loads(payload)
    if not isinstance(job, LoopJob | SweepJob):
        raise TypeError(f"{type(job).__name__} is not a job")
    return job
