"""The font for mathematics that pages hold: in pixels, two dots are two dots, and brackets grow."""

from __future__ import annotations

from importlib.resources import files
from io import BytesIO

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from symbody.display.html import maths_style
from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import math_element, mathml_matrix

from .conftest import Surfer

DARK = 150  # of 255: a dot of 16 px is grey at its edge
DOT = 2  # its rows


def pixels(surfer: Surfer, formula: str, size: int) -> NDArray[np.bool_]:
    box = "#f { padding: 8px; display: inline-block; } body { margin: 20px; background: #fff; }"
    style = f"{box} math {{ font-size: {size}px; }}"
    page_text = (
        f"<!doctype html><style>{maths_style(True)}{style}</style><span id=f>{math_element(formula)}</span>"
    )
    page = surfer.new_page((400, 300))
    page.goto(surfer.write("formula.html", page_text).as_uri())
    page.evaluate("document.fonts.ready.then(() => 0)")
    assert page.evaluate("document.fonts.check('16px \"Symbody Math\"')")
    image = Image.open(BytesIO(page.locator("#f").screenshot())).convert("L")
    return np.asarray(image) < DARK


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


@pytest.mark.parametrize("name", ["s", "beta", "theta", "phi", "x"])
def test_dots_are_dots_at_16_px(name: str, surfer: Surfer) -> None:
    letter = blobs(pixels(surfer, mathml_name(name), 16))  # thin strokes break at this size
    for order in (1, 2):
        dark = pixels(surfer, mathml_name(name, order), 16)
        rows = dark.any(axis=1)
        top = np.nonzero(rows)[0][0]
        assert not rows[top : top + DOT + 2].all(), "no white row between dots and letter"
        assert blobs(dark[top : top + DOT]) == order
        assert blobs(dark) == order + letter, "a dot touches its letter"


def test_brackets_grow(surfer: Surfer) -> None:
    heights = []
    for rows in (1, 4):
        dark = pixels(surfer, mathml_matrix([["<mi>a</mi>"]] * rows), 16)
        first = np.nonzero(dark.any(axis=0))[0][0]
        heights.append(np.count_nonzero(dark[:, first : first + 3].any(axis=1)))
    assert heights[1] > 2.5 * heights[0]


def test_the_font_is_small_and_has_its_licence() -> None:
    folder = files("symbody.display")
    assert len(folder.joinpath("maths.woff2").read_bytes()) < 60_000
    assert "SIL OPEN FONT LICENSE Version 1.1" in folder.joinpath("maths_font_license.txt").read_text("utf-8")
