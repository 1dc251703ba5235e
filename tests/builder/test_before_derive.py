"""What would make a derivation fail is said before it, at the field or element where it is mended."""

from __future__ import annotations

from typing import Any

import pytest

from symbody.builder.model_text import data_from_text
from symbody.builder.tasks.check import check_model
from symbody.formats.model_files import examples_folder

Change = Any


def example() -> dict[str, Any]:
    path = examples_folder() / "slider_crank" / "slider_crank.toml"
    return data_from_text(path.read_text(encoding="utf-8"), "slider_crank").data


FAULTS: dict[str, tuple[Change, str]] = {
    "two bodies of one name": (lambda d: d["body"][1].update(name="Crank"), "/body/0/name"),
    "two joints of one name": (lambda d: d["joint"][2].update(name="A"), "/joint/0/name"),
    "two coordinates of one name": (lambda d: d["joint"][3].update(coordinate="theta"), "/joint/0/coordinate"),
    "a coordinate that is a parameter": (lambda d: d["joint"][0].update(coordinate="L1"), ""),
    "an empty name": (lambda d: d["body"][0].update(name=""), "/body/0"),
    "a name that is too long": (lambda d: d["body"][0].update(name="N" * 2000), "/body/0"),
    "a formula that ends too early": (lambda d: d["body"][0].update(mass="2*(m1"), "/body/0/mass"),
    "a formula with an unknown word": (lambda d: d["body"][0].update(mass="m1*foo"), "/body/0/mass"),
    "too few components": (lambda d: d["body"][0].update(inertia=["1", "1"]), "/body/0/inertia"),
    "a joint from a body to itself": (
        lambda d: d["joint"][1].update(between=["Crank.A", "Crank.B"]), "/joint/1",
    ),
    "a joint to a body that is not there": (
        lambda d: d["joint"][1].update(between=["Crank.B", "Nobody"]), "/joint/1/between/1",
    ),
    "a frame that is not there": (lambda d: d["joint"][1].update(between=["Crank.Q", "Rod.B"]), "/joint/1/between/0"),
    "too many joints in the trees": (
        lambda d: [joint.update(tree=True) for joint in d["joint"]], "/joint/3",
    ),
    "coordinates that are missing": (lambda d: d["joint"][0].update(type="planar", coordinates=["x"]), "/joint/0"),
}  # fmt: skip


@pytest.mark.parametrize("case", FAULTS)
def test_a_fault_is_caught_before_the_equations(case: str) -> None:
    change, pointer = FAULTS[case]
    data = example()
    change(data)
    errors = [
        each
        for each in check_model({"data": data, "folder": ""}, lambda *_: None)["problems"]
        if each["severity"] == "error"
    ]
    assert errors, case
    assert any(each["pointer"].startswith(pointer) for each in errors), errors
    assert all(each["what"] and (each["fix"] or each["why"]) for each in errors), errors


def test_a_body_without_a_joint_moves_freely_and_that_is_counted() -> None:
    data = example()
    data["body"].append({"name": "Loose", "mass": "1", "inertia": ["1", "1", "1"]})
    answer = check_model({"data": data, "folder": ""}, lambda *_: None)
    assert [each for each in answer["problems"] if each["severity"] == "error"] == []
    assert answer["summary"]["freedoms"] == 1 + 6
    assert any("Loose" in each["what"] for each in answer["problems"])


def test_joints_out_of_the_trees_are_counted_as_constraints() -> None:
    data = example()
    for joint in data["joint"]:
        joint["tree"] = False
    summary = check_model({"data": data, "folder": ""}, lambda *_: None)["summary"]
    assert (summary["freedoms"], summary["rotation_tree"], summary["constraints"]) == (1, [], 20)
    assert [chord["joint"] for chord in summary["chords"]] == ["A", "B", "C", "D"]
    assert len(summary["redundant"]) == 20 - (3 * 6 - 1)


def test_gaps_are_counted_apart_from_constraints_and_are_not_redundant() -> None:
    """A ball in the air and one on the floor: what its contact holds while it is closed takes no freedom."""
    data = {
        "version": 2,
        "name": "ball",
        "gravity": ["0", "0", "-9.81"],
        "body": [{"name": "Ball", "mass": "1", "inertia": ["1", "1", "1"]}],
        "joint": [{"name": "move", "type": "free", "between": ["ground", "Ball"]}],
        "contact": [
            {
                "name": "floor", "between": ["ground", "Ball"], "shapes": ["plane", {"sphere": "0.1"}],
                "normal": "rigid",
            }
        ],
    }  # fmt: skip
    summary = check_model({"data": data, "folder": ""}, lambda *_: None)["summary"]
    counts = [summary[name] for name in ("freedoms", "constraints", "unilateral", "redundant", "counting")]
    assert counts == [6, 0, 1, [], []]


def test_nothing_is_said_of_a_model_without_faults() -> None:
    answer = check_model({"data": example(), "folder": ""}, lambda *_: None)
    assert [each for each in answer["problems"] if each["severity"] != "note"] == []
