"""What a page that simulates itself holds, and what it refuses."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pytest

import symbody as sb
import symbody.visual.viewer.page as page_module
from symbody.errors import UsageError
from symbody.visual.viewer.live_page import LivePage
from tests.equations.test_dependent_speeds import skate
from tests.faults.test_constraint_rows import parallelogram

TEMPLATE = (
    "<!doctype html><html><head><meta content=\"script-src 'sha256-program'\"><title>symbody</title></head><body>"
    '<script type="application/json" id="symbody-data">null</script>'
    '<template id="symbody-formulas"></template><script id="symbody-program">0</script></body></html>'
)
EVIL = "</script><script>alert(1)</script>"


@pytest.fixture(autouse=True)
def pages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_module, "built_file", {"live.html": TEMPLATE}.__getitem__)


def oscillator(name: str = "oscillator") -> sb.EquationSet:
    slide = sb.Prismatic("slide", "ground", sb.Body("Block", mass="m", frames={EVIL: sb.Frame(at=("L", 0, 0))}),
                         coordinate="x", force=sb.Drive(applied="F", stiffness="k"))  # fmt: skip
    return sb.form_equations(
        sb.Model(name, [slide], parameters={"m": 2, "k": 8, "L": 0.5}, inputs=["F"], initial={"x": 0.3})
    )


def written(path: Path, **words: Any) -> tuple[LivePage, str]:
    view = sb.animate(oscillator(EVIL), path, live=True, **words)
    assert isinstance(view, LivePage)
    return view, path.read_text(encoding="utf-8")


def test_names_that_look_like_elements_are_inert(tmp_path: Path) -> None:
    _, text = written(tmp_path / "a.html", sliders={"m": (1, 3)})
    assert text.count("<script") == 2 and text.count("</script") == 2 and "alert(1)</" not in text


def test_the_policy_names_the_program_and_nothing_is_evaluated(tmp_path: Path) -> None:
    view, text = written(tmp_path / "a.html")
    program = re.findall(r'<script id="symbody-program">(.*?)</script>', text, flags=re.S)[0]
    digest = base64.b64encode(hashlib.sha256(program.encode()).digest()).decode()
    assert f"'sha256-{digest}'" in text and "sha256-program" not in text
    assert program == view.program.script and "eval(" not in program and "Function(" not in program


def test_sliders_say_what_they_move(tmp_path: Path) -> None:
    view, _ = written(
        tmp_path / "a.html", sliders={"m": (1, 3), "F": (-5, 5), "x": None, "x_dot": (-1, 1), "L": None}
    )
    controls = {control["name"]: control for control in view.data["live"]["controls"]}
    assert [control["kind"] for control in controls.values()] == [
        "parameter",
        "input",
        "initial",
        "initial",
        "parameter",
    ]
    assert (controls["m"]["min"], controls["m"]["max"], controls["m"]["value"]) == (1, 3, 2)
    assert controls["x"]["value"] == 0.3 and controls["F"]["value"] == 0
    assert json.dumps(view.data)
    tables = view.data["live"]["tables"]
    assert [table["parameter"] for table in tables] == ["L"] and tables[0]["entries"]


def test_a_slider_of_an_input_begins_at_its_number(tmp_path: Path) -> None:
    view, _ = written(tmp_path / "a.html", sliders={"F": None}, inputs={"F": "2.5"})
    (control,) = view.data["live"]["controls"]
    assert (control["min"], control["value"], control["max"]) == (0.0, 2.5, 5.0)
    for law in ("3*sin(t)", lambda t, q, u: 1.0, sb.Table([0, 1], [0, 1])):
        assert refused(oscillator(), sliders={"F": (-5, 5)}, inputs={"F": law}) == "animation.slider_law"


@pytest.mark.parametrize(
    ("sliders", "code"),
    [
        ({"y": (0, 1)}, "animation.unknown_slider"),
        ({"m": (3, 1)}, "animation.slider"),
        ({"m": (3, 4)}, "animation.slider_start"),
    ],
)
def test_sliders_that_mean_nothing_are_refused(sliders: Any, code: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError) as caught:
        sb.animate(oscillator(), tmp_path / "a.html", live=True, sliders=sliders)
    assert caught.value.problems[0].code == code and not list(tmp_path.iterdir())


def test_words_of_a_page_need_a_path() -> None:
    with pytest.raises(UsageError) as caught:
        sb.animate(oscillator(), live=True, sliders=["x"], inputs={"F": "1"})
    assert caught.value.problems[0].code == "animation.live_widget"


def refused(eqs: sb.EquationSet, **words: Any) -> str:
    with pytest.raises(UsageError) as caught:
        sb.animate(eqs, live=True, path="never.html", **words)
    (problem,) = caught.value.problems
    assert problem.fix and not Path("never.html").exists()
    return problem.code


def test_motions_that_only_python_keeps_on_their_branch_are_refused() -> None:
    """Flat at the start, flat on the way, and with speeds that end at a vanishing pivot."""
    flat = {"initial": {"a": 0.0, "a_dot": 6.0, "d_dot": 6.0}}
    assert refused(parallelogram(), **flat) == "animation.live_branch"
    assert refused(parallelogram(), initial={"a": 1.0, "a_dot": 6.0, "d": 1.0}) == "animation.live_branch"
    assert refused(sb.form_equations(skate(), dependent_speeds=("y_dot",))) == "animation.live_pivots"
    with_partition = {"constraints": sb.Partition(), "initial": {"a": 1.0}}
    assert refused(parallelogram(), **with_partition) == "animation.live_constraints"
