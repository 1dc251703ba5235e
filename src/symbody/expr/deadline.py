"""How long a derivation may take: stages that are named, and checks where the work is done.

A check is cheap, so it stands wherever a derivation spends its time: with every thousandth node of a graph,
and in the passes over them. It raises before anything is changed, so a graph is whole after it, and what was
found before serves the next attempt.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from numbers import Real
from typing import Final, TypeVar

from symbody.errors import Problem, TimeLimitError, UsageError

Result = TypeVar("Result")

# Nodes between two checks, less one: a power of 2, some milliseconds.
TICK: Final = 1023


class Deadline:
    """A time at which work has to end, and what has been done of it."""

    def __init__(self, limit: float, work: str, cure: str) -> None:
        self.limit = limit
        self.work = work
        self.cure = cure
        self.end = time.perf_counter() + limit
        self.notes: tuple[str, ...] = ()
        self.stages: list[tuple[str, float]] = []  # names and times at which they began

    def error(self) -> TimeLimitError:
        """Return the problem for a limit that has passed, with the longest stages."""
        begins = [begin for _, begin in self.stages]
        finished = [(name, end - begin) for (name, begin), end in zip(self.stages, begins[1:], strict=False)]
        stage = self.stages[-1][0] if self.stages else self.work
        longest = sorted(finished, key=lambda done: -done[1])[:3]
        stages = ", ".join(f"{name} ({spent:.2g} s)" for name, spent in finished if (name, spent) in longest)
        problem = Problem(
            "time.over_limit",
            f"stage {stage}",
            what=f"{self.work} takes longer than time_limit = {self.limit:g} s",
            why=f"finished stages, longest first: {stages}" if stages else "it is the first stage",
            fix=f"allow more time, or {self.cure}",
        )
        return TimeLimitError(problem, stage=stage, finished=tuple(finished), notes=self.notes)


_CURRENT: Final[ContextVar[Deadline | None]] = ContextVar("deadline", default=None)
_WATCH: Final[ContextVar[Callable[[str], object] | None]] = ContextVar("watch", default=None)


def in_time(seconds: float | None, work: str, cure: str, do: Callable[[], Result]) -> Result:
    """Call `do` within a time limit; of nested limits the earlier end holds.

    Raises
    ------
    UsageError
        If the limit is not a positive number of seconds.
    TimeLimitError
        When time is up. It holds on to nothing that was made.
    """
    check_limit(seconds)
    if seconds is None:
        return do()
    outer, own = _CURRENT.get(), Deadline(float(seconds), work, cure)
    token = _CURRENT.set(own if outer is None or own.end < outer.end else outer)
    try:
        return do()
    except TimeLimitError as late:
        found = TimeLimitError(*late.problems, stage=late.stage, finished=late.finished, notes=late.notes)
    finally:
        _CURRENT.reset(token)
    raise found  # anew: the frames behind the other one hold the graph


def check_limit(seconds: float | None) -> None:
    """Refuse a limit that is not a positive number of seconds.

    Raises
    ------
    UsageError
        If it is not a positive number of seconds.
    """
    if seconds is None:
        return
    number = float(seconds) if isinstance(seconds, Real) and not isinstance(seconds, bool) else math.nan
    if not number > 0.0:
        raise UsageError(
            Problem("time.limit", "time_limit", f"time_limit = {seconds!r} is not a positive time", "",
                    "give seconds, more than 0, or leave it out")
        )  # fmt: skip


def check() -> None:
    """Raise if time is up.

    Raises
    ------
    TimeLimitError
        With the stage, and what was done before it.
    """
    deadline = _CURRENT.get()
    if deadline is not None and time.perf_counter() > deadline.end:
        raise deadline.error()


@contextmanager
def watch_stages(watch: Callable[[str], object]) -> Iterator[None]:
    """Call `watch` with the name of each stage that begins in this context; outer ones go on watching."""
    outer = _WATCH.get()

    def watch_all(stage: str) -> None:
        if outer is not None:
            outer(stage)
        watch(stage)

    token = _WATCH.set(watch_all)
    try:
        yield
    finally:
        _WATCH.reset(token)


def begin(stage: str, notes: tuple[str, ...] = ()) -> None:
    """Begin a stage, which ends the one before; `notes` say what was chosen until now."""
    watch = _WATCH.get()
    if watch is not None:
        watch(stage)
    deadline = _CURRENT.get()
    if deadline is not None:
        deadline.stages.append((stage, time.perf_counter()))
        deadline.notes += notes
        check()
