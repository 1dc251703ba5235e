"""What the published schema refuses, the roles explain, and nothing else: drawn fits, mutated into misfits."""

from __future__ import annotations

import copy
import json
import random
import re
from collections.abc import Iterator
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest

from symbody.errors import FormatError, ModelError
from symbody.formats.places import pointer
from symbody.formats.reading import parse_toml
from symbody.formats.schema import check_structure, file_schema
from symbody.model.model import KINDS
from symbody.model.registry import read_element

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/*.toml"))
# Codes for words that the schema lists: the constructors check them, so that scripts get the same messages.
WORDS = {
    "block.unknown_gain", "model.angle_sequence", "model.axis_letter", "model.curve_kind", "model.curve_words",
    "model.speeds",
}  # fmt: skip
# Any fault at a law, whose curve the constructor checks: the schema sees its types and that there are two points.
CURVE = "curve"
FORMULAS = (1, 2.5, -3, "2*a", "pi/3", "")
TEXTS = ("A", "B.tip", "q1", "a b", "xyz", "")
ODD: tuple[Any, ...] = (
    None, True, -1, 7, 1.5, "", "x", "w", "pchip", [], ["x"], [1, 2, 3], ["x", "y"], [[1, 2, 3]], {}, {"a": 1},
    {"x": [1]}, {"x": [1, 2], "y": [3, 4]}, {"value": 1}, {"rotation": True}, [["z", 1]], {"name": "n"},
)  # fmt: skip


@cache
def schema() -> dict[str, Any]:
    return file_schema()


@cache
def validator() -> jsonschema_rs.Draft202012Validator:
    return jsonschema_rs.Draft202012Validator(json.dumps(schema()))


def content(path: Path) -> dict[str, Any]:
    return parse_toml(path.read_text(encoding="utf-8"), path.name)


def draw(node: dict[str, Any], chance: random.Random) -> Any:
    """Draw a value that fits a part of the schema."""
    if "$ref" in node:
        return draw(schema()["$defs"][node["$ref"].rpartition("/")[2]], chance)
    for several in ("anyOf", "oneOf"):
        if several in node and "enum" not in node:
            choices = [choice for choice in node[several] if choice.get("type") != "null"]
            return draw(chance.choice(choices), chance)
    if "const" in node or "enum" in node:
        return node.get("const") or chance.choice(node["enum"])
    if "pattern" in node:
        return chance.choice(("xyz", "313", "space 123"))
    return draw_type(node, chance)


def draw_type(node: dict[str, Any], chance: random.Random) -> Any:
    kind = node["type"]
    if kind == "array":
        if "prefixItems" in node:
            return [draw(item, chance) for item in node["prefixItems"]]
        count = chance.randint(node.get("minItems", 0), node.get("maxItems", 3))
        return [draw(node["items"], chance) for _ in range(count)]
    if kind == "object":
        return draw_table(node, chance)
    plain = {"boolean": (True, False), "integer": (1, 2), "string": TEXTS}
    return chance.choice(plain[kind] if isinstance(kind, str) else FORMULAS)


def draw_table(node: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    known = node.get("properties", {})
    keys = [key for key in known if key in node.get("required", ()) or chance.random() < 0.5]
    table = {key: draw(known[key], chance) for key in keys}
    if isinstance(node.get("additionalProperties"), dict):
        names = node.get("propertyNames", {}).get("enum", ("q1", "q2", "tip"))
        for name in chance.sample(names, chance.randint(0, 2)):
            table[name] = draw(node["additionalProperties"], chance)
    return table


def containers(node: object) -> Iterator[Any]:
    if isinstance(node, dict | list):
        yield node
        for inner in node.values() if isinstance(node, dict) else node:
            yield from containers(inner)


def mutate(data: Any, chance: random.Random) -> None:
    """Change, add or leave out one entry somewhere."""
    node = chance.choice(list(containers(data)))
    value = copy.deepcopy(chance.choice(ODD))
    if isinstance(node, list):
        if node and chance.random() < 0.5:
            node[chance.randrange(len(node))] = value
        else:
            node[chance.randrange(len(node) + 1) :] = [value] if chance.random() < 0.7 else []
        return
    key = chance.choice([*node, "type", "axis", "shape", "mass", "version", "torque"])
    if chance.random() < 0.3:
        node.pop(key, None)
    else:
        node[key] = value


def explanations(data: dict[str, Any]) -> tuple[bool, set[str]]:
    """Whether the structure is refused, and the codes of what the entries say."""
    try:
        fitting = check_structure(data, pointer)
    except FormatError as error:
        assert all(problem.fix and problem.where for problem in error.problems)
        return True, set()
    codes: set[str] = set()
    for kind in KINDS:
        for entry in fitting.get(kind, ()):
            try:
                read_element(kind, entry)
            except ModelError as error:
                codes |= {problem.code for problem in error.problems}
                codes |= {CURVE for problem in error.problems if re.search(r"\blaw\b", problem.where)}
    return False, codes


def are_refused_if_explained(seed: int, count: int) -> None:
    """Check drawn and copied files, most of them mutated: explained if the schema refuses them, else not."""
    chance = random.Random(seed)
    verdicts = []
    examples = [json.loads(json.dumps(content(path), default=float)) for path in EXAMPLES]
    for number in range(count):
        data = drawn_file(number, examples, chance)
        for _ in range(chance.randrange(3)):
            mutate(data, chance)
        refused = not validator().is_valid(data)
        has_misfits, codes = explanations(data)
        if refused:
            assert has_misfits or codes & {*WORDS, CURVE}, data
        else:
            assert not has_misfits and not codes & WORDS, data
        verdicts.append(refused)
    assert 0.2 * count < sum(verdicts) < 0.8 * count


def drawn_file(number: int, examples: list[Any], chance: random.Random) -> Any:
    """One element, or at times an example or a whole file, in which each key is mutated less often."""
    if number % 10 == 0:
        return copy.deepcopy(chance.choice(examples))
    if number % 10 == 1:
        return draw(schema(), chance)
    kind = chance.choice(KINDS)
    return {"name": "m", kind: [draw(schema()["properties"][kind]["items"], chance)]}


def test_the_schema_refuses_what_the_roles_explain() -> None:
    are_refused_if_explained(35, 500)


@pytest.mark.exhaustive
def test_the_schema_refuses_what_the_roles_explain_in_many_files() -> None:
    are_refused_if_explained(36, 5000)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_fit(path: Path) -> None:
    assert check_structure(content(path), pointer)


@pytest.mark.parametrize("number", [2.0, Decimal(2), True, 3, 0])
def test_integers_are_no_floats(number: object) -> None:
    with pytest.raises(FormatError):
        check_structure({"version": number, "name": "x"}, pointer)
    table = {"name": "road", "file": "road.csv", "columns": [1, number]}
    if type(number) is int:
        assert check_structure({"name": "x", "table": [table]}, pointer)
    else:
        with pytest.raises(FormatError):
            check_structure({"name": "x", "table": [table]}, pointer)
