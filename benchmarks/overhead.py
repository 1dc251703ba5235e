"""What a user's loop costs around the motion: first runs, repeated ones, short ones, calls, events, tables.

Processor time throughout, all engines in turns. The first table asks every engine for the same motions of a
chain; the second symbody and SciPy for a closed loop, whose rows SciPy does not keep; the third is of symbody
alone, beside the plain call, SciPy's events and NumPy's interpolation.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import count
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.engines.around import ATOL, OURS, RTOL, Move, available, process_seconds, start_angles
from benchmarks.engines.moving import parameters
from benchmarks.event_cases import events_table
from benchmarks.mechanisms import EXAMPLES, spatial_chain
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, in_turns, medians, processor_seconds

Floats = NDArray[np.float64]
Samples = Mapping[str, Callable[[], float]]

LINKS: Final = 5
SHORT: Final = 0.01  # seconds between two samples of a controller
_STEPS: Final = 200
_TIMES: Final = 10  # short motions and calls are timed so many at once
_CALLS: Final = 2000
_GRAVITY: Final = 9.81
_BOUNCES: Final = 20
POINTS: Final = 100_000
LANES: Final = (8, 64)


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the tables of this benchmark."""
    yield chain(settings)
    yield closed_loop(settings)
    yield inside(settings)
    yield events_table(settings)


# One chain, all engines


def chain(settings: Settings, links: int = LINKS, *, processes: bool = True) -> Table:
    """Return what motions of one second cost, and one of 10 ms, by all engines that are installed."""
    makers = dict(available())
    missing = [f"{label}: not installed" for label, maker in makers.items() if maker is None]
    moves = {label: maker(links) for label, maker in makers.items() if maker is not None}
    rows = [*(_first_rows([*moves], links) if processes else ()), *_again_rows(moves, links, settings)]
    notes = (
        f"{links} hinged bodies, 1 s of motion; median of {settings.rounds} rounds in turns, first runs once",
        f"tolerance {RTOL:g}; MuJoCo's steps do not aim at one",
        *missing,
    )
    return _beside("around the loop: a chain", [*moves], rows, notes)


def _first_rows(labels: list[str], links: int) -> Iterator[tuple[str, dict[str, float]]]:
    with tempfile.TemporaryDirectory() as folder:
        cold = {label: process_seconds(label, links, f"{folder}/{k}") for k, label in enumerate(labels)}
        warm = {label: process_seconds(label, links, f"{folder}/{k}") for k, label in enumerate(labels)}
    yield "first motion on a machine", cold
    yield "first motion of a later process", warm


def _again_rows(
    moves: Mapping[str, Move], links: int, settings: Settings
) -> Iterator[tuple[str, dict[str, float]]]:
    start = start_angles(links)
    for move in moves.values():
        move(start, 1.0, 1.0)  # whatever is made by the first motion
    turn = count(1)

    def another_state(move: Move) -> float:
        return processor_seconds(lambda: move(start + 1e-6 * next(turn), 1.0, 1.0))

    def another_mass(move: Move) -> float:
        return processor_seconds(lambda: move(start, 1.0 + 1e-6 * next(turn), 1.0))

    def short(move: Move) -> float:
        return _mean(lambda: move(start + 1e-6 * next(turn), 1.0, SHORT), _TIMES)

    for what, task in (
        ("again, other initial values", another_state),
        ("again, other parameters", another_mass),
    ):
        samples: Samples = {label: partial(task, move) for label, move in moves.items()}
        yield what, medians(in_turns(samples, settings.rounds))
    eqs = sb.form_equations(spatial_chain(links).model())
    first = dict(zip(eqs.coordinate_names, start.tolist(), strict=True))
    stepper = sb.Stepper(eqs, SHORT, parameters=parameters(links), initial=first, rtol=RTOL, atol=ATOL)
    yield from _short_rows(stepper, {label: partial(short, move) for label, move in moves.items()}, settings)


def _short_rows(
    stepper: sb.Stepper, samples: Samples, settings: Settings
) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield what short motions cost: symbody's by a stepper, and by whole calls of `simulate`."""
    stepper.step()
    by_steps = {OURS: lambda: _mean(stepper.step, _STEPS)}
    times = medians(in_turns({**samples, **by_steps}, settings.rounds))
    yield f"{SHORT * 1e3:g} ms of motion (symbody: Stepper)", times
    yield (
        f"{SHORT * 1e3:g} ms of motion by simulate",
        medians(in_turns({OURS: samples[OURS]}, settings.rounds)),
    )


def _beside(
    title: str, labels: list[str], rows: list[tuple[str, dict[str, float]]], notes: tuple[str, ...]
) -> Table:
    def cell(label: str, times: Mapping[str, float]) -> str:
        if label not in times:
            return ""
        return seconds_text(times[label]) + ("" if label == OURS else ratio_text(times[label], times[OURS]))

    lines = [(what, *(cell(label, times) for label in labels)) for what, times in rows]
    return Table(title, ("processor time", *labels), tuple(lines), notes)


# A closed loop


def closed_loop(settings: Settings) -> Table:
    """Return what the slider-crank costs by `simulate` and by SciPy around the same function."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    f = sb.compile(eqs, "xdot", free=["m2"])
    mass = float(sb.compile(eqs, "m2", parameters={})(0.0, *_rest(eqs)))
    first = sb.assemble(eqs)
    x, r = np.array([*first.u.values(), *first.q.values()]), np.zeros(len(eqs.input_names))
    speed = eqs.speed_names[0]

    def ours(shift: float, value: float, end: float) -> None:
        sb.simulate(
            eqs, end, {speed: shift}, parameters={"m2": value}, times=[0.0, end], rtol=RTOL, atol=ATOL
        )

    def scipy(shift: float, value: float, end: float) -> None:
        p = np.array([value])

        def rates(t: float, x: Floats) -> Floats:
            return np.asarray(f.of_state(t, x, r, p))

        solve_ivp(rates, (0.0, end), x + shift * 1e-9, "DOP853", [end], rtol=RTOL, atol=ATOL)

    turn = count(1)
    engines = {OURS: ours, "SciPy, our function (drifts)": scipy}
    tasks: dict[str, Callable[[Any], float]] = {
        "again, other initial values": lambda go: processor_seconds(lambda: go(1e-6 * next(turn), mass, 1.0)),
        "again, other parameters": lambda go: processor_seconds(
            lambda: go(0.0, mass * (1 + 1e-6 * next(turn)), 1.0)
        ),
    }

    def short(go: Callable[[float, float, float], None]) -> float:
        return _mean(lambda: go(1e-6 * next(turn), mass, SHORT), _TIMES)

    for go in engines.values():
        go(0.0, mass, 1.0)
    rows = []
    for what, task in tasks.items():
        samples: Samples = {label: partial(task, go) for label, go in engines.items()}
        rows.append((what, medians(in_turns(samples, settings.rounds))))
    stepper = sb.Stepper(eqs, SHORT, rtol=RTOL, atol=ATOL)
    rows += _short_rows(stepper, {label: partial(short, go) for label, go in engines.items()}, settings)
    notes = (f"slider-crank, 1 s of motion; median of {settings.rounds} rounds in turns",)
    return _beside("around the loop: a closed loop", [*engines], rows, notes)


def _rest(eqs: sb.EquationSet) -> tuple[Floats, Floats, Floats]:
    names = (eqs.coordinate_names, eqs.speed_names, eqs.input_names)
    return np.zeros(len(names[0])), np.zeros(len(names[1])), np.zeros(len(names[2]))


# Calls, events, tables


def inside(settings: Settings, points: int = POINTS, bounces: int = _BOUNCES) -> Table:
    """Return what a call with parameters costs beside one without, an event, and a long table."""
    rows = [*_call_rows(settings), _event_row(settings, bounces), _table_row(settings, points)]
    rows += [_lanes_row(settings, count) for count in LANES]
    notes = (
        f"median of {settings.rounds} rounds in turns; an event: a ball that bounces {bounces} times, over "
        f"that; a table: an input of {points} points, 1 s of motion; lanes: 1 ms of a cart-pole, a new force "
        "for each",
    )
    columns = ("processor time", "symbody", "beside")
    return Table("calls, events, tables", columns, tuple(rows), notes)


def _call_rows(settings: Settings) -> Iterator[tuple[str, ...]]:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    plain, free = sb.compile(eqs, "udot"), sb.compile(eqs, "udot", free=["m2"])
    q, u, r = _rest(eqs)
    q += 0.3
    p = np.ones(1)
    samples: Samples = {
        "plain": lambda: _mean(lambda: plain(0.0, q, u, r), _CALLS),
        "free": lambda: _mean(lambda: free(0.0, q, u, r, p), _CALLS),
        "bound": lambda: _mean(lambda: free.bind(p)(0.0, q, u, r), _CALLS // 10),
    }
    times = medians(in_turns(samples, settings.rounds))
    beside = f"f(t, q, u, r): {seconds_text(times['plain'])}"
    yield "f(t, q, u, r, p)", seconds_text(times["free"]) + ratio_text(times["free"], times["plain"]), beside
    yield (
        "f.bind(p)(t, q, u, r)",
        seconds_text(times["bound"]) + ratio_text(times["bound"], times["plain"]),
        beside,
    )


class _Touch:
    """The ball touches the ground, in SciPy's words."""

    terminal = True
    direction = -1.0

    def __call__(self, t: float, x: Floats) -> float:
        """Return the height."""
        return float(x[1])


def _event_row(settings: Settings, bounces: int) -> tuple[str, ...]:
    """Compare with SciPy, which ends at each bounce and is started again."""
    ball = sb.form_equations(
        sb.Model(
            "ball",
            [sb.Body("B", mass=1), sb.Prismatic("j", "ground", "B", axis="y", coordinate="y")],
            gravity=(0, -_GRAVITY, 0),
        )
    )
    bounce = sb.Event("y", -1, {"y_dot": "-y_dot"}, "hit")
    end = float(np.sqrt(2.0 / _GRAVITY) * 2.0 * bounces)

    def ours() -> float:
        run: list[sb.Trajectory] = []
        spent = processor_seconds(
            lambda: run.append(sb.simulate(ball, end, {"y": 1.0}, events=bounce, rtol=RTOL, atol=ATOL))
        )
        return spent / len(run[0].events)

    f = sb.compile(ball, "xdot")

    def bouncing() -> int:
        t, x, hits = 0.0, np.array([0.0, 1.0]), 0
        while t < end:
            done = solve_ivp(f.of_state, (t, end), x, "DOP853", events=_Touch(), rtol=RTOL, atol=ATOL)
            t, x = float(done.t[-1]), np.array([-done.y[0, -1], max(done.y[1, -1], 1e-14)])
            hits += done.status == 1
        return hits

    def scipy() -> float:
        hits: list[int] = []
        return processor_seconds(lambda: hits.append(bouncing())) / max(hits[0], 1)

    times = medians(in_turns({"ours": ours, "scipy": scipy}, settings.rounds))
    beside = f"SciPy's events: {seconds_text(times['scipy'])}{ratio_text(times['scipy'], times['ours'])}"
    return "an event", seconds_text(times["ours"]), beside


def _table_row(settings: Settings, points: int) -> tuple[str, ...]:
    """Compare with SciPy around the same function and NumPy's interpolation."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "rr_robot" / "rr_robot.toml"))
    name = eqs.input_names[0]
    t = np.linspace(0.0, 1.0, points)
    values = np.sin(3.0 * t)
    table, f = sb.Table(t, values), sb.compile(eqs, "xdot")
    first = sb.assemble(eqs)
    x, r = np.array([*first.u.values(), *first.q.values()]), np.zeros(len(eqs.input_names))

    def ours() -> float:
        return processor_seconds(
            lambda: sb.simulate(eqs, 1.0, inputs={name: table}, times=[0.0, 1.0], rtol=RTOL, atol=ATOL)
        )

    def rates(time: float, state: Floats) -> Floats:
        r[0] = np.interp(time, t, values)
        return np.asarray(f.of_state(time, state, r))

    def scipy() -> float:
        options = {"rtol": RTOL, "atol": ATOL, "max_step": 1e-2}
        return processor_seconds(lambda: solve_ivp(rates, (0.0, 1.0), x, "DOP853", **options))

    ours()
    times = medians(in_turns({"ours": ours, "scipy": scipy}, settings.rounds))
    beside = (
        f"SciPy and numpy.interp: {seconds_text(times['scipy'])}{ratio_text(times['scipy'], times['ours'])}"
    )
    return f"an input of {points} points", seconds_text(times["ours"]), beside


def _lanes_row(settings: Settings, count: int) -> tuple[str, ...]:
    """Compare a step of many motions at once with as many single ones."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "cart_pole" / "cart_pole.toml"))
    random = np.random.default_rng(18)
    forces = random.normal(0.0, 3.0, (_STEPS, count))
    lanes = sb.LaneStepper(eqs, 1e-3, count, initial={"theta": random.uniform(-0.3, 0.3, count)})
    singles = [lanes.lane(place) for place in range(count)]

    def together() -> None:
        for row in forces:
            lanes.step(F=row)

    def one_by_one() -> None:
        for row in forces.tolist():
            for single, force in zip(singles, row, strict=True):
                single.step(F=force)

    samples: Samples = {
        "ours": lambda: processor_seconds(together) / forces.size,
        "single": lambda: processor_seconds(one_by_one) / forces.size,
    }
    times = medians(in_turns(samples, settings.rounds))
    beside = (
        f"{count} of sb.Stepper: {seconds_text(times['single'])}{ratio_text(times['single'], times['ours'])}"
    )
    return f"a step of each of {count} lanes", seconds_text(times["ours"]), beside


def _mean(task: Callable[[], object], times: int) -> float:
    """Return the processor time of one of several runs."""

    def repeat() -> None:
        for _ in range(times):
            task()

    return processor_seconds(repeat) / times
