"""What the page receives at each change: problems with pointers, a summary, a picture, poses."""

from __future__ import annotations

import base64
import copy
import threading
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.builder.model_text import data_from_text
from symbody.builder.task_failure import TaskFailure
from symbody.builder.tasks.check import check_model
from symbody.builder.tasks.pose import find_pose
from symbody.formats.model_files import examples_folder
from symbody.formats.native import to_data
from tests.builder.conftest import Answer, Builder


def example(name: str) -> dict[str, Any]:
    return data_from_text((examples_folder() / name / f"{name}.toml").read_text(), name).data


def check(data: dict[str, Any]) -> dict[str, Any]:
    return check_model({"data": data, "folder": ""}, lambda stage, percent: None)


def positions(answer: dict[str, Any]) -> np.ndarray[Any, Any]:
    values = np.frombuffer(base64.b64decode(answer["picture"]["motion"]["positions"]), "<f4")
    return values.reshape(-1, 3).astype(float)


EXAMPLES = ["bicycle", "projectile", "rr_robot", "slider_crank", "spatial_four_bar", "spinning_top_omega",
            "spring_mass_damper"]  # fmt: skip


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_have_a_summary_and_stand_where_they_are_assembled(name: str) -> None:
    answer = check(example(name))
    assert [each for each in answer["problems"] if each["severity"] == "error"] == []
    model = sb.load_model(examples_folder() / name / f"{name}.toml")
    eqs = sb.form_equations(model)
    summary = answer["summary"]
    assert summary["freedoms"] == eqs.degrees_of_freedom
    assert summary["coordinates"] == list(eqs.coordinate_names)
    assert (
        sum(chord["equations"] for chord in summary["chords"])
        == summary["constraints"]
        == len(eqs.multiplier_names)
    )
    state = sb.assemble(eqs)
    expected = np.array([state[f"frame r {body.name} ground ground"] for body in model.bodies])
    np.testing.assert_allclose(positions(answer), expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


def test_the_loop_of_the_slider_crank_is_closed_by_joint_b() -> None:
    summary = check(example("slider_crank"))["summary"]
    assert summary["rotation_tree"] == ["A", "C", "D"] and summary["translation_tree"] == ["A", "C", "D"]
    (chord,) = summary["chords"]
    assert chord["joint"] == "B" and chord["equations"] == 2
    assert set(chord["loop"]) == {"ground", "Crank", "Rod", "Piston"}
    assert summary["tree_choice"]["B"] == {"rotation": False, "translation": False}


def test_a_choice_of_trees_changes_coordinates_and_closing_joint() -> None:
    data = example("slider_crank")
    data["joint"][3]["tree"] = False
    summary = check(data)["summary"]
    assert [chord["joint"] for chord in summary["chords"]] == ["D"]
    data["joint"][3]["tree"], data["joint"][1]["tree"] = True, True
    data["joint"][0]["tree"] = data["joint"][2]["tree"] = True
    (problem,) = [each for each in check(data)["problems"] if each["severity"] == "error"][:1]
    assert problem["code"] == "topology.cycle"
    (change,) = problem["repair"]["patch"]
    assert change["op"] == "add" and change["path"].endswith("/tree") and change["value"] is False
    kind, place = change["path"].split("/")[1:3]
    data[kind][int(place)]["tree"] = False
    assert not [each for each in check(data)["problems"] if each["severity"] == "error"]


BROKEN: dict[str, tuple[Any, str, str]] = {
    "an unknown place": (
        lambda d: d["joint"][0].update(between=["ground", "Krank.A"]),
        "/joint/0/between/1",
        "A",
    ),
    "a bad formula": (lambda d: d["body"][1].update(mass="m1 +"), "/body/1/mass", "Rod"),
    "an unknown symbol": (lambda d: d["body"][1].update(mass="m7"), "/body/1/mass", "Rod"),
    "a missing type": (lambda d: d["joint"][2].pop("type"), "/joint/2", "C"),
    "an unknown key": (lambda d: d["body"][0].update(weight="1"), "/body/0/weight", "Crank"),
    "a bad axis": (lambda d: d["joint"][3].update(axis="q"), "/joint/3/axis", "D"),
    "an unknown initial value": (lambda d: d["initial"].update(phi="1"), "/initial/phi", ""),
    "a circle of parameters": (lambda d: d["parameters"].update(m1="m2", m2="m1"), "/parameters/m1", ""),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_fault_has_a_pointer_and_the_rest_is_drawn(case: str) -> None:
    change, pointer, element = BROKEN[case]
    data = example("slider_crank")
    change(data)
    answer = check(data)
    errors = [each for each in answer["problems"] if each["severity"] == "error"]
    assert (pointer, element) in [(each["pointer"], each["element"]) for each in errors]
    assert all(each["what"] for each in errors)
    assert answer["picture"] is not None and len(answer["picture"]["scene"]["bodies"]) >= 3


RING: dict[str, Any] = {
    "name": "ring",
    "body": [{"name": f"B{k}", "mass": "1", "inertia": ["1", "1", "1"]} for k in (1, 2, 3)],
    "joint": [
        {"name": f"J{k}", "type": "revolute", "between": ends}
        for k, ends in enumerate([["ground", "B1"], ["B1", "B2"], ["B2", "B3"], ["B3", "ground"]], 1)
    ],
}
TYPING = {
    "an open bracket": ("body", 0, {"mass": "2*(m"}),
    "an unknown symbol": ("body", 0, {"mass": "m9"}),
    "a component of inertia": ("body", 1, {"inertia": ["1", "*", "1"]}),
    "a place": ("body", 0, {"frames": {"A": {"at": ["-L/", "0", "0"]}}}),
    "a key that is none, with a sound value": ("body", 2, {"weight": "1"}),
    "an axis": ("joint", 3, {"axis": "q"}),
    "half a name": ("joint", 0, {"coordinate": "2"}),
}


@pytest.mark.parametrize("case", TYPING)
def test_half_a_formula_does_not_change_which_joints_close_loops(case: str) -> None:
    section, place, change = TYPING[case]
    data = {**RING, section: [{**e, **(change if k == place else {})} for k, e in enumerate(RING[section])]}
    before, answer = check(RING)["summary"], check(data)
    errors = [each["pointer"] for each in answer["problems"] if each["severity"] == "error"]
    assert errors and all(each.startswith(f"/{section}/{place}/{next(iter(change))}") for each in errors)
    for tree in ("rotation_tree", "translation_tree", "tree_choice"):
        assert answer["summary"][tree] == before[tree]
    assert len(answer["picture"]["scene"]["bodies"]) == 4


def test_a_ring_without_lengths_is_named_and_its_repair_moves() -> None:
    (warning,) = [each for each in check(RING)["problems"] if each["severity"] == "warning"]
    assert warning["code"] == "builder.coincident" and "J1, J2, J3 and J4 coincide" in warning["what"]
    mended = copy.deepcopy(RING)
    for change in warning["repair"]["patch"]:
        *parents, last = change["path"].split("/")[1:]
        place: Any = mended
        for part in parents:
            place = place[int(part) if isinstance(place, list) else part]
        place[int(last) if isinstance(place, list) else last] = change["value"]
    answer = check(mended)
    assert [each for each in answer["problems"] if each["severity"] != "note"] == []
    assert answer["summary"]["freedoms"] == 1
    crossed = copy.deepcopy(mended)
    crossed["body"][0]["frames"]["C"] = {"at": ["0", "1", "0"]}  # one body with a length is enough
    assert [each for each in check(crossed)["problems"] if each["code"] == "builder.coincident"] == []
    pendulum = {**RING, "joint": RING["joint"][:3]}  # an open chain may turn about centres of mass
    assert [each for each in check(pendulum)["problems"] if each["severity"] == "warning"] == []


def test_several_faults_keep_their_own_places() -> None:
    data = example("slider_crank")
    data["joint"][0]["axis"] = "q"
    data["joint"][2].pop("type")
    data["joint"][3]["between"] = ["ground", "Nobody"]
    pointers = {each["pointer"] for each in check(data)["problems"] if each["severity"] == "error"}
    assert {"/joint/0/axis", "/joint/2", "/joint/3/between/1"} <= pointers


def test_a_repair_mends_what_it_says() -> None:
    data = example("slider_crank")
    data["joint"][0]["between"] = ["ground", "Crnk.A"]
    (problem,) = [each for each in check(data)["problems"] if each["severity"] == "error"]
    (change,) = problem["repair"]["patch"]
    assert change == {"op": "replace", "path": "/joint/0/between/1", "value": "Crank.A"}


def test_an_initial_value_of_nothing_can_be_removed() -> None:
    data = example("slider_crank")
    data["initial"]["phi"] = "1"
    (problem,) = [each for each in check(data)["problems"] if each["severity"] == "error"]
    assert problem["repair"] == {
        "label": "remove the initial value of phi", "patch": [{"op": "remove", "path": "/initial/phi"}]
    }  # fmt: skip


def test_the_first_steps_of_a_model_are_not_met_with_faults() -> None:
    empty = check({"name": "untitled", "gravity": ["0", "-9.81", "0"]})
    assert [each["severity"] for each in empty["problems"]] == ["note"]
    alone = check({"name": "untitled", "body": [{"name": "A", "mass": "1", "inertia": ["1", "1", "1"]}]})
    assert alone["summary"]["freedoms"] == 6 and not [
        e for e in alone["problems"] if e["severity"] == "error"
    ]
    assert alone["picture"]["scene"]["bodies"][1]["name"] == "A"
    wild: list[dict[str, Any]] = [{}, {"name": 3}, {"name": "x", "body": 3}, {"name": "x", "body": [3, None]},
                                  {"name": "x", "joint": [{"between": 1}]}, {"name": "x", "parameters": [1]}]  # fmt: skip
    for data in wild:
        assert check(data)["problems"]


def test_loops_that_do_not_close_are_named_and_drawn_as_given() -> None:
    data = example("slider_crank")
    data["parameters"]["L1"] = "3"
    data["initial"] = {}
    data["joint"][0]["motion"] = "pi/2"
    answer = check(data)
    assert any(each["code"].startswith("assembly.") for each in answer["problems"])
    assert answer["picture"] is not None and answer["values"] == {}


def test_parameters_without_value_are_a_warning() -> None:
    data = example("slider_crank")
    data["parameters"]["L2"] = ""
    answer = check(data)
    warned = [each for each in answer["problems"] if each["severity"] == "warning"]
    assert [each["pointer"] for each in warned] == ["/parameters/L2"]
    assert answer["summary"]["coordinates"] == ["theta", "beta", "s"] and answer["picture"] is not None


def test_formulas_are_shown_at_their_places() -> None:
    formulas = check(example("slider_crank"))["formulas"]
    assert "<mfrac>" in formulas["/body/0/frames/A/at/0"] and "/parameters/L1" not in formulas
    assert "/joint/0/between/0" not in formulas and "/name" not in formulas


def test_a_pose_moves_the_loop() -> None:
    data = example("slider_crank")
    pose = find_pose({"data": data, "folder": "", "fixed": {"theta": 0.3}, "guess": {}}, lambda *_: None)
    eqs = sb.form_equations(sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml"))
    state = sb.assemble(eqs, fixed={"theta": 0.3})
    assert pose["values"]["s"] == pytest.approx(state.q["s"])
    np.testing.assert_allclose(pose["positions"][2], [state.q["s"], 0, 0], atol=1e-9)
    with pytest.raises(TaskFailure) as caught:
        find_pose({"data": data, "folder": "", "fixed": {"s": 9.0}, "guess": {}}, lambda *_: None)
    assert caught.value.problems[0]["code"].startswith("assembly.")


def test_the_layout_of_the_diagram_is_no_change_of_the_mechanism() -> None:
    data = example("rr_robot")
    assert check(data) is check({**data, "layout": {"nodes": {"a": [1, 2]}}})


def test_the_server_checks_and_lets_the_newest_win(builder: Builder) -> None:
    data = to_data(sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml"))
    assert builder.get("check", data=data)["summary"]["freedoms"] == 1
    assert set(builder.get("pose", data=data, fixed={"theta": 0.2})["values"]) == {"theta", "beta", "s"}
    assert builder.ask("pose", data=data, fixed={"s": 9.0}).status == 422
    answers: list[Answer] = []

    def change(k: int) -> None:
        changed = {**data, "parameters": {**data["parameters"], "L1": f"0.4{k}"}}
        answers.append(builder.ask("check", data=changed, page="one"))

    threads = [threading.Thread(target=change, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {answer.status for answer in answers} <= {200, 409} and 200 in {
        answer.status for answer in answers
    }
    assert {answer.code for answer in answers if answer.status == 409} <= {"builder.superseded"}


def test_a_formula_is_echoed_or_its_fault_is_pointed_at(builder: Builder) -> None:
    assert "<msub>" in builder.get("formula", text="m1*L^2/2")["mathml"]
    assert "deg" not in builder.get("formula", text="30 deg")["mathml"]
    answer = builder.ask("formula", text="2*(a", pointer="/body/0/mass")
    assert answer.status == 422 and answer.data["problems"][0]["pointer"] == "/body/0/mass"


def test_advice_is_in_the_words_of_the_page() -> None:
    """Nothing of files and Python where neither is in sight."""
    data = example("slider_crank")
    data["body"][0]["mass"] = "q"
    data["body"][1]["inertia"] = ["1", "1", "5"]
    data["joint"][0]["between"] = ["ground.post", "Crank.A"]
    cures = {each["code"]: each["fix"] for each in check(data)["problems"] if each["severity"] == "error"}
    assert cures["names.unknown"].endswith(" Or make it a parameter.")
    assert any(cure.endswith("Unphysical, if ticked, uses them unchanged") for cure in cures.values())
    assert any(cure.endswith(" Or add this frame to the ground.") for cure in cures.values())
    assert not any(word in cure for cure in cures.values() for word in ("Python", "in a file", "[ground"))
