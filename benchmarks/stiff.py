"""Work beside precision of stiff motions: elastic segments, a bushing, contact and friction.

Every method works in a process of its own. Figures are processor time of one whole run, without forming and
compiling; a run that takes longer than the limit is cut, and the finer settings of its method are left out.
Errors are those of the places at the end, beside a motion far more exact than all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from benchmarks.engines.stiff_methods import END, METHODS, exact_places
from benchmarks.precision import PREPARING, Diagram, Point, fastest, points_of, timed
from benchmarks.process import Process, Step, Task
from benchmarks.stiff_problems import PROBLEMS
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings

LIMIT: Final = 30.0  # s that a run may take
BOUNDS: Final = (1e-3, 1e-5, 1e-8)
_USELESS: Final = 0.1  # m or rad: an error that is no result
_MUJOCO: Final = "MuJoCo"


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
            stopped = process.ask("prepare", PREPARING).stopped
            for setting in about.settings:
                if stopped:
                    break
                steps, stopped = (answer := process.ask(str(setting), settings.limit)).steps, answer.stopped
                points += points_of(family(method), method, about.label(setting), steps, exact, _USELESS)
            if stopped:
                notes.append(f"{method}, {about.label(setting)}: {stopped}")
    return Diagram(points, notes)


def family(method: str) -> str:
    """Return under which name a method is compared: all of MuJoCo's are one."""
    return _MUJOCO if method.startswith(_MUJOCO) else method


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
            seconds, end = timed(lambda: run(float(word)), rounds)
        except RuntimeError:
            return
        yield Step(word, seconds, end)

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


def summary(results: Mapping[str, Diagram]) -> Table:
    """Return the table of the fastest runs below each bound, with their errors."""
    families = tuple(dict.fromkeys(map(family, METHODS)))
    rows = []
    for name, diagram in results.items():
        for bound in BOUNDS:
            cells = (_cell(fastest(diagram.points, each, bound)) for each in families)
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
