"""Pages: what they hold, what names cannot do to them, files, browsers, notebooks; a browser opens them elsewhere."""

from __future__ import annotations

import base64
import html
import json
import re
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.errors import EnvironmentFault, SymbodyError, UsageError
from symbody.visual.viewer import animation as animation_module
from symbody.visual.viewer import built_files
from symbody.visual.viewer import page as page_module
from symbody.visual.viewer.animation import LiveAnimation
from tests.mechanisms import example

EXAMPLES = Path(__file__).parents[2] / "examples"
TEMPLATE = (
    "<!doctype html><html><head><title>symbody</title></head><body>"
    '<script type="application/json" id="symbody-data">null</script><script>/* the player */</script></body></html>'
)


@pytest.fixture(autouse=True)
def pages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages of the size of a test: those that are built are opened in a browser by other tests."""
    monkeypatch.setattr(
        page_module, "built_file", {"player.html": TEMPLATE, "widget.js": "export default {};"}.__getitem__
    )
    for module in (page_module, sys.modules.get("symbody.visual.viewer.notebook_widget")):
        if module is not None:
            monkeypatch.setattr(module, "built_file", page_module.built_file)


@cache
def four_bar() -> sb.Trajectory:
    return sb.simulate(example("four_bar"), 0.5)


def content(text: str) -> Any:
    """The data of a page, as a browser reads them."""
    scripts = re.findall(r"<script[^>]*>(.*?)</script>", text, flags=re.S)
    assert len(scripts) == 2 and scripts[1] == "/* the player */"
    return json.loads(scripts[0])


def decoded(text: str, kind: str, *shape: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind).reshape(shape)


def test_the_page_holds_the_poses(tmp_path: Path) -> None:
    run, path = four_bar(), tmp_path / "motion.html"
    shown = sb.animate(run, path, vectors="all", traces=["Coupler.P", "Rocker"], title="Crank & rocker")
    data = content(path.read_text(encoding="utf-8"))
    times = decoded(data["motion"]["times"], "<f8", -1)
    np.testing.assert_array_equal(times, shown.motion.times)
    names = [body["name"] for body in data["scene"]["bodies"]]
    assert names == ["ground", "Crank", "Coupler", "Rocker"]
    positions = decoded(data["motion"]["positions"], "<f4", times.size, 3, 3)
    for k, name in enumerate(names[1:]):
        np.testing.assert_allclose(positions[:, k].T, run.at(times)[f"frame r {name}"], rtol=1e-6, atol=1e-7)
    quaternions = decoded(data["motion"]["quaternions"], "<f4", times.size, 3, 4)
    np.testing.assert_allclose(quaternions, shown.motion.quaternions, rtol=0.0, atol=1e-7)
    assert [curve["name"] for curve in data["motion"]["curves"]] == ["theta", "beta", "phi"]
    assert {vector["name"] for vector in data["motion"]["vectors"]} == {
        f"reaction {joint}" for joint in "ABCD"
    }
    assert data["title"] == "Crank & rocker"
    assert data["options"] == {
        "view": "auto",
        "theme": "auto",
        "speed": 1.0,
        "traces": ["Coupler.P", "Rocker.CoM"],
    }
    assert "<title>Crank &amp; rocker</title>" in path.read_text(encoding="utf-8")
    assert repr(shown) == f"<Animation 'Crank & rocker': t = 0 to 0.5 s, {times.size} samples>"


HOSTILE = (
    "</script><script>alert(1)</script>",
    "<!--<script>",
    '"; alert(1); "',
    "\u2028 \\u003c \N{GREEK SMALL LETTER PHI}",
    "%s {0} $1 \\1",
)


@pytest.mark.parametrize("name", HOSTILE)
def test_names_cannot_leave_their_place(name: str, tmp_path: Path) -> None:
    rod = sb.Body("Rod", mass=1, inertia=(1, 1, 1))
    model = sb.Model(name, [rod, sb.Revolute("hinge", "ground", rod, axis="z", coordinate="phi")])
    run = sb.simulate(sb.form_equations(model), 0.1, initial={"phi_dot": 1})
    sb.animate(run, tmp_path / "page.html", title=name)
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    data = content(text)
    assert data["scene"]["name"] == data["title"] == name
    assert re.search(r"<title>(.*?)</title>", text, flags=re.S)[1] == html.escape(name)  # type: ignore[index]
    frame = sb.animate(run, tmp_path / "page.html")._repr_html_()
    assert frame.count("<") == frame.count(">") == 2  # one element, whatever it holds


def test_a_state_is_a_still_picture(tmp_path: Path) -> None:
    state = sb.assemble(example("four_bar"), {"theta": 1.0})
    shown = sb.animate(state, tmp_path / "still.html", vectors="all")
    assert shown.motion.times.tolist() == [0.0]
    np.testing.assert_allclose(shown.motion.positions[0, 1], state["frame r Coupler"], atol=1e-12)


def test_motions_from_files_are_shown(tmp_path: Path) -> None:
    run = four_bar()
    run.save(tmp_path / "run")
    shown = sb.animate(sb.Trajectory.load(tmp_path / "run"), tmp_path / "a.html")
    np.testing.assert_array_equal(
        shown.motion.positions, sb.animate(run, tmp_path / "b.html").motion.positions
    )
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_cases_of_sweeps_are_shown(tmp_path: Path) -> None:
    sweep = sb.sweep(example("four_bar"), 0.2, times=np.linspace(0.0, 0.2, 9), parameters={"L1": [0.1, 0.2]})
    shown = sb.animate(sweep.trajectory(0), tmp_path / "case.html")
    crank = shown.scene.bodies[1]
    assert {frame.name: frame.at[0] for frame in crank.frames}["B"] == 0.05  # half of the case's own length
    with pytest.raises(UsageError, match=r"sweep.trajectory\(3\)"):
        sb.animate(sweep, tmp_path / "no.html")  # type: ignore[arg-type]


REFUSED: dict[str, tuple[dict[str, Any], str, str]] = {
    "film": ({"path": "run.mp4"}, "animation.suffix", "save_animation"),
    "trace": ({"traces": ["Coupler.Q"]}, "animation.unknown_point", "Coupler.P"),
    "vector": ({"vectors": "Z"}, "animation.unknown_vector", '"all"'),
    "curve": ({"curves": ["psi"]}, "equations.unknown_output", "phi"),
    "outside": ({"times": (0.4, 0.9)}, "animation.times", "0 to 0.5"),
    "turned round": ({"times": (0.4, 0.1)}, "animation.times", "not part"),
    "no times": ({"times": []}, "animation.times", "linspace"),
    "words": ({"times": ["soon"]}, "animation.times", "linspace"),
    "endless": ({"times": [0.0, np.inf, 1.0]}, "animation.times", "linspace"),
    "view": ({"view": "above"}, "animation.option", "isometric"),
    "theme": ({"theme": "blue"}, "animation.option", "dark"),
    "speed": ({"speed": 0.0}, "animation.option", "> 0"),
    "model": (
        {"model": sb.load_model(EXAMPLES / "rr_robot" / "rr_robot.toml")},
        "trajectory.another_model",
        "no joint",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_makes_no_picture_is_refused(case: str, tmp_path: Path) -> None:
    words, code, text = REFUSED[case]
    with pytest.raises(SymbodyError, match=re.escape(text)) as caught:
        sb.animate(four_bar(), **{"path": tmp_path / "page.html", **words})
    assert caught.value.problems[0].code == code
    assert list(tmp_path.iterdir()) == []


def test_motions_without_model_or_samples_are_refused(tmp_path: Path) -> None:
    run = four_bar()
    with pytest.raises(UsageError, match="model=") as caught:
        sb.animate(replace(run, provenance=None), tmp_path / "page.html")
    assert caught.value.problems[0].code == "animation.no_model"
    shown = sb.animate(replace(run, provenance=None, evaluate=None), tmp_path / "page.html", model=run.model)
    np.testing.assert_allclose(
        shown.motion.positions, sb.animate(run, tmp_path / "page.html").motion.positions
    )
    none = replace(run, t=run.t[:0], q=run.q[:, :0], u=run.u[:, :0], stored={}, dense_output=None)
    with pytest.raises(UsageError, match="no samples"):
        sb.animate(none, tmp_path / "page.html")


def test_a_page_that_cannot_be_written_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "folder.html").mkdir()
    for path in (tmp_path / "no" / "page.html", tmp_path / "folder.html", tmp_path / "a\0b.html"):
        with pytest.raises(EnvironmentFault) as caught:
            sb.animate(four_bar(), path)
        assert caught.value.problems[0].code == "animation.unwritable"
    page = tmp_path / "page.html"
    page.write_text("before")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(EnvironmentFault, match="No space.*\n.*\n.*free some space"):
        sb.animate(four_bar(), page)
    assert page.read_text() == "before" and sorted(tmp_path.iterdir()) == sorted(
        [tmp_path / "folder.html", page]
    )


def test_an_installation_without_pages_says_how_to_get_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    folder = tmp_path / "no pages"
    folder.mkdir()
    monkeypatch.setattr(
        built_files, "_FOLDER", str(folder)
    )  # an absolute path takes the place of the package
    with pytest.raises(EnvironmentFault, match="not include the pages(.|\n)*Node 20") as caught:
        sb.animate(four_bar(), tmp_path / "page.html")
    assert caught.value.problems[0].code == "animation.no_pages"
    assert "during" not in caught.value.problems[0].why
    (folder / "missing.txt").write_text("npm ci failed: the registry is away\n")
    with pytest.raises(
        EnvironmentFault, match="during this installation: npm ci failed: the registry is away"
    ):
        sb.animate(four_bar(), tmp_path / "page.html")
    assert list(tmp_path.iterdir()) == [folder]


def test_without_a_path_the_browser_opens(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: not opened.append(url))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    sb.animate(four_bar())
    (file,) = tmp_path.iterdir()
    assert opened == [file.as_uri()]
    assert content(file.read_text(encoding="utf-8"))["title"] == "four-bar"
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    sb.animate(four_bar())  # on a machine without a display a script goes on
    (path,) = {*tmp_path.iterdir()} - {file}
    assert capsys.readouterr().out == f"no browser opened; the page is {path}\n"


def test_in_a_notebook_nothing_opens_and_the_picture_is_a_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    shell = SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setattr("webbrowser.open", lambda url: pytest.fail("a browser opened"))
    shown = sb.animate(four_bar())
    frame = shown._repr_html_()
    source = re.fullmatch(
        r'<iframe srcdoc="(.*)" title="four-bar" sandbox="allow-scripts" .*></iframe>', frame, flags=re.S
    )
    assert source is not None and html.unescape(source[1]) == shown.html


class TestLive:
    """With anywidget: time and sliders."""

    @pytest.fixture(autouse=True)
    def needs_anywidget(self) -> None:
        pytest.importorskip("anywidget")

    def test_time_is_shared(self) -> None:
        view = sb.animate(four_bar(), live=True)
        assert isinstance(view, LiveAnimation)
        seen: list[float] = []
        view.observe(lambda change: seen.append(change["new"]))
        view.seek(0.25)
        assert (view.time, seen, view.state) == (0.25, [0.25], None)
        assert "application/vnd.jupyter.widget-view+json" in json.dumps(view._repr_mimebundle_())

    def test_sliders_move_coordinates(self) -> None:
        view = sb.animate(example("four_bar"), live=True, sliders=["theta", ("phi", 1, 3), "L2"])
        theta, phi, length = view.widget.sliders
        assert (theta["name"], theta["unit"], phi["min"], phi["max"]) == ("theta", "rad", 1.0, 3.0)
        assert (length["min"], length["value"], length["max"]) == (0.25, 0.5, 0.75)
        view.widget.slider_values = {**view.widget.slider_values, "theta": 1.4}  # phi follows
        assert view.state["theta"] == 1.4 and view.state.residual < 1e-9
        np.testing.assert_allclose(
            view.widget.pose["positions"][1], view.state["frame r Coupler"], atol=1e-12
        )
        view.widget.slider_values = {**view.widget.slider_values, "phi": 2.0}
        assert view.state["phi"] == 2.0

    def test_sliders_move_parameters_and_shapes_follow(self) -> None:
        view = sb.animate(example("four_bar"), live=True, sliders=["L2"])
        before = view.widget.data["scene"]
        view.widget.slider_values = {"L2": 0.55}
        assert view.widget.data["scene"] != before
        assert view.state["L2"] == 0.55 and view.state.residual < 1e-9
        np.testing.assert_allclose(
            view.widget.pose["positions"][1], view.state["frame r Coupler"], atol=1e-12
        )

    def test_out_of_reach_the_picture_stays(self) -> None:
        view = sb.animate(example("four_bar"), live=True, sliders=[("L2", 0.1, 5)])
        before = view.state
        view.widget.slider_values = {"L2": 4.0}
        assert view.state is before and "assembly.open" in view.widget.message
        view.widget.slider_values = {"L2": 0.5}
        assert view.widget.message == ""

    def test_what_makes_no_slider_is_refused(self) -> None:
        cases: list[tuple[dict[str, Any], str]] = [
            ({"sliders": ["thete"]}, "animation.unknown_slider"), ({"sliders": ["energy"]}, "animation.unknown_slider"),
            ({"sliders": [("theta", 2, 1)]}, "animation.slider"),
        ]  # fmt: skip
        for words, code in cases:
            with pytest.raises(UsageError) as caught:
                sb.animate(example("four_bar"), **words)
            assert caught.value.problems[0].code == code


def test_without_anywidget_live_pictures_say_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(animation_module, "import_module", missing)
    with pytest.raises(EnvironmentFault, match=r"symbody\[notebook\]") as caught:
        sb.animate(four_bar(), live=True)
    assert caught.value.problems[0].code == "animation.no_anywidget"
