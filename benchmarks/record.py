"""The figures that README and pages show: measured into `record.json`, and written into the pages from it.

    python -m benchmarks record    measure, in an hour without other work, and write file and pages
    python -m benchmarks render    write the pages from the file

The file holds every sample, the processor, its load, the versions and the date. A page has a block
``<!-- figures: NAME -->`` to ``<!-- end of figures -->`` for some of `BLOCKS`; no speed beside others stands
elsewhere on it.
"""

from __future__ import annotations

import json
import os
import platform
import re
import statistics
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import symbody
from benchmarks import growth, robots, trajectories
from benchmarks.engines.around import available, process_seconds, start_angles
from benchmarks.engines.call_loops.loops import c_compiler
from benchmarks.engines.moving import installed, ours
from benchmarks.operations import ROBOTS
from benchmarks.robots import BATCH, COLUMNS, LOOP, OURS, PYTHON, Figure, ratios
from benchmarks.table import ratio_text, seconds_text
from benchmarks.timing import Settings, in_turns, processor_seconds

ROOT: Final = Path(__file__).parents[1]
FILE: Final = Path(__file__).with_name("record.json")
PAGES: Final = ("README.md", "docs/comparison.md", "docs/robots.md")
# The smallest and the largest of the robots.
MEASURED: Final = ("ur5", "talos")
BOUND, LINKS, BODIES, SHORT = 1e-4, 5, 6, 0.01
_SHORT_MOTIONS: Final = 10
_PACKAGES: Final = (
    "numpy", "scipy", "sympy", "llvmlite", "pin", "casadi", "mujoco", "mujoco-mjx", "jax", "pydy",
    "cython", "scikit-sundae",
)  # fmt: skip
_BLOCK: Final = re.compile(r"(<!-- figures: (\w+) -->\n).*?(<!-- end of figures -->)", re.DOTALL)

Record = dict[str, Any]


# Measuring


def measure(settings: Settings, file: Path = FILE) -> None:
    """Measure all, and write the file after each part."""
    record: Record = {
        "date": datetime.now(UTC).isoformat(timespec="minutes"),
        "processor": processor(),
        "processors": os.cpu_count(),
        "python": platform.python_version(),
        "versions": versions(),
        "rounds": settings.rounds,
        "load": [os.getloadavg()[0]],
    }
    for name, part in PARTS.items():
        print(f"{name} ...", flush=True)
        record[name] = part(settings)
        record["load"].append(os.getloadavg()[0])
        file.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def calls(settings: Settings) -> Record:
    """Return the figures of robots, and what was left out."""
    found, notes = robots.figures(settings, {name: ROBOTS[name] for name in MEASURED})
    return {"figures": [asdict(figure) for figure in found], "notes": notes}


def motions(settings: Settings) -> Record:
    """Return seconds of a motion by each engine at its coarsest setting whose error is below the bound."""
    engines = {label: maker(LINKS, 2.0) for label, maker in installed() if maker is not None}
    reference = ours(LINKS, 2.0).move(trajectories.REFERENCE).angles
    settings_of = {
        label: trajectories.coarsest(engine, reference, BOUND) for label, engine in engines.items()
    }
    met = {label: setting for label, (setting, error) in settings_of.items() if error <= BOUND}

    def seconds(label: str) -> float:
        return engines[label].move(met[label]).seconds

    return in_turns({label: partial(seconds, label) for label in met}, settings.rounds)


def first(settings: Settings) -> Record:
    """Return processor seconds of one process that makes an engine and moves, with nothing kept before."""
    labels = [label for label, maker in available() if maker is not None]

    def seconds(label: str) -> float:
        with tempfile.TemporaryDirectory() as folder:
            return process_seconds(label, LINKS, folder)

    return in_turns({label: partial(seconds, label) for label in labels}, 1)


def short(settings: Settings) -> Record:
    """Return processor seconds of a motion of 10 ms, from another state each time."""
    moves = {label: maker(LINKS) for label, maker in available() if maker is not None}
    start = start_angles(LINKS)

    def seconds(label: str) -> float:
        def all_motions() -> None:
            for k in range(_SHORT_MOTIONS):
                moves[label](start + 1e-6 * k, 1.0, SHORT)

        return processor_seconds(all_motions) / _SHORT_MOTIONS

    for label in moves:
        seconds(label)
    return in_turns({label: partial(seconds, label) for label in moves}, settings.rounds)


def equations(settings: Settings) -> Record:
    """Return seconds to form and count the equations of a spatial chain, once."""
    with tempfile.TemporaryDirectory() as folder:
        stages = growth.stages(BODIES, folder, settings.limit)
    peer = growth.peer_seconds(BODIES, settings.limit)
    if peer is None or "sequence" not in stages:  # a limit was reached: there is nothing to compare
        return {}
    return {OURS: [stages["form"] + stages["sequence"]], "SymPy": [peer]}


PARTS: Final[Mapping[str, Callable[[Settings], Record]]] = MappingProxyType(
    {"motions": motions, "first": first, "short": short, "equations": equations, "robots": calls}
)


def processor() -> str:
    """Return the name of the processor."""
    table = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", table.read_text("utf-8")) if table.is_file() else []
    return str(names[0]) if names else platform.processor() or platform.machine()


def versions() -> dict[str, str]:
    """Return the versions of what is measured, and of the C compiler."""
    found = {"symbody": symbody.__version__}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    if (compiler := c_compiler()) is not None:
        told = subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True).stdout
        found[Path(compiler).name] = told.strip()
    return found


# Writing


def render(root: Path = ROOT, file: Path = FILE) -> None:
    """Write the blocks of all pages."""
    record = json.loads(file.read_text(encoding="utf-8"))
    for page in PAGES:
        path = root / page
        path.write_text(rendered(path.read_text(encoding="utf-8"), record), encoding="utf-8")


def rendered(text: str, record: Record) -> str:
    """Return a page with its blocks as the record has them."""
    return _BLOCK.sub(lambda found: f"{found[1]}{BLOCKS[found[2]](record)}\n{found[3]}", text)


def sentence(record: Record) -> str:
    """Return the one sentence about speed."""
    by_engine = {f.engine: f for f in _figures(record) if (f.robot, f.task, f.place) == _SHOWN}
    own = by_engine[OURS]
    beside = [
        f"{name} {_times(by_engine[engine].nanoseconds, own.nanoseconds)} times"
        for engine, name in _NAMES.items()
        if engine in by_engine
    ]
    took, price = seconds_text(1e-9 * _middle(own.nanoseconds)), seconds_text(own.prepared or 0.0)
    return (
        f"One call of the forward dynamics of a UR5 arm takes {took} in a compiled loop; "
        f"{_listed(beside)} as long. Before it can be called, forming and compiling it takes {price}"
        f"{_other_price(by_engine.get('Pinocchio by CasADi'))}."
    )


def _other_price(figure: Figure | None) -> str:
    return "" if figure is None or figure.prepared is None else f", that C {seconds_text(figure.prepared)}"


def short_table(record: Record) -> str:
    """Return the table of the README."""
    lines = ["| task | symbody | times as long |", "|---|---|---|"]
    figures = _figures(record)
    for robot, label in (("ur5", "a UR5 arm"), ("talos", "a Talos humanoid")):
        for place, way in ((LOOP, "from C"), (PYTHON, "from Python")):
            found = [f for f in figures if (f.robot, f.task, f.place) == (robot, "forward dynamics", place)]
            own = next((f for f in found if f.engine == OURS), None)
            if own is None:
                continue
            order = [f for engine in COLUMNS[place] for f in found if f.engine == engine != OURS]
            beside = [
                f"{f.engine} {_times(f.nanoseconds, own.nanoseconds)}{_price(f.prepared)}" for f in order
            ]
            text = f"{seconds_text(1e-9 * _middle(own.nanoseconds))}{_price(own.prepared)}"
            lines.append(f"| forward dynamics of {label}, one call {way} | {text} | {'; '.join(beside)} |")
    for part, label in _PARTS.items():
        samples = record.get(part, {})
        if OURS not in samples:
            continue
        beside = [f"{name} {_times(x, samples[OURS])}" for name, x in samples.items() if name != OURS]
        lines.append(f"| {label} | {seconds_text(_middle(samples[OURS]))} | {'; '.join(beside)} |")
    return "\n".join(lines) + _mjx(figures) + f"\n\n{_trust(record)}"


def _mjx(figures: list[Figure]) -> str:
    """Return what belongs below a table that has MJX: it is not made for what is timed."""
    return f"\n\n{_MJX}" if any(figure.engine == "MJX" for figure in figures) else ""


def _trust(record: Record) -> str:
    """Return how the figures of the README were taken, and how far they can be trusted."""
    figures = _figures(record)
    own = {(f.robot, f.task, f.place): f.nanoseconds for f in figures if f.engine == OURS}
    spreads = [ratios(f.nanoseconds, own[f.robot, f.task, f.place]) for f in figures]
    widest = max(max(x[-1] / x[len(x) // 2], x[len(x) // 2] / x[0]) for x in spreads)
    return (
        f"Ratios are medians of {record['rounds']} rounds, engines taking turns; the first motion and the "
        f"equations were measured once. All ran on {record['processors']} processors at {_load(record)}; "
        "above one job for a processor times are longer than on an idle machine. Ratios hold within their "
        f"spread, for calls up to a factor of {widest:.1f} to either side ([all spreads](docs/robots.md))."
    )


def _price(prepared: float | None) -> str:
    return "" if prepared is None else f" ({seconds_text(prepared)})"


def place_table(place: str, record: Record) -> str:
    """Return the table of one way of calling, for all robots and tasks."""
    figures = [figure for figure in _figures(record) if figure.place == place]
    found = robots.table(figures, place)
    columns = [k for k in range(len(found.columns)) if any(row[k] for row in found.rows)]
    rows = [found.columns, ("---",) * len(found.columns), *found.rows]
    return "\n".join(f"| {' | '.join(row[k] for k in columns)} |" for row in rows) + _mjx(figures)


def machine(record: Record) -> str:
    """Return where and when the record was taken."""
    named = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    notes = "; ".join(record["robots"]["notes"])
    return (
        f"{record['date']}, {record['processor']}, {record['processors']} processors, {_load(record)}. "
        f"Python {record['python']}, {named}.\n\n{notes}."
    )


BLOCKS: Final[Mapping[str, Callable[[Record], str]]] = MappingProxyType(
    {
        "sentence": sentence,
        "table": short_table,
        "loops": partial(place_table, LOOP),
        "python": partial(place_table, PYTHON),
        "batches": partial(place_table, BATCH),
        "machine": machine,
    }
)

_SHOWN: Final = ("ur5", "forward dynamics", LOOP)
_NAMES: Final = MappingProxyType(
    {
        "Pinocchio by CasADi": "C that CasADi writes for Pinocchio's algorithm",
        "Pinocchio C++": "Pinocchio in C++",
        "MuJoCo": "MuJoCo",
    }
)
_MJX: Final = (
    "MJX is made for thousands of states at once on a graphics card; "
    "here it computes one state a call, on a processor."
)
_PARTS: Final = MappingProxyType(
    {
        "motions": "2 s of five hinged bodies, error below 1e-4",
        "equations": f"equations of a spatial chain of {BODIES} bodies, formed and counted",
        "first": "the first motion on a machine, compilation included",
        "short": "10 ms of motion by one call of `simulate`",
    }
)


def _figures(record: Record) -> list[Figure]:
    return [Figure(**each) for each in record["robots"]["figures"]]


def _load(record: Record) -> str:
    return f"load {min(record['load']):.1f} to {max(record['load']):.1f}"


def _times(theirs: list[float], own: list[float]) -> str:
    return ratio_text(ratios(theirs, own)[len(own) // 2], 1.0)[2:-2]


def _middle(samples: list[float]) -> float:
    return statistics.median(samples)


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def speeds_outside_of_blocks(text: str) -> Iterator[str]:
    """Yield lines of a page that say how fast something is beside others, and are of no block."""
    for line in _BLOCK.sub("", text).splitlines():
        if re.search(
            r"\b\d[\d.,]*(?: to \d[\d.,]*)? times as (?:fast|long)|\d(?:x|×) (?:as|faster|slower)", line
        ):
            yield line
