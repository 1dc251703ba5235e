"""The published schema lets pass what pydantic lets pass: every example, and nothing that pydantic refuses."""

from __future__ import annotations

import copy
import json
import math
import random
from collections.abc import Iterator
from datetime import date
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from symbody.formats.schema import ModelFile
from symbody.formats.schema_fit import fits_schema
from symbody.formats.toml_syntax import parse_toml

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/*.toml"))
ODD = [
    None,
    True,
    -1,
    7,
    1.5,
    2.0,
    date(2026, 1, 1),
    math.nan,
    Decimal("Infinity"),
    "",
    "x",
    "\ud800",
    [],
    ["x"],
    [1, 2, 3],
    {},
    {"a": 1},
]


def content(path: Path) -> dict[str, Any]:
    return parse_toml(path.read_text(encoding="utf-8"), path.name)


def accepts(data: object) -> bool:
    try:
        ModelFile.model_validate(data)
    except ValidationError:
        return False
    return True


def containers(node: object) -> Iterator[Any]:
    if isinstance(node, dict | list):
        yield node
        for inner in node.values() if isinstance(node, dict) else node:
            yield from containers(inner)


def change(data: Any, chance: random.Random) -> None:
    """Change, add or leave out one entry somewhere."""
    node = chance.choice(list(containers(data)))
    value = copy.deepcopy(chance.choice(ODD))
    if isinstance(node, list):
        node[chance.randrange(len(node) + 1) :] = [value] if chance.random() < 0.7 else []
        return
    key = chance.choice([*node, "type", "axis", "shape", "mass", "version", 3])
    if chance.random() < 0.3:
        node.pop(key, None)
    else:
        node[key] = value


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_pass_without_pydantic(path: Path) -> None:
    assert fits_schema(content(path))


def test_nothing_passes_that_pydantic_refuses() -> None:
    chance = random.Random(18)
    verdicts = []
    contents = [content(path) for path in EXAMPLES]
    for _ in range(600):
        data = copy.deepcopy(chance.choice(contents))
        for _ in range(chance.randrange(1, 3)):
            change(data, chance)
        verdicts.append((fits_schema(data), accepts(data)))
        assert not verdicts[-1][0] or verdicts[-1][1], json.dumps(data, default=str)
    assert 20 < sum(quick for quick, _ in verdicts) > 0.8 * sum(slow for _, slow in verdicts)


@pytest.mark.parametrize("number", [2.0, Decimal(2), True, 3, 0])
def test_integers_are_no_floats(number: object) -> None:
    data = {"version": number, "name": "x"}
    assert not fits_schema(data) and not accepts(data)
    table = {"name": "road", "file": "road.csv", "columns": [1, number]}
    assert fits_schema({"name": "x", "table": [table]}) is (type(number) is int)


@pytest.mark.parametrize("odd", ["\ud800", math.nan, math.inf, Decimal("NaN"), date(2026, 1, 1), {1: 2}])
def test_what_is_no_json_is_left_to_pydantic(odd: object) -> None:
    assert fits_schema({"name": "x"}) and not fits_schema({"name": odd})
    assert not fits_schema({"name": "x", "parameters": {"m": odd}})
