"""How large the house is, and how many of its files run for one body on one pin."""

from __future__ import annotations

import ast
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
    sizes = room_sizes()
    names = ("lines", "files", "folders", "modules with one user")
    table = tuple((name, *(str(size[k]) for size in sizes.values())) for k, name in enumerate(names))
    yield Table("rooms: how large they are", ("", *sizes), table, (_SIZE_NOTE,))


_ROOMS: Final = {
    "kernels, LLVM": ("kernels", "codegen/kernels", "codegen/llvm", "simulation/native"),
    "pages, pictures": ("visual", "builder", "display"),
}
_SIZE_NOTE: Final = (
    "Python and JavaScript below src/symbody; a module has one user if one other file imports it"
)
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


def room_sizes() -> dict[str, tuple[int, int, int, int]]:
    """Return lines, files, folders, and modules with one user, of kernels, of pages, and of all else."""
    files = [path for path in _HOME.rglob("*") if path.suffix in {".py", ".js"} and "pages" not in path.parts]
    users = Counter(module for path in files for module in _imported_modules(path))
    parts: dict[str, list[Path]] = {name: [] for name in (*_ROOMS, "all else")}
    for path in files:
        name = path.relative_to(_HOME).as_posix()
        inside = (part for part, rooms in _ROOMS.items() if name.startswith(tuple(f"{r}/" for r in rooms)))
        parts[next(inside, "all else")].append(path)
    sizes = {}
    for part, here in parts.items():
        lines = sum(len(path.read_text("utf-8").splitlines()) for path in here)
        single = sum(users[_module_name(path)] == 1 for path in here if path.name != "__init__.py")
        sizes[part] = lines, len(here), len({path.parent for path in here}), single
    return sizes


def _imported_modules(path: Path) -> set[str]:
    """Return the modules, and names inside modules, that a file imports."""
    if path.suffix != ".py":
        return set()
    nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    modules = {str(node.module) for node in imports}
    modules |= {f"{node.module}.{name.name}" for node in imports for name in node.names}
    return modules | {name.name for node in nodes if isinstance(node, ast.Import) for name in node.names}


def _module_name(path: Path) -> str:
    return ".".join(("symbody", *path.relative_to(_HOME).with_suffix("").parts))


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
