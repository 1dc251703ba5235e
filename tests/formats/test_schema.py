"""The schema: published as it is, refusing conversions, agreeing with the constructors."""

from __future__ import annotations

import inspect
import json
from decimal import Decimal
from pathlib import Path

import pytest

from symbody import formats
from symbody.errors import FormatError
from symbody.formats import schema
from symbody.formats.places import pointer
from symbody.formats.schema import VERSION, check_structure
from symbody.model import Model, elements
from symbody.model.class_folders import definition_name
from symbody.model.declarations.field import OTHER_NAMES
from symbody.model.model import KINDS
from symbody.model.registry import element_types

PUBLISHED = Path(formats.__file__).with_name("schema.json")


def test_published_schema_is_current() -> None:
    assert PUBLISHED.read_text(encoding="utf-8") == schema.schema_text(), "run: python docs/list_elements.py"
    assert json.loads(schema.schema_text())["additionalProperties"] is False
    assert (
        json.loads(schema.schema_text())["$id"] == f"urn:symbody:model-file:{VERSION}"
    )  # one version, the file's


def section_types() -> list[tuple[str, str]]:
    return [(kind, word) for kind in KINDS for word in element_types(kind)]


@pytest.mark.parametrize(("kind", "word"), section_types())
def test_keys_of_elements_are_their_arguments(kind: str, word: str) -> None:
    names = set(inspect.signature(element_types(kind)[word]).parameters)
    keys = {
        "shape" if name == "shapes" and kind == "body" else name
        for name in names - {"start", "end", "folder"}
    }
    keys |= ({"between"} if "start" in names else set()) | ({"type"} if word else set())
    definition = schema.file_schema()["$defs"][definition_name(word or kind)]
    assert set(definition["properties"]) == keys


def test_every_element_is_listed_with_its_fields() -> None:
    listed = {(each["section"], each["type"]): each for each in elements()}
    assert list(listed) == section_types() and json.loads(json.dumps(elements())) == elements()
    pitch = next(field for field in listed["joint", "screw"]["fields"] if field["name"] == "pitch")
    assert pitch["required"] and pitch["unit"] == "m" and pitch["role"] == "quantity" and pitch["sentence"]
    for each in listed.values():
        assert all(field["sentence"] or field["unit"] for field in each["fields"]), each["type"]


def test_keys_of_the_model() -> None:
    keys = set(inspect.signature(Model).parameters) - {"elements", "ground_shapes", "notes"}
    assert set(schema.model_table().fields) - set(KINDS) == keys | {"include", "layout", "version"}


@pytest.mark.parametrize("value", ["m", "", 1, 1.5, Decimal("1.50"), -(10**30)])
def test_numbers_and_texts_are_expressions(value: object) -> None:
    data = {"name": "a", "body": [{"name": "b", "mass": value}]}
    assert check_structure(data, pointer) is data


@pytest.mark.parametrize(
    "data",
    [
        {"name": 1},
        {"name": "a", "x": 1},
        {"name": "a", "body": {}},
        {"name": "a", "inputs": "F"},
        {"name": "a", "body": [{"name": "b", "mass": True}]},
        {"name": "a", "body": [{"name": "b", "mass": [1]}]},
        {"name": "a", "body": [{"name": "b", "mass": Decimal("Infinity")}]},
        {"name": "a", "gravity": [1, 2]},
        {"name": "a", "parameters": {"m": float("nan")}},
        {"name": "a", "version": True},
        {"name": "a", "version": 0},
        {"name": "a", "force": [{"name": "f", "on": "A", "vector": (1, 2, 3)}]},
        {"name": "a", "ground": []},
        {"name": "a", "parameters": {1: 2}},
    ],
)
def test_nothing_is_converted(data: object) -> None:
    with pytest.raises(FormatError):
        check_structure(data, pointer)


def test_names_of_other_programs_lead_to_ours() -> None:
    known = {*element_types("joint"), *element_types("constraint")}
    assert set(OTHER_NAMES.values()) <= known and not known & set(OTHER_NAMES)
    joint = {"name": "J", "type": "Hinge", "between": ["ground", "A"]}
    data = {"name": "m", "body": [{"name": "A", "mass": 1}], "joint": [joint]}
    with pytest.raises(FormatError, match="the key is called 'revolute'"):
        formats.from_data(data)
