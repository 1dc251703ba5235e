"""The command ``python -m benchmarks``."""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from types import MappingProxyType
from typing import Final

from rich.console import Console

from benchmarks import (
    analyses,
    contacts,
    couplings,
    derivation,
    evaluation,
    expressions,
    growth,
    growth_of_analyses,
    motion,
    nodes,
    operations,
    overhead,
    pages,
    record,
    robots,
    rooms,
    second_calls,
    stiff,
    sweep,
    trajectories,
)
from benchmarks.table import Table, show
from benchmarks.timing import Settings
from symbody.storage import VARIABLE

BENCHMARKS: Final[Mapping[str, Callable[[Settings], Iterator[Table]]]] = MappingProxyType(
    {
        "nodes": nodes.tables,
        "expressions": expressions.tables,
        "derivation": derivation.tables,
        "growth": lambda settings: chain(growth.tables(settings), growth_of_analyses.tables(settings)),
        "evaluation": evaluation.tables,
        "analyses": analyses.tables,
        "couplings": couplings.tables,
        "motion": motion.tables,
        "trajectories": trajectories.tables,
        "operations": operations.tables,
        "overhead": overhead.tables,
        "second_calls": second_calls.tables,
        "robots": robots.tables,
        "stiff": stiff.tables,
        "contacts": contacts.tables,
        "sweep": sweep.tables,
        "pages": pages.tables,
        "rooms": rooms.tables,
    }
)

_WIDTH: Final = 150


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables of the benchmarks named on the command line, or of all."""
    default = Settings()
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description="symbody beside its peers, as ratios"
    )
    parser.add_argument(
        "name", nargs="*", help=f"{', '.join(BENCHMARKS)} (default: all), or record, or render"
    )
    parser.add_argument(
        "--limit", type=float, default=default.limit, help="seconds one round of one engine may take"
    )
    parser.add_argument(
        "--rounds",
        type=int,
        default=default.rounds,
        help="rounds, of which medians or shortest times are taken",
    )
    parser.add_argument(
        "--long", action="store_true", help="derivation: wait an hour for a peer instead of the limit"
    )
    chosen = parser.parse_args(arguments)
    if chosen.name in (["record"], ["render"]):
        if chosen.name == ["record"]:
            record.measure(Settings(chosen.limit, chosen.rounds))
        record.render()
        return
    unknown = [name for name in chosen.name if name not in BENCHMARKS]
    if unknown:
        parser.error(f"there is no benchmark {', '.join(unknown)}; there are {', '.join(BENCHMARKS)}")
    if chosen.rounds < 1 or chosen.limit <= 0:
        parser.error("--rounds must be at least 1 and --limit above 0")
    console = Console()
    if not console.is_terminal:  # a file is as wide as it has to be
        console = Console(width=_WIDTH)
    console.print(
        f"{platform.machine()}, Python {platform.python_version()}; in brackets: times symbody's figure\n"
    )
    for name in chosen.name or BENCHMARKS:
        for table in BENCHMARKS[name](Settings(chosen.limit, chosen.rounds, chosen.long)):
            show(table, console)


if __name__ == "__main__":
    os.environ[VARIABLE] = "off"  # figures are of the work, not of finding it done
    main()
