"""A picture after a change of parameters: what the check of the same model shows, with nothing formed anew."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from symbody.builder.tasks import check, mechanisms
from symbody.builder.tasks.check import check_model
from symbody.builder.tasks.reading import Latest
from symbody.builder.tasks.redraw import redraw_model
from symbody.formats.model_files import examples_folder
from symbody.formats.native import load_model, to_data
from tests.tiers import cases

FILES = {path.stem: path for path in sorted(examples_folder().glob("*/*.toml"))}


def data_of(name: str) -> dict[str, Any]:
    return json.loads(json.dumps(to_data(load_model(FILES[name]))))


def changed(data: dict[str, Any]) -> dict[str, Any]:
    """Return data whose parameters of a plain value are a little larger."""
    grown = {name: _grown(value) for name, value in data.get("parameters", {}).items()}
    return {**data, "parameters": grown}


def _grown(value: str) -> str:
    try:
        return repr(1.004 * float(value))
    except ValueError:
        return value


def report(stage: str, percent: int | None) -> None:
    """Take no notice."""


def ask(task: Any, data: dict[str, Any], where: str) -> Any:
    return task({"data": data, "folder": where}, report)


def numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        return [number for key in sorted(value) for number in numbers(value[key])]
    if isinstance(value, list):
        return [number for each in value for number in numbers(each)]
    return [float(value)] if isinstance(value, int | float) else []


@pytest.mark.parametrize("name", cases(FILES, fast=lambda name: name != "stewart_platform"))
def test_it_shows_what_the_check_shows(name: str) -> None:
    data = data_of(name)
    ask(redraw_model, data, str(FILES[name].parent))
    before = mechanisms.formed_count()
    quick = ask(redraw_model, changed(data), str(FILES[name].parent))
    assert mechanisms.formed_count() == before
    full = ask(check_model, changed(data), str(FILES[name].parent))
    if not any(each["severity"] == "error" for each in full["problems"]):
        assert quick["picture"] is not None
    if quick["picture"] is None:
        return
    assert quick["values"] == pytest.approx(full["values"], rel=1e-9, abs=1e-9)
    scenes = [each["picture"]["scene"] for each in (quick, full)]
    size = scenes[1]["size"]
    assert np.allclose(numbers(scenes[0]), numbers(scenes[1]), rtol=1e-5, atol=1e-6 * size)
    assert [body["name"] for body in scenes[0]["bodies"]] == [body["name"] for body in scenes[1]["bodies"]]


@pytest.mark.parametrize(
    "name", cases(["slider_crank", "four_bar", "bicycle", "stewart_platform"], fast=["four_bar", "bicycle"])
)
def test_a_check_of_other_values_forms_nothing_and_says_the_same(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, where = data_of(name), str(FILES[name].parent)
    ask(check_model, data, where)
    before = mechanisms.formed_count()
    quick = ask(check_model, changed(data), where)
    assert mechanisms.formed_count() == before
    for module, caches in ((mechanisms, ("_MECHANISMS", "_SOLVERS")), (check, ("_CHECKS",))):
        for each in caches:
            monkeypatch.setattr(module, each, Latest(4))
    anew = ask(check_model, changed(data), where)
    assert mechanisms.formed_count() == 1
    assert quick["problems"] == anew["problems"] and quick["summary"] == anew["summary"]
    assert quick["formulas"] == anew["formulas"]
    assert quick["values"] == pytest.approx(anew["values"], rel=1e-9, abs=1e-9)
    assert quick["picture"]["scene"] == anew["picture"]["scene"]


def test_what_cannot_be_drawn_at_once_is_left_to_the_check() -> None:
    data = data_of("slider_crank")
    where = str(FILES["slider_crank"].parent)
    assert ask(redraw_model, data, where)["picture"] is not None
    for value in ("", "L1 +", "theta", "L9", "-1e400", "L1"):
        wrong = {**data, "parameters": {**data["parameters"], "L1": value}}
        assert ask(redraw_model, wrong, where)["picture"] is None, value
    assert ask(redraw_model, {**data, "body": data["body"][:-1]}, where)["picture"] is None
