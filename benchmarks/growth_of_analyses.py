"""The growth of analyses with the number of bodies: forming, first and later motions, linear equations.

Figures are seconds of the processor, of all threads together: other work on the computer counts little.
The last row has the exponents of growth between the two sizes before it: 1 where twice the bodies take twice
the time.
"""

from __future__ import annotations

import gc
import math
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from time import process_time
from types import MappingProxyType
from typing import Final

import symbody as sb
from benchmarks.large_mechanisms import LARGE
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings
from symbody.storage import VARIABLE

SIZES: Final[Mapping[str, Sequence[int]]] = MappingProxyType(
    {
        "chain": (200, 500, 1000, 2000),
        "tree": (200, 500, 1000, 2000),
        "ring": (15, 30, 60),
        "truss": (15, 30, 60),
    }
)
_STAGES: Final = ("load", "form", "first simulate", "simulate again", "linearize")
# Matrices of linear equations have as many entries as states squared, and eigenvalues take their third power.
_MOST_LINEAR: Final = 500
_END: Final = 0.01  # s of motion: a few steps

Figures = Mapping[str, float]


def tables(settings: Settings, sizes: Mapping[str, Sequence[int]] = SIZES) -> Iterator[Table]:
    """Yield a table for each kind of mechanism."""
    for kind, counts in sizes.items():
        rows: list[tuple[str, ...]] = []
        figures: list[tuple[int, Figures]] = []
        notes: list[str] = []
        for bodies in counts:
            measured, reason = _figures(kind, bodies, settings.limit)
            figures.append((bodies, measured))
            rows.append((str(bodies), *(_cell(measured, stage) for stage in _STAGES)))
            if reason:
                notes.append(f"{bodies} bodies: {reason}")
                break
        if len(figures) > 1:
            rows.append(("exponent", *(_exponent(figures, stage) for stage in _STAGES)))
        yield Table(
            f"growth: {kind}, seconds of the processor", ("bodies", *_STAGES), tuple(rows), tuple(notes)
        )


def _cell(figures: Figures, stage: str) -> str:
    return seconds_text(figures[stage]) if stage in figures else ""


def _exponent(figures: Sequence[tuple[int, Figures]], stage: str) -> str:
    """Return the exponent of growth between the two largest sizes that a stage was measured for."""
    points = [(bodies, one[stage]) for bodies, one in figures if one.get(stage, 0.0) > 0.0]
    if len(points) < 2:
        return ""
    (few, short), (many, long) = points[-2:]
    return f"{growth_exponent(few, short, many, long):.2f}"


def growth_exponent(few: float, short: float, many: float, long: float) -> float:
    """Return k where the time grows as the k-th power of the size.

    >>> growth_exponent(10, 1.0, 20, 4.0)
    2.0
    """
    return math.log(long / short) / math.log(many / few)


def _figures(kind: str, bodies: int, limit: float) -> tuple[Figures, str]:
    """Return seconds by stage in a new process without anything stored, and why there are no more."""
    with tempfile.TemporaryDirectory() as folder, Process(_attempt, kind, bodies, folder) as process:
        steps, stopped = (answer := process.ask("analyse", limit)).steps, answer.stopped
    return {step.name: step.figure for step in steps}, stopped


def _attempt(kind: str, bodies: int, folder: str) -> Task:
    path = Path(folder, "model.toml")
    os.environ[VARIABLE] = str(Path(folder, "kept"))

    def task(word: str) -> Iterator[Step]:
        sb.save_model(LARGE[kind](bodies), path)
        small = sb.form_equations(LARGE[kind](3))
        sb.simulate(small, _END)  # imports what motions need, and compiles their loop
        sb.linearize(small)
        gc.collect()
        start = process_time()
        model = sb.load_model(path)
        loaded = process_time()
        yield Step("load", loaded - start)
        eqs = sb.form_equations(model)
        formed = process_time()
        yield Step("form", formed - loaded)
        for name in ("first simulate", "simulate again"):
            before = process_time()
            sb.simulate(eqs, _END)
            yield Step(name, process_time() - before)
        if bodies <= _MOST_LINEAR:
            before = process_time()
            sb.linearize(eqs)
            yield Step("linearize", process_time() - before)

    return task
