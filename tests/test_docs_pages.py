"""The scripts of the tutorial and of the pages that show results: they run, and print what the pages show."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import pytest

import symbody
from docs.run_pages import run_page

DOCS = Path(__file__).parents[1] / "docs"
PLAYER = Path(symbody.__file__).parent / "visual" / "pages"
FAST = [
    DOCS / "index.md",
    DOCS / "simulate.md",
    DOCS / "model_file.md",
    *sorted((DOCS / "tutorial").glob("[1-5]_*.md")),
]
FAST += sorted((DOCS / "how_to").glob("[!i]*.md"))[::6]  # every sixth of these in the fast tier
WITH_CODE = sorted(
    path for path in DOCS.rglob("*.md") if re.search("^```[a-z]", path.read_text(encoding="utf-8"), re.M)
)
PAGES = [*FAST, *(pytest.param(page, marks=pytest.mark.exhaustive) for page in WITH_CODE if page not in FAST)]
# Pages that show motions in browsers, and as films.
SHOW = ("animation.md", "live_pages.md")
# Packages that are in no extra, by the page that uses them.
NEEDED = {"gymnasium_environment.md": "gymnasium"}
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
    if page.name in SHOW and not (PLAYER / "player.html").is_file():
        pytest.skip("the pages that show motions are not built")
    if page.name == "film.md" and shutil.which("ffmpeg") is None:
        pytest.skip("films are made by ffmpeg")
    if page.name in NEEDED:
        pytest.importorskip(NEEDED[page.name])
    outputs = run_page(page.read_text(encoding="utf-8"), tmp_path)
    if not any(output.shown for output in outputs):
        return  # a page that shows nothing that is printed
    for output in outputs:
        shown = output.shown.text if output.shown else ""
        assert agree(output.printed, shown), f"run: python docs/run_pages.py {page.relative_to(DOCS.parent)}"


def test_equations_that_a_page_shows_typeset_are_those_printed(tmp_path: Path) -> None:
    page = (
        "```python\nimport sympy\nprint(sympy.Symbol('x') / 2)\n```\n```math\n\\frac{x}{2}\n```\n"
        "```python\nprint('after')\n```\n"
    )
    equation, text = run_page(page, tmp_path)
    assert equation.shown is not None and agree(equation.printed, equation.shown.text)
    assert text.printed == "after\n"


def test_what_is_not_run_says_why(tmp_path: Path) -> None:
    (output,) = run_page(
        "<!-- before:\na = 2\n-->\n```python\nprint(a)\n```\n<!-- not run: a part -->\n```python\nstop\n```\n",
        tmp_path,
    )
    assert output.printed == "2\n"
    (tmp_path / "next").mkdir()
    with pytest.raises(ValueError, match="a block in rust is not run"):
        run_page("```rust\nfn f() {}\n```\n", tmp_path / "next")


def test_numbers_agree_to_the_digits_that_matter() -> None:
    assert agree("x = 0.33333\n", "x   = 0.33334")
    assert not agree("x = 0.33", "x = 0.34")
    assert not agree("x = 1", "y = 1")
    assert agree("326 samples", "327 samples") and not agree("326 poses", "327 poses")
