"""The scripts of the tutorial and of the pages that show results: they run, and print what the pages show."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from docs.run_pages import run_page

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS / "index.md", DOCS / "simulate.md", DOCS / "model_file.md"]
PAGES += sorted((DOCS / "tutorial").glob("[!i]*.md"))
HOW_TO = sorted((DOCS / "how_to").glob("[!i]*.md"))
# Every third of these in the fast tier.
PAGES += [
    page if k % 3 == 0 else pytest.param(page, marks=pytest.mark.exhaustive) for k, page in enumerate(HOW_TO)
]
COURSE = sorted((DOCS / "course").glob("[0-9]*.md"))
PAGES += [pytest.param(page, marks=pytest.mark.exhaustive) for page in COURSE]
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")


STEPS = re.compile(r"\d+ samples")  # one step more or less is another processor's rounding


def agree(printed: str, shown: str) -> bool:
    """Return whether two texts are equal but for blanks, counts of steps and the last digits of numbers."""
    printed, shown = (STEPS.sub("samples", text) for text in (printed, shown))
    if re.sub(r"\s+", "", NUMBER.sub("#", printed)) != re.sub(r"\s+", "", NUMBER.sub("#", shown)):
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=1e-3, abs_tol=1e-7) for a, b in pairs)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_scripts_print_what_the_page_shows(page: Path, tmp_path: Path) -> None:
    outputs = run_page(page.read_text(encoding="utf-8"), tmp_path)
    for output in outputs:
        shown = output.shown.text if output.shown else ""
        assert agree(output.printed, shown), f"run: python docs/run_pages.py {page.relative_to(DOCS.parent)}"


def test_numbers_agree_to_the_digits_that_matter() -> None:
    assert agree("x = 0.33333\n", "x   = 0.33334")
    assert not agree("x = 0.33", "x = 0.34")
    assert not agree("x = 1", "y = 1")
    assert agree("326 samples", "327 samples") and not agree("326 poses", "327 poses")
