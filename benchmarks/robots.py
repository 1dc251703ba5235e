"""Robots beside Pinocchio's C++, C by CasADi of the same recursion, and MuJoCo, at the same random states.

One call after another in compiled loops, as a program in C sees it; the same called from Python, state by
state; and batches on one core. In brackets stands how many times symbody's time of the same round an engine
takes: the median of the rounds, then the least and the greatest.

Symbody's time stands a second time with subnormal numbers in the scratch before each round: what other
calculations left in memory must make no difference.

All are given the tree alone, without damping and friction, which the recursions of Pinocchio leave out. What
a table compares is computed by all at the same states first; what differs is not timed. Pinocchio fills half
of the mass matrix, and derives along tangents where symbody has a column for each component of a quaternion.
"""

from __future__ import annotations

import statistics
import sysconfig
from collections.abc import Iterator, Mapping
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Final

import numpy as np

import symbody as sb
from benchmarks.engines.call_loops.loops import c_compiler
from benchmarks.operations import ROBOTS, ROBOTS_FOLDER, Robot
from benchmarks.robot_calls import (
    TASKS,
    Caller,
    Compiled,
    InCpp,
    OnSubnormals,
    casadi_c,
    cpp_program,
    median_of_passes,
    mujoco_calls,
    python_mujoco,
    python_pinocchio,
    python_symbody,
)
from benchmarks.robot_checks import (
    ALLOWED,
    casadi_differences,
    mujoco_differences,
    pinocchio_differences,
    wrong,
)
from benchmarks.robot_states import STATES, robot_states
from benchmarks.table import Table, difference_text, seconds_text
from benchmarks.timing import Settings, rotated

LOOPS: Final = ("Pinocchio C++", "CasADi's C", "MuJoCo")
PYTHON: Final = ("Pinocchio", "MuJoCo")
# Longer functions are not compiled for several points at once here.
_LONGEST_IN_LANES: Final = 300_000
# Points of a batch: many, but no more than so many results, which the processor's caches hold.
_BATCH: Final = 8000
_RESULTS: Final = 200_000

# What rounds gave: engine, then task, then the time of a call in each round [ns].
Times = dict[str, dict[str, list[float]]]


def tables(
    settings: Settings,
    robots: Mapping[str, Robot] = ROBOTS,
    folder: Path | None = None,
    *,
    peers: bool = True,
    count: int = STATES,
) -> Iterator[Table]:
    """Yield the table of compiled loops, that of calls from Python, and that of batches."""
    where = folder if folder is not None else Path(sysconfig.get_path("purelib"), ROBOTS_FOLDER)
    rows: list[list[tuple[str, ...]]] = [[], [], []]
    notes: list[str] = []
    for name, robot in robots.items():
        path = where / robot.path
        if not path.is_file():
            notes.append(f"{name} is not installed: {robot.path}")
            continue
        with TemporaryDirectory() as scratch:
            bench = RobotBench(name, robot, path, Path(scratch), peers=peers, count=count)
            for found, new in zip(rows, bench.rows(settings.rounds), strict=True):
                found += new
            notes += bench.notes
    notes = [f"{count} states, {settings.rounds} rounds", *dict.fromkeys(notes)]
    yield Table(
        "robots, one call in compiled loops",
        ("task", "symbody", OnSubnormals.name, *LOOPS, "difference"),
        tuple(rows[0]),
        tuple(notes),
    )
    yield Table("robots, one call from Python", ("task", "symbody", *PYTHON), tuple(rows[1]))
    yield Table("robots, batches on one core", ("task", "symbody", "Pinocchio C++"), tuple(rows[2]))


class RobotBench:
    """A robot in all engines there are; `notes` say what is left out."""

    def __init__(
        self, name: str, robot: Robot, path: Path, scratch: Path, *, peers: bool, count: int
    ) -> None:
        self.name = name
        self.notes: list[str] = []
        self.differences: dict[str, dict[str, float]] = {}
        pin = import_module("pinocchio") if peers and find_spec("pinocchio") else None
        self.states = robot_states(path, robot, pin, count)
        self.ours = Compiled(self.states)
        self.loops: list[Caller] = [self.ours, OnSubnormals(self.ours)]
        if c_compiler() is None:
            self.loops = []
            self._note("compiled loops are left out: there is no C compiler")
        self.python: list[Caller] = [python_symbody(self.ours)]
        if peers:
            self._add_pinocchio(scratch)
            self._add_casadi()
            self._add_mujoco(robot.floating)

    def _add_pinocchio(self, scratch: Path) -> None:
        cpp, why = cpp_program(self.states, scratch)
        self._note(why)
        if self.states.pin_model is not None:
            self._differ("Pinocchio C++", pinocchio_differences(self.ours, cpp))
            self.python.append(python_pinocchio(self.states))
        if cpp is not None:
            self.loops.append(cpp)

    def _add_casadi(self) -> None:
        peer, why = casadi_c(self.ours)
        self._note(why)
        if peer is not None:
            self._differ("CasADi's C", casadi_differences(self.ours, peer))
            self.loops.append(peer)

    def _add_mujoco(self, floating: bool) -> None:
        peer, why = mujoco_calls(self.states, floating)
        self._note(f"{self.name}: {why}" if "read" in why else why)
        if peer is not None:
            self._differ("MuJoCo", mujoco_differences(self.ours, peer))
            self.loops.append(peer)
            self.python.append(python_mujoco(peer))

    def rows(self, rounds: int) -> tuple[list[tuple[str, ...]], list[tuple[str, ...]], list[tuple[str, ...]]]:
        """Return the rows of the three tables."""
        loops, python = in_rounds(self.loops, rounds), in_rounds(self.python, rounds)
        batches = self._batches(rounds)
        first: list[tuple[str, ...]] = []
        second: list[tuple[str, ...]] = []
        third: list[tuple[str, ...]] = []
        for task in TASKS:
            label = f"{self.name}, {task}"
            worst = [self.differences[peer][task] for peer in LOOPS if task in self.differences.get(peer, {})]
            cells = [self._cell(loops, peer, task) for peer in LOOPS]
            difference = difference_text(max(worst)) if worst else ""
            if "symbody" in loops:
                subnormal = ratio_cell(loops[OnSubnormals.name][task], loops["symbody"][task])
                first.append((label, _time(loops["symbody"][task]), subnormal, *cells, difference))
            cells = [self._cell(python, peer, task) for peer in PYTHON]
            second.append((label, _time(python["symbody"][task]), *cells))
            if task in batches["symbody"]:
                cell = self._cell(batches, "Pinocchio C++", task)
                third.append((label, _time(batches["symbody"][task]), cell))
        return first, second, third

    def _batches(self, rounds: int) -> Times:
        """Return times of an evaluation in large batches, and of Pinocchio's recursions one by one."""
        cpp = [caller for caller in self.loops if isinstance(caller, InCpp)]
        return in_rounds([Batches(self.ours), *cpp], rounds)

    def _cell(self, times: Times, peer: str, task: str) -> str:
        compared = self.differences.get("Pinocchio C++" if peer == "Pinocchio" else peer, {})
        if (
            task not in times.get(peer, {})
            or task not in times.get("symbody", {})
            or not _agree(compared.get(task))
        ):
            return ""
        return ratio_cell(times[peer][task], times["symbody"][task])

    def _differ(self, who: str, found: dict[str, float]) -> None:
        self.differences[who] = found
        self.notes += [f"{self.name}, {line}" for line in wrong(found, who)]

    def _note(self, text: str) -> None:
        if text:
            self.notes.append(text)


class Batches:
    """Symbody's functions over large batches by one thread, as called from Python."""

    name = "symbody"

    def __init__(self, ours: Compiled) -> None:
        self._calls = {}
        for name, f in ours.functions.items():
            if f.operations > _LONGEST_IN_LANES:
                continue
            points = min(_BATCH, _RESULTS // f.sequence.output_size)
            copies = max(1, points // len(ours.states.q))
            q, u, r = (np.tile(x, (copies, 1)) for x in ours.inputs(name))
            in_lanes = sb.CompiledFunction(f.sequence, f.signature, lanes=True)
            in_lanes(0.0, q, u, r)  # compiles
            self._calls[name] = (in_lanes, q, u, r)

    def round(self) -> dict[str, float]:
        """Return the time of one evaluation of each task [ns]."""
        return {
            name: median_of_passes(partial(self._pass, name), len(call[1]))
            for name, call in self._calls.items()
        }

    def _pass(self, name: str) -> float:
        f, q, u, r = self._calls[name]
        start = process_time()
        f(0.0, q, u, r)
        return 1e9 * (process_time() - start) / len(q)


def in_rounds(callers: list[Caller], rounds: int) -> Times:
    """Return the times of all, each taking its turn in every round."""
    found: Times = {caller.name: {} for caller in callers}
    by_name = {caller.name: caller for caller in callers}
    for turn in range(rounds):
        for name in rotated(list(by_name), turn):
            for task, took in by_name[name].round().items():
                found[name].setdefault(task, []).append(took)
    return found


def ratio_cell(theirs: list[float], ours: list[float]) -> str:
    """Return a median time, and the median, least and greatest ratio to symbody's of the same round.

    >>> ratio_cell([1000.0, 1100.0, 1200.0], [100.0, 100.0, 100.0])
    '1.10 us (11x; 10 to 12)'
    """
    ratios = sorted(a / b for a, b in zip(theirs, ours, strict=True))
    middle, low, high = (_ratio(x) for x in (statistics.median(ratios), ratios[0], ratios[-1]))
    return f"{_time(theirs)} ({middle}x; {low} to {high})"


def _ratio(x: float) -> str:
    return f"{x:.0f}" if x >= 9.95 else f"{x:.1f}" if x >= 0.995 else f"{x:.2f}"


def _time(nanoseconds: list[float]) -> str:
    return seconds_text(1e-9 * statistics.median(nanoseconds))


def _agree(difference: float | None) -> bool:
    return difference is not None and difference < ALLOWED
