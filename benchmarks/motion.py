"""Motions in the compiled loop, beside SciPy's DOP853 around the same compiled function.

The same tolerances and the same stored points; SciPy gets the function as a user would give it. Each loop is
compared with the calls of its own right-hand side, too: what the method and projection cost on top. A stage
waits for the one before, so calls are timed in a chain, each at a state that depends on the result before;
the processor overlaps calls that do not wait for each other, and their time stands in brackets.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.mechanisms import EXAMPLES
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, seconds
from symbody.codegen.llvm.kernel_library import compile_kernels

Floats = NDArray[np.float64]

# Example, seconds, tolerance.
RUNS: Final = (
    ("spinning_top", 10.0, 1e-10),
    ("spinning_top_omega", 10.0, 1e-10),
    ("rr_robot", 10.0, 1e-10),
    ("slider_crank", 10.0, 1e-8),
)
GOAL: Final = 50.0
# The loop over its calls, at most: of trees, and of closed loops.
CALLS_GOALS: Final = (2.0, 2.5)
POINTS: Final = 501


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of this benchmark."""
    yield motions(settings)


def motions(settings: Settings, runs: Sequence[tuple[str, float, float]] = RUNS) -> Table:
    """Return loop times and evaluations, in brackets SciPy's over ours, and loops over their calls."""
    rows = [_row(name, end, rtol, settings.rounds) for name, end, rtol in runs]
    columns = (
        "example",
        "steps",
        "evaluations",
        "loop",
        "goal",
        "a call in a chain",
        "loop over its calls",
        "goal of calls",
    )
    tree, closed = CALLS_GOALS
    notes = (
        f"shortest of {settings.rounds} rounds in turns; {POINTS} stored points; SciPy's DOP853 in brackets, "
        f"goal: {GOAL:g} times",
        f"calls that need not wait for each other in brackets; goal: {tree:g}, of closed loops {closed:g}",
    )
    return Table("motion in the compiled loop", columns, tuple(rows), notes)


def _row(name: str, end: float, rtol: float, rounds: int) -> tuple[str, ...]:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))
    start = sb.assemble(eqs)
    times = np.linspace(0.0, end, POINTS)
    x = np.array([*start.u.values(), *start.q.values()])
    f = sb.compile(eqs, "xdot")
    r = np.zeros(len(eqs.input_names))
    kept: list[int] = []

    def peer() -> None:
        options = {"method": "DOP853", "t_eval": times, "rtol": rtol, "atol": 1e-10}
        kept.append(solve_ivp(lambda t, x: f.of_state(t, x, r), (0.0, end), x, **options).nfev)

    loops, others, chained, apart = [], [], [], []
    for _ in range(rounds):
        run = sb.simulate(eqs, end, times=times, rtol=rtol, atol=1e-10, integrator=sb.Explicit())
        loops.append(run.statistics.loop_seconds)
        others.append(seconds(peer))
        chained.append(_call_seconds(eqs, run, 1e-300))
        apart.append(_call_seconds(eqs, run, 0.0))
    calls, loop, other = run.statistics.evaluations, min(loops), min(others)
    share, best = loop / (calls * min(chained)), loop / (calls * min(apart))
    is_closed = bool(eqs.multiplier_names)
    return (
        name,
        str(run.statistics.accepted),
        f"{calls} ({kept[0] / calls:.2f})",
        f"{seconds_text(loop)} ({other / loop:.0f}){' (drifts)' if is_closed else ''}",
        "met" if other / loop >= GOAL else f"{other / loop / GOAL:.0%}",
        f"{seconds_text(min(chained))} ({seconds_text(min(apart))})",
        f"{share:.2f} ({best:.2f})",
        "met" if share <= CALLS_GOALS[is_closed] else f"{share / CALLS_GOALS[is_closed]:.0%}",
    )


def _call_seconds(eqs: sb.EquationSet, run: sb.Trajectory, link: float) -> float:
    """Return the time of a call of what the loop calls, at the samples of a run; see `_calls`."""
    function = sb.compile(eqs, ["xdot", "power"])
    inputs, work = np.zeros(len(eqs.input_names)), np.zeros(function.work_size)
    n_u = len(eqs.speed_names)
    states = np.ascontiguousarray(np.vstack([run.u, run.q]).T)
    arrays = [states, np.zeros(1), inputs, function.constants(), work, *np.zeros((2, states.shape[1] + 1))]
    places = [array.ctypes.data for array in arrays]
    sizes = len(states), n_u, states.shape[1] - n_u

    def calls() -> None:
        _chain_calls()(function.address, *sizes, places[0], link, *places[1:])

    calls()
    return min(seconds(calls) for _ in range(20)) / len(states)


@cache
def _chain_calls() -> Callable[..., None]:
    """Return `chained_calls.chain_calls` as machine code."""
    file = Path(__file__).with_name("chained_calls.py")
    place = compile_kernels(file.read_text(encoding="utf-8"), file.name)["chain_calls"]
    pointer, integer = ctypes.c_void_p, ctypes.c_int64
    kinds = [pointer, *[integer] * 3, pointer, ctypes.c_double, *[pointer] * 6]
    return ctypes.CFUNCTYPE(None, *kinds)(place)
