"""The cases of a part, computed: the arrays of the compiled loops, and the way to them in another process."""

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
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, find_breakpoints
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, goal_of
from symbody.simulation.native.cases import Cases, Outcome, run_cases
from symbody.simulation.native.interface import Memory, Projector, Record, RightHandSide
from symbody.simulation.native.lanes.arithmetic import WIDTH
from symbody.simulation.native.lanes.cases import Single, run_cases_in_lanes
from symbody.simulation.native.lanes.steps import ONE, TRIALS, Bundle
from symbody.simulation.native.run import fresh_memory, method_arrays
from symbody.simulation.sweeps.job import NOT_STARTED, Job, Part, Records, Signal, blocks
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# A register, and a line of the processor's cache, has so many bytes at most: what begins at a multiple of it
# is loaded by one access.
_LINE: Final = 64
# Cases whose breakpoints are looked for at once.
_TOGETHER: Final = 256


def compute(job: Job, part: Part, records: Records, stop: Integers, done: Integers) -> None:
    """Compute the cases of a part that have not ended, in one thread, without the interpreter's lock."""
    records.codes[~np.isfinite(part.states).all(axis=1)] = NOT_STARTED
    method = job.method
    breakpoints = _breakpoints(job, part)
    cases = _cases(job, part, breakpoints)
    single = _single(job, cases, breakpoints)
    outcome = Outcome(records.x, records.codes, records.counts, records.reached, stop, done)
    first_step = 0.0 if method.first_step is None else float(method.first_step)
    if job.lanes and part.count >= WIDTH and job.state_size:
        function = job.function.in_lanes()
        wide = single.rhs._replace(
            address=function.address,
            n_u=single.rhs.n_u * WIDTH,
            parameters=_aligned(single.rhs.parameters.size * WIDTH),
            constants=_aligned(single.rhs.constants.size * WIDTH),
            work=_aligned(function.work_size),
            clock=_aligned(WIDTH),
        )
        run_cases_in_lanes(single, wide, _bundle(single.memory), job.span[0], first_step, cases, outcome)
    else:
        run_cases(*single, job.span[0], first_step, cases, outcome)


def _breakpoints(job: Job, part: Part) -> Sequence[Breakpoints]:
    """Return the breakpoints of all cases, or one for all."""
    if job.breakpoints is not None:
        return job.breakpoints
    functions = time_functions(job.function.sequence, {}, with_parameters=True)
    if functions is None:
        return [NO_BREAKPOINTS]
    found: list[Breakpoints] = []
    for first, last in blocks(part.count, _TOGETHER):
        found += find_breakpoints(functions, job.span, part.parameters[first:last])
    return found


def _cases(job: Job, part: Part, breakpoints: Sequence[Breakpoints]) -> Cases:
    sizes = [own.longest.size for own in breakpoints]
    firsts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    nothing = np.zeros((part.count, 0))
    closing = job.closing
    return Cases(
        _copied(part.states),
        _copied(part.parameters),
        _constants(job.function, part.parameters),
        nothing if closing is None else _copied(part.parameters),
        nothing if closing is None else _constants(closing, part.parameters),
        _copied(part.scales),
        _copied(part.sizes),
        _copied(part.atol),
        firsts if firsts.size == part.count else np.zeros(part.count, dtype=np.int64),
    )


def _copied(array: Floats) -> Floats:
    """Return an array that can be written to: those of a message cannot, and numba would compile anew."""
    return np.array(array, dtype=np.float64, order="C")


def _single(job: Job, cases: Cases, breakpoints: Sequence[Breakpoints]) -> Single:
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
    goal = goal_of(job.span, job.rtol, np.ones(n), longest, breakpoints)
    goal = goal._replace(max_trials=job.max_steps, stop_when_stiff=job.stop_when_stiff)
    memory = fresh_memory(tableau, np.zeros(n), job.span[0])
    scratch = np.zeros((0, n)), np.zeros(1), np.zeros((0, memory.F.shape[1], n))
    record = Record(job.times, np.zeros(job.times.size), *scratch, False, False)
    return Single(rhs, _projector(job, cases), method_arrays(tableau), goal, memory, record)


def _bundle(memory: Memory) -> Bundle:
    """Return what all lanes need, in which nothing is computed yet."""
    n = memory.K.shape[1] * WIDTH
    trial, minus_zero = _aligned(TRIALS, WIDTH), _aligned(1, n)
    trial[ONE] = 1.0
    minus_zero[:] = -0.0
    tolerances = _aligned(1, n)
    tolerances[:] = 1.0
    return Bundle(
        _aligned(memory.vectors.shape[0], n),
        _aligned(memory.K.shape[0], n),
        _aligned(memory.F.shape[1], n),
        _aligned(1, n),
        _aligned(1, n),
        minus_zero,
        tolerances,
        trial,
        np.zeros((WIDTH, memory.real.size)),
        np.zeros((WIDTH, memory.counts.size), dtype=np.int64),
        np.full(WIDTH, -1, dtype=np.int64),
        np.zeros(WIDTH, dtype=np.int64),
    )


def _aligned(*shape: int) -> Floats:
    """Return zeros that begin where registers are loaded by one access."""
    size = math.prod(shape)
    room = np.zeros(size + _LINE // 8)
    first = -room.ctypes.data % _LINE // 8
    return room[first : first + size].reshape(shape)


def _constants(function: CompiledFunction, parameters: Floats) -> Floats:
    found = function.constants(parameters)
    if found.ndim == 1:  # nothing to compute beforehand
        return np.zeros((parameters.shape[0], 0))
    return _copied(np.broadcast_to(found, (parameters.shape[0], found.shape[1])))


def _projector(job: Job, cases: Cases) -> Projector:
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


def run_part(payload: bytes, part: Part, threads: int) -> Records | str:
    """Compute a part in another process; return why it cannot be done there rather than raise.

    Whatever else comes back in place of records then comes from the executor itself.
    """
    try:
        job = _job(payload)
        records = Records.empty(part.first, part.count, job.times.size, job.state_size)
        signal = Signal.new()
        size = -(-part.count // max(threads, 1))
        ends = list(blocks(part.count, size))
        if len(ends) == 1:
            compute(job, part, records, signal.stop, signal.done)
        else:
            with ThreadPoolExecutor(len(ends)) as pool:
                tasks = [
                    pool.submit(
                        compute, job, part.cut(*both), records.cut(*both), signal.stop, Signal.new().done
                    )
                    for both in ends
                ]
                for task in tasks:
                    task.result()
    except Exception as error:  # it may not be known where the answer is read
        return f"{type(error).__name__}: {error}"
    return records


# A part may be computed in several threads of a worker.
_JOBS: Final[SingleFlight[bytes, Job]] = SingleFlight(4)


def _job(payload: bytes) -> Job:
    """Return a job whose functions are compiled once in a process."""
    return _JOBS.get(payload, partial(_unpacked, payload))


def _unpacked(payload: bytes) -> Job:
    job = pickle.loads(payload)
    if not isinstance(job, Job):
        raise TypeError(f"{type(job).__name__} is no job")
    return job
