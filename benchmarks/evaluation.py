"""Compiled functions on one core: how long they take to compile, and an evaluation in a large batch.

One point after the other by thorough and by quick code, and several points at once in lanes. Batches are
called as a user calls them; what NumPy and the way into machine code cost is in the figures. Times are those
of the processor, so that what else runs on the machine does not count.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np

import symbody as sb
from benchmarks.mechanisms import EXAMPLES, spatial_chain
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, processor_seconds
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.machine import lanes
from symbody.storage import VARIABLE

POINTS: Final = 4000
CHAINS: Final = (3, 7, 20)
FILES: Final = ("spinning_top", "slider_crank")

_COLUMNS: Final = (
    "accelerations of",
    "operations",
    "form",
    "sequence",
    "compile",
    "quick",
    "lanes",
    "a point",
    "by quick code",
    "in lanes",
)


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of this benchmark."""
    yield evaluations(settings)


def evaluations(settings: Settings, files: Sequence[str] = FILES, chains: Sequence[int] = CHAINS) -> Table:
    """Return times of compiling and of evaluations, in brackets over those of thorough code."""
    rows = [
        _row(name, lambda name=name: sb.load_model(EXAMPLES / name / f"{name}.toml"), settings.rounds)
        for name in files
    ]
    rows += [_row(f"chain, {n} bodies", spatial_chain(n).model, settings.rounds) for n in chains]
    notes = (
        f"shortest of {settings.rounds} rounds; batches of {POINTS} points; {lanes()} lanes here",
        "compiled anew each time, nothing is read from the disk",
    )
    return Table("compiled functions on one core", _COLUMNS, tuple(rows), notes)


def _row(name: str, model: Callable[[], sb.Model], rounds: int) -> tuple[str, ...]:
    mechanism = model()
    eqs = sb.form_equations(mechanism)
    pair = form_sequence(eqs, "udot")
    source = np.random.default_rng(7)
    sizes = (len(eqs.coordinate_names), len(eqs.speed_names), len(eqs.input_names))
    q, u, r = (source.uniform(0.2, 1.0, (POINTS, size)) for size in sizes)

    def made(*, quick: bool = False, in_lanes: bool = False) -> CompiledFunction:
        function = CompiledFunction(*pair, quick=quick, lanes=in_lanes)
        function(0.0, q, u, r)
        return function

    kept = os.environ.get(VARIABLE, "")
    os.environ[VARIABLE] = "off"
    try:
        functions = [made(), made(quick=True), made(in_lanes=True)]
        calls = [_shortest(rounds, lambda f=f: f(0.0, q, u, r)) for f in functions]
        form = _shortest(rounds, lambda: sb.form_equations(mechanism))
        sequence = _shortest(rounds, lambda: form_sequence(sb.form_equations(mechanism), "udot")) - form
        thorough, quick, both = (
            _shortest(rounds, make) - call
            for make, call in zip(
                (made, lambda: made(quick=True), lambda: made(in_lanes=True)), calls, strict=True
            )
        )
    finally:
        os.environ[VARIABLE] = kept
    points = [seconds_text(call / POINTS) for call in calls]
    return (
        name,
        str(functions[0].operations),
        *map(seconds_text, (form, sequence, thorough, quick, both - thorough)),
        points[0],
        *(text + ratio_text(call, calls[0]) for text, call in zip(points[1:], calls[1:], strict=True)),
    )


def _shortest(rounds: int, action: Callable[[], object]) -> float:
    return min(processor_seconds(action) for _ in range(rounds))
