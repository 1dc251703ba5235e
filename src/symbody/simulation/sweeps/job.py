"""What a worker is sent, what it computes, and what it sends back: nothing but code and numbers.

A case comes out the same whatever else is computed beside it, so results do not depend on how cases are cut
into parts, nor on who computes them.
"""

from __future__ import annotations

import math
import pickle
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.native import places
from symbody.simulation.native.cases import Cases, Outcome, run_cases
from symbody.simulation.native.interface import Goal, Projector, Record, RightHandSide
from symbody.simulation.native.run import fresh_memory, method_arrays

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Codes of cases besides those of the compiled loop.
NOT_ENDED: Final = -1
NOT_STARTED: Final = -2
WORKER_LOST: Final = -3


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """One sweep as a worker sees it.

    Attributes
    ----------
    function : CompiledFunction
        The derivative xdot, with what varies as its arguments p.
    closing : CompiledFunction or None
        Computes `constraints.PROJECTED`.
    times : (N,) array
        The samples to store.
    rounding, limit : float
        As in `Projector`.
    """

    function: CompiledFunction
    closing: CompiledFunction | None
    span: tuple[float, float]
    times: Floats
    method: Explicit | FixedStep
    rtol: float
    atol: float
    max_steps: int
    stop_when_stiff: bool
    rounding: float = 0.0
    limit: float = math.inf

    @property
    def state_size(self) -> int:
        """Number of speeds and coordinates."""
        return len(self.function.signature.u) + len(self.function.signature.q)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Some cases that are not yet computed; one row each.

    Attributes
    ----------
    first : int
        The number of the first.
    states : (cases, n) array
        First states x = (u, q); a row that is not finite is left out.
    parameters : (cases, n_p) array
        What varies.
    scales, sizes : (cases, constraints), (cases, n_q) arrays
        As in `Projector`.
    """

    first: int
    states: Floats
    parameters: Floats
    scales: Floats
    sizes: Floats

    @property
    def count(self) -> int:
        """How many cases."""
        return len(self.states)

    def cut(self, start: int, stop: int) -> Part:
        """Return some of the cases."""
        rows = slice(start, stop)
        return Part(
            self.first + start,
            self.states[rows],
            self.parameters[rows],
            self.scales[rows],
            self.sizes[rows],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What is known of some cases; one row each.

    Attributes
    ----------
    x : (cases, N, n) array
        The samples, not a number where a motion did not reach.
    codes : (cases,) array of int
        How each ended.
    counts : (cases, `places.COUNTS`) array of int
        What each cost, and what is to blame.
    reached : (cases,) array
        Time up to which each is known [s].
    """

    first: int
    x: Floats
    codes: Integers
    counts: Integers
    reached: Floats

    @classmethod
    def empty(cls, first: int, count: int, samples: int, states: int) -> Records:
        """Return records of cases that nothing is known of."""
        return cls(
            first,
            np.full((count, samples, states), np.nan),
            np.full(count, NOT_ENDED, dtype=np.int64),
            np.zeros((count, places.COUNTS), dtype=np.int64),
            np.full(count, np.nan),
        )

    @property
    def count(self) -> int:
        """How many cases."""
        return len(self.codes)

    def cut(self, start: int, stop: int) -> Records:
        """Return some of the cases, the same memory."""
        rows = slice(start, stop)
        return Records(
            self.first + start, self.x[rows], self.codes[rows], self.counts[rows], self.reached[rows]
        )

    def put(self, other: Records) -> None:
        """Take over what others know of some of these cases."""
        rows = slice(other.first - self.first, other.first - self.first + other.count)
        self.x[rows], self.codes[rows] = other.x, other.codes
        self.counts[rows], self.reached[rows] = other.counts, other.reached


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """What the one who waits and the compiled loop tell each other.

    Attributes
    ----------
    stop : array of one int
        Anything but 0 ends the loop.
    done : array of one int
        How many cases have ended.
    """

    stop: Integers
    done: Integers

    @classmethod
    def new(cls) -> Signal:
        """Return a signal that says nothing."""
        return cls(np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))


def compute(job: Job, part: Part, records: Records, stop: Integers, done: Integers) -> None:
    """Compute the cases of a part that have not ended, in one thread, without the interpreter's lock."""
    records.codes[~np.isfinite(part.states).all(axis=1)] = NOT_STARTED
    function, closing, tableau = job.function, job.closing, job.method.tableau
    start, end = job.span
    nothing = np.zeros((part.count, 0))
    cases = Cases(
        np.ascontiguousarray(part.states),
        np.ascontiguousarray(part.parameters),
        _constants(function, part.parameters),
        nothing if closing is None else np.ascontiguousarray(part.parameters),
        nothing if closing is None else _constants(closing, part.parameters),
        np.ascontiguousarray(part.scales),
        np.ascontiguousarray(part.sizes),
    )
    rhs = RightHandSide(
        function.address,
        len(function.signature.u),
        np.zeros(0),
        np.zeros(cases.parameters.shape[1]),
        np.zeros(cases.constants.shape[1]),
        np.zeros(function.work_size),
        np.zeros(1),
    )
    max_step = math.inf if job.method.max_step is None else float(job.method.max_step)
    goal = Goal(
        end,
        1.0 if end >= start else -1.0,
        job.rtol,
        np.full(job.state_size, job.atol),
        max_step,
        job.max_steps,
        job.stop_when_stiff,
    )
    n = job.state_size
    memory = fresh_memory(tableau, np.zeros(n), start)
    scratch = np.zeros((0, n)), np.zeros(1), np.zeros((0, memory.F.shape[1], n))
    record = Record(job.times, np.zeros(job.times.size), *scratch, False, False)
    outcome = Outcome(records.x, records.codes, records.counts, records.reached, stop, done)
    first_step = 0.0 if job.method.first_step is None else float(job.method.first_step)
    run_cases(
        rhs, _projector(job, cases), method_arrays(tableau), goal, memory, record, start, first_step,
        cases, outcome,
    )  # fmt: skip


def _constants(function: CompiledFunction, parameters: Floats) -> Floats:
    found = function.constants(parameters)
    if found.ndim == 1:  # nothing to compute beforehand
        return np.zeros((parameters.shape[0], 0))
    return np.ascontiguousarray(np.broadcast_to(found, (parameters.shape[0], found.shape[1])))


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


def blocks(count: int, size: int) -> Iterator[tuple[int, int]]:
    """Yield the ends of blocks of a size; the last may be shorter."""
    for start in range(0, count, size):
        yield start, min(start + size, count)


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


_LOCK: Final = threading.Lock()  # a part may be computed in several threads of a worker


def _job(payload: bytes) -> Job:
    """Return a job whose functions are compiled once in a process."""
    with _LOCK:
        return _unpacked(payload)


@lru_cache(maxsize=4)
def _unpacked(payload: bytes) -> Job:
    job = pickle.loads(payload)
    if not isinstance(job, Job):
        raise TypeError(f"{type(job).__name__} is no job")
    return job
