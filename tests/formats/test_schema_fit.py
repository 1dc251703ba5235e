"""The published schema lets pass what pydantic lets pass: every example, and nothing that pydantic refuses."""

from __future__ import annotations

import copy
import json
import math
import random
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from symbody.formats import schema_fit
from symbody.formats.schema import ModelFile
from symbody.formats.schema_fit import fits, published_schema
from symbody.formats.toml_syntax import parse_toml

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/*.toml"))
ODD = [
    None,
    True,
    -1,
    7,
    1.5,
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
# Keys that say nothing about values, or that pydantic does not look at.
SILENT = {"$defs", "$schema", "default", "description", "discriminator", "pattern", "propertyNames", "title"}


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
    key = chance.choice([*node, "type", "axis", "shape", "mass"])
    if chance.random() < 0.3:
        node.pop(key, None)
    else:
        node[key] = value


def test_every_keyword_of_the_schema_is_looked_at_or_silent() -> None:
    named = {"properties", "$defs"}

    def keywords(node: Any) -> Iterator[str]:
        for key, inner in node.items() if isinstance(node, dict) else ():
            yield key
            if key in named:
                for entry in inner.values():
                    yield from keywords(entry)
            elif key not in {"default", "discriminator"}:
                for entry in inner if isinstance(inner, list) else [inner]:
                    yield from keywords(entry)

    assert set(keywords(published_schema())) <= SILENT | set(schema_fit._CHECKS)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_pass_without_pydantic(path: Path) -> None:
    assert fits(published_schema(), content(path))


def test_nothing_passes_that_pydantic_refuses() -> None:
    chance = random.Random(18)
    verdicts = []
    contents = [content(path) for path in EXAMPLES]
    for _ in range(400):
        data = copy.deepcopy(chance.choice(contents))
        for _ in range(chance.randrange(1, 3)):
            change(data, chance)
        verdicts.append((fits(published_schema(), data), accepts(data)))
        assert not verdicts[-1][0] or verdicts[-1][1], json.dumps(data, default=str)
    assert 20 < sum(quick for quick, _ in verdicts) > 0.8 * sum(slow for _, slow in verdicts)
