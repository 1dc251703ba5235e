"""Work beside precision of stiff motions: elastic segments, a bushing, contact and friction.

Every method works in a process of its own. Figures are processor time of one whole run, without forming and
compiling; a run that takes longer than the limit is cut, and the finer settings of its method are left out.
Errors are those of the places at the end, beside a motion far more exact than all others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from time import process_time
from typing import Final, NamedTuple

import numpy as np

from benchmarks.engines.stiff_methods import END, METHODS, exact_places
from benchmarks.process import Process, Step, Task
from benchmarks.stiff_problems import PROBLEMS, Floats
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, processor_seconds

LIMIT: Final = 30.0  # s that a run may take
BOUNDS: Final = (1e-3, 1e-5, 1e-8)
_PREPARING: Final = 300.0  # s that forming and compiling may take
_SHORT: Final = 0.5  # s, below which a run is repeated
_USELESS: Final = 0.1  # m or rad: an error that is no result
_MUJOCO: Final = "MuJoCo"


class Point(NamedTuple):
    """What one setting of a method costs [s of processor time] and how far its end is off [m or rad]."""

    method: str
    setting: str
    error: float
    seconds: float


class Diagram(NamedTuple):
    """The points of a problem, and what to say about what is missing among them."""

    points: Sequence[Point]
    notes: Sequence[str]


def measure(name: str, settings: Settings) -> Diagram:
    """Return the points of a problem by all methods that are installed."""
    exact, apart = exact_places(PROBLEMS[name])
    notes = [f"the reference, of order 8, is {apart:.0e} from one of order 5"]
    points: list[Point] = []
    for method, about in METHODS.items():
        if not about.is_installed:
            notes.append(f"{method}: not installed")
            continue
        with Process(attempt, name, method, settings.rounds) as process:
            stopped = process.ask("prepare", _PREPARING).stopped
            for setting in about.settings:
                if stopped:
                    break
                steps, stopped = (answer := process.ask(str(setting), settings.limit)).steps, answer.stopped
                points += _points(method, about.label(setting), steps, exact)
            if stopped:
                notes.append(f"{method}, {about.label(setting)}: {stopped}")
    return Diagram(points, notes)


def _points(method: str, setting: str, steps: Sequence[Step], exact: Floats) -> Iterator[Point]:
    """Yield what a round has measured, unless it was cut or its end is far off."""
    for step in steps:
        values = np.full(exact.shape, np.nan) if step.values is None else step.values
        error = float(np.abs(values - exact).max())
        if error < _USELESS:
            yield Point(method, setting, error, step.figure)


def attempt(name: str, method: str, rounds: int) -> Task:
    """Return what answers each setting with the time of its runs and the places at the end.

    A run that fails gives no step: finer settings may do.
    """
    run = None

    def task(word: str) -> Iterator[Step]:
        nonlocal run
        if run is None:
            run = METHODS[method].make(PROBLEMS[name])
            return
        try:
            start = process_time()
            end = run(float(word))
            spent = [process_time() - start]
        except RuntimeError:
            return
        if spent[0] < _SHORT:
            spent += [processor_seconds(lambda: run(float(word))) for _ in range(rounds - 1)]
        yield Step(word, sorted(spent)[len(spent) // 2], end)

    return task


def table(name: str, diagram: Diagram) -> Table:
    """Return the table of one problem."""
    rows = []
    for point in diagram.points:
        rivals = [other.seconds for other in diagram.points if other.error <= point.error]
        time = seconds_text(point.seconds) + ratio_text(point.seconds, min(rivals))
        rows.append((point.method, point.setting, f"{point.error:.1e}", time))
    notes = (
        f"processor time of a whole run of {END:g} s; in brackets over the fastest that is as exact",
        *diagram.notes,
    )
    return Table(f"stiff: {name}", ("integrator", "setting", "error [m, rad]", "time"), tuple(rows), notes)


def fastest(points: Iterable[Point], family: str, bound: float) -> Point | None:
    """Return the fastest point of a method, or of all of MuJoCo's, with an error below a bound."""
    fit = [
        point for point in points
        if point.error <= bound and family in (point.method, point.method.partition(" ")[0])
    ]  # fmt: skip
    return min(fit, key=lambda point: point.seconds, default=None)


def summary(results: Mapping[str, Diagram]) -> Table:
    """Return the table of the fastest runs below each bound, with their errors."""
    families = (*(name for name in METHODS if not name.startswith(_MUJOCO)), _MUJOCO)
    rows = []
    for name, diagram in results.items():
        for bound in BOUNDS:
            cells = (_cell(fastest(diagram.points, family, bound)) for family in families)
            rows.append((name, f"{bound:.0e}", *cells))
    notes = ("fastest setting with an error below the bound, and its error",)
    return Table("stiff: fastest", ("motion", "error below", *families), tuple(rows), notes)


def _cell(point: Point | None) -> str:
    return "" if point is None else f"{seconds_text(point.seconds)} ({point.error:.0e})"


def tables(settings: Settings) -> Iterator[Table]:
    """Yield a table for each problem, and that of the fastest."""
    limited = replace(settings, limit=min(settings.limit, LIMIT))
    results = {}
    for name in PROBLEMS:
        results[name] = measure(name, limited)
        yield table(name, results[name])
    yield summary(results)
