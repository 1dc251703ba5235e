"""The font for mathematics that pages hold: in pixels, two dots are two dots, and brackets grow."""

from __future__ import annotations

from importlib.resources import files
from io import BytesIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from symbody.display.html import maths_style
from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import math_element, mathml_matrix

from .conftest import Surfer

DARK = 150  # of 255: a dot of 16 px is grey at its edge
DOT = 2  # its rows


def pixels(surfer: Surfer, formulas: list[str], size: int) -> list[NDArray[np.bool_]]:
    """Return where each formula, drawn in a page of its own font, is dark."""
    box = "p > span { padding: 8px; display: inline-block; } body { margin: 20px; background: #fff; }"
    drawn = "".join(f"<p><span>{math_element(each)}</span></p>" for each in formulas)
    style = f"<style>{maths_style(True)}{box} math {{ font-size: {size}px; }}</style>"
    page = surfer.new_page((400, 300))
    page.goto(surfer.write("formulas.html", f"<!doctype html>{style}{drawn}").as_uri())
    page.evaluate("document.fonts.ready.then(() => 0)")
    assert page.evaluate("document.fonts.check('16px \"Symbody Math\"')")
    shots = [each.screenshot() for each in page.locator("p > span").all()]
    return [np.asarray(Image.open(BytesIO(each)).convert("L")) < DARK for each in shots]


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


def test_dots_are_dots_at_16_px(surfer: Surfer) -> None:
    drawn = [(name, order) for name in ("s", "beta", "theta", "phi", "x") for order in (0, 1, 2)]
    letter = 0
    for case, dark in zip(drawn, pixels(surfer, [mathml_name(*each) for each in drawn], 16), strict=True):
        if case[1] == 0:
            letter = blobs(dark)  # thin strokes break at this size
            continue
        rows = dark.any(axis=1)
        top = np.nonzero(rows)[0][0]
        assert not rows[top : top + DOT + 2].all(), f"{case}: no white row between dots and letter"
        assert blobs(dark[top : top + DOT]) == case[1], case
        assert blobs(dark) == case[1] + letter, f"{case}: a dot touches its letter"


def test_brackets_grow(surfer: Surfer) -> None:
    heights = []
    for dark in pixels(surfer, [mathml_matrix([["<mi>a</mi>"]] * rows) for rows in (1, 4)], 16):
        first = np.nonzero(dark.any(axis=0))[0][0]
        heights.append(np.count_nonzero(dark[:, first : first + 3].any(axis=1)))
    assert heights[1] > 2.5 * heights[0]


def test_the_font_is_small_and_has_its_licence() -> None:
    folder = files("symbody.display")
    assert len(folder.joinpath("maths.woff2").read_bytes()) < 60_000
    assert "SIL OPEN FONT LICENSE Version 1.1" in folder.joinpath("maths_font_license.txt").read_text("utf-8")
