"""How many files of symbody run for one body on one pin: what a reader goes through to follow one call."""

from __future__ import annotations

import pkgutil
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Final

import symbody as sb
from benchmarks.table import Table
from benchmarks.timing import Settings

_HOME: Final = Path(sb.__file__).parent


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the one table; nothing is timed, so the settings change nothing."""
    del settings
    _import_all()
    calls = traced_calls()
    files = {call: {file for file, _ in functions} for call, functions in calls.items()}
    rooms = {call: Counter(map(_room, names)) for call, names in files.items()}
    rows = [("functions", *(str(len(functions)) for functions in calls.values()))]
    rows.append(("files", *(str(len(names)) for names in files.values())))
    for room in sorted(set().union(*rooms.values())):
        rows.append((f"  {room}", *(str(counts[room] or "") for counts in rooms.values())))
    yield Table("rooms: a pendulum from model to motion", ("", *calls), tuple(rows), (_NOTE,))


_NOTE: Final = "files below src/symbody with a function that runs during the call; imports are done before"


def traced_calls() -> dict[str, set[tuple[str, str]]]:
    """Return the (file, function) pairs that run in each call, files relative to the package."""
    traces: dict[str, set[tuple[str, str]]] = {}

    def trace(name: str, call: Callable[[], object]) -> object:
        with _Tracer() as tracer:
            result = call()
        traces[name] = tracer.functions
        return result

    model = trace("Model", pendulum)
    assert isinstance(model, sb.Model)
    eqs = trace("form_equations", lambda: sb.form_equations(model))
    assert isinstance(eqs, sb.EquationSet)
    trace("mass_matrix", lambda: eqs.mass_matrix)
    trace("compile", lambda: sb.compile(eqs, "udot"))
    trace("simulate", lambda: sb.simulate(eqs, 1.0, {"phi": 0.3}))
    return traces


def pendulum() -> sb.Model:
    """Return one body on one pin."""
    rod = sb.Body("Rod", mass="m", inertia=("I", "I", 0), frames={"top": sb.Frame(at=(0, 0, "l"))})
    pin = sb.Revolute("pin", "ground", "Rod.top", axis="x", coordinate="phi")
    values = {"m": 1.0, "I": 0.1, "l": 0.5, "g": 9.81}
    return sb.Model("pendulum", [rod, pin], gravity=(0, 0, "-g"), parameters=values)


class _Tracer:
    """Collects the functions of the package that run inside a ``with`` block."""

    def __init__(self) -> None:
        self.functions: set[tuple[str, str]] = set()
        self._files: Mapping[str, str] = {
            str(path): path.relative_to(_HOME).as_posix() for path in _HOME.rglob("*.py")
        }

    def __enter__(self) -> _Tracer:
        sys.setprofile(self._note)
        return self

    def __exit__(self, *error: object) -> None:
        sys.setprofile(None)

    def _note(self, frame: FrameType, event: str, argument: object) -> None:
        if event == "call" and frame.f_code.co_filename in self._files:
            self.functions.add((self._files[frame.f_code.co_filename], frame.f_code.co_qualname))


def _room(file: str) -> str:
    return file.split("/")[0].removesuffix(".py")


def _import_all() -> None:
    """Import all modules, so that what runs when a module is loaded counts for no call."""
    for module in pkgutil.walk_packages(sb.__path__, "symbody."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
