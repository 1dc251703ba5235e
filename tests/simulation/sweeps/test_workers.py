"""Executors whose workers never begin, or begin late."""

from __future__ import annotations

import concurrent.futures
import math
import threading
import time

import pytest

import symbody as sb
from tests.simulation.sweeps.test_sweep import same_bits, tops

Task = concurrent.futures.Future[object]


class Idle(concurrent.futures.Executor):
    """Has no worker: what it is given waits."""

    def __init__(self) -> None:
        self.tasks: list[Task] = []

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        self.tasks.append(concurrent.futures.Future())
        return self.tasks[-1]


class Slow(concurrent.futures.ThreadPoolExecutor):
    """Takes its time with each part."""

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        def later() -> object:
            time.sleep(0.3 if arguments else 0.0)
            return function(*arguments, **named)

        return super().submit(later)


class PartsAlone(concurrent.futures.Executor):
    """Knows no other function than that for parts."""

    def __init__(self) -> None:
        self._pool = Slow(1)

    def submit(self, function, /, payload, part, threads):  # type: ignore[no-untyped-def]
        return self._pool.submit(function, payload, part, threads)


def test_an_executor_without_workers_is_told_of() -> None:
    idle = Idle()
    with pytest.raises(sb.EnvironmentFault, match="sweep.no_worker_began") as fault:
        tops(executor=idle, part=1, patience=0.2)
    assert "0.2 s" in str(fault.value) and "patience" in str(fault.value)
    assert len(idle.tasks) > 1 and all(task.cancelled() for task in idle.tasks)


def test_workers_that_are_busy_are_told_of_and_can_be_waited_for() -> None:
    end = threading.Event()
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        pool.submit(end.wait)
        with pytest.raises(sb.EnvironmentFault, match="busy with something else"):
            tops(executor=pool, patience=0.2)
        timer = threading.Timer(0.3, end.set)
        timer.start()
        assert same_bits(tops(), tops(executor=pool, patience=math.inf))
        timer.join()


@pytest.mark.parametrize("executor", [Slow(1), PartsAlone()], ids=["slow", "parts alone"])
def test_a_worker_that_has_begun_may_take_its_time(executor: concurrent.futures.Executor) -> None:
    began = time.monotonic()
    assert same_bits(tops(), tops(executor=executor, part=6, patience=0.1))
    assert time.monotonic() - began > 0.3


@pytest.mark.parametrize("patience", [0, -1.0, math.nan, True, "long", None])
def test_patience_is_a_length_of_time(patience: float) -> None:
    with pytest.raises(sb.UsageError, match="sweep.patience"):
        tops(patience=patience)
