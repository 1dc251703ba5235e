"""The same expressions written, differentiated, compiled and evaluated by every engine."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Final

import numpy as np

from benchmarks.engines.algebra import Compiled
from benchmarks.engines.engine import OURS, PEERS, Engine
from benchmarks.problems import Problem, pendulum, random_operations, serial_chain
from benchmarks.process import Floats, Process, Round, Step
from benchmarks.table import Table, difference_text, ratio_text, seconds_text
from benchmarks.timing import Settings, medians, rotated, seconds, seconds_per_call

PROBLEMS: Final = (
    *(serial_chain(links) for links in (3, 6, 10)),
    random_operations(5000),
    *(pendulum(links) for links in (3, 5, 8)),
)

_POINTS: Final = 256  # evaluated in one loop: few enough to stay in the processor's cache
_PATIENCE: Final = 20.0  # seconds; an engine that has used so many does not go the whole way again
_EVALUATIONS: Final = 5  # for each round; they are short, so that engines take turns many times

_STAGES: Final = ("build", "differentiate", "compile")
_TOTAL: Final = "all three"
_CALLS: Final = ("one call", "in a loop")
_OPERATIONS: Final = "operations"
_VALUES: Final = "values"

# What an engine is asked: to go the whole way, to evaluate, to show and count what it has.
_FORM, _EVALUATE, _SHOW = "form", "evaluate", "show"
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
    found = {label: _summary(answers) for label, answers in _rounds(problem, settings, engines).items()}
    ours = found[OURS.label]
    return Table(
        problem.name,
        _COLUMNS,
        tuple(_row(label, summary, ours, settings.limit) for label, summary in found.items()),
        (
            *(
                f"{label}, {_open_stage(summary)}: {summary.stopped}"
                for label, summary in found.items()
                if summary.stopped
            ),
            *(
                f"{peer.label}: left out, {peer.package} is not installed"
                for peer in peers
                if not peer.installed
            ),
        ),
    )


def _rounds(problem: Problem, settings: Settings, engines: Mapping[str, Engine]) -> dict[str, list[Round]]:
    """Return all answers of each engine."""
    answers: dict[str, list[Round]] = {label: [] for label in engines}
    with ExitStack() as stack:
        processes = {
            label: stack.enter_context(Process(_Attempt, engine, problem))
            for label, engine in engines.items()
        }

        def ask(label: str, word: str) -> None:
            if not _stopped(answers[label]):
                answers[label].append(processes[label].ask(word, settings.limit))

        spent = dict.fromkeys(engines, 0.0)
        for turn in range(settings.rounds):
            for label in rotated(list(engines), turn):
                if spent[label] < _PATIENCE:
                    spent[label] += seconds(partial(ask, label, _FORM))
        for turn in range(settings.rounds * _EVALUATIONS):
            for label in rotated(list(engines), turn):
                ask(label, _EVALUATE)
        for label in engines:
            ask(label, _SHOW)
    return answers


def _stopped(answers: Sequence[Round]) -> str:
    return answers[-1].stopped if answers else ""


class _Attempt:
    """One engine at one problem; runs in a process of its own."""

    def __init__(self, engine: Engine, problem: Problem) -> None:
        self._engine = engine
        self._problem = problem
        self._points = problem.points(_POINTS)
        self._compiled: list[Compiled] = []
        engine.new()  # imports what it needs

    def __call__(self, word: str) -> Iterator[Step]:
        """Yield each step when it is done."""
        if word == _FORM:
            yield from self._form()
        elif word == _EVALUATE:
            yield from self._evaluate(self._compiled[-1])
        else:
            yield from self._show(self._compiled[-1])

    def _form(self) -> Iterator[Step]:
        """Go the whole way, from nothing."""
        problem = self._problem
        self._compiled.clear()
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
        self._compiled.append(algebra.compile(results))
        yield Step(_STAGES[2], perf_counter() - start)

    def _evaluate(self, compiled: Compiled) -> Iterator[Step]:
        points = self._points
        yield Step(_CALLS[0], seconds_per_call(lambda: compiled.one(points[0])))
        yield Step(_CALLS[1], seconds_per_call(lambda: compiled.many(points)) / len(points))

    def _show(self, compiled: Compiled) -> Iterator[Step]:
        """Yield results of both ways to call, and the operations they cost."""
        alone = np.stack([np.array(compiled.one(point)) for point in self._points[:4]])
        yield Step(_VALUES, values=np.concatenate([compiled.many(self._points), alone]))
        yield Step(_OPERATIONS, compiled.count())


def _summary(answers: Sequence[Round]) -> _Summary:
    samples: dict[str, list[float]] = {}
    values = None
    for answer in answers:
        figures = {step.name: step.figure for step in answer.steps}
        if all(stage in figures for stage in _STAGES):
            figures[_TOTAL] = sum(figures[stage] for stage in _STAGES)
        for name, figure in figures.items():
            samples.setdefault(name, []).append(figure)
        values = next((step.values for step in answer.steps if step.values is not None), values)
    return _Summary(medians(samples), values, _stopped(answers))


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
        cells[_open_stage(found)] = "not done"
        if found.stopped.startswith(">"):
            cells[_TOTAL] = found.stopped + _beside(label, limit, reference.get(_TOTAL)).replace("(", "(> ")
    if label != OURS.label and found.values is not None and ours.values is not None:
        cells[_COLUMNS[-1]] = difference_text(relative_difference(found.values, ours.values))
    return (label, *(cells.get(column, "") for column in _COLUMNS[1:]))


def _open_stage(found: _Summary) -> str:
    """Return the first column that has no figure."""
    return next(name for name in (*_STAGES, *_CALLS, _OPERATIONS) if name not in found.figures)


def _beside(label: str, value: float, reference: float | None) -> str:
    return "" if label == OURS.label else ratio_text(value, reference)


def relative_difference(values: Floats, reference: Floats) -> float:
    """Return the largest difference relative to the largest value of `reference` in the same row.

    Both are (points, results); nan wherever one of them has nan.
    """
    size = np.max(np.abs(reference), axis=1, keepdims=True)
    return float(np.max(np.abs(values - reference) / size))
