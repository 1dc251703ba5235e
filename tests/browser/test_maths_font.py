"""The font for mathematics that pages hold: in pixels, two dots are two dots, brackets grow, rows are close."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from symbody.display.html import maths_style
from symbody.expr.printing.equation_layout import equations_html
from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import math_element, mathml_matrix

DARK = 150  # of 255: a dot of 16 px is grey at its edge
DOT = 2  # its rows
BOX = 140  # pixels: the height of the part of the page in which a formula stands
WIDTH = 400
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
Shoot = Callable[[Path, int], bytes]
Pixels = Callable[[list[str]], list[NDArray[np.bool_]]]


def shoot_with_chromium(chromium: Any) -> Shoot:
    def shoot(page: Path, height: int) -> bytes:
        tab = chromium.new_page(viewport={"width": WIDTH, "height": height})
        tab.goto(page.as_uri())
        tab.evaluate("document.fonts.ready.then(() => 0)")
        assert tab.evaluate("document.fonts.check('16px \"Symbody Math\"')")
        taken: bytes = tab.screenshot()
        tab.close()
        return taken

    return shoot


def shoot_with_firefox(page: Path, height: int) -> bytes:
    taken = page.with_suffix(".png")
    profile = page.parent / "profile"
    profile.mkdir(exist_ok=True)
    command = [
        str(FIREFOX),
        "--headless",
        "--no-remote",
        "--profile",
        profile,
        f"--window-size={WIDTH},{height}",
    ]
    subprocess.run(
        [*command, "--screenshot", taken, page.as_uri()], check=True, capture_output=True, timeout=120
    )
    return taken.read_bytes()


@pytest.fixture(params=["chromium", "firefox"])
def pixels(request: pytest.FixtureRequest, chromium: Any, tmp_path: Path) -> Pixels:
    """Return where each piece of HTML, drawn at 16 px in a page of our own font, is dark."""
    if request.param == "firefox" and FIREFOX is None:
        pytest.skip("Firefox is not installed")
    shoot = shoot_with_firefox if request.param == "firefox" else shoot_with_chromium(chromium)

    def draw(pieces: list[str]) -> list[NDArray[np.bool_]]:
        place = f"div.box {{ height: {BOX}px; overflow: hidden; box-sizing: border-box; padding: 8px; }}"
        style = f"<style>{maths_style(True)}{place} body {{ margin: 0; background: #fff; }} math {{ font-size: 16px; }}"
        drawn = "".join(f'<div class="box">{piece}</div>' for piece in pieces)
        page = tmp_path / "formulas.html"
        page.write_text(f"<!doctype html><meta charset=utf-8>{style}</style>{drawn}", encoding="utf-8")
        shot = np.asarray(Image.open(BytesIO(shoot(page, BOX * len(pieces)))).convert("L")) < DARK
        assert shot.shape == (BOX * len(pieces), WIDTH)
        return list(shot.reshape(len(pieces), BOX, WIDTH))

    return draw


def blobs(dark: NDArray[np.bool_]) -> int:
    """Return how many connected spots there are."""
    left, count = set(zip(*np.nonzero(dark), strict=True)), 0
    while left:
        count, edge = count + 1, [left.pop()]
        while edge:
            i, j = edge.pop()
            near = {(i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1)} & left
            left -= near
            edge += near
    return count


def test_dots_are_dots_at_16_px(pixels: Pixels) -> None:
    drawn = [(name, order) for name in ("s", "beta", "theta", "phi", "x") for order in (0, 1, 2)]
    letter = 0
    for case, dark in zip(drawn, pixels([math_element(mathml_name(*each)) for each in drawn]), strict=True):
        if case[1] == 0:
            letter = blobs(dark)  # thin strokes break at this size
            continue
        rows = dark.any(axis=1)
        top = np.nonzero(rows)[0][0]
        assert not rows[top : top + DOT + 2].all(), f"{case}: no white row between dots and letter"
        assert blobs(dark[top : top + DOT]) == case[1], case
        assert blobs(dark) == case[1] + letter, f"{case}: a dot touches its letter"


def test_brackets_grow(pixels: Pixels) -> None:
    heights = []
    for dark in pixels([math_element(mathml_matrix([["<mi>a</mi>"]] * rows)) for rows in (1, 4)]):
        first = np.nonzero(dark.any(axis=0))[0][0]
        heights.append(np.count_nonzero(dark[:, first : first + 3].any(axis=1)))
    assert heights[1] > 2.5 * heights[0]


def test_rows_of_equations_are_close(pixels: Pixels) -> None:
    (dark,) = pixels([equations_html([("<mi>x</mi>", "<mi>z</mi>")] * 2)])
    first, second = np.nonzero(np.diff(dark.any(axis=1).astype(int)) == 1)[0]
    assert (
        second - first < 2.5 * 16
    )  # with the metrics of a font for tall brackets Firefox makes it 4 times the size


def test_the_font_is_small_and_has_its_licence() -> None:
    folder = files("symbody.display")
    assert len(folder.joinpath("maths.woff2").read_bytes()) < 60_000
    assert "SIL OPEN FONT LICENSE Version 1.1" in folder.joinpath("maths_font_license.txt").read_text("utf-8")
