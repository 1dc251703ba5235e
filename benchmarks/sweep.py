"""Many motions: tops and slider-cranks of different masses, by one thread and by two, with and without lanes.

Throughput is stated for each core, beside the same motions one by one in the loop for a single motion, and by
SciPy's DOP853 with the same compiled function.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.mechanisms import EXAMPLES
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, processor_seconds, seconds

CASES: Final = 100_000
WITHOUT_LANES: Final = 10_000  # they take five times as long
END: Final = 10.0
THREADS: Final = (1, 2)
# Of so many times the throughput of one thread.
GOAL: Final = 0.8
CRANKS: Final = 512
# Of so many times the throughput of a loop without lanes.
CLOSED_GOAL: Final = 1.3
_ALONE: Final = 20


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the tables of this benchmark."""
    yield tops(settings)
    yield cranks(settings)


def tops(settings: Settings, cases: int = CASES) -> Table:
    """Return times of all cases and of one, and what a second thread brings."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "spinning_top" / "spinning_top.toml"))
    masses = np.linspace(0.9, 1.1, cases)
    times = [END]

    def swept(threads: int, lanes: bool, count: int) -> sb.Sweep:
        return sb.sweep(eqs, END, {"m": masses[:count]}, times=times, threads=threads, lanes=lanes)

    rows = []
    for lanes, count in ((True, cases), (False, min(cases, WITHOUT_LANES))):
        swept(2, lanes, 64)  # compiles
        spent, work = _alternating(settings, partial(swept, lanes=lanes, count=count))
        for threads in THREADS:
            share = spent[THREADS[0]] / spent[threads] / threads
            rows.append(
                (
                    f"{threads} thread{'s' * (threads > 1)}, {'lanes' if lanes else 'no lanes'}",
                    f"{count}",
                    seconds_text(spent[threads]),
                    f"{count / spent[threads]:.0f}",
                    f"{count / work[threads]:.0f}",
                    f"{share:.0%}{' met' if share >= GOAL else ''}",
                )
            )
    alone = [
        sb.simulate(eqs, END, parameters={"m": mass}, times=times, integrator=sb.Explicit()).statistics
        for mass in masses[:_ALONE]
    ]
    loop = min(run.loop_seconds for run in alone)
    rows.append(("one by one, its loop alone", "", "", f"{1 / loop:.0f}", f"{1 / loop:.0f}", ""))
    peer = _peer(eqs)
    rows.append(("SciPy's DOP853", "", "", f"{1 / peer:.0f}", f"{1 / peer:.0f}", ""))
    columns = ("by", "cases", "in", "cases a second", "a second of processor", "of its threads")
    notes = (
        f"tops of {END:g} s at rtol 1e-8; {os.cpu_count()} processors; goal: {GOAL:.0%} of twice one thread",
        "what else runs on the machine slows what is in seconds down, hardly what is in seconds of processor",
    )
    return Table("many motions", columns, tuple(rows), notes)


def cranks(settings: Settings, cases: int = CRANKS) -> Table:
    """Return what lanes bring for closed loops that are held by projection, without and with first states."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    masses = np.linspace(0.7, 0.9, cases)

    def work(end: float, lanes: bool) -> float:
        options = {"times": [end], "threads": 1, "lanes": lanes, "constraints": sb.Projection()}
        sb.sweep(eqs, end, {"m3": masses[:16]}, **options)  # compiles
        swept = partial(sb.sweep, eqs, end, {"m3": masses}, **options)
        return min(processor_seconds(swept) for _ in range(min(settings.rounds, 3))) / cases

    starts = work(0.0, False)
    whole = {lanes: work(END, lanes) for lanes in (False, True)}
    rows = []
    for name, less in (("integration", starts), ("whole sweep", 0.0)):
        spent = [whole[lanes] - less for lanes in (False, True)]
        ratio = spent[0] / spent[1]
        met = " met" if name == "integration" and ratio >= CLOSED_GOAL else ""
        rows.append((name, *map(seconds_text, spent), f"{ratio:.2f}{met}"))
    columns = ("of one slider-crank", "no lanes", "lanes", "ratio")
    notes = (
        f"{cases} closed by projection for {END:g} s, in seconds of processor; goal: {CLOSED_GOAL:g} times",
        f"first states, {seconds_text(starts)} each, are found case by case: the same with and without lanes",
    )
    return Table("many closed loops", columns, tuple(rows), notes)


def _alternating(
    settings: Settings, swept: Callable[[int], sb.Sweep]
) -> tuple[dict[int, float], dict[int, float]]:
    """Return the least time and the least time of processors by number of threads, measured in turns."""
    spent, work = dict.fromkeys(THREADS, math.inf), dict.fromkeys(THREADS, math.inf)
    for _ in range(min(settings.rounds, 3)):
        for threads in THREADS:
            began = time.process_time()
            spent[threads] = min(spent[threads], seconds(partial(swept, threads)))
            work[threads] = min(work[threads], time.process_time() - began)
    return spent, work


def _peer(eqs: sb.EquationSet) -> float:
    """Return the time of one motion by SciPy."""
    f, start = sb.compile(eqs, "xdot"), sb.assemble(eqs)
    x = np.array([*start.u.values(), *start.q.values()])
    options = {"method": "DOP853", "t_eval": [END], "rtol": 1e-8, "atol": 1e-10}
    return min(
        processor_seconds(lambda: solve_ivp(lambda t, x: f.of_state(t, x), (0.0, END), x, **options))
        for _ in range(5)
    )
