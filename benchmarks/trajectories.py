"""Motions of equal accuracy: each engine at its coarsest setting that meets a bound on the error at the end.

The reference is symbody's own motion at the tightest tolerance; what the others reach at theirs tells whether
that is right. Only moving is timed, not deriving or compiling; symbody, SciPy and SUNDIALS step one compiled
function, the others their own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.engines.moving import OURS, Engine, installed, ours, worst
from benchmarks.table import Table, difference_text, ratio_text, seconds_text
from benchmarks.timing import Settings, in_turns, medians

LINKS, END = 5, 2.0
ERRORS: Final = (1e-4, 1e-8)
REFERENCE: Final = 1e-13


def tables(settings: Settings, links: int = LINKS, end: float = END) -> Iterator[Table]:
    """Yield one table for each bound on the error."""
    engines: dict[str, Engine] = {}
    missing = []
    for label, maker in installed():
        if maker is None:
            missing.append(f"{label}: not installed")
            continue
        try:
            engines[label] = maker(links, end)
        except Exception as error:  # a peer that is there, but lacks a compiler or a package of its own
            missing.append(f"{label}: left out, {type(error).__name__}: {' '.join(str(error).split())[:200]}")
    reference = ours(links, end).move(REFERENCE).angles
    for bound in ERRORS:
        found = {label: coarsest(engine, reference, bound) for label, engine in engines.items()}
        yield _table(engines, found, bound, settings, tuple(missing), f"{links} hinged bodies, {end:g} s")


def coarsest(engine: Engine, reference: object, bound: float) -> tuple[float, float]:
    """Return the first setting that meets the bound, and its error; the last one if none does."""
    setting, error = 0.0, float("inf")
    for setting in engine.settings:
        error = worst(engine.move(setting).angles, reference)
        if error <= bound:
            break
    return setting, error


def _table(
    engines: Mapping[str, Engine],
    found: Mapping[str, tuple[float, float]],
    bound: float,
    settings: Settings,
    missing: tuple[str, ...],
    what: str,
) -> Table:
    def seconds(label: str) -> float:
        return engines[label].move(found[label][0]).seconds

    met = [label for label, (_, error) in found.items() if error <= bound]
    samples = in_turns({label: lambda label=label: seconds(label) for label in met}, settings.rounds)
    times = medians(samples)
    rows = []
    for label, (setting, error) in found.items():
        if label not in times:
            rows.append((label, f"{setting:.1e}", difference_text(error), "not reached"))
            continue
        beside = "" if label == OURS else ratio_text(times[label], times[OURS])
        rows.append((label, f"{setting:.1e}", difference_text(error), seconds_text(times[label]) + beside))
    notes = (
        f"median of {settings.rounds} rounds in turns; error: largest of the angles at the end [rad]",
        "setting: relative tolerance, of MuJoCo the step [s]",
        *missing,
    )
    return Table(
        f"{what}, errors below {bound:.0e}", ("engine", "setting", "error", "time"), tuple(rows), notes
    )
