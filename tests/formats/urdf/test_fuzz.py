"""Damaged robots: whatever is read, nothing but our own errors comes out, and soon."""

from __future__ import annotations

import random
import re

import pytest

from symbody.errors import SymbodyError
from symbody.formats import model_from_urdf, model_to_urdf
from tests.formats.urdf.test_save_urdf import CHAIN, FOLLOWER

PIECES = (
    "",
    "<",
    ">",
    '"',
    "-",
    "1e9",
    "1e300",
    "0",
    "nan",
    "joint",
    "A",
    "&#10;",
    "é",
    " ",
    "ground",
    "continuous",
)


VALUES = re.compile(r'"([^"]*)"')
WORDS = ("", "-", "1e9", "1e-300", "1e400", "0", "nan", "1 2 3", "0 0 0", "A", "B", "base", "q", "é", "12", "ground",
         "CoM", "t", "a.b", "${x}", "continuous", "fixed", "floating", "planar")  # fmt: skip


def damaged(text: str, seed: int) -> str:
    """Values exchanged, and now and then a few characters lost or put in."""
    dice = random.Random(seed)
    values = VALUES.findall(text)
    for _ in range(dice.randint(1, 3)):
        found = dice.choice(list(VALUES.finditer(text)))
        text = f'{text[: found.start()]}"{dice.choice((*WORDS, *values))}"{text[found.end() :]}'
    if dice.random() < 0.2:
        k = dice.randrange(len(text))
        text = text[:k] + dice.choice(PIECES) + text[k + dice.randint(0, 2) :]
    return text


def attempt(seed: int) -> None:
    text = damaged(CHAIN if seed % 2 else FOLLOWER, seed)
    try:
        model_to_urdf(model_from_urdf(text, floating_base=seed % 3 == 0))
    except SymbodyError as error:
        assert all(problem.fix and problem.what for problem in error.problems), text


def test_damaged_robots() -> None:
    for seed in range(300):
        attempt(seed)


@pytest.mark.exhaustive
def test_more_damaged_robots() -> None:
    for seed in range(300, 5000):
        attempt(seed)
