"""The public surface: every name exists, says what it is, and costs nothing until it is used."""

from __future__ import annotations

import contextlib
import functools
import importlib
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

import symbody

ROOT = Path(symbody.__file__).parent
HEAVY = {"llvmlite", "matplotlib", "numpy", "pandas", "pydantic", "scipy", "sympy"}
SURFACES = ["symbody"] + [f"symbody.{stub.parent.name}" for stub in sorted(ROOT.glob("*/__init__.pyi"))]
NAMES = [(surface, name) for surface in SURFACES for name in importlib.import_module(surface).__all__]

# Prints what the import added; os and the like are there before it anyway.
REPORT = """
import sys, warnings
filters = list(warnings.filters)
import symbody
assert warnings.filters == filters, "importing symbody changed the warning filters"
print(*sorted({name.partition(".")[0] for name in sys.modules}), sep="\\n")
"""


@pytest.mark.parametrize(("surface", "name"), NAMES, ids=[".".join(pair) for pair in NAMES])
def test_public_name_exists_and_is_documented(surface: str, name: str) -> None:
    value = getattr(importlib.import_module(surface), name)
    if not callable(value):  # a table or a constant: its module tells about it
        return
    text = inspect.getdoc(value) or ""
    # a dataclass without docstring gets its own signature as one
    assert text and not text.startswith(f"{name}("), f"{surface}.{name} has no docstring"


def test_headings_of_the_public_names_are_those_of_the_reference() -> None:
    text = (ROOT / "__init__.pyi").read_text(encoding="utf-8").partition("__version__")[2]
    headings = [line[2:].partition(":")[0] for line in text.splitlines() if line.startswith("# ")]
    index = (ROOT.parents[1] / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
    listed = [line[6:] for line in index.splitlines() if line.startswith("names/")]
    assert list(dict.fromkeys(heading.lower().replace(" ", "_") for heading in headings)) == listed


def test_public_names_are_listed_for_completion() -> None:
    assert set(symbody.__all__) <= set(dir(symbody))


def test_unknown_name_is_an_attribute_error() -> None:
    name = "no_such_name"
    with pytest.raises(AttributeError, match=name):
        getattr(symbody, name)


def import_in_fresh_process(kill_after: float, retries: int) -> subprocess.CompletedProcess[str]:
    """Run REPORT; a slow start on a busy machine gets another chance, a hang does not."""
    # EAGER_IMPORT is lazy_loader's switch for debugging
    environment = {key: value for key, value in os.environ.items() if key != "EAGER_IMPORT"}
    run = functools.partial(
        subprocess.run,
        [sys.executable, "-c", REPORT],
        env=environment,
        capture_output=True,
        text=True,
        timeout=kill_after,
        check=False,
    )
    for _ in range(retries):
        with contextlib.suppress(subprocess.TimeoutExpired):
            return run()
    return run()


def test_import_loads_nothing_heavy_and_changes_nothing() -> None:
    # What is loaded is asserted, since seconds depend on the machine: without these packages the
    # import is a matter of milliseconds. The 3 s only end a hang.
    run = import_in_fresh_process(kill_after=3.0, retries=2)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    loaded = set(run.stdout.split())
    assert "symbody" in loaded
    assert not loaded & HEAVY, f"import symbody loads {sorted(loaded & HEAVY)}"


def test_words_of_books_are_answered_by_ours() -> None:
    with pytest.raises(AttributeError, match="the key is called 'Revolute'"):
        _ = importlib.import_module("symbody").Hinge
