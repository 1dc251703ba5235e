"""A spatial chain from its file to the first call of its accelerations, from ten bodies to two thousand.

Stages are seconds of the processor, of all threads together: other work on the computer counts little.
Every figure is of a process that has only imported what it needs: once with nothing on the disk, and once
more with what the first one left there. "per body" is followed by its ratio to the shortest chain's: where it
stays at 1, the work grows with the number of bodies. The last column is KanesMethod with `cse` and its time
over ours for the same stages, as far as it gets within the time limit.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from time import process_time
from typing import Final

import numpy as np

import symbody as sb
from benchmarks.engines.deriving import DERIVE, ENGINES
from benchmarks.mechanisms import spatial_chain
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, seconds_per_call
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.storage import VARIABLE

if sys.platform != "win32":
    import resource

SIZES: Final = (10, 60, 200, 1000, 2000)

_PEER: Final = "SymPy"
_MEMORY: Final = "memory"
_CALL: Final = "one call"
_STAGES: Final = ("load", "form", "sequence", "compile")
_COLUMNS: Final = (
    "bodies", *_STAGES, "all", "per body", _MEMORY, _CALL, "per body", "from the disk",
    f"form and count, {_PEER}",
)  # fmt: skip
_MEGABYTE: Final = 2**20

Figures = Mapping[str, float]


def tables(settings: Settings, sizes: Sequence[int] = SIZES) -> Iterator[Table]:
    """Yield the table of chains, from file to first call."""
    rows: list[tuple[str, ...]] = []
    notes = [
        "stages: seconds of the processor",
        "memory: the most that the process had, with Python and all packages",
    ]
    first: tuple[float, float] | None = None
    peer_goes_on = True
    for links in sizes:
        with tempfile.TemporaryDirectory() as folder:
            fresh, again = (stages(links, folder, settings.limit) for _ in range(2))
        if _CALL not in fresh or _CALL not in again:
            notes.append(f"{links} bodies: not done within {settings.limit:g} s")
            break
        each = sum(fresh[stage] for stage in _STAGES) / links, fresh[_CALL] / links
        first = first or each
        peer = peer_seconds(links, settings.limit) if peer_goes_on else None
        peer_goes_on = peer is not None
        rows.append((str(links), *_cells(fresh, again, each, first), _peer_cell(peer, fresh)))
    if not peer_goes_on:
        notes.append(f"{_PEER} is not asked for chains longer than the one it did not finish")
    title = "growth: a spatial chain of hinged bodies, from file to first call"
    yield Table(title, _COLUMNS, tuple(rows), tuple(notes))


def _cells(
    fresh: Figures, again: Figures, each: tuple[float, float], first: tuple[float, float]
) -> Iterator[str]:
    yield from (seconds_text(fresh[stage]) for stage in _STAGES)
    yield seconds_text(sum(fresh[stage] for stage in _STAGES))
    yield seconds_text(each[0]) + ratio_text(each[0], first[0])
    yield f"{fresh[_MEMORY] / _MEGABYTE:.0f} MB"
    yield seconds_text(fresh[_CALL])
    yield seconds_text(each[1]) + ratio_text(each[1], first[1])
    yield seconds_text(sum(again[stage] for stage in _STAGES))


def _peer_cell(peer: float | None, fresh: Figures) -> str:
    return "" if peer is None else seconds_text(peer) + ratio_text(peer, fresh["form"] + fresh["sequence"])


def stages(links: int, folder: str, limit: float) -> Figures:
    """Return the seconds of each stage, with what the folder keeps; fewer stages if the limit is reached."""
    with Process(_attempt, links, folder) as process:
        return {step.name: step.figure for step in process.ask("derive", limit).steps}


def peer_seconds(links: int, limit: float) -> float | None:
    """Return how long SymPy forms and counts the same equations, None if the limit is reached."""
    with Process(ENGINES[_PEER], spatial_chain(links)) as process:
        steps = {step.name: step.figure for step in process.ask(DERIVE, limit).steps}
    return steps["form"] + steps["count"] if "count" in steps else None


def _attempt(links: int, folder: str) -> Task:
    path = Path(folder, "chain.toml")
    if not path.exists():
        sb.save_model(spatial_chain(links).model(), path)
    os.environ[VARIABLE] = str(Path(folder, "kept"))
    load_model, form_equations = sb.load_model, sb.form_equations  # imports what they need

    def task(word: str) -> Iterator[Step]:
        gc.collect()  # of the imports
        start = process_time()
        model = load_model(path)
        loaded = process_time()
        yield Step("load", loaded - start)
        eqs = form_equations(model)
        formed = process_time()
        yield Step("form", formed - loaded)
        sequence, signature = form_sequence(eqs, "udot")
        sequenced = process_time()
        yield Step("sequence", sequenced - formed)
        function = CompiledFunction(sequence, signature)
        q, u = np.full(links, 0.1), np.full(links, 0.2)
        function(0.0, q, u)
        yield Step("compile", process_time() - sequenced)
        yield Step(_MEMORY, _most_memory())
        yield Step(_CALL, min(seconds_per_call(lambda: function(0.0, q, u)) for _ in range(5)))

    return task


def _most_memory() -> float:
    """Return the most memory this process has had [byte], not a number where it is not told."""
    if sys.platform == "win32":
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
