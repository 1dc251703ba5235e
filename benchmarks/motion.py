"""Motions in the compiled loop, beside SciPy's DOP853 around the same compiled function.

The same tolerances and the same stored points; SciPy gets the function as a user would give it. A closed loop
is compared with its own right-hand side: what projection costs on top.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.mechanisms import EXAMPLES
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, seconds

# Example, seconds, tolerance, initial values beside those of the file.
RUNS: Final = (
    ("spinning_top", 10.0, 1e-10),
    ("spinning_top_omega", 10.0, 1e-10),
    ("rr_robot", 10.0, 1e-10),
    ("slider_crank", 10.0, 1e-8),
)
GOAL: Final = 50.0
POINTS: Final = 501


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of this benchmark."""
    yield motions(settings)


def motions(settings: Settings, runs: Sequence[tuple[str, float, float]] = RUNS) -> Table:
    """Return loop times and evaluations, and in brackets SciPy's over ours."""
    rows = [_row(name, end, rtol, settings.rounds) for name, end, rtol in runs]
    columns = (
        "example",
        "steps",
        "evaluations",
        "loop",
        "a call of the function",
        "loop over its calls",
        "goal",
    )
    notes = (
        f"shortest of {settings.rounds} rounds in turns; {POINTS} stored points; SciPy's DOP853 in brackets, "
        f"goal: {GOAL:g} times",
    )
    return Table("motion in the compiled loop", columns, tuple(rows), notes)


def _row(name: str, end: float, rtol: float, rounds: int) -> tuple[str, ...]:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))
    start = sb.assemble(eqs)
    times = np.linspace(0.0, end, POINTS)
    x = np.array([*start.u.values(), *start.q.values()])
    f = sb.compile(eqs, "xdot")
    r = np.zeros(len(eqs.input_names))
    loops, others = [], []
    for _ in range(rounds):
        run = sb.simulate(eqs, end, times=times, rtol=rtol, atol=1e-10, integrator=sb.Explicit())
        loops.append(run.statistics.loop_seconds)
        kept: list[int] = []

        def peer(kept: list[int] = kept) -> None:
            options = {"method": "DOP853", "t_eval": times, "rtol": rtol, "atol": 1e-10}
            kept.append(solve_ivp(lambda t, x: f.of_state(t, x, r), (0.0, end), x, **options).nfev)

        others.append(seconds(peer))
    calls = run.statistics.evaluations
    batch = np.tile(x, (100_000, 1))
    one = min(seconds(lambda: f.of_state(0.0, batch, r)) for _ in range(rounds)) / len(batch)
    loop, other = min(loops), min(others)
    closed = " (drifts)" if eqs.multiplier_names else ""
    return (
        name,
        str(run.statistics.accepted),
        f"{calls} ({kept[0] / calls:.2f})",
        f"{seconds_text(loop)} ({other / loop:.0f}){closed}",
        seconds_text(one),
        f"{loop / (calls * one):.2f}",
        "met" if other / loop >= GOAL else f"{other / loop / GOAL:.0%}",
    )
