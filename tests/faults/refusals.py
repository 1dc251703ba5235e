"""What a refusal must be: our own error, with code, place and cure, and nothing changed by the attempt."""

from __future__ import annotations

import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import pytest

from symbody.errors import ModelError, SymbodyError
from symbody.formats import load_model
from symbody.model import Model
from symbody.model.element import Element

FILES = Path(__file__).parent / "model_files"


def refused(
    attempt: Callable[[], object], kind: type[SymbodyError] = SymbodyError, words: str = ""
) -> list[tuple[str, str]]:
    """Return code and place of each problem that an attempt raises; `words` stand in the message."""
    with pytest.raises(kind) as caught:
        attempt()
    assert caught.value.problems
    for problem in caught.value.problems:
        assert problem.what and problem.where
        assert problem.fix, f"{problem.code} has no cure"
    assert words in str(caught.value)
    return [(problem.code, problem.where) for problem in caught.value.problems]


def refused_model(*elements: Element, words: str = "", **rest: object) -> list[tuple[str, str]]:
    """Return what is wrong with a model; its parts must come out of the attempt as they went in."""
    before = deepcopy((elements, rest))
    found = refused(lambda: Model("bad", elements, **rest), ModelError, words)
    assert (elements, rest) == before
    return found


def refused_file(name: str, code: str, words: str = "") -> None:
    """Check that a fault file raises its code with the line, and stays as it is.

    Which line it is stands in the file and is tested with the formats.
    """
    path = FILES / f"{name}.toml"
    before = path.read_bytes()
    found = refused(lambda: load_model(path), words=words)
    assert code in [code for code, _ in found]
    assert all(re.match(rf"{re.escape(str(path))}:\d+", where) for _, where in found)
    assert path.read_bytes() == before
