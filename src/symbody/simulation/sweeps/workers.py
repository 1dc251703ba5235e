"""Computes the chunks of a sweep: by threads of this process, or by the workers of any Executor."""

from __future__ import annotations

import math
import os
import pickle
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final, NamedTuple, NoReturn

import numpy as np

from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.simulation.native.run import Progress
from symbody.simulation.status import Status
from symbody.simulation.sweeps.compute import compute_chunk, compute_in_loop
from symbody.simulation.sweeps.loop_job import LoopJob
from symbody.simulation.sweeps.records import CODES, NOT_ENDED, CaseDetails, Chunk, Records, blocks
from symbody.simulation.sweeps.sweep_job import SweepJob

# Time between two calls of progress, and two looks for Ctrl-C [s].
_TICK: Final = 0.1
# Chunks that wait with an executor at one time.
_WINDOW: Final = 64
# A chunk that was lost so often is tried alone, and then case by case, each given up if it is lost.
_SUSPECT: Final = 2
_GIVEN_UP: Final = 4
# Many cases: lanes are full, and what is lost or repeated is little. Few: all workers work.
_LARGEST_CHUNK: Final = 1024
_CHUNKS: Final = 16
# How long a worker is waited for: processes on slow disks take a minute to load what they need [s].
PATIENCE: Final = 300.0


class Workers(NamedTuple):
    """The threads and processes that compute.

    Attributes
    ----------
    executor : Executor or None
        None for threads of this process.
    threads : int
        Threads of this process, or of each worker.
    part : int or None
        How many cases make a chunk.
    patience : float
        How long an executor may take until one of its workers begins anything [s].
    """

    executor: Executor | None
    threads: int
    part: int | None
    patience: float = PATIENCE


@dataclass(frozen=True, slots=True)
class Listener:
    """What is called while the work goes on.

    Attributes
    ----------
    progress : callable or None
        With the share that is done; False ends the sweep.
    on_chunk : callable
        With the records of each chunk that is complete.
    notes : list of str
        What the caller should know of the workers; they add to it.
    """

    progress: Progress | None
    on_chunk: Callable[[Records], None]
    notes: list[str] = field(default_factory=list)


def check_workers(
    executor: Executor | None, threads: int | None, part: int | None, patience: float
) -> Workers:
    """Return the threads and processes that compute.

    Raises UsageError if threads, part, executor or patience have values without meaning.
    """
    problems = []
    for name, value in (("threads", threads), ("part", part)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
            problems.append(
                Problem(f"sweep.{name}", name, f"{name} = {value!r} is not a positive whole number", "",
                        "give a whole number, 1 or greater, or leave it out")
            )  # fmt: skip
    if executor is not None and not isinstance(executor, Executor):
        problems.append(
            Problem("sweep.executor", "executor", f"{type(executor).__name__} is not an Executor", "",
                    "give a concurrent.futures.Executor, such as Client(...).get_executor() of Dask")
        )  # fmt: skip
    if isinstance(patience, bool) or not isinstance(patience, int | float) or not patience > 0.0:
        problems.append(
            Problem("sweep.patience", "patience", f"patience = {patience!r} is not a valid duration", "",
                    "give seconds, or math.inf to wait for workers indefinitely")
        )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    usual = 1 if executor is not None else os.cpu_count() or 1
    return Workers(executor, usual if threads is None else threads, part, float(patience))


def cut_chunks(
    cases: Chunk, missing: Sequence[tuple[int, int]], size: int | None, least: int = 1
) -> list[Chunk]:
    """Return the missing cases in chunks of `size`, by default of `least` or more."""
    count = sum(stop - start for start, stop in missing)
    length = size or max(least, min(_LARGEST_CHUNK, -(-count // _CHUNKS)))
    return [
        cases.cut(start + low, start + high)
        for start, stop in missing
        for low, high in blocks(stop - start, length)
    ]


def compute_here(
    job: LoopJob, chunks: Sequence[Chunk], records: Records, threads: int, listener: Listener
) -> bool:
    """Compute chunks in threads of this process; return whether Ctrl-C ended it, between two steps."""
    stop, total = np.zeros(1, dtype=np.int64), max(1, sum(chunk.count for chunk in chunks))
    ended = [np.zeros(1, dtype=np.int64) for _ in chunks]
    interrupted = False
    if job.lanes:
        job.derivative.in_lanes()  # compiled once, not by each thread
    with ThreadPoolExecutor(threads) as pool:
        waiting: dict[Future[None], Records] = {}
        try:
            for chunk, done in zip(chunks, ended, strict=True):
                own = records.cut(chunk.first, chunk.first + chunk.count)
                waiting[pool.submit(compute_in_loop, job, chunk, own, stop, done)] = own
            while waiting:
                for task in wait(waiting, _TICK, FIRST_COMPLETED).done:
                    own = waiting.pop(task)
                    task.result()
                    if not (own.codes == NOT_ENDED).any():
                        listener.on_chunk(own)
                share = float(sum(done[0] for done in ended)) / total
                if listener.progress is not None and listener.progress(share) is False:
                    raise KeyboardInterrupt
        except KeyboardInterrupt:
            interrupted = True
        finally:
            stop[0] = 1  # leaving the pool waits for its threads
            for task in waiting:
                task.cancel()
    return interrupted


def compute_there(
    job: LoopJob | SweepJob, chunks: Sequence[Chunk], records: Records, workers: Workers, listener: Listener,
    *, has_results: bool = False,
) -> bool:  # fmt: skip
    """Compute chunks by the workers of the executor; return whether Ctrl-C, or that it broke, ended it.

    Chunks of workers that end too early are submitted anew. Raises EnvironmentFault if no worker began or
    could compute anything.

    Parameters
    ----------
    has_results : bool
        Whether these workers have computed other cases, which are kept whatever happens now.
    """
    assert workers.executor is not None
    if not chunks:
        return False
    dispatch = _Dispatch(job, chunks, records, workers, workers.executor, listener, has_results)
    try:
        dispatch.run()
    except (KeyboardInterrupt, BrokenExecutor):
        return True
    finally:
        dispatch.cancel()
    return False


class _Dispatch:
    """Chunks on their way to workers and back.

    Before them goes a call that takes no time, by which an executor shows whether it has a worker at all: a
    chunk that has not come back may be a long one, and not all executors report whether one has begun.
    """

    def __init__(
        self, job: LoopJob | SweepJob, chunks: Sequence[Chunk], records: Records, workers: Workers,
        executor: Executor, listener: Listener, has_results: bool,
    ) -> None:  # fmt: skip
        self.has_results, self._records, self._listener = has_results, records, listener
        self._payload, self._threads, self._executor = pickle.dumps(job), workers.threads, executor
        self._queue = list(reversed(chunks))
        self._failures = dict.fromkeys((chunk.first for chunk in chunks), 0)
        self._waiting: dict[Future[Records | str], Chunk] = {}
        self._total = max(1, sum(chunk.count for chunk in chunks))
        self._done = 0
        self._broken = ""
        self._patience, self._began = workers.patience, time.monotonic()
        self._probe: Future[int] | None = None
        if workers.patience < math.inf:
            with suppress(Exception):  # what is wrong with an executor shows when it is given chunks
                self._probe = executor.submit(os.getpid)

    def run(self) -> None:
        """Submit chunks until all are back.

        Raises EnvironmentFault if no worker begins or can compute anything; BrokenExecutor if the executor
        broke after some chunks had come back.
        """
        while self._waiting or (self._queue and not self._broken):
            self._submit()
            for task in wait(self._waiting, _TICK, FIRST_COMPLETED).done:
                self._probe = None  # a worker has begun, and the call is over in no time
                self._take_back(task, self._waiting.pop(task))
            waited = time.monotonic() - self._began
            if self._probe is not None and not self._probe.done() and waited >= self._patience:
                raise _no_worker_began(self._patience)
            progress = self._listener.progress
            if progress is not None and progress(self._done / self._total) is False:
                raise KeyboardInterrupt
        if self._broken:
            self._end()

    def cancel(self) -> None:
        """Withdraw all chunks."""
        for task in self._waiting:
            task.cancel()
        if self._probe is not None and not self._probe.done():  # some executors report that as a failure
            self._probe.cancel()

    def _submit(self) -> None:
        while self._queue and len(self._waiting) < _WINDOW and not self._broken:
            chunk = self._queue[-1]
            in_doubt = any(
                self._failures[each.first] >= _SUSPECT for each in (chunk, *self._waiting.values())
            )
            if self._waiting and in_doubt:
                return  # whose fault it is shows only where nothing else is computed
            try:
                task = self._executor.submit(compute_chunk, self._payload, chunk, self._threads)
            except (AssertionError, RuntimeError) as error:  # broken, closed, or may start no processes
                self._broken = f"{type(error).__name__}: {error}"
                return
            self._waiting[task] = self._queue.pop()

    def _take_back(self, task: Future[Records | str], chunk: Chunk) -> None:
        try:
            records = task.result()
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # cancelled, killed, unreachable: each executor has words of its own
            records = f"{type(error).__name__}: {error}"
            self._broken = records if isinstance(error, BrokenExecutor) else self._broken
        if isinstance(records, Records):
            self._records.put(records)
            self._done, self.has_results = self._done + chunk.count, True
            self._listener.on_chunk(records)
            return
        self._failures[chunk.first] += 1
        if self._broken:
            self._give_up(chunk, records)
        elif self._failures[chunk.first] < _GIVEN_UP:
            self._queue.insert(0, chunk)  # suspects come last, when everything else is safe
        elif not self.has_results:
            raise _no_worker(records)
        elif chunk.count > 1:  # whose fault it is
            for low, high in blocks(chunk.count, 1):
                self._queue.insert(0, chunk.cut(low, high))
                self._failures[chunk.first + low] = _GIVEN_UP - 1
        else:
            self._give_up(chunk, records)

    def _give_up(self, chunk: Chunk, why: str) -> None:
        cases = range(chunk.first, chunk.first + chunk.count)
        self._records.details.update(dict.fromkeys(cases, CaseDetails(f"lost: {why}")))
        self._records.codes[cases.start - self._records.first : cases.stop - self._records.first] = CODES[
            Status.WORKER_LOST
        ]

    def _end(self) -> NoReturn:
        """End the work of an executor that broke: whoever gave it chose where to compute.

        Raises EnvironmentFault if nothing was computed, else BrokenExecutor.
        """
        if not self.has_results:
            raise _no_worker(self._broken)
        self._listener.notes.append(
            f"the executor broke ({self._broken}): finished cases are kept; the same call with another "
            f"executor continues where a store= was given"
        )
        raise BrokenExecutor(self._broken)


def _no_worker(why: str) -> EnvironmentFault:
    return EnvironmentFault(
        Problem("sweep.no_worker", "executor", "no worker of the executor could compute a part", why,
                "install the same version of symbody and Python for all workers, give them memory for "
                "fewer cases with part=..., call sweep under `if __name__ == '__main__':` where processes "
                "are started, or leave executor out")
    )  # fmt: skip


def _no_worker_began(patience: float) -> EnvironmentFault:
    return EnvironmentFault(
        Problem("sweep.no_worker_began", "executor",
                f"no worker of the executor has started any work for {patience:g} s",
                "it has no workers, or all of them are busy with something else",
                "check that its workers run and are connected, wait longer with patience=... in seconds "
                "or math.inf, or leave executor out")
    )  # fmt: skip
