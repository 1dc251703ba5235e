"""Wires of the diagram: who reads what of whom, complete models and others, and what examples name in files."""

from __future__ import annotations

import base64
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.builder.model_text import data_from_text
from symbody.builder.wires import model_wires
from symbody.formats.model_files import examples_folder

from .conftest import Builder

PENDULUM: dict[str, Any] = {
    "name": "pendulum",
    "inputs": ["goal"],
    "parameters": {"k": "1"},
    "body": [{"name": "Rod", "mass": "1"}, {"name": "Loose", "mass": "1"}],
    "joint": [
        {
            "name": "pin",
            "type": "revolute",
            "between": ["ground", "Rod"],
            "coordinate": "theta",
            "torque": {"applied": "servo - k*theta_dot"},
        }
    ],
    "signal": [
        {"name": "error", "value": "goal - theta"},
        {"name": "lag", "rate": "(error - lag)/k"},
        {"name": "far", "value": "Loose_x + lag_dot"},
    ],
    "block": [{"name": "servo", "type": "pid", "input": "error", "gains": {"p": "k", "i": "2*k"}}],
}


def seen(data: dict[str, Any]) -> set[tuple[str, str, str]]:
    return {(wire["source"], wire["target"], name) for wire in model_wires(data) for name in wire["names"]}


def test_wires_are_the_names_that_formulas_read() -> None:
    assert seen(PENDULUM) == {
        ("/block/0", "/joint/0", "servo"),
        ("/inputs/0", "/signal/0", "goal"),
        ("/joint/0", "/signal/0", "theta"),
        ("/signal/0", "/signal/1", "error"),
        ("/body/1", "/signal/2", "Loose_x"),
        ("/signal/1", "/signal/2", "lag_dot"),
        ("/signal/0", "/block/0", "error"),
    }


def test_rates_lead_to_the_symbols_whose_rates_they_are() -> None:
    data = {**PENDULUM, "signal": [{"name": "fast", "value": "theta_dot*servo_integral"}]}
    roots = {wire["source"]: wire["roots"] for wire in model_wires(data) if wire["target"] == "/signal/0"}
    assert roots == {"/joint/0": ["theta"], "/block/0": ["servo_integral"]}


def test_incomplete_entries_have_the_wires_of_what_can_be_read() -> None:
    signals = [
        {"name": "error", "value": "goal - theta"},
        {"name": "both", "value": "error +", "rate": "2*error"},
    ]
    blocks = [{"name": "servo", "type": "pid", "input": "error", "gains": {"q": "goal"}}, {"type": "nothing"}]
    wires = seen({**PENDULUM, "signal": signals, "block": blocks})
    assert ("/signal/0", "/signal/1", "error") in wires
    assert ("/inputs/0", "/block/0", "goal") in wires
    assert ("/block/0", "/joint/0", "servo") in wires


@pytest.mark.parametrize(
    "wrong", [{"signal": 3}, {"signal": ["x"]}, {"inputs": "F"}, {"joint": [{"name": 2}]}]
)
def test_data_that_are_no_model_have_no_wires(wrong: dict[str, Any]) -> None:
    assert model_wires(wrong) == []


def test_outputs_lead_to_the_elements_they_name_and_parts_to_their_prefix() -> None:
    path = examples_folder() / "four_legs" / "four_legs.toml"
    data = data_from_text(path.read_text(encoding="utf-8"), path.name, str(path.parent)).data
    wires = seen(data)
    assert ("/include/0", "/signal/0", "FL_Shank.foot") in wires
    assert ("/signal/3", "/force/0", "FL_N") in wires
    assert not any(source == "/joint/0" for source, _, _ in wires), "z is a component here, no coordinate"


@pytest.mark.parametrize("name", ["four_legs", "quarter_car"])
def test_examples_that_name_files_are_complete_and_are_saved_with_them(builder: Builder, name: str) -> None:
    opened = builder.get("open", example=name)
    assert opened["wires"] == model_wires(opened["data"])
    check = builder.get("check", data=opened["data"], document=opened["document"])
    assert [each for each in check["problems"] if each["severity"] == "error"] == []
    assert check["wires"] == opened["wires"]
    path = builder.folder / name / f"{name}.toml"
    path.parent.mkdir()
    builder.get("save", document=opened["document"], path=str(path), data=opened["data"], overwrite=True)
    saved = sb.load_model(path)
    original = sb.load_model(examples_folder() / name / f"{name}.toml")
    assert saved.elements == original.elements


def test_a_draft_of_an_example_knows_its_files(builder: Builder) -> None:
    opened = builder.get("open", example="quarter_car")
    builder.get("draft", document=opened["document"], data=opened["data"])
    draft = builder.get("open", draft=opened["document"])
    check = builder.get("check", data=draft["data"], document=draft["document"])
    assert [each for each in check["problems"] if each["severity"] == "error"] == []


def test_copies_stay_inside_the_folder(builder: Builder, tmp_path: Path) -> None:
    opened = builder.get("open", example="quarter_car")
    folder = builder.folder / "linked"
    folder.mkdir()
    (folder / "road.csv").symlink_to(tmp_path / "elsewhere.csv")
    path = folder / "car.toml"
    builder.get("save", document=opened["document"], path=str(path), data=opened["data"], overwrite=True)
    assert not (tmp_path / "elsewhere.csv").exists()


def test_an_fmu_is_exported_with_notes(builder: Builder) -> None:
    opened = builder.get("open", example="quarter_car")
    written = builder.get("export", document=opened["document"], data=opened["data"], kind="fmu")
    assert written["name"] == "quarter-car.fmu"
    with zipfile.ZipFile(BytesIO(base64.b64decode(written["base64"]))) as archive:
        assert "modelDescription.xml" in archive.namelist()
    assert any("road is an input" in note["what"] for note in written["notes"])
    assert {note["severity"] for note in written["notes"]} == {"note"}


def test_a_model_that_is_no_fmu_is_refused_in_words(builder: Builder) -> None:
    answer = builder.ask("export", data={"name": "nothing", "joint": [{"name": "A"}]}, kind="fmu")
    assert answer.status == 422 and answer.data["problems"][0]["what"]
