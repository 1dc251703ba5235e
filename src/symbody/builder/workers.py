"""Workers: processes that can be killed at any instant, with one of them warm in reserve."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from threading import Condition, Lock
from typing import Any, Final

from symbody.builder.page_problems import page_problem
from symbody.builder.refusal import refusal
from symbody.builder.task_failure import TaskFailure
from symbody.builder.worker_process import run_worker
from symbody.errors import Problem

OnStage = Callable[[str, int | None, Any], None]
Payload = dict[str, Any]

_TICK: Final = 0.05
# How long an older request may still compute when a newer one waits [s]: a new process takes as long to load,
# and forms the mechanism anew.
_GRACE: Final = 2.5


class Worker:
    """One process that runs one task at a time."""

    def __init__(self) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=run_worker, args=(theirs,), daemon=True, name="symbody worker")
        self._process.start()
        theirs.close()
        self._turn = Lock()
        self._is_loaded = False

    @property
    def is_alive(self) -> bool:
        """Whether it can take tasks."""
        return self._process.is_alive()

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid or 0

    def run(
        self,
        task: str,
        payload: Payload,
        on_stage: OnStage | None = None,
        is_over: Callable[[], bool] = lambda: False,
    ) -> Any:
        """Return what a task returns.

        Parameters
        ----------
        on_stage : callable, optional
            Is called with the name of each stage, and the percentage or None.
        is_over : callable
            Whether nobody waits for the result any more; the process is killed then.

        Raises
        ------
        TaskFailure
            If the task fails or its process ends.
        TimeoutError
            If it was over.
        """
        with self._turn:
            self._load()
            return self._exchange(task, payload, on_stage, is_over)

    def load(self) -> None:
        """Wait until the process has loaded what tasks need; on a busy computer that takes longest.

        Raises
        ------
        TaskFailure
            If the process ends.
        """
        with self._turn:
            self._load()

    def _load(self) -> None:
        try:
            while not self._is_loaded:
                if self._pipe.poll(_TICK):
                    self._is_loaded = self._pipe.recv() == ("ready",)
                elif not self._process.is_alive() and not self._pipe.poll(0):
                    raise EOFError
        except (EOFError, OSError):
            self.kill()
            raise TaskFailure([_worker_lost()]) from None

    def _exchange(
        self, task: str, payload: Payload, on_stage: OnStage | None, is_over: Callable[[], bool]
    ) -> Any:
        try:
            self._pipe.send((task, payload))
            while True:
                while not self._pipe.poll(_TICK):
                    if is_over():
                        raise TimeoutError
                    if not self._process.is_alive() and not self._pipe.poll(0):
                        raise EOFError
                kind, *content = self._pipe.recv()
                if kind == "stage":
                    if on_stage is not None:
                        on_stage(*content)
                elif kind == "failed":
                    raise TaskFailure(content[0])
                else:
                    return content[0]
        except (EOFError, OSError) as error:
            self.kill()
            if isinstance(error, TimeoutError):
                raise
            raise TaskFailure([_worker_lost()]) from None

    def kill(self) -> None:
        """End the process at once, whatever it computes."""
        with suppress(ValueError, AttributeError):
            self._process.kill()
            self._process.join(1.0)
        with suppress(OSError):
            self._pipe.close()


class Reserve:
    """Workers on demand: once there is need, one is always on the way, because loading takes seconds."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._spare: Worker | None = None
        self._given: list[Worker] = []
        self._is_open = True

    def warm(self) -> None:
        """Begin a worker, if there is none in reserve."""
        with self._lock:
            if self._is_open and self._spare is None:
                self._spare = Worker()

    def take(self) -> Worker:
        """Return a worker, and begin another."""
        with self._lock:
            if not self._is_open:
                raise refusal("builder.closing", "", "the builder is shutting down", fix="start it again")
            worker = self._spare if self._spare is not None and self._spare.is_alive else Worker()
            self._spare = Worker()
            self._given = [each for each in self._given if each.is_alive] + [worker]
            return worker

    def close(self) -> None:
        """End all workers."""
        with self._lock:
            self._is_open = False
            for worker in (*self._given, *([self._spare] if self._spare else [])):
                worker.kill()


class NewestOnly:
    """Runs requests one at a time in one warm worker; of those that wait only the newest is run."""

    def __init__(self, reserve: Reserve) -> None:
        self._reserve = reserve
        self._worker: Worker | None = None
        self._free = Condition()
        self._is_busy = False
        self._newest: dict[tuple[str, str], int] = {}

    def run(self, task: str, payload: Payload, page: str, limit: float, turn: int = 0) -> Any:
        """Return what a task returns.

        Parameters
        ----------
        turn : int
            Place of the request among those of its page; 0: it is the newest.

        Raises
        ------
        UsageError
            If a newer request of the same page came, or time is up.
        TaskFailure
            If the task fails.
        """
        key = (page, task)
        with self._free:
            newest = self._newest.get(key, 0)
            ticket = turn or newest + 1
            if ticket < newest:
                raise _superseded_error()
            self._newest[key] = ticket
            while self._is_busy:
                self._free.wait()
                if self._newest[key] != ticket:
                    raise _superseded_error()
            self._is_busy = True
        try:
            if self._worker is None or not self._worker.is_alive:
                self._worker = self._reserve.take()
            self._worker.load()
            begun = time.monotonic()

            def is_over() -> bool:
                spent = time.monotonic() - begun
                return spent > limit or (self._newest[key] != ticket and spent > _GRACE)

            return self._worker.run(task, payload, is_over=is_over)
        except TimeoutError:
            if self._newest[key] != ticket:
                raise _superseded_error() from None
            raise refusal(
                "builder.time_limit",
                task,
                f"this takes longer than {limit:g} s",
                "the mechanism is large, or its loops are hard to close",
                "continue: saving, deriving and simulating have no such limit",
            ) from None
        finally:
            with self._free:
                self._is_busy = False
                self._free.notify_all()


def _superseded_error() -> Exception:
    return refusal(
        "builder.superseded", "", "a newer request replaced this one", fix="wait for the answer to that"
    )


def _worker_lost() -> dict[str, Any]:
    what = "the process that computed this has ended"
    cure = "try again, or make the model smaller"
    return page_problem(Problem("builder.worker_lost", "", what, "memory may have run out", cure), {})
