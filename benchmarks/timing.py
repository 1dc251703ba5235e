"""Timing on a noisy machine: many short samples, taken in turns, of which the median counts."""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter, process_time


@dataclass(frozen=True, slots=True)
class Settings:
    """How long to wait for one round of one engine [s], how many rounds to make; `long`: wait for peers."""

    limit: float = 60.0
    rounds: int = 5
    long: bool = False


def seconds(task: Callable[[], object]) -> float:
    """Return how long one run of `task` takes."""
    start = perf_counter()
    task()
    return perf_counter() - start


def processor_seconds(task: Callable[[], object]) -> float:
    """Return the processor time of one run of `task`, which must not call other processes."""
    start = process_time()
    kept = task()
    spent = process_time() - start
    del kept  # freeing the result is not part of making it
    return spent


def seconds_per_call(task: Callable[[], object], *, at_least: float = 0.02) -> float:
    """Return the time of one call, from a sample of calls lasting `at_least` seconds together.

    The first call is not counted.
    """
    task()
    count = 1
    while True:
        start = perf_counter()
        for _ in range(count):
            task()
        spent = perf_counter() - start
        if spent >= at_least:
            return spent / count
        count *= 2 if spent <= 0 else max(2, min(100, int(1.2 * at_least / spent)))


def in_turns(tasks: Mapping[str, Callable[[], float]], rounds: int) -> dict[str, list[float]]:
    """Return `rounds` samples of each task, all tasks taking one turn in every round."""
    samples: dict[str, list[float]] = {name: [] for name in tasks}
    for turn in range(rounds):
        for name in rotated(list(tasks), turn):
            gc.collect()
            samples[name].append(tasks[name]())
    return samples


def rotated(names: list[str], turn: int) -> list[str]:
    """Return `names` beginning with another one in every turn, so that none always runs after the same."""
    start = turn % len(names) if names else 0
    return names[start:] + names[:start]


def medians(samples: Mapping[str, list[float]]) -> dict[str, float]:
    """Return the median of each list that has an entry."""
    return {name: statistics.median(values) for name, values in samples.items() if values}
