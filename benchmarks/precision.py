"""Work beside precision: what a setting of a method costs, and how far its motion is off."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from time import process_time
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.process import Step
from benchmarks.timing import processor_seconds

Floats = NDArray[np.float64]
PREPARING: Final = 300.0  # s that forming, compiling and references may take
_SHORT: Final = 0.5  # s, below which a run is repeated


class Point(NamedTuple):
    """What one setting of a method costs, and how far places are off.

    Attributes
    ----------
    family, method, setting : str
        What is compared with others, such as an engine or a law; how it moves; how finely.
    error : float
        Of places [m or rad].
    seconds : float
        Processor time of one run.
    """

    family: str
    method: str
    setting: str
    error: float
    seconds: float


class Diagram(NamedTuple):
    """The points of a problem, and what to say about what is missing among them."""

    points: Sequence[Point]
    notes: Sequence[str]


def points_of(
    family: str, method: str, setting: str, steps: Iterable[Step], exact: Floats, useless: float
) -> Iterator[Point]:
    """Yield what a round has measured, unless it was cut or its places are too far off to be a result."""
    for step in steps:
        if step.values is None:
            continue
        error = float(np.abs(step.values - exact).max())
        if error < useless:
            yield Point(family, method, setting, error, step.figure)


def timed(run: Callable[[], Floats], rounds: int) -> tuple[float, Floats]:
    """Return the processor time of a run, of a short one the median of all rounds, and what it returns."""
    start = process_time()
    values = run()
    spent = [process_time() - start]
    if spent[0] < _SHORT:
        spent += [processor_seconds(run) for _ in range(rounds - 1)]
    return sorted(spent)[len(spent) // 2], values


def fastest(points: Iterable[Point], family: str, bound: float) -> Point | None:
    """Return the fastest point of a family with an error up to a bound."""
    fit = [point for point in points if point.error <= bound and point.family == family]
    return min(fit, key=lambda point: point.seconds, default=None)
