"""A robot whose fingers follow each other: without that, by a constraint, and substituted."""

from __future__ import annotations

import re
import sysconfig
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

import symbody as sb
from benchmarks.operations import ROBOTS, ROBOTS_FOLDER
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, in_turns, medians, processor_seconds
from symbody.formats import model_from_urdf

_TAG: Final = re.compile(r"<mimic\b[^>]*?(/>|>\s*</mimic>)")
_TASKS: Final = {"forward dynamics": "udot", "derivatives": "A"}
_COLUMNS: Final = ("without the tag", "constraint", "substituted")
_STATES: Final = 1000
_REPEATS: Final = 20
_NOTE: Final = f"batches of {_STATES} states on one core, a state; medians of processor time, {{}} rounds"


def tables(settings: Settings, folder: Path | None = None) -> Iterator[Table]:
    """Yield the one table."""
    path = (folder or Path(sysconfig.get_path("purelib"), ROBOTS_FOLDER)) / ROBOTS["panda"].path
    if not path.is_file():
        yield Table("couplings", ("task", *_COLUMNS), (), (f"panda is not installed: {path.name}",))
        return
    rows = []
    for task, output in _TASKS.items():
        calls = panda_calls(path.read_text(encoding="utf-8"), output)
        tasks = {name: partial(_seconds_a_state, call) for name, call in calls.items()}
        times = medians(in_turns(tasks, settings.rounds))
        own = times["substituted"]
        others = (f"{seconds_text(times[name])} ({times[name] / own:.2f})" for name in _COLUMNS[:2])
        rows.append((f"panda, {task}", *others, seconds_text(own)))
    yield Table("couplings", ("task", *_COLUMNS), tuple(rows), (_NOTE.format(settings.rounds),))


def _seconds_a_state(call: Callable[[], object]) -> float:
    """Return the processor time of a state in batches that last long enough to be measured."""
    call()
    return processor_seconds(lambda: [call() for _ in range(_REPEATS)]) / (_REPEATS * _STATES)


def panda_calls(text: str, output: str) -> dict[str, Callable[[], object]]:
    """Return a call of an output for each form of a robot whose URDF has ``<mimic>``, at the same states."""
    tied, free = model_from_urdf(text), model_from_urdf(_TAG.sub("", text))
    forms = {
        "without the tag": sb.form_equations(free),
        "constraint": sb.form_equations(tied),
        "substituted": sb.form_equations(tied, substitute=True),
    }
    random = np.random.default_rng(2024)
    names = forms["constraint"].coordinate_names
    values = {name: random.uniform(-2, 2, _STATES) for name in names}
    for name, value in forms["substituted"].formed.coupled.leaders.items():
        values[name] = values[value[0]]  # the fingers move alike
    calls: dict[str, Callable[[], object]] = {}
    for name, eqs in forms.items():
        q = np.array([values[x] for x in eqs.coordinate_names]).T.copy()
        r = np.zeros((_STATES, len(eqs.input_names)))
        calls[name] = partial(sb.compile(eqs, output), 0.0, q, 0.1 * q, r)
    return calls
