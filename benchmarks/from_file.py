"""The examples, from file to equations: what somebody waits who opens one."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Sequence
from time import perf_counter
from typing import Final

from sympy.core.cache import clear_cache

import symbody as sb
from benchmarks.mechanisms import EXAMPLES
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings

FILES: Final = ("rr_robot", "spinning_top", "slider_crank", "projectile", "spring_mass_damper")
BAR: Final = 0.3  # s from file to equations

_STAGES: Final = ("load", "accelerations", "formulas")


def examples(settings: Settings, files: Sequence[str] = FILES) -> Table:
    """Return the table of `files`, folders of the examples."""
    rows: list[tuple[str, ...]] = []
    notes = [
        f"shortest of {settings.rounds} runs; the first time is in a process that has only imported symbody"
    ]
    for name in files:
        with Process(_attempt, name) as process:
            answers = [process.ask("derive", settings.limit) for _ in range(settings.rounds)]
        notes += [f"{name}: {answer.stopped}" for answer in answers[-1:] if answer.stopped]
        runs = [{step.name: step.figure for step in answer.steps} for answer in answers if not answer.stopped]
        if runs:
            rows.append((name, *_cells(runs)))
    columns = ("example", *_STAGES, "all three", "first time", f"of {BAR:g} s")
    return Table("examples, from file to equations", columns, tuple(rows), tuple(notes))


def _cells(runs: Sequence[dict[str, float]]) -> Iterator[str]:
    for stage in _STAGES:
        yield seconds_text(min(run[stage] for run in runs))
    first, best = sum(runs[0].values()), min(sum(run.values()) for run in runs)
    yield seconds_text(best)
    yield seconds_text(first)
    yield f"{100 * first / BAR:.0f} %"


def _attempt(name: str) -> Task:
    path = EXAMPLES / name / f"{name}.toml"
    load_model, form_equations = sb.load_model, sb.form_equations  # imports what they need

    def task(word: str) -> Iterator[Step]:
        clear_cache()
        gc.collect()
        start = perf_counter()
        model = load_model(path)
        yield Step("load", perf_counter() - start)
        start = perf_counter()
        eqs = form_equations(model)
        eqs.roots("udot")
        yield Step("accelerations", perf_counter() - start)
        start = perf_counter()
        eqs.dynamic_equations()
        yield Step("formulas", perf_counter() - start)

    return task
