"""Jobs: work that takes long, in processes of their own, with stages to watch and a way to end it."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass, field, replace
from threading import Condition, Thread
from typing import Any, Final

from symbody.builder.page_problems import fault_problem, page_problem
from symbody.builder.refusal import refusal
from symbody.builder.settings import ServerLimits
from symbody.builder.task_failure import TaskFailure
from symbody.builder.workers import Reserve, Worker
from symbody.errors import Problem, SymbodyError

Payload = dict[str, Any]

_WAIT: Final = 1.0  # how long a page is kept waiting for news [s]
_MOST_KEPT: Final = 20  # jobs whose results are remembered
_MOST_RUNS: Final = 3  # finished jobs whose process stays, to compute further outputs or write further tabs
_HOLDING: Final = ("simulate", "equations")  # jobs whose process has more to give


@dataclass(frozen=True, slots=True)
class JobState:
    """What is known of a job.

    Attributes
    ----------
    version : int
        Grows with each change.
    stages : tuple of str
        All stages until now, the last of them under way.
    begun, ended : float
        Times of the system's steady clock [s].
    """

    kind: str
    state: str = "running"
    version: int = 0
    stages: tuple[str, ...] = ()
    percent: int | None = None
    begun: float = field(default_factory=time.monotonic)
    ended: float | None = None
    result: Any = None
    problems: tuple[Any, ...] = ()

    def answer(self) -> dict[str, Any]:
        """Return what the page is told."""
        return {
            "kind": self.kind,
            "state": self.state,
            "seen": self.version,
            "stage": self.stages[-1] if self.stages else "",
            "stages": list(self.stages),
            "percent": self.percent,
            "elapsed": round((self.ended or time.monotonic()) - self.begun, 2),
            "result": self.result,
            "problems": list(self.problems),
        }


class Jobs:
    """All jobs of a run of the server."""

    def __init__(self, reserve: Reserve, limits: ServerLimits) -> None:
        self._reserve = reserve
        self._limits = limits
        self._news = Condition()
        self._states: dict[str, JobState] = {}
        self._workers: dict[str, Worker] = {}

    def start(self, kind: str, payload: Payload) -> str:
        """Begin a job and return its identifier.

        Raises
        ------
        UsageError
            If too many are running.
        """
        with self._news:
            running = [state for state in self._states.values() if state.state == "running"]
            if len(running) >= self._limits.jobs:
                raise refusal(
                    "builder.too_many_jobs",
                    kind,
                    f"{len(running)} jobs are running already",
                    fix="wait for one of them, or cancel it",
                )
            job = secrets.token_hex(16)
            self._workers[job] = self._reserve.take()
            self._states[job] = JobState(kind)
            self._forget()
        try:
            Thread(target=self._run_job, args=(job, kind, payload), daemon=True).start()
        except RuntimeError as error:  # the system has no thread left
            self._end(job, "failed", problems=(fault_problem(error),))
            self._release(job)
        return job

    def state(self, job: str, seen: int) -> dict[str, Any]:
        """Return the state of a job: when it is newer than the one seen, or after a second."""
        with self._news:
            self._find_job(job)
            self._news.wait_for(lambda: job not in self._states or self._states[job].version > seen, _WAIT)
            return self._find_job(job).answer()

    def cancel(self, job: str) -> dict[str, Any]:
        """End a job at once; one that has ended stays as it is."""
        with self._news:
            state = self._find_job(job)
            if state.state == "running":
                self._store_state(job, replace(state, state="cancelled", ended=time.monotonic()))
                self._workers.pop(job).kill()
            return self._find_job(job).answer()

    def ask(self, job: str, task: str, payload: Payload) -> Any:
        """Return what a task returns in the process of a finished run, which holds the run.

        Raises
        ------
        UsageError
            If that process is there no more.
        TaskFailure
            If the task fails.
        """
        with self._news:
            self._find_job(job)
            worker = self._workers.get(job)
            if worker is None or self._states[job].state != "done":
                raise refusal(
                    "builder.run_forgotten",
                    job,
                    "this run is no longer available",
                    "newer runs replaced it",
                    "simulate again",
                )
        until = time.monotonic() + self._limits.check
        try:
            return worker.run(task, payload, is_over=lambda: time.monotonic() > until)
        except TimeoutError:
            raise refusal("builder.time_limit", task, "this takes too long", fix="simulate again") from None

    def _run_job(self, job: str, kind: str, payload: Payload) -> None:
        until = time.monotonic() + self._limits.job
        worker = self._workers.get(job)
        if worker is None:  # it was cancelled before it began
            return
        try:
            result = worker.run(
                kind, payload, lambda *news: self._note(job, *news), lambda: time.monotonic() > until
            )
            self._end(job, "done", result=result)
        except TaskFailure as failure:
            self._end(job, "failed", problems=tuple(failure.problems))
        except TimeoutError:
            what = f"the job took longer than {self._limits.job:g} s"
            problem = page_problem(
                Problem("builder.time_limit", kind, what, fix="make the model smaller"), {}
            )
            self._end(job, "failed", problems=(problem,))
        except SymbodyError as error:
            self._end(job, "failed", problems=tuple(page_problem(each, {}) for each in error.problems))
        except Exception as error:  # a fault of ours: the job ends, and the page reads why
            self._end(job, "failed", problems=(fault_problem(error),))
        finally:
            self._release(job)

    def _note(self, job: str, stage: str, percent: int | None) -> None:
        with self._news:
            state = self._states.get(job)
            if state is None or state.state != "running":
                return
            stages = state.stages if stage in state.stages[-1:] else (*state.stages, stage)
            self._store_state(job, replace(state, stages=stages, percent=percent))

    def _end(self, job: str, word: str, result: Any = None, problems: tuple[Any, ...] = ()) -> None:
        with self._news:
            state = self._states.get(job)
            if state is not None and state.state == "running":  # not cancelled
                ended = replace(state, state=word, result=result, problems=problems, ended=time.monotonic())
                self._store_state(job, ended)

    def _store_state(self, job: str, state: JobState) -> None:
        """Store a newer state; the lock is held."""
        self._states[job] = replace(state, version=state.version + 1)
        self._news.notify_all()

    def _release(self, job: str) -> None:
        """End the process of a job, unless it holds a run that may be looked at further."""
        with self._news:
            state = self._states.get(job)
            runs = [each for each in self._workers if self._holds_run(each)]
            idle = [] if state is None or self._holds_run(job) else [job]
            ended = [
                self._workers.pop(each) for each in (*idle, *runs[:-_MOST_RUNS]) if each in self._workers
            ]
        for worker in ended:
            worker.kill()

    def _holds_run(self, job: str) -> bool:
        state = self._states.get(job)
        return state is not None and state.kind in _HOLDING and state.state == "done"

    def _forget(self) -> None:
        """Drop the oldest results; the lock is held."""
        ended = [job for job, state in self._states.items() if state.state != "running"]
        for job in ended[:-_MOST_KEPT]:
            del self._states[job]
            worker = self._workers.pop(job, None)
            if worker is not None:
                worker.kill()

    def _find_job(self, job: str) -> JobState:
        state = self._states.get(job)
        if state is None:
            raise refusal("builder.unknown_job", job[:40], "there is no such job", fix="start it again")
        return state
