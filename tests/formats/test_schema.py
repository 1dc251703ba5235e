"""The schema: published as it is, refusing conversions, agreeing with the constructors."""

from __future__ import annotations

import inspect
import json
from decimal import Decimal
from pathlib import Path

import pytest
from pydantic import ValidationError

from symbody import formats
from symbody.errors import FormatError
from symbody.formats import checking, schema, schema_joints
from symbody.formats.entries import CONSTRAINTS, ELEMENTS, JOINTS
from symbody.formats.schema import ModelFile
from symbody.model import Drive, Frame, Model
from symbody.model.model import KINDS

PUBLISHED = Path(formats.__file__).with_name("schema.json")


def test_published_schema_is_current() -> None:
    cure = (
        "python -c 'from symbody.formats import schema; print(schema.schema_text(), end=\"\")' > schema.json"
    )
    assert PUBLISHED.read_text(encoding="utf-8") == schema.schema_text(), f"write it anew: {cure}"
    assert json.loads(schema.schema_text())["additionalProperties"] is False


def words(entry: type) -> set[str]:
    return set(entry.model_fields)


def arguments(make: object) -> set[str]:
    names = set(inspect.signature(make).parameters)
    kept = {"shape" if name == "shapes" else name for name in names - {"start", "end"}}
    return kept | ({"between"} if "start" in names else set())


def class_word(word: str) -> str:
    return word.title().replace("_", "")


@pytest.mark.parametrize("kind", ELEMENTS)
def test_keys_of_elements_are_their_arguments(kind: str) -> None:
    assert words(getattr(schema, f"{class_word(kind)}Entry")) == arguments(ELEMENTS[kind])


@pytest.mark.parametrize("word", JOINTS)
def test_keys_of_joints_are_their_arguments(word: str) -> None:
    assert words(getattr(schema_joints, f"{class_word(word)}Entry")) == arguments(JOINTS[word]) | {"type"}


def test_keys_of_parts_and_of_the_model() -> None:
    assert words(schema.FrameEntry) == arguments(Frame)
    assert words(schema_joints.DriveEntry) == arguments(Drive)
    kinds = set(KINDS) & words(ModelFile)
    assert words(ModelFile) - kinds == (arguments(Model) - {"elements", "ground_shapes", "notes"}) | {
        "layout",
        "version",
    }


@pytest.mark.parametrize("value", ["m", "", 1, 1.5, Decimal("1.50"), -(10**30)])
def test_numbers_and_texts_are_expressions(value: object) -> None:
    read = ModelFile.model_validate({"name": "a", "body": [{"name": "b", "mass": value}]})
    assert read.body[0].mass == value and type(read.body[0].mass) is type(value)


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
    ],
)
def test_nothing_is_converted(data: object) -> None:
    with pytest.raises(ValidationError):
        ModelFile.model_validate(data)


def test_names_of_other_programs_lead_to_ours() -> None:
    known = {*JOINTS, *CONSTRAINTS}
    assert set(checking._OTHER_NAMES.values()) <= known and not known & set(checking._OTHER_NAMES)
    joint = {"name": "J", "type": "Hinge", "between": ["ground", "A"]}
    data = {"name": "m", "body": [{"name": "A", "mass": 1}], "joint": [joint]}
    with pytest.raises(FormatError, match="it is called 'revolute' here"):
        formats.from_data(data)
