"""Equations of motion: the examples from their files, and mechanisms beside sympy.physics.mechanics.

"form" is all up to symbolic accelerations for symbody, and up to mass matrix and forcing for SymPy's
KanesMethod, which leaves solving them to numbers. "count" makes the shared sequence of operations: for SymPy
that is `cse`. "M and F" are the operations of mass matrix and forcing, "udot" those of the accelerations; all
parameters stay symbols. The accelerations that SymPy's M and F give are compared with symbody's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Final

from benchmarks.engines.deriving import COMPILE, DERIVE, ENGINES, OURS, VALUES
from benchmarks.expressions import relative_difference
from benchmarks.from_file import FILES, examples
from benchmarks.kane import robot, top
from benchmarks.mechanisms import Mechanism, example, pendulum_on_cart, spatial_chain
from benchmarks.process import Floats, Process, Round
from benchmarks.table import Table, difference_text, ratio_text, seconds_text
from benchmarks.timing import Settings, rotated, seconds

FAMILIES: Final[Mapping[str, Sequence[Mechanism]]] = MappingProxyType(
    {
        "examples": (example("rr_robot", robot), example("spinning_top", top)),
        "pendulum on a cart, absolute angles": tuple(map(pendulum_on_cart, (2, 5, 10, 20))),
        "spatial chain of hinged bodies": tuple(map(spatial_chain, (2, 5, 10, 20, 50))),
    }
)

_LONG: Final = 3600.0  # s, the limit of a round with --long
_PATIENCE: Final = 20.0  # s; who has used so many does not derive again

_STAGES: Final = ("form", "count")
_TIMES: Final = (*_STAGES, "both", "compile")
_COUNTS: Final = ("M and F", "udot")
_COLUMNS: Final = ("size", "engine", *_STAGES, "both", *_COUNTS, "compile", "difference")


@dataclass(frozen=True, slots=True)
class _Summary:
    """Shortest times and the counts of one engine by column, what it computed, and why it was stopped."""

    figures: Mapping[str, float]
    values: Floats | None
    stopped: str


def tables(
    settings: Settings,
    files: Sequence[str] = FILES,
    families: Mapping[str, Sequence[Mechanism]] = FAMILIES,
) -> Iterator[Table]:
    """Yield the table of the examples and one for each family of mechanisms."""
    yield examples(settings, files)
    for title, members in families.items():
        yield _family(title, members, settings)


def _family(title: str, members: Sequence[Mechanism], settings: Settings) -> Table:
    limit = _LONG if settings.long else settings.limit
    engines = list(ENGINES)
    rows, notes = [], [f"shortest of {settings.rounds} runs; SymPy's cache is emptied before each"]
    for mechanism in members:
        found = _summaries(mechanism, engines, settings.rounds, limit)
        for label, summary in found.items():
            rows.append(_row(mechanism.name, label, summary, found[OURS]))
            if summary.stopped:
                notes.append(f"{mechanism.name}, {label}: {summary.stopped}")
            if summary.stopped and label != OURS:
                engines.remove(label)
                notes.append(f"{label} is not asked for larger ones")
    return Table(title, _COLUMNS, tuple(rows), tuple(notes))


def _summaries(
    mechanism: Mechanism, engines: Sequence[str], rounds: int, limit: float
) -> dict[str, _Summary]:
    answers: dict[str, list[Round]] = {label: [] for label in engines}
    spent = dict.fromkeys(engines, 0.0)
    with ExitStack() as stack:
        processes = {label: stack.enter_context(Process(ENGINES[label], mechanism)) for label in engines}

        def ask(label: str, word: str) -> None:
            if not any(answer.stopped for answer in answers[label]):
                answers[label].append(processes[label].ask(word, limit))

        for turn in range(rounds):
            for label in rotated(list(engines), turn):
                if spent[label] < _PATIENCE:
                    spent[label] += seconds(partial(ask, label, DERIVE))
        for word in (VALUES, COMPILE):
            for label in engines:
                ask(label, word)
    return {label: _summary(found) for label, found in answers.items()}


def _summary(answers: Sequence[Round]) -> _Summary:
    figures: dict[str, float] = {}
    values = None
    for answer in answers:
        here = {step.name: step.figure for step in answer.steps if step.values is None}
        if all(stage in here for stage in _STAGES):
            here["both"] = sum(here[stage] for stage in _STAGES)
        for name, figure in here.items():
            figures[name] = min(figure, figures.get(name, figure))
        values = next((step.values for step in answer.steps if step.values is not None), values)
    return _Summary(figures, values, answers[-1].stopped)


def _row(name: str, label: str, found: _Summary, ours: _Summary) -> tuple[str, ...]:
    figures, reference = found.figures, ours.figures
    cells = {column: seconds_text(figures[column]) for column in _TIMES if column in figures}
    cells |= {column: f"{figures[column]:.0f}" for column in _COUNTS if column in figures}
    if label != OURS:
        cells = {
            column: text + ratio_text(figures[column], reference.get(column))
            for column, text in cells.items()
        }
        if "M and F" in figures:  # solving them is not counted
            ratio = ratio_text(figures["M and F"], reference.get("udot"))
            cells["udot"] = f"{figures['M and F']:.0f} + solving{ratio}"
        if found.values is not None and ours.values is not None:
            cells["difference"] = difference_text(relative_difference(found.values, ours.values))
    if "both" not in figures:
        cells["both"] = "not done"
    return (name if label == OURS else "", label, *(cells.get(column, "") for column in _COLUMNS[2:]))
