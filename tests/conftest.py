"""Settings for every test: deterministic, without a screen, without a folder left behind."""

from __future__ import annotations

import os
import tempfile

import pytest
from hypothesis import settings

# Before anything imports matplotlib: the tests run where there is no display.
os.environ["MPLBACKEND"] = "Agg"

# Compiled code goes to a folder of this run, not to the user's, unless one is named; processes that tests start inherit it.
_CODE = tempfile.TemporaryDirectory(prefix="symbody-tests-")
os.environ.setdefault("SYMBODY_CACHE", _CODE.name)

# The same examples on every machine; a failure prints what reproduces it, nothing is stored.
settings.register_profile("fast", max_examples=50, deadline=None, derandomize=True, database=None)
settings.register_profile("exhaustive", parent=settings.get_profile("fast"), max_examples=2000)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--part", metavar="K/N", help="run each Nth of the chosen tests, from the Kth on: 1/40 .. 40/40"
    )


def pytest_configure(config: pytest.Config) -> None:
    # addopts begin with -m "not exhaustive"; any other expression that names the tier asks for it
    chosen = config.option.markexpr
    wants_all = "exhaustive" in chosen and "not exhaustive" not in chosen
    settings.load_profile("exhaustive" if wants_all else "fast")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("exhaustive"):
            item.add_marker(pytest.mark.timeout(0))  # may take as long as it needs
    part = config.getoption("--part")
    if part is None:
        return
    first, _, count = part.partition("/")
    if not (first.isdecimal() and count.isdecimal() and 1 <= int(first) <= int(count)):
        raise pytest.UsageError(f"--part {part}: give two whole numbers K/N with 1 <= K <= N, --part 3/40")
    config.hook.pytest_deselected(
        items=[item for k, item in enumerate(items) if k % int(count) != int(first) - 1]
    )
    items[:] = items[int(first) - 1 :: int(count)]
