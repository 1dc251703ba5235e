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
from math import cos, pi, sin, sqrt
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.engines.around import ATOL, OURS, RTOL, Move, available, process_seconds, start_angles
from benchmarks.engines.moving import parameters
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
_SLOPE: Final = 0.08  # of the wheel's road
_SPOKES: Final = pi / 8  # half the angle between two


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


# Events: motions whose states, directions or equations change, over how often they do


class Case(NamedTuple):
    """A motion with events."""

    what: str
    run: Callable[[], sb.Trajectory]


def events_table(settings: Settings) -> Table:
    """Return what events cost in motions of several kinds: all of `simulate`, and the compiled loop alone."""
    cases = {case.what: case.run for case in event_cases()}
    loops: dict[str, list[float]] = {what: [] for what in cases}
    counts = {what: len(run().events) for what, run in cases.items()}

    def sample(what: str) -> float:
        kept: list[sb.Trajectory] = []
        spent = processor_seconds(lambda: kept.append(cases[what]()))
        loops[what].append(kept[0].statistics.loop_seconds)
        return spent

    samples: Mapping[str, Callable[[], float]] = {what: partial(sample, what) for what in cases}
    times = medians(in_turns(samples, settings.rounds))
    inside = medians(loops)
    rows = [
        (what, str(count), seconds_text(times[what] / count), seconds_text(inside[what] / count))
        for what, count in counts.items()
    ]
    notes = (f"median of {settings.rounds} rounds in turns; the whole motion over its events",)
    return Table("events", ("motion", "events", "an event", "of it in the loop"), tuple(rows), notes)


def event_cases() -> Iterator[Case]:
    """Yield the motions, their equations formed."""
    ball = _slider("ball", (0, -_GRAVITY, 0))
    bounce = sb.Event("y", -1, {"y_dot": "-y_dot"}, "hit")
    fall = sqrt(2.0 / _GRAVITY)
    yield Case("bouncing ball", lambda: sb.simulate(ball, 40.0 * fall, {"y": 1.0}, events=bounce))
    wheel = _wheel()
    strike = sb.Event("th + a", -1, {"th": "a", "th_dot": "cos(2*a)*th_dot"}, "strike")
    yield Case("rimless wheel", lambda: sb.simulate(wheel, 20.0, {"th": 0.0, "th_dot": -1.5}, events=strike))
    rest = _slider("slider", (0, 0, 0))
    yield Case("31 zeros of sin(t)", lambda: sb.simulate(rest, 100.0, events=sb.Event("sin(t)")))
    belt = _belt()
    yield Case("block dragged over a belt", lambda: sb.simulate(belt, 10.0))
    ropes = _two_ropes()
    start = {"x": -0.3, "y": -sqrt(0.55), "x_dot": 1.0, "y_dot": -0.3 / sqrt(0.55)}
    yield Case("ball on two ropes", lambda: sb.simulate(ropes, 2.0, start))


def _slider(name: str, gravity: tuple[float, float, float]) -> sb.EquationSet:
    guide = sb.Prismatic("j", "ground", "B", axis="y", coordinate="y")
    return sb.form_equations(sb.Model(name, [sb.Body("B", mass=1), guide], gravity=gravity))


def _wheel() -> sb.EquationSet:
    """Return a rimless wheel as a pendulum about the spoke on the ground; a strike takes the next one."""
    body = sb.Body("W", mass=1, inertia=(0, 0, 0), frames={"F": sb.Frame(at=(0, -1, 0))})
    joint = sb.Revolute("j", "ground", "W.F", axis="z", coordinate="th")
    gravity = (_GRAVITY * sin(_SLOPE), -_GRAVITY * cos(_SLOPE), 0.0)
    return sb.form_equations(sb.Model("wheel", [body, joint], gravity=gravity, parameters={"a": _SPOKES}))


def _belt() -> sb.EquationSet:
    friction = sb.Friction(mu=0.2, mu_static=0.3)
    pull = sb.Drive(applied="40*(0.3*t - x)")
    guide = sb.Prismatic("guide", "ground", "Block", coordinate="x", friction=friction, force=pull)
    return sb.form_equations(sb.Model("belt", [sb.Body("Block", 1.5), guide], gravity=(0, 0, -_GRAVITY)))


def _two_ropes() -> sb.EquationSet:
    place = sb.Rectangular("place", "ground", "Ball", coordinates=["x", "y"])
    first = sb.Distance("first", "ground", "Ball", 0.8, rope=True)
    second = sb.Distance("second", "ground.peg", "Ball", "l", rope=True)
    return sb.form_equations(
        sb.Model("two ropes", [sb.Body("Ball", 0.7), place, first, second], gravity=(0, -_GRAVITY, 0),
                 ground={"peg": sb.Frame(at=(-0.2, -0.5, 0))}, parameters={"l": sqrt(0.13)})
    )  # fmt: skip
