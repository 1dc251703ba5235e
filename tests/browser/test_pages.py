"""Pages that `animate` writes, in Chromium: they open without a complaint and show what the run says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.formats.model_files import load_model
from tests.browser.conftest import PAGES, Surfer, wait_until
from tests.browser.test_player import changed, pixels
from tests.mechanisms import example

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = sorted([*EXAMPLES.glob("*/*.toml"), *EXAMPLES.glob("*/*.urdf"), *EXAMPLES.glob("notes/*/*.toml")])
MOST_BYTES = 1_000_000  # of a page without its data


def open_file(surfer: Surfer, path: Path) -> Any:
    page = surfer.new_page((900, 560))
    page.goto(path.as_uri())
    wait_until(page, "window.symbodyPlayer !== undefined")
    return page


def moving(path: Path, end: float = 2.0) -> sb.Trajectory:
    model = load_model(path)
    return sb.simulate(
        sb.form_equations(model), end, parameters={n: 1 for n, v in model.parameters.items() if v is None}
    )


def test_the_four_bar_moves_as_computed(surfer: Surfer) -> None:
    run = moving(EXAMPLES / "four_bar" / "four_bar.toml")
    path = surfer.folder / "four_bar.html"
    shown = sb.animate(run, path, vectors="all", traces=["Coupler.P"])
    assert (PAGES / "player.html").stat().st_size < MOST_BYTES
    page = open_file(surfer, path)
    assert page.title() == "four-bar"
    page.evaluate("symbodyPlayer.setPlaying(false)")
    assert changed(pixels(page, 0.1), pixels(page, 0.3)) > 400
    for t in (0.0, 0.7, 2.0):
        page.evaluate("t => symbodyPlayer.setTime(t)", t)
        for k, body in enumerate(shown.scene.bodies[1:], start=1):
            script = "k => symbodyPlayer.viewer.bodyPosition(k, symbodyPlayer.viewer.rig.camera.position.clone()).toArray()"
            where = page.evaluate(script, k)
            np.testing.assert_allclose(
                where, run.at(t)[f"frame r {body.name}"], atol=1.1e-3 * shown.scene.size
            )


@pytest.mark.parametrize(
    "name", ["</script><script>throw 1</script>", "<!--<script>", '"quoted" & \N{GREEK SMALL LETTER PHI}']
)
def test_hostile_names_stay_names(surfer: Surfer, name: str) -> None:
    rod = sb.Body("Rod", mass=1, inertia=(1, 1, 1), frames={"pin": sb.Frame(at=(-1, 0, 0))})
    model = sb.Model(name, [rod, sb.Revolute("hinge", "ground", rod["pin"], axis="z", coordinate="phi")])
    run = sb.simulate(sb.form_equations(model), 0.5, initial={"phi_dot": 1})
    sb.animate(run, surfer.folder / "page.html")
    assert open_file(surfer, surfer.folder / "page.html").title() == name


@pytest.mark.exhaustive
def test_frames_of_notebooks_are_closed_and_work(surfer: Surfer) -> None:
    run = moving(EXAMPLES / "spring_mass_damper" / "spring_mass_damper.toml")
    shown = sb.animate(run, surfer.folder / "page.html")
    path = surfer.write("notebook.html", f"<!doctype html><body>{shown._repr_html_()}</body>")
    page = surfer.new_page((900, 600))
    page.goto(path.as_uri())
    frame = page.frames[-1]
    frame.wait_for_selector("canvas")
    assert frame.evaluate("document.title") == "spring-mass-damper"
    assert frame.evaluate("window.origin") == "null"  # what it runs reaches nothing of the notebook


@pytest.mark.exhaustive
@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_example_opens(surfer: Surfer, path: Path) -> None:
    run = moving(path)
    sb.animate(run, surfer.folder / "page.html", vectors="all")
    page = open_file(surfer, surfer.folder / "page.html")
    page.evaluate("symbodyPlayer.setPlaying(false)")
    first = pixels(page, float(run.t[0]))
    assert len(np.unique(first.reshape(-1, 4), axis=0)) > 50
    moved = float(np.abs(np.diff(run.q, axis=1)).sum())
    assert moved < 1e-6 or changed(first, pixels(page, float(run.t[-1]) * 0.4)) > 0


@pytest.mark.exhaustive
def test_a_report_fits_a_phone_and_has_its_numbers_in_one_column(surfer: Surfer, tmp_path: Path) -> None:
    sb.save_report(example("four_bar"), tmp_path / "report.html")
    page = surfer.new_page((390, 844))
    page.goto((tmp_path / "report.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.set_viewport_size({"width": 1440, "height": 900})
    ends = page.evaluate(
        "[...document.querySelectorAll('.sb-equation')].filter(e => e.closest('details') === null)"
        ".map(e => Math.round(e.getBoundingClientRect().right))"
    )
    assert len(ends) > 20 and len(set(ends)) == 1
