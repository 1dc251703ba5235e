"""Robots: code generated for one of them, and libraries that read one at run time, at the same random states.

Generated: symbody's machine code; the C that symbody writes; the C that CasADi writes for Pinocchio's
algorithms; MJX and symbody's JAX, compiled by XLA. Libraries: Pinocchio in C++ and MuJoCo.

One call after another in compiled loops, as a program in C sees it; the same called from Python, state by
state; and batches on one core. After the ratio to symbody's time of the same round, the median of the rounds
with the least and the greatest in brackets, stands what generating and compiling took, from the model to a
function: processor time, with the compilers that were called.

All are given the tree alone, without damping and friction, which the recursions of Pinocchio leave out. What
a table compares is computed by all at the same states first; what differs is not timed. Pinocchio fills half
of the mass matrix, and derives along tangents where symbody has a column for each component of a quaternion.
"""

from __future__ import annotations

import statistics
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from types import MappingProxyType
from typing import Any, Final

import numpy as np

import symbody as sb
from benchmarks.engines.call_loops.loops import c_compiler
from benchmarks.operations import ROBOTS, ROBOTS_FOLDER, Robot
from benchmarks.robot_calls import (
    TASKS,
    Caller,
    Compiled,
    FromPython,
    InC,
    InCpp,
    InMujoco,
    OurC,
    casadi_c,
    cpp_program,
    jax_calls,
    median_of_passes,
    mujoco_calls,
    python_mujoco,
    python_pinocchio,
    python_symbody,
)
from benchmarks.robot_states import STATES, Floats, States, robot_states
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, rotated

OURS: Final = "symbody"
LOOP, PYTHON, BATCH = "one call in compiled loops", "one call from Python", "batches on one core"
# Who stands in which table: generated code first, libraries after it.
COLUMNS: Final[Mapping[str, Sequence[str]]] = {
    LOOP: (OURS, OurC.name, InC.name, InCpp.name, InMujoco.name),
    PYTHON: (OURS, InC.name, "symbody's JAX", "MJX", "Pinocchio", InMujoco.name),
    BATCH: (OURS, InCpp.name),
}
# States at which engines are compared, and the largest difference that rounding explains: mass matrices of
# humanoids have conditions of 1e6 to 1e8.
COMPARED: Final = 100
ALLOWED: Final = 1e-6
# Longer functions are not compiled for several points at once here.
_LONGEST_IN_LANES: Final = 300_000
# Points of a batch: many, but no more than so many results, which the processor's caches hold.
_BATCH: Final = 8000
_RESULTS: Final = 200_000

# What deviates: by task, the largest difference of a state over its largest result.
Differences = dict[str, float]

# What rounds gave: engine, then task, then the time of a call in each round [ns].
Times = dict[str, dict[str, list[float]]]


@dataclass(frozen=True, slots=True)
class Figure:
    """The time of one call in each round [ns]; what generating and compiling took [s], None for libraries."""

    robot: str
    task: str
    place: str
    engine: str
    nanoseconds: list[float]
    prepared: float | None = None


def figures(
    settings: Settings,
    robots: Mapping[str, Robot] = ROBOTS,
    folder: Path | None = None,
    *,
    peers: bool = True,
    count: int = STATES,
) -> tuple[list[Figure], list[str]]:
    """Return all figures, and notes on what is left out."""
    where = folder if folder is not None else Path(sysconfig.get_path("purelib"), ROBOTS_FOLDER)
    found: list[Figure] = []
    notes: list[str] = []
    for name, robot in robots.items():
        path = where / robot.path
        if not path.is_file():
            notes.append(f"{name} is not installed: {robot.path}")
            continue
        with TemporaryDirectory() as scratch:
            bench = RobotBench(name, robot, path, Path(scratch), peers=peers, count=count)
            found += bench.figures(settings.rounds)
            notes += bench.notes
    return found, [f"{count} states, {settings.rounds} rounds", *dict.fromkeys(notes)]


def tables(
    settings: Settings,
    robots: Mapping[str, Robot] = ROBOTS,
    folder: Path | None = None,
    *,
    peers: bool = True,
    count: int = STATES,
) -> Iterator[Table]:
    """Yield the table of compiled loops, that of calls from Python, and that of batches."""
    found, notes = figures(settings, robots, folder, peers=peers, count=count)
    for place in COLUMNS:
        yield table(found, place, tuple(notes) if place == LOOP else ())


def table(found: Sequence[Figure], place: str, notes: tuple[str, ...] = ()) -> Table:
    """Return the table of one way of calling."""
    by_key = {(f.robot, f.task, f.engine): f for f in found if f.place == place}
    rows = []
    for robot, task in dict.fromkeys((robot, task) for robot, task, _ in by_key):
        ours = by_key[robot, task, OURS]
        cells = [_cell(by_key.get((robot, task, engine)), ours) for engine in COLUMNS[place]]
        rows.append((f"{robot}, {task}", *cells))
    return Table(f"robots, {place}", ("task", *COLUMNS[place]), tuple(rows), notes)


def _cell(figure: Figure | None, ours: Figure) -> str:
    if figure is None:
        return ""
    text = _time(figure.nanoseconds) if figure is ours else ratio_cell(figure.nanoseconds, ours.nanoseconds)
    return text if figure.prepared is None else f"{text}; {seconds_text(figure.prepared)}"


class RobotBench:
    """A robot in all engines there are; `notes` say what is left out."""

    def __init__(
        self, name: str, robot: Robot, path: Path, scratch: Path, *, peers: bool, count: int
    ) -> None:
        self.name = name
        self.notes: list[str] = []
        pin = import_module("pinocchio") if peers and find_spec("pinocchio") else None
        self.states = robot_states(path, robot, pin, count)
        self.ours = Compiled(self.states)
        self.loops: list[Caller] = [self.ours]
        self.python: list[Caller] = [python_symbody(self.ours)]
        self.batches: list[Caller] = [Batches(self.ours)]
        self._untrue: set[tuple[str, str]] = set()
        if c_compiler() is None:
            self.loops = []
            self.notes.append("compiled loops are left out: there is no C compiler")
        else:
            written = OurC(self.ours, scratch)
            self._differ(written.name, our_c_differences(self.ours, written))
            self.loops.append(written)
        if peers:
            self._add_pinocchio(scratch)
            self._add_mujoco(robot.floating)

    def _add_pinocchio(self, scratch: Path) -> None:
        if self.states.pin_model is None:
            self.notes.append("Pinocchio is left out: pin is not installed")
            return
        cpp, why = cpp_program(self.states, scratch)
        written, why_not = casadi_c(self.states, scratch)
        self._note(why)
        self._note(f"{self.name}: {why_not}" if written and why_not else why_not)
        differences = pinocchio_differences(self.ours, cpp, written)
        for engine in (InCpp.name, "Pinocchio", InC.name):
            self._differ(engine, differences)
        self.python.append(python_pinocchio(self.states))
        if written is not None:
            self.loops.append(written)
            self.python.append(written.from_python())
        if cpp is not None:
            self.loops.append(cpp)
            self.batches.append(cpp)

    def _add_mujoco(self, floating: bool) -> None:
        peer, why = mujoco_calls(self.states, floating)
        self._note(f"{self.name}: {why}" if "read" in why else why)
        if peer is not None:
            self._differ(InMujoco.name, mujoco_differences(self.ours, peer))
            self.loops.append(peer)
            self.python.append(python_mujoco(peer))
        compiled, why = jax_calls(self.ours, peer)
        self._note(why)
        for caller in compiled:
            self._differ(caller.name, jax_differences(self.ours, peer, caller))
            self.python.append(caller)

    def figures(self, rounds: int) -> Iterator[Figure]:
        """Yield the figures of all, each taking its turn in every round."""
        for place, callers in ((LOOP, self.loops), (PYTHON, self.python), (BATCH, self.batches)):
            times, prepared = in_rounds(callers, rounds), {c.name: c.prepared for c in callers}
            for task in [task for task in TASKS if task in times.get(OURS, {})]:
                for engine, by_task in times.items():
                    if task in by_task and (engine, task) not in self._untrue:
                        price = prepared[engine].get(task)
                        yield Figure(self.name, task, place, engine, by_task[task], price)

    def _differ(self, who: str, found: Differences) -> None:
        for task, difference in found.items():
            if not difference < ALLOWED:
                self._untrue.add((who, task))
                self.notes.append(
                    f"{self.name}, {who}, {task}: results differ by {difference:.0e}, so it is not timed"
                )

    def _note(self, text: str) -> None:
        if text:
            self.notes.append(text)


class Batches:
    """Symbody's functions over large batches by one thread, as called from Python."""

    name = OURS
    prepared: Mapping[str, float] = MappingProxyType({})

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


def ratios(theirs: list[float], ours: list[float]) -> list[float]:
    """Return the times over symbody's of the same round, in order."""
    return sorted(a / b for a, b in zip(theirs, ours, strict=True))


def ratio_cell(theirs: list[float], ours: list[float]) -> str:
    """Return the median, and in brackets the least and the greatest ratio to symbody's of the same round.

    >>> ratio_cell([1000.0, 1100.0, 1200.0], [100.0, 100.0, 100.0])
    '11 (10-12)'
    """
    found = ratios(theirs, ours)
    middle, low, high = (_ratio(x) for x in (statistics.median(found), found[0], found[-1]))
    return middle if low == high else f"{middle} ({low}-{high})"


def _ratio(x: float) -> str:
    return f"{x:.0f}" if x >= 9.95 else f"{x:.1f}" if x >= 0.995 else f"{x:.2f}"


def _time(nanoseconds: list[float]) -> str:
    return seconds_text(1e-9 * statistics.median(nanoseconds))


# That all compute the same


def pinocchio_differences(ours: Compiled, cpp: InCpp | None, written: InC | None) -> Differences:
    """Return how far symbody's results, and those of the two programs, are from Pinocchio's in Python."""
    states = ours.states
    pin: Any = import_module("pinocchio")
    model = states.pin_model
    data = model.createData()
    expected: dict[str, list[list[Floats]]] = {name: [] for name in TASKS}
    for k in range(min(COMPARED, len(states.q))):
        q, v, tau, a = states.pin_q[k], states.pin_v[k], states.pin_tau[k], states.pin_a[k]
        expected["forward dynamics"].append([np.array(pin.aba(model, data, q, v, tau))])
        expected["inverse dynamics"].append([np.array(pin.rnea(model, data, q, v, a))])
        upper = np.triu(np.array(pin.crba(model, data, q)))
        expected["mass matrix"].append([upper + np.triu(upper, 1).T])
        pin.computeABADerivatives(model, data, q, v, tau)
        driven = np.array(data.Minv)[:, states.driven]
        expected["derivatives"].append([np.array(x) for x in (data.ddq, data.ddq_dq, data.ddq_dv)] + [driven])
    found = {
        name: largest(_in_order(ours, name), [np.array(x) for x in zip(*values, strict=True)])
        for name, values in expected.items()
    }
    if cpp is not None:
        aba, _ = cpp.results()
        count = len(expected["forward dynamics"])
        again = largest([aba[:count]], [np.array([x for (x,) in expected["forward dynamics"]])])
        found["forward dynamics"] = max(found["forward dynamics"], again)
    for name, calls in written.calls.items() if written is not None else ():
        theirs = calls.results(*(x[:COMPARED] for x in written.inputs(name)))
        if name == "mass matrix":
            theirs = [np.triu(x) + np.swapaxes(np.triu(x, 1), 1, 2) for x in theirs]
        if name == "derivatives":
            theirs[-1] = theirs[-1][:, :, states.driven]
        found[name] = max(
            found[name], largest(theirs, [np.array(x) for x in zip(*expected[name], strict=True)])
        )
    return found


def our_c_differences(ours: Compiled, written: OurC) -> Differences:
    """Return how far the results of symbody's C are from those of its machine code."""
    found: Differences = {}
    for name in written.functions:
        own = np.hstack([x[:COMPARED].reshape(min(COMPARED, len(x)), -1) for x in ours.results(name)])
        found[name] = largest(written.results(name, len(own)), [own])
    return found


def jax_differences(ours: Compiled, peer: InMujoco | None, caller: FromPython) -> Differences:
    """Return how far accelerations compiled by XLA are from symbody's, where both have the same axes."""
    name = "forward dynamics"
    own = ours.results(name)[0][:COMPARED]
    theirs = np.array([caller.calls[name](k) for k in range(len(own))])
    if caller.name == "MJX" and peer is not None:
        kept = [k for k in range(len(peer.calls.order)) if k not in peer.calls.turned]
        own, theirs = own[:, peer.calls.order[kept]], theirs[:, kept]
    return {name: largest([own], [theirs])}


def mujoco_differences(ours: Compiled, peer: InMujoco) -> Differences:
    """Return how far MuJoCo's results are from symbody's, where both have the same axes."""
    calls, found = peer.calls, {}
    kept = [k for k in range(len(calls.order)) if k not in calls.turned]
    for name, inverse in (("forward dynamics", False), ("inverse dynamics", True)):
        own = ours.results(name)[0][:COMPARED][:, calls.order[kept]]
        theirs = np.array([calls.result(k, inverse)[kept] for k in range(len(own))])
        found[name] = largest([own], [theirs])
    return found


def largest(found: list[Floats], expected: list[Floats]) -> float:
    """Return the largest difference at a state, relative to its largest value; nan where one is nan."""
    worst = 0.0
    for one, other in zip(found, expected, strict=True):
        flat, reference = one.reshape(len(one), -1), other.reshape(len(other), -1)
        if reference.shape[1]:
            size = np.abs(reference).max(axis=1)
            worst = float(np.maximum(worst, (np.abs(flat - reference).max(axis=1) / size).max()))
    return worst


def _in_order(ours: Compiled, name: str) -> list[Floats]:
    """Return symbody's results in Pinocchio's order and directions."""
    states, order = ours.states, ours.states.order
    found = [x[:COMPARED] for x in ours.results(name)]
    if name == "mass matrix":
        return [found[0][:, order][:, :, order]]
    if name != "derivatives":
        return [found[0][:, order]]
    udot, slopes = found
    n_q, n_u = states.q.shape[1], states.u.shape[1]
    by_q = np.einsum("kij,kjl->kil", slopes[:, order, :n_q], _tangents(states)[: len(slopes)])
    by_u = slopes[:, order, n_q : n_q + n_u][:, :, order]
    by_r = slopes[:, order, n_q + n_u :]
    return [udot[:, order], by_q, by_u, by_r]


def _tangents(states: States) -> Floats:
    """Return how coordinates change along Pinocchio's v, apart from shifts of the base: no u' reads them."""
    names, speeds = states.eqs.coordinate_names, states.eqs.speed_names
    found = np.zeros((len(states.q), len(names), len(speeds)))
    for column, speed in enumerate(speeds[k] for k in states.order):
        if speed.removesuffix("_dot") in names:
            found[:, names.index(speed.removesuffix("_dot")), column] = 1.0
        elif speed == "base_wx":
            rows = [names.index(f"base_{part}") for part in ("qw", "qx", "qy", "qz")]
            w, x, y, z = states.q[:, rows].T
            turns = 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
            for k, row in enumerate(rows):
                found[:, row, column : column + 3] = turns[k].T
    return found
