"""From the words of a message to lines and pointers."""

from __future__ import annotations

import pytest

from symbody.errors import Problem
from symbody.formats.places import line_locator, pointer, relocate, words

TEXT = """name = "a"
[[body]]
name = "A"
[body.frames]
tip = { at = [1, 2,
  3] }
[[body]]
name = "A, mass"
"""
BASES = {"model": (), "body A": ("body", 0), "body A, mass": ("body", 1)}


@pytest.mark.parametrize(
    ("where", "placed"),
    [
        ("body A", "f:2, body A"),
        ("body A, frames.tip.at[2], column 4", "f:6, body A, frames.tip.at[2], column 4"),
        ("body A, inertia[0]", "f:2, body A, inertia[0]"),
        ("body A, mass, name", "f:8, body A, mass, name"),
        ("model, name", "f:1, name"),
        ("body A; body A, name", "f:2, body A; f:3, body A, name"),
        ("body Ab", "f, body Ab"),
        ("", "f"),
    ],
)
def test_words_to_lines(where: str, placed: str) -> None:
    (problem,) = relocate([Problem("c", where, "what")], BASES, line_locator(TEXT, "f"))
    assert problem == Problem("c", placed, "what")


def test_pointer_escapes() -> None:
    assert pointer(("joint", 2, "a/b~c")) == "#/joint/2/a~1b~0c"
    assert pointer(()) == "#"


def test_words() -> None:
    assert words(("frames", "tip", "at", 1)) == "frames.tip.at[1]"
