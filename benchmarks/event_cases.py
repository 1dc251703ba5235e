"""What an event costs: motions whose states, directions or equations change, over how often they do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import cos, pi, sin, sqrt
from typing import Final, NamedTuple

import symbody as sb
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, in_turns, medians, processor_seconds

_GRAVITY: Final = 9.81
_SLOPE: Final = 0.08  # of the wheel's road
_SPOKES: Final = pi / 8  # half the angle between two


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
