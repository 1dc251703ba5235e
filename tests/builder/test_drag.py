"""A body that is dragged: the loops stay closed, and a point of the body follows the pointer."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.builder.model_text import data_from_text
from symbody.builder.task_failure import TaskFailure
from symbody.builder.tasks.check import check_model
from symbody.builder.tasks.drag import drag_body
from symbody.formats.model_files import examples_folder
from tests.builder.conftest import Builder
from tests.tiers import rows

CENTRE = [0.0, 0.0, 0.0]


def example(name: str) -> dict[str, Any]:
    return data_from_text((examples_folder() / name / f"{name}.toml").read_text(), name).data


def start(data: dict[str, Any]) -> dict[str, float]:
    values: dict[str, float] = check_model({"data": data, "folder": ""}, lambda *_: None)["values"]
    return values


def drag(data: dict[str, Any], body: str, origin: Any, direction: Any, **more: Any) -> dict[str, Any]:
    line = {"origin": list(origin), "direction": list(direction)}
    payload = {"data": data, "folder": "", "body": body, "point": CENTRE, "guess": {}, **line, **more}
    return drag_body(payload, lambda *_: None)


def test_a_piston_goes_where_it_is_drawn_and_the_crank_turns() -> None:
    data = example("slider_crank")
    before = start(data)
    answer = drag(data, "Piston", (before["s"] - 0.1, 0.4, 3.0), (0.0, 0.0, -1.0), guess=before)
    assert answer["values"]["s"] == pytest.approx(before["s"] - 0.1, abs=1e-4)
    assert answer["distance"] == pytest.approx(0.4, abs=1e-3)
    eqs = sb.form_equations(sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml"))
    state = sb.assemble(eqs, fixed={"s": answer["values"]["s"]}, guess=answer["values"])
    assert state.q == pytest.approx(answer["values"], abs=1e-7)
    assert answer["positions"][1] == pytest.approx(
        list(np.ravel(state['frame r "Rod" ground ground'])), abs=1e-7
    )


@pytest.mark.parametrize(
    ("name", "body"),
    rows([("spatial_four_bar", "Crank"), ("spatial_four_bar", "Rod"), ("stewart_platform", "Platform"),
          ("bicycle", "FrontWheel"), ("spinning_top_omega", "Top"), ("rr_robot", "Link2")],
         fast=lambda name, _: name != "stewart_platform"),
)  # fmt: skip
def test_a_point_of_a_spatial_mechanism_comes_nearer_and_loops_stay_closed(name: str, body: str) -> None:
    data = example(name)
    guess = start(data)
    point = [0.05, 0.02, 0.03]
    here = drag(data, body, (0.0, 0.0, 50.0), (0.3, 0.2, -1.0), guess=guess, point=point)
    direction = np.array([0.3, 0.2, -1.0])
    aim = np.array(here["at"]) + [0.03, 0.05, 0.04]
    answer = drag(data, body, aim - 4.0 * direction, direction, guess=here["values"], point=point)
    unit = direction / np.linalg.norm(direction)
    apart = aim - np.array(here["at"])
    assert answer["distance"] < np.linalg.norm(apart - (apart @ unit) * unit)
    path = next((examples_folder() / name).glob("*.toml"))
    eqs = sb.form_equations(sb.load_model(path))
    state = sb.assemble(eqs, guess=answer["values"])
    assert state.q == pytest.approx({n: answer["values"][n] for n in state.q}, abs=1e-7)


def test_beyond_its_reach_the_mechanism_stays_assembled() -> None:
    data = example("slider_crank")
    answer = drag(data, "Piston", (9.0, 0.0, 3.0), (0.0, 0.0, -1.0), guess=start(data))
    for _ in range(6):
        answer = drag(data, "Piston", (9.0, 0.0, 3.0), (0.0, 0.0, -1.0), guess=answer["values"])
    assert 1.3 < answer["values"]["s"] <= 1.4 + 1e-9
    crank = answer["positions"][0]
    assert np.hypot(*crank[:2]) == pytest.approx(0.2, abs=1e-9)


def test_what_cannot_be_dragged_says_why() -> None:
    data = example("slider_crank")
    guess = start(data)
    driven = {**data, "joint": [{**data["joint"][0], "motion": "pi/6"}, *data["joint"][1:]]}
    driven["initial"] = {}
    for body, model, code in (
        ("Crank", driven, "builder.immovable"), ("Nobody", data, "builder.drag"), ("ground", data, "builder.drag"),
    ):  # fmt: skip
        with pytest.raises(TaskFailure) as caught:
            drag(model, body, (0.0, 1.0, 3.0), (0.0, 0.0, -1.0))
        assert caught.value.problems[0]["code"] == code and caught.value.problems[0]["fix"]
    with pytest.raises(TaskFailure) as caught:
        drag(data, "Crank", (0.0, 1.0, 3.0), (0.0, 0.0, 0.0), guess=guess)
    assert caught.value.problems[0]["code"] == "builder.drag"
    open_loop = {**data, "parameters": {**data["parameters"], "L2": "0.1"}, "initial": {}}
    open_loop["joint"] = [{**data["joint"][0], "motion": "pi/2"}, *data["joint"][1:]]
    with pytest.raises(TaskFailure) as caught:
        drag(open_loop, "Piston", (0.0, 1.0, 3.0), (0.0, 0.0, -1.0))
    assert caught.value.problems[0]["code"].startswith("assembly.")


def test_a_slack_rope_lets_a_body_go_until_it_is_taut() -> None:
    data = data_from_text(
        'name = "pendulum on a rope"\ngravity = ["0", "-9.81", "0"]\n'
        '[[body]]\nname = "Bob"\nmass = "1"\ninertia = ["1", "1", "1"]\n'
        '[[joint]]\nname = "plane"\ntype = "rectangular"\nbetween = ["ground", "Bob"]\ncoordinates = ["x", "y"]\n'
        '[[constraint]]\nname = "rope"\ntype = "distance"\nbetween = ["ground", "Bob"]\nvalue = "1"\nrope = true\n'
        '[initial]\nx = "0.2"\ny = "-0.5"\n',
        "rope",
    ).data
    near = drag(data, "Bob", (0.5, -0.6, 2.0), (0.0, 0.0, -1.0))
    assert (near["values"]["x"], near["values"]["y"]) == pytest.approx((0.5, -0.6), abs=1e-3)
    far = drag(data, "Bob", (3.0, -4.0, 2.0), (0.0, 0.0, -1.0), guess=near["values"])
    assert np.hypot(far["values"]["x"], far["values"]["y"]) <= 1.0 + 1e-6


def test_the_server_answers_a_drag(builder: Builder) -> None:
    data = example("slider_crank")
    builder.get("check", data=data)
    answer = builder.get(
        "drag", data=data, body="Crank", point=[0, 0, 0], origin=[0.1, 0.3, 2], direction=[0, 0, -1], guess={}
    )
    assert set(answer) == {"values", "positions", "quaternions", "at", "distance", "size"}
    wrong = builder.ask("drag", data=data, body="Crank", point=[0, 0], origin=[0, 0, 2], direction=[0, 0, -1])
    assert (wrong.status, wrong.code) == (422, "builder.request")
