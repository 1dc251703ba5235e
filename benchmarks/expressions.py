"""The same expressions written, differentiated, compiled and evaluated by every engine."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from time import perf_counter
from typing import Final

import numpy as np

from benchmarks.engines.algebra import Compiled
from benchmarks.engines.engine import OURS, PEERS, Engine
from benchmarks.problems import Problem, pendulum, random_operations, serial_chain
from benchmarks.process import Floats, Process, Round, Step
from benchmarks.table import Table, difference_text, ratio_text, seconds_text
from benchmarks.timing import Settings, medians, rotated, seconds_per_call

PROBLEMS: Final = (
    *(serial_chain(links) for links in (3, 6, 10)),
    random_operations(5000),
    *(pendulum(links) for links in (3, 5, 8)),
)

_POINTS: Final = 256  # evaluated in one loop: few enough to stay in the processor's cache
_PATIENCE: Final = 20.0  # seconds; an engine that has used so many is not asked for another round

_STAGES: Final = ("build", "differentiate", "compile")
_TOTAL: Final = "all three"
_CALLS: Final = ("one call", "in a loop")
_OPERATIONS: Final = "operations"
_VALUES: Final = "values"
_COLUMNS: Final = ("engine", *_STAGES, _TOTAL, _OPERATIONS, *_CALLS, "difference")


@dataclass(frozen=True, slots=True)
class _Summary:
    """Medians of one engine by column, what it computed, and why it was stopped."""

    figures: Mapping[str, float]
    values: Floats | None
    stopped: str


def tables(
    settings: Settings, problems: Sequence[Problem] = PROBLEMS, peers: Sequence[Engine] = PEERS
) -> Iterator[Table]:
    """Yield one table for each problem."""
    for problem in problems:
        yield _compared(problem, settings, peers)


def _compared(problem: Problem, settings: Settings, peers: Sequence[Engine]) -> Table:
    engines = {engine.label: engine for engine in (OURS, *peers) if engine.installed}
    found = {label: _summary(rounds) for label, rounds in _rounds(problem, settings, engines).items()}
    ours = found[OURS.label]
    return Table(
        problem.name,
        _COLUMNS,
        tuple(_row(label, summary, ours, settings.limit) for label, summary in found.items()),
        (
            *(f"{label}: {summary.stopped}" for label, summary in found.items() if summary.stopped),
            *(f"{peer.label}: left out, {peer.package} is not installed" for peer in peers if not peer.installed),
        ),
    )


def _rounds(problem: Problem, settings: Settings, engines: Mapping[str, Engine]) -> dict[str, list[Round]]:
    rounds: dict[str, list[Round]] = {label: [] for label in engines}
    spent = dict.fromkeys(engines, 0.0)
    with ExitStack() as stack:
        processes = {
            label: stack.enter_context(Process(_Attempt, engine, problem)) for label, engine in engines.items()
        }
        for turn in range(settings.rounds):
            for label in rotated(list(engines), turn):
                if spent[label] < _PATIENCE and not (rounds[label] and rounds[label][-1].stopped):
                    start = perf_counter()
                    rounds[label].append(processes[label].ask(settings.limit))
                    spent[label] += perf_counter() - start
    return rounds


class _Attempt:
    """The whole way through one problem, from nothing; runs in a process of its own."""

    def __init__(self, engine: Engine, problem: Problem) -> None:
        self._engine = engine
        self._problem = problem
        self._points = problem.points(_POINTS)
        self._compared = False
        engine.new()  # imports what it needs

    def __call__(self) -> Iterator[Step]:
        """Yield each stage when it is done."""
        problem = self._problem
        algebra = self._engine.new()
        gc.collect()
        start = perf_counter()
        x = algebra.inputs(problem.inputs)
        built = problem.build(algebra, x)
        yield Step(_STAGES[0], perf_counter() - start)
        start = perf_counter()
        results = problem.differentiate(algebra, x, built)
        yield Step(_STAGES[1], perf_counter() - start)
        start = perf_counter()
        compiled = algebra.compile(results)
        yield Step(_STAGES[2], perf_counter() - start)
        yield from self._evaluated(compiled)

    def _evaluated(self, compiled: Compiled) -> Iterator[Step]:
        points = self._points
        yield Step(_CALLS[0], seconds_per_call(lambda: compiled.one(points[0])))
        yield Step(_CALLS[1], seconds_per_call(lambda: compiled.many(points)) / len(points))
        if not self._compared:
            self._compared = True
            alone = np.stack([np.array(compiled.one(point)) for point in points[:4]])
            yield Step(_VALUES, values=np.concatenate([compiled.many(points), alone]))
            yield Step(_OPERATIONS, compiled.count())


def _summary(rounds: Sequence[Round]) -> _Summary:
    samples: dict[str, list[float]] = {}
    values = None
    for finished in rounds:
        figures = {step.name: step.figure for step in finished.steps}
        if all(stage in figures for stage in _STAGES):
            figures[_TOTAL] = sum(figures[stage] for stage in _STAGES)
        for name, figure in figures.items():
            samples.setdefault(name, []).append(figure)
        values = next((step.values for step in finished.steps if step.values is not None), values)
    return _Summary(medians(samples), values, rounds[-1].stopped)


def _row(label: str, found: _Summary, ours: _Summary, limit: float) -> tuple[str, ...]:
    figures, reference = found.figures, ours.figures
    cells = {name: seconds_text(figures[name]) for name in _STAGES if name in figures}
    for name in (_TOTAL, *_CALLS):
        if name in figures:
            cells[name] = seconds_text(figures[name]) + _beside(label, figures[name], reference.get(name))
    if _OPERATIONS in figures:
        count = figures[_OPERATIONS]
        cells[_OPERATIONS] = f"{count:.0f}" + _beside(label, count, reference.get(_OPERATIONS))
    if _TOTAL not in figures:
        cells[next(stage for stage in _STAGES if stage not in figures)] = "not done"
        if found.stopped.startswith(">"):
            cells[_TOTAL] = found.stopped + _beside(label, limit, reference.get(_TOTAL)).replace("(", "(> ")
    if label != OURS.label and found.values is not None and ours.values is not None:
        cells[_COLUMNS[-1]] = difference_text(relative_difference(found.values, ours.values))
    return (label, *(cells.get(column, "") for column in _COLUMNS[1:]))


def _beside(label: str, value: float, reference: float | None) -> str:
    return "" if label == OURS.label else ratio_text(value, reference)


def relative_difference(values: Floats, reference: Floats) -> float:
    """Return the largest difference relative to the largest value of `reference` in the same row.

    Both are (points, results); nan wherever one of them has nan.
    """
    size = np.max(np.abs(reference), axis=1, keepdims=True)
    return float(np.max(np.abs(values - reference) / size))
