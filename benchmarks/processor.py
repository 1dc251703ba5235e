"""Processor time of this process's descendants, by what they are: it hardly depends on what else runs."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Final

# What is in a command, and what such a process is called.
_KINDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "--type=renderer": "page",
        "--type=gpu-process": "graphics",
        "--type=": "browser",
        "symbody builder": "server",
        "multiprocessing": "workers",
    }
)
_TABLES: Final = Path("/proc")


Spent = Mapping[tuple[str, int], float]


def spent_by_process() -> Spent:
    """Return the processor time [s] that each descendant of this process has taken, by its kind and number.

    It is empty where the system has no tables of processes.
    """
    spent = {}
    for process, command, seconds in _descendants():
        kind = next((kind for mark, kind in _KINDS.items() if mark in command), "")
        if kind and process != os.getpid():
            spent[kind, process] = seconds
    return spent


def spent_between(before: Spent, after: Spent) -> dict[str, float]:
    """Return the processor time [s] of each kind between two looks; of what has ended it is not known."""
    spent: Counter[str] = Counter()
    for (kind, process), seconds in after.items():
        spent[kind] += seconds - before.get((kind, process), 0.0)
    return dict(spent)


def _descendants() -> Iterator[tuple[int, str, float]]:
    """Yield number, command and processor time [s] of this process and all that come from it."""
    if not _TABLES.is_dir():
        return
    known: dict[int, tuple[int, str, float]] = {}
    for folder in _TABLES.iterdir():
        if folder.name.isdecimal():
            with suppress(OSError, ValueError, IndexError):  # it has ended meanwhile
                known[int(folder.name)] = _read(folder)
    for process, (_, command, seconds) in known.items():
        ancestor = process
        while ancestor in known and ancestor != os.getpid():
            ancestor = known[ancestor][0]
        if ancestor == os.getpid():
            yield process, command, seconds


def _read(folder: Path) -> tuple[int, str, float]:
    """Return parent, command and processor time [s] of a process."""
    fields = (folder / "stat").read_text().rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return int(fields[1]), command, ticks / os.sysconf("SC_CLK_TCK")
