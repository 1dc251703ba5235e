"""Pages that simulate themselves, in Chromium: sliders, pulled bodies, pause; each without a complaint."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.browser.conftest import Surfer, accessibility_faults, wait_until

EXAMPLES = Path(__file__).parents[2] / "examples"
MOST_BYTES = 1_500_000
SLIDERS = {"m2": (0.5, 3), "L2": (0.1, 2), "F": (-50, 50), "theta": (-3, 3)}


@cache
def equations(name: str) -> sb.EquationSet:
    path = EXAMPLES / name / f"{name}.toml"
    return sb.form_equations(
        sb.load_model(path) if path.exists() else sb.load_urdf(path.with_suffix(".urdf"))
    )


def open_live(surfer: Surfer, tmp_path: Path, name: str, sliders: Any, **options: Any) -> Any:
    """Return an open page of an example."""
    path = tmp_path / "live.html"
    sb.animate(equations(name), path, live=True, sliders=sliders)
    assert path.stat().st_size < MOST_BYTES
    page = surfer.new_page((1200, 720), **options)
    page.goto(path.as_uri())
    wait_until(page, "window.symbodyLive !== undefined && symbodyLive.simulation.time > 0.05")
    return page


def move(page: Any, name: str, value: float) -> None:
    page.get_by_role("slider", name=name, exact=True).evaluate(
        "(each, value) => { each.value = value; each.dispatchEvent(new Event('input')); }", value
    )


def state(page: Any) -> list[float]:
    return page.evaluate("Array.from(symbodyLive.simulation.state)")


def test_a_cam_whose_follower_lifts_off_loads_and_runs(surfer: Surfer, tmp_path: Path) -> None:
    """The page computes 8 s before it shows the first picture, with some hundred strikes: see `test_consumers`."""
    path = EXAMPLES / "gallery" / "contacts" / "cam_lift_off.toml"
    sb.animate(sb.form_equations(sb.load_model(path)), tmp_path / "cam.html", live=True)
    page = surfer.new_page((1200, 720))
    page.goto((tmp_path / "cam.html").as_uri())
    wait_until(page, "window.symbodyLive !== undefined && symbodyLive.simulation.time > 0.05")
    page.get_by_role("button", name="Pause").click()
    page.evaluate("symbodyLive.simulation.advanceTo(4)")
    run = sb.simulate(sb.form_equations(sb.load_model(path)), 4.0, times=[0, 4])
    assert page.evaluate("symbodyLive.simulation.time") == 4
    assert state(page)[1] == pytest.approx(run["y"][-1], abs=1e-4)


def test_a_page_runs_pauses_steps_and_starts_anew(surfer: Surfer, tmp_path: Path) -> None:
    page = open_live(surfer, tmp_path, "slider_crank", SLIDERS)
    page.get_by_role("button", name="Pause").click()
    before = page.evaluate("symbodyLive.simulation.time")
    page.get_by_role("button", name="Step").click()
    assert page.evaluate("symbodyLive.simulation.time") == pytest.approx(before + 1 / 60)
    page.get_by_role("button", name="Reset").click()
    assert page.evaluate("symbodyLive.simulation.time") == 0
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until(page, "symbodyLive.simulation.time > 0.05")
    eqs = equations("slider_crank")
    assert page.locator(".sb-formulas .sb-equation").count() == len(eqs.speed_names) + len(
        eqs.multiplier_names
    )
    assert "J" in page.locator(".sb-readings").inner_text()


def test_forces_of_contacts_are_arrows_with_footprints_that_a_switch_hides(
    surfer: Surfer, tmp_path: Path
) -> None:
    """A wheel that rolls bears its weight where it touches: the page computes so, and draws so."""
    wheel = sb.Body("Wheel", mass=5, inertia=(0.05, 0.1, 0.05))
    normal, friction = sb.NormalForce(stiffness=1e5, dissipation=0.5), sb.Friction(mu=0.8, v0=1e-2)
    road = sb.Contact("road", "ground", wheel, ["plane", {"sphere": 0.2}], normal=normal, friction=friction)
    plane = sb.Planar("move", "ground", wheel, axis="y", coordinates=["z", "x", "turn"])
    eqs = sb.form_equations(sb.Model("wheel", [plane, road], gravity=(0, 0, -9.81)))
    depth = (5 * 9.81 / 1e5) ** (2 / 3)
    start = {"z": 0.2 - depth, "x_dot": 1.0, "turn_dot": 5.0}
    sb.animate(eqs, tmp_path / "live.html", live=True, initial=start)
    page = surfer.new_page((1200, 720))
    page.goto((tmp_path / "live.html").as_uri())
    wait_until(page, "window.symbodyLive !== undefined && symbodyLive.simulation.time > 0.5")
    page.keyboard.press(" ")
    (x,) = page.evaluate("[symbodyLive.simulation.state[4]]")
    source = "const [s, a] = [symbodyLive.player.viewer.source, new Float64Array(3)]"
    force, place = (
        page.evaluate(f"(() => {{ {source}; s.{each}(0, 0, a); return Array.from(a); }})()")
        for each in ("vectorAt", "placeAt")
    )
    assert force == pytest.approx((0, 0, 5 * 9.81), abs=0.1)
    assert place == pytest.approx((x, 0, -depth / 2), abs=1e-4)
    viewer = "symbodyLive.player.viewer.contents"
    assert page.evaluate(f"{viewer}.footprints.object.count") > 3
    page.get_by_role("button", name="Display options").click()
    for name, hidden in (("Contacts", f"{viewer}.arrows.tip(0) === null"),
                         ("Footprints", f"!{viewer}.footprints.object.visible")):  # fmt: skip
        page.get_by_role("checkbox", name=name).uncheck()
        wait_until(page, hidden)


@pytest.mark.exhaustive
def test_axe_finds_nothing(surfer: Surfer, tmp_path: Path) -> None:
    page = open_live(surfer, tmp_path, "slider_crank", SLIDERS)
    page.keyboard.press(" ")
    for width, height in ((1440, 900), (1024, 768), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.wait_for_selector(f".sb-bench[data-theme={scheme}]")
            assert accessibility_faults(page) == [], (width, scheme)


@pytest.mark.exhaustive
def test_sliders_move_what_they_name(surfer: Surfer, tmp_path: Path) -> None:
    page = open_live(surfer, tmp_path, "slider_crank", SLIDERS)
    page.keyboard.press(" ")
    move(page, "F", 20)
    move(page, "m2", 2)
    assert page.evaluate("symbodyLive.simulation.input('F')") == pytest.approx(20, abs=0.2)
    move(page, "theta", 1)
    assert page.evaluate("symbodyLive.simulation.time") == 0
    assert state(page)[3] == pytest.approx(1, abs=0.02)
    before = page.evaluate("symbodyLive.player.viewer.scene.bodies[2].frames.map((each) => each.at[0])")
    move(page, "L2", 1.5)
    after = page.evaluate("symbodyLive.player.viewer.scene.bodies[2].frames.map((each) => each.at[0])")
    assert before != after and max(after) == pytest.approx(0.75, abs=0.01)


@pytest.mark.exhaustive
def test_an_input_begins_at_its_number(surfer: Surfer, tmp_path: Path) -> None:
    path = tmp_path / "live.html"
    eqs = equations("slider_crank")
    sb.animate(eqs, path, live=True, sliders={"F": (-50, 50)}, inputs={"F": 12})
    page = surfer.new_page((1200, 720))
    page.goto(path.as_uri())
    wait_until(page, "window.symbodyLive !== undefined && symbodyLive.simulation.time > 0.2")
    page.keyboard.press(" ")
    assert page.evaluate("symbodyLive.simulation.input('F')") == 12
    time = page.evaluate("symbodyLive.simulation.time")
    run = sb.simulate(eqs, time, inputs={"F": 12})
    now = [float(run[name][-1]) for name in eqs.state_names]
    assert state(page)[: len(now)] == pytest.approx(now, abs=1e-5)
    page.get_by_role("button", name="Reset").click()
    assert page.evaluate("symbodyLive.simulation.input('F')") == 12


@pytest.mark.exhaustive
def test_a_slider_that_cannot_assemble_says_so_and_keeps_the_state(surfer: Surfer, tmp_path: Path) -> None:
    page = open_live(surfer, tmp_path, "slider_crank", SLIDERS)
    page.keyboard.press(" ")
    move(page, "theta", 1.5)
    before = state(page)
    move(page, "L2", 0.1)
    assert "cannot be assembled with L2 = 0.1" in page.locator(".sb-note").inner_text()
    assert state(page) == before and page.locator('input[aria-invalid="true"]').count() == 1
    move(page, "L2", 1.2)
    assert page.locator(".sb-note").is_hidden() and page.locator('input[aria-invalid="true"]').count() == 0


@pytest.mark.exhaustive
def test_a_body_is_pulled_with_the_mouse(surfer: Surfer, tmp_path: Path) -> None:
    page = open_live(surfer, tmp_path, "slider_crank", {"theta_dot": (-6, 6)})
    page.keyboard.press(" ")
    move(page, "theta_dot", 0)
    x, y = page.evaluate(
        "(() => { const p = symbodyLive.simulation.computePose().positions; "
        "return symbodyLive.player.viewer.pagePlace([p[6], p[7], p[8]]); })()"
    )
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60, y, steps=4)
    assert page.evaluate("symbodyLive.simulation.isPulled") is True
    before = page.evaluate("symbodyLive.simulation.time")
    wait_until(page, f"symbodyLive.simulation.time > {before + 0.5}")
    assert page.locator(".sb-thread").evaluate("each => each.style.visibility") == "visible"
    page.mouse.up()
    assert page.evaluate("symbodyLive.simulation.isPulled") is False
    assert abs(page.evaluate("symbodyLive.simulation.energies().work")) > 1e-3


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["spinning_top", "four_bar", "bicycle", "robot_arm"])
def test_other_mechanisms_run(name: str, surfer: Surfer, tmp_path: Path) -> None:
    names = [*equations(name).input_names[:2], *equations(name).coordinate_names[:2]]
    page = open_live(surfer, tmp_path, name, names, color_scheme="dark")
    wait_until(page, "symbodyLive.simulation.time > 0.3")
    assert np.isfinite(state(page)).all()
    assert page.evaluate("symbodyLive.simulation.violation()") < 1e-6
