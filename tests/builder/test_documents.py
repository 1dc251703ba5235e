"""Documents: opened, saved to the byte, noticed when changed outside, recovered."""

from __future__ import annotations

import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.builder import documents
from symbody.builder.model_text import data_from_text, text_from_data
from symbody.formats.model_files import examples_folder
from symbody.formats.native import to_data
from tests.builder.conftest import Builder

EXAMPLES = sorted(examples_folder().glob("*/*.toml"))
CRANK = examples_folder() / "slider_crank" / "slider_crank.toml"
PENDULUM = """# A pendulum; the comment stays
name = "pendulum"   # this one too
gravity = [0, "-g", 0]

[parameters]
g = 9.81  # m/s^2
L = 1.50

[[body]]
name = "Bob"
mass = 2

[[joint]]
name = "pivot"
type = "revolute"
between = ["ground", "Bob"]
coordinate = "theta"
"""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_what_was_not_changed_keeps_every_byte(path: Path) -> None:
    text = path.read_bytes().decode()
    folder = str(path.parent)
    through_page = json.loads(json.dumps(data_from_text(text, path.name, folder).data))
    for variant in (text, text.replace("\n", "\r\n"), "\N{ZERO WIDTH NO-BREAK SPACE}" + text):
        assert text_from_data(through_page, variant, folder) == variant


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_is_data_of_the_same_model(path: Path) -> None:
    opened = data_from_text(path.read_text(), path.name, str(path.parent))
    assert all(problem["severity"] == "note" for problem in opened.problems) and opened.model is not None
    assert to_data(sb.load_model(path)) == to_data(opened.model)


def test_a_file_says_what_its_parameters_are() -> None:
    text = 'name = "x"\n[parameters]\n# all\nm = 1 # kg: of the rod\nl = 2\n"a#b" = "3*l" #  half # more\n'
    assert data_from_text(text, "x.toml").comments == {"m": "kg: of the rod", "a#b": "half # more"}
    assert data_from_text('name = "x"\n', "x.toml").comments == {}


def test_a_change_keeps_comments_order_and_the_digits_of_all_else() -> None:
    data = data_from_text(PENDULUM, "pendulum").data
    data["parameters"]["g"] = "9.8"
    data["layout"] = {"nodes": {"Bob": [10, 20.5]}}
    text = text_from_data(data, PENDULUM)
    assert "# A pendulum; the comment stays" in text and "# this one too" in text and "# m/s^2" in text
    assert "g = 9.8 " in text and "L = 1.50" in text
    again = data_from_text(text, "pendulum").data
    assert again["layout"] == {"nodes": {"Bob": [10, 20.5]}}
    assert text_from_data(again, text) == text


INCOMPLETE = {
    "no type": {"name": "x", "joint": [{"name": "j", "between": ["ground", ""]}]},
    "no name": {"name": "", "body": [{"mass": "m"}]},
    "unknown key": {"name": "x", "body": [{"name": "A", "colour": "red"}]},
    "unknown symbol": {"name": "x", "body": [{"name": "A", "mass": "m1", "inertia": ["1.50", "0", "0"]}]},
    "turns": {
        "name": "x",
        "joint": [{"name": "j", "type": "spherical", "angles": "313", "between": ["A", "B"]}],
    },
    "formula": {
        "name": "x",
        "gravity": ["0", "-9.81*", "0"],
        "parameters": {"a": "", "b": "2", "c": "30 deg"},
    },
    "flags": {
        "name": "x",
        "joint": [{"name": "j", "type": "revolute", "between": ["ground", "A"], "tree": False}],
    },
}


@pytest.mark.parametrize("data", INCOMPLETE.values(), ids=INCOMPLETE)
def test_what_is_no_model_yet_is_saved_and_opened_too(data: dict[str, object]) -> None:
    text = text_from_data(data)
    opened = data_from_text(text, "draft")
    assert opened.data == data and opened.problems
    assert text_from_data(opened.data, text) == text
    with_comment = f"# mine\n{text}"
    changed = {**opened.data, "name": "y"}
    assert text_from_data(changed, with_comment).startswith("# mine\n")


def test_a_model_that_becomes_incomplete_keeps_its_comments() -> None:
    text = PENDULUM.replace("mass = 2", "mass = 2  # kg\nunphysical = false").replace("[0, ", "[ 0.0, ")
    data = data_from_text(text, "pendulum").data
    data["joint"].append({"name": "second", "type": "revolute", "between": ["Bob", ""]})
    saved = text_from_data(data, text)
    assert saved.startswith(text) and "second" in saved
    assert data_from_text(saved, "pendulum").data["joint"][1:] == data["joint"][1:]
    del data["joint"][1]
    mended = text_from_data(data, saved)
    assert all(comment in mended for comment in ("# A pendulum; the comment stays", "# kg", "# m/s^2"))
    assert data_from_text(mended, "pendulum").problems == []


def test_problems_of_a_file_name_lines_and_pointers(builder: Builder) -> None:
    path = builder.folder / "broken.toml"
    path.write_text(PENDULUM.replace("mass = 2", 'mass = "q"'))
    (problem,) = builder.get("open", path=str(path))["problems"]
    assert (problem["pointer"], problem["line"], problem["element"]) == ("/body/0/mass", 11, "Bob")
    assert problem["repair"]["patch"] == [{"op": "add", "path": "/parameters/q", "value": "1"}]
    path.write_text(PENDULUM.replace('"pivot"', '"pivot'))
    answer = builder.ask("open", path=str(path))
    assert answer.status == 422 and answer.data["problems"][0]["line"] == 14
    path.write_bytes(b"name = '\xff'")
    assert builder.ask("open", path=str(path)).code == "builder.not_text"


def test_open_save_and_the_list_of_recent_files(builder: Builder) -> None:
    path = builder.folder / "crank.toml"
    path.write_bytes(CRANK.read_bytes())
    document = builder.get("open", path=str(path))
    before = path.stat().st_mtime_ns
    saved = builder.get("save", document=document["document"], path=str(path), data=document["data"],
                        fingerprint=document["fingerprint"])  # fmt: skip
    assert saved["fingerprint"] == document["fingerprint"]
    assert path.read_bytes() == CRANK.read_bytes() and path.stat().st_mtime_ns == before
    assert builder.get("recent")["files"][0]["path"] == str(path)
    document["data"]["parameters"]["L1"] = "0.45"
    saved = builder.get("save", document=document["document"], path=str(path), data=document["data"],
                        fingerprint=saved["fingerprint"])  # fmt: skip
    assert path.read_text() == CRANK.read_text().replace("L1 = 0.4 ", "L1 = 0.45 ")
    assert not builder.get("changed", document=document["document"], fingerprint=saved["fingerprint"])[
        "changed"
    ]


def test_of_two_pages_that_save_at_the_same_time_one_is_told(
    builder: Builder, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = builder.folder / "two_tabs.toml"
    path.write_text(PENDULUM)
    pages = [builder.get("open", path=str(path)) for _ in range(2)]
    write = documents.write_text

    def write_slowly(*given: Any, **named: Any) -> Any:  # what the other page does meanwhile comes in between
        time.sleep(0.3)
        return write(*given, **named)

    monkeypatch.setattr(documents, "write_text", write_slowly)

    def save(k: int) -> tuple[int, str]:
        page = pages[k]
        answer = builder.ask("save", document=page["document"], path=str(path), fingerprint=page["fingerprint"],
                             data=page["data"] | {"name": f"page {k}"})  # fmt: skip
        return answer.status, "" if answer.status == 200 else answer.code

    with ThreadPoolExecutor(2) as both:
        answers = list(both.map(save, range(2)))
    assert sorted(answers) == [(200, ""), (409, "builder.changed_outside")]
    assert f'name = "page {answers.index((200, ""))}"' in path.read_text()


def test_a_file_changed_outside_is_noticed_and_kept(builder: Builder) -> None:
    path = builder.folder / "outside.toml"
    path.write_text(PENDULUM)
    document = builder.get("open", path=str(path))
    path.write_text(PENDULUM + "# changed by another program\n")
    told = {"document": document["document"], "fingerprint": document["fingerprint"]}
    assert builder.get("changed", **told)["changed"]
    data = document["data"] | {"name": "mine"}
    answer = builder.ask("save", path=str(path), data=data, **told)
    assert answer.status == 409 and answer.code == "builder.changed_outside"
    assert "another program" in path.read_text()
    builder.get("save", path=str(path), data=data, overwrite=True, **told)
    assert 'name = "mine"' in path.read_text() and "changed by another program" in path.read_text()
    path.unlink()
    assert builder.get("changed", **told)["changed"]


def test_a_new_document_does_not_take_the_place_of_a_file(builder: Builder) -> None:
    path = builder.folder / "there.toml"
    path.write_text(PENDULUM)
    document = builder.get("new")
    answer = builder.ask("save", document=document["document"], path=str(path), data=document["data"])
    assert answer.status == 409 and path.read_text() == PENDULUM


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere"
)
def test_a_folder_that_cannot_be_written_to_costs_nothing(builder: Builder) -> None:
    folder = builder.folder / "closed"
    folder.mkdir(mode=0o500)
    document = builder.get("new")
    answer = builder.ask(
        "save", document=document["document"], path=str(folder / "x.toml"), data=document["data"]
    )
    assert answer.status == 422 and answer.code == "file.not_saved"


def test_drafts_outlive_the_server(builder: Builder) -> None:
    document = builder.get("open", example="slider_crank")
    data = document["data"] | {"name": "unsaved"}
    builder.get("draft", document=document["document"], data=data)
    (draft,) = [each for each in builder.get("recovery")["drafts"] if each["id"] == document["document"]]
    assert draft["name"] == "slider_crank" and draft["path"] is None
    assert builder.get("open", draft=draft["id"])["data"] == data
    path = builder.folder / "recovered.toml"
    builder.get("save", document=draft["id"], path=str(path), data=data)
    assert sb.load_model(path).name == "unsaved"
    assert draft["id"] not in [each["id"] for each in builder.get("recovery")["drafts"]]


def test_a_page_of_an_earlier_run_goes_on(builder: Builder) -> None:
    identifier, data = "0123456789abcdef" * 2, {"name": "old"}
    answer = builder.ask("draft", document=identifier, data=data)
    assert answer.status == 404 and answer.code == "builder.unknown_document"
    builder.get("adopt", document=identifier, path=str(builder.folder / "old.toml"), name="old")
    builder.get("draft", document=identifier, data=data)
    assert builder.ask("adopt", document=identifier[::-1], path="/etc/x.toml").status == 403


def test_examples_texts_robots_and_folders(builder: Builder) -> None:
    listed = {each["name"]: each for each in builder.get("examples")["examples"]}
    assert {path.stem for path in EXAMPLES} - listed.keys() == {"leg"}  # a part of another example
    assert "robot_arm" in listed
    assert listed["slider_crank"]["title"] == "Slider-Crank" and "piston" in listed["slider_crank"]["summary"]
    assert builder.get("open", example="robot_arm")["data"]["joint"]
    assert builder.get("open", text=PENDULUM, name="pendulum.toml")["data"]["body"][0]["name"] == "Bob"
    robot = builder.folder / "arm.urdf"
    robot.write_text((examples_folder() / "robot_arm" / "robot_arm.urdf").read_text())
    assert builder.get("open", urdf=str(robot))["path"] is None
    (builder.folder / "sub").mkdir()
    entries = builder.get("folder", path=str(builder.folder))["entries"]
    assert {"name": "arm.urdf", "kind": "urdf"} in entries and {"name": "sub", "kind": "folder"} in entries
    assert builder.ask("open", example="nothing").status == 404
    assert builder.ask("open").code == "builder.open"


def test_the_palette_is_that_of_the_schema(builder: Builder) -> None:
    answer = builder.get("schema")
    types = {(each["section"], each["type"]) for each in answer["elements"]}
    assert {
        ("body", ""),
        ("joint", "revolute"),
        ("constraint", "gear"),
        ("spring", ""),
        ("force", ""),
    } <= types
    for each in answer["elements"]:
        assert each["definition"] in answer["schema"]["$defs"] and each["summary"] and each["title"]
