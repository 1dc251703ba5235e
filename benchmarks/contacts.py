"""Work beside precision of bodies that fall on a floor: a bouncing ball, a sliding box, a tumbling box.

Laws of contact differ: symbody's is that of Hunt and Crossley with exponent 3/2, or rigid with dry friction
and the restitution of Poisson, of Newton with `MoreauJean`; MuJoCo's a convex problem of soft rows; Drake's
that of Hunt and Crossley with exponent 1, continuous or in its discrete solver SAP. They have the same
restitution at the same speed and impacts as long, so that they are as hard, and each error is that beside a
far more exact motion of the same law: the greatest distance of a place at any tenth of a second. Every law
works in a process of its own, in the loop of its engine. Figures are processor time of one whole run, of
symbody the whole call of `simulate`, without forming and compiling; of Drake with the building of its plant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from benchmarks import many_contacts
from benchmarks.contact_problems import PROBLEMS, Floats
from benchmarks.engines.contact_methods import COMPLIANT, LAWS
from benchmarks.precision import PREPARING, Diagram, Point, fastest, points_of, timed
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings

BOUNDS: Final = (1e-1, 1e-2, 1e-3, 1e-5)  # m
_REFERENCE: Final = "reference"
_USELESS: Final = 1.0  # m: an error that is no result


def measure(name: str, settings: Settings) -> Diagram:
    """Return the points of a problem by all laws that are installed."""
    points: list[Point] = []
    notes: list[str] = []
    for law, about in LAWS.items():
        if not about.is_installed:
            notes.append(f"{law}: not installed")
            continue
        with Process(attempt, name, law, settings.rounds) as process:
            first = process.ask(_REFERENCE, PREPARING)
            if len(first.steps) < 2:
                notes.append(f"{law}: {first.stopped or 'no reference'}")
                continue
            exact, second = (_values(step) for step in first.steps)
            notes.append(f"{law}: its reference is {np.abs(exact - second).max():.0e} from a coarser one")
            for method, choices in about.methods.items():
                for setting in choices:
                    answer = process.ask(f"{method}|{setting!r}", settings.limit)
                    points += points_of(law, method, f"{setting:g}", answer.steps, exact, _USELESS)
                    if answer.stopped or not answer.steps:
                        why = answer.stopped or "the motion ends early"
                        notes.append(f"{law}, {method} {setting:g}: {why}")
    return Diagram(points, notes)


def _values(step: Step) -> Floats:
    return np.empty(0) if step.values is None else step.values


def attempt(name: str, law: str, rounds: int) -> Task:
    """Return what answers each method and setting with the time of its runs and the places.

    A run that fails gives no step: finer settings may do.
    """
    move = LAWS[law].make(PROBLEMS[name])
    compiled: set[str] = set()

    def task(word: str) -> Iterator[Step]:
        if word == _REFERENCE:
            for method, setting in (LAWS[law].reference, LAWS[law].second):
                yield Step(word, 0.0, move(method, setting))
            return
        method, _, text = word.partition("|")
        setting = float(text)
        try:
            if method not in compiled:
                compiled.add(method)
                move(method, LAWS[law].methods[method][0])
            seconds, places = timed(lambda: move(method, setting), rounds)
        except RuntimeError:
            return
        yield Step(word, seconds, places)

    return task


def table(name: str, diagram: Diagram) -> Table:
    """Return the table of one problem, beside the fastest of symbody's compliant runs as exact."""
    rows = []
    for point in diagram.points:
        ours = fastest(diagram.points, COMPLIANT, point.error)
        time = seconds_text(point.seconds) + ratio_text(point.seconds, ours and ours.seconds)
        rows.append((point.family, point.method, point.setting, f"{point.error:.1e}", time))
    notes = (
        f"processor time of {PROBLEMS[name].end:g} s of motion; in brackets over symbody's fastest as exact",
        *diagram.notes,
    )
    columns = ("law", "method", "rtol, accuracy, step [s]", "error [m]", "time")
    return Table(f"contacts: {name}", columns, tuple(rows), notes)


def summary(results: Mapping[str, Diagram]) -> Table:
    """Return the table of the fastest runs below each bound, with their errors and ratios."""
    rows = []
    for name, diagram in results.items():
        for bound in BOUNDS:
            ours = fastest(diagram.points, COMPLIANT, bound)
            cells = (_cell(fastest(diagram.points, law, bound), ours) for law in LAWS)
            rows.append((name, f"{bound:.0e}", *cells))
    notes = ("fastest setting with an error below the bound, and its error; in brackets times symbody's",)
    return Table("contacts: fastest", ("motion", "error below [m]", *LAWS), tuple(rows), notes)


def _cell(point: Point | None, ours: Point | None) -> str:
    if point is None:
        return ""
    ratio = "" if ours is None or point is ours else ratio_text(point.seconds, ours.seconds)
    return f"{seconds_text(point.seconds)}{ratio}, {point.error:.0e}"


def tables(settings: Settings) -> Iterator[Table]:
    """Yield a table for each problem, and that of the fastest."""
    results = {}
    for name in PROBLEMS:
        results[name] = measure(name, settings)
        yield table(name, results[name])
    yield summary(results)
    yield from many_contacts.tables(settings)
