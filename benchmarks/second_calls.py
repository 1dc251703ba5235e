"""What `simulate` costs when it is called again, with other initial values and parameters each time.

Everything that a mechanism needs once is made by the first call; here the calls after it are measured, in
processor time, and the files of the package that code of one of them runs in.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import count
from pathlib import Path
from types import FrameType, MappingProxyType
from typing import Any, Final

import symbody as sb
from benchmarks.mechanisms import EXAMPLES
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, in_turns, medians, processor_seconds

Call = Callable[[float], sb.Trajectory]  # of a small number, another one at each call

GOAL: Final = 6e-4  # of the four-bar [s]
FILES_GOAL: Final = 35  # of the pendulum
CALLS: Final = 31
_PACKAGE: Final = str(Path(sb.__file__).parent)


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of this benchmark."""
    yield second_calls(settings)


def second_calls(settings: Settings, calls: int = CALLS) -> Table:
    """Return the shortest and the median time of a call, that in the loop, and how many files run."""
    made = {name: make() for name, make in CASES.items()}
    turn = count(1)
    loops: dict[str, list[float]] = {name: [] for name in made}

    def sample(name: str) -> float:
        kept: list[sb.Trajectory] = []
        spent = processor_seconds(lambda: kept.append(made[name](1e-6 * next(turn))))
        loops[name].append(kept[0].statistics.loop_seconds)
        return spent

    files = {name: len(files_of(partial(call, 1e-3))) for name, call in made.items()}
    samples: Mapping[str, Callable[[], float]] = {name: partial(sample, name) for name in made}
    times = in_turns(samples, calls * settings.rounds)
    middle, inside = medians(times), medians(loops)
    rows = [
        (name, *map(seconds_text, (min(times[name]), middle[name], inside[name])), str(files[name]))
        for name in made
    ]
    notes = (
        f"{calls * settings.rounds} calls of each in turns, other initial values and parameters at each; "
        f"goals: {seconds_text(GOAL)} for the four-bar, {FILES_GOAL} files for the pendulum",
    )
    columns = ("simulate again", "shortest", "median", "of it in the loop", "files of symbody")
    return Table("a second call", columns, tuple(rows), notes)


def files_of(task: Callable[[], object]) -> list[str]:
    """Return the files of the package in which code runs during the third run of a task, by their paths."""
    task()
    task()
    found = set[str]()

    def note(frame: FrameType, _event: str, _argument: Any) -> None:
        if frame.f_code.co_filename.startswith(_PACKAGE):
            found.add(frame.f_code.co_filename[len(_PACKAGE) + 1 :])

    before = sys.gettrace()
    sys.settrace(note)
    try:
        task()
    finally:
        sys.settrace(before)
    return sorted(found)


def pendulum() -> Call:
    """Return motions of a pendulum."""
    body = sb.Body("B", mass="m", inertia=(0, 0, "I"), frames={"pin": sb.Frame(at=(0, "l", 0))})
    pin = sb.Revolute("pin", "ground", "B.pin", axis="z", coordinate="th")
    values = {"m": 1.0, "I": 0.1, "l": 0.5}
    eqs = sb.form_equations(sb.Model("pendulum", [body, pin], gravity=(0, -9.81, 0), parameters=values))
    return lambda shift: sb.simulate(eqs, 1.0, {"th": 0.5 + shift}, parameters={"m": 1.0 + shift})


def four_bar() -> Call:
    """Return motions of a closed loop."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml"))
    speed = eqs.speed_names[0]
    return lambda shift: sb.simulate(eqs, 1.0, {speed: shift}, parameters={"m1": 1.0 + shift})


def belt() -> Call:
    """Return motions of a block that sticks and slips."""
    friction = sb.Friction(mu=0.2, mu_static=0.3)
    pull = sb.Drive(applied="40*(0.3*t - x)")
    guide = sb.Prismatic("guide", "ground", "Block", coordinate="x", friction=friction, force=pull)
    model = sb.Model("belt", [sb.Body("Block", "m"), guide], gravity=(0, 0, -9.81), parameters={"m": 1.5})
    eqs = sb.form_equations(model)
    return lambda shift: sb.simulate(eqs, 2.0, {"x": shift}, parameters={"m": 1.5 + shift})


def ball() -> Call:
    """Return motions of a ball that bounces."""
    guide = sb.Prismatic("j", "ground", "B", axis="y", coordinate="y")
    model = sb.Model("ball", [sb.Body("B", "m"), guide], gravity=(0, -9.81, 0), parameters={"m": 1.0})
    eqs, bounce = sb.form_equations(model), sb.Event("y", -1, {"y_dot": "-y_dot"}, "hit")

    def call(shift: float) -> sb.Trajectory:
        return sb.simulate(eqs, 1.0, {"y": 1.0 + shift}, parameters={"m": 1.0 + shift}, events=bounce)

    return call


CASES: Final[Mapping[str, Callable[[], Call]]] = MappingProxyType(
    {"pendulum": pendulum, "four-bar": four_bar, "block that sticks": belt, "ball that bounces": ball}
)
