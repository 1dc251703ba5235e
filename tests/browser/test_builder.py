"""The builder's page in a browser: examples, gestures, messages, files, and what assistive programs find."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.formats.model_files import examples_folder

from .builder_keys import choose, type_frames, type_rows
from .builder_page import BuilderPage, overlaps
from .conftest import accessibility_faults

HARMLESS = ("GPU stall", "GroupMarkerNotSet")


@pytest.mark.exhaustive
def test_every_example_opens_without_overlap(visit: Any) -> None:
    builder = visit()
    cards = builder.page.locator(".card")
    cards.first.wait_for()
    names = [str(each.get_attribute("data-testid")).removeprefix("example-") for each in cards.all()]
    assert len(names) >= 5
    for name in names:
        builder.open_example(name)
        assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
        assert overlaps(builder.page, ".body-node") == [], name
        assert overlaps(builder.page, ".edge-badge") == [], name
        assert builder.state("check.picture") is not None
        builder.page.get_by_role("button", name="Files").or_(builder.page.locator(".brand")).first.click()
        builder.page.get_by_role("menuitem", name="Examples and recent files").click()


def crank_of_example(times: list[float], name: str) -> Any:
    model = sb.load_model(examples_folder() / "slider_crank" / "slider_crank.toml")
    motion = sb.simulate(sb.form_equations(model), times[-1], times=np.array(times))
    return motion[name]


def assert_same_motion(builder: BuilderPage) -> None:
    times, values = builder.curve("s")
    assert np.max(np.abs(np.array(values) - crank_of_example(times, "s"))) < 1e-6
    assert builder.state("check.summary.freedoms") == 1


PARAMETERS = {
    "m1": "1.0", "m2": "1.5", "m3": "0.8", "I1": "0.02", "I2": "0.15", "L1": "0.4", "L2": "1.0", "G": "9.81",
}  # fmt: skip
INITIAL = {"theta": "30 deg", "beta": "-12 deg", "s": "1.3", "theta_dot": "5.0"}
BODIES = {
    "Crank": ("m1", "I1", {"A": "-L1/2", "B": "L1/2"}),
    "Rod": ("m2", "I2", {"B": "-L2/2", "C": "L2/2"}),
    "Piston": ("m3", "", {}),
}
PLACES = {"Crank": (330, 50), "Rod": (560, 130), "Piston": (330, 270)}


@pytest.mark.exhaustive  # a ring of links is built with the mouse in the fast tier
def test_a_slider_crank_is_built_with_the_mouse(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.new()
    for number, (name, (mass, inertia, frames)) in enumerate(BODIES.items(), 1):
        builder.drop("body", *PLACES[name])
        assert builder.steps() >= number
        builder.rename("node-Body1", name)
        builder.fill("Mass", mass)
        for label in ("xx", "yy", "zz"):
            builder.fill(f"Inertia {label}", inertia if label == "zz" and inertia else "0")
        for place_of_row, (frame, place) in enumerate(frames.items()):
            builder.press_button("Add a frame")
            row = page.get_by_test_id("properties").locator(".map-row").nth(place_of_row).locator("input")
            row.first.fill(frame)
            row.first.press("Enter")
            builder.fill(f"{frame} at x", place)
    builder.keys("Escape", "Escape")
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    for name, value in PARAMETERS.items():
        builder.press_button("Add a parameter")
        builder.fill("Name of p1", name)
        builder.fill(name, value)
    builder.fill("Gravity y", "-G")
    builder.press_button("Add an input")
    builder.fill("Input 1", "F")
    builder.join("Ground", "Crank.A", "revolute")
    builder.fill("Coordinate", "theta")
    builder.join("Crank.B", "Rod.B", "revolute")
    builder.join("Piston", "Rod.C", "revolute")
    builder.fill("Coordinate", "beta")
    builder.join("Ground", "Piston", "prismatic")
    builder.fill("Coordinate", "s")
    builder.press_button("Add force")
    builder.fill("Applied", "F")
    builder.wait_checked()
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    for number, (name, value) in enumerate(INITIAL.items()):
        builder.press_button("Add an initial value")
        row = page.get_by_test_id("initial").locator(".table-row").nth(number).locator("input")
        row.nth(0).fill(name)
        row.nth(1).fill(value)
        row.nth(1).press("Enter")
    builder.wait_checked()
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    builder.simulate()
    assert_same_motion(builder)


JOINTS = (
    ("revolute", "ground", "Crank.A", "theta"),
    ("revolute", "Crank.B", "Rod.B", ""),
    ("revolute", "Piston", "Rod.C", "beta"),
    ("prismatic", "ground", "Piston", "s"),
)


@pytest.mark.exhaustive
def test_a_slider_crank_is_built_with_the_keys_alone(visit: Any) -> None:
    builder = visit()
    builder.page.locator(".card").first.wait_for()
    builder.go_to("New model")
    builder.keys("Enter")
    builder.page.get_by_test_id("node-Ground").wait_for()
    type_rows(builder, "Add a parameter", PARAMETERS)
    builder.keys("F4")
    builder.type_into("Gravity y", "-G")
    builder.keys("Escape")
    for name, (mass, inertia, frames) in BODIES.items():
        builder.insert("body")
        builder.keys("F4", "Control+a")
        builder.page.keyboard.type(name)
        builder.keys("Enter")
        builder.type_into("Mass", mass)
        for label in ("xx", "yy", "zz"):
            builder.type_into(f"Inertia {label}", inertia if label == "zz" and inertia else "0")
        builder.keys("Escape")
        type_frames(builder, frames)
    for element, start, end, coordinate in JOINTS:
        builder.insert(element)
        builder.keys("F4")
        choose(builder, "Between Start", start)
        choose(builder, "Between End", end)
        if coordinate:
            builder.type_into("Coordinate", coordinate)
            builder.keys("Enter")
        builder.keys("Escape")
    builder.keys("Escape", "Escape")
    builder.wait_checked()
    type_rows(builder, "Add an initial value", INITIAL)
    builder.wait_checked()
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    builder.simulate()
    assert_same_motion(builder)


@pytest.mark.exhaustive
def test_gestures_are_single_steps_and_escape_leaves_no_trace(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("slider_crank")
    before = builder.state("data")
    page.mouse.move(*builder.middle("port-Ground"))
    page.mouse.down()
    page.mouse.move(*builder.middle("port-Rod.C"), steps=6)
    page.mouse.up()
    page.get_by_test_id("chooser").wait_for()
    builder.keys("Escape")
    assert page.get_by_test_id("chooser").count() == 0
    assert (builder.steps(), builder.state("data")) == (0, before)

    x, y = builder.middle("node-Crank")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y + 30, steps=8)
    page.mouse.up()
    assert builder.steps() == 1
    left, top = builder.state("data.layout.nodes.Crank")
    assert left % 10 == 0 and top % 10 == 0
    builder.keys("Control+z")
    assert builder.state("data") == before

    page.get_by_test_id("node-Crank").click()
    page.get_by_test_id("properties").get_by_label("Mass", exact=True).press_sequentially("23")
    assert builder.steps() == 1
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    builder.keys("Control+z")
    assert builder.state("data") == before

    builder.keys("Control+a", "Control+c", "Control+v")
    names = [each["name"] for each in [*builder.state("data.body"), *builder.state("data.joint")]]
    assert len(names) == len(set(names)) == 14
    builder.keys("Delete")
    assert builder.state("data.body.length") == 3
    builder.keys("Control+z", "Control+z")
    assert builder.state("data") == before


@pytest.mark.exhaustive
def test_a_message_leads_to_its_field_and_mends_it(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("slider_crank")
    page.get_by_test_id("node-Crank").click()
    builder.fill("Mass", "m9")
    builder.wait_checked()
    field = page.get_by_test_id("properties").get_by_label("Mass", exact=True)
    assert field.get_attribute("aria-invalid") == "true"
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    page.get_by_role("tab", name="Problems").click()
    page.get_by_test_id("problem").first.click()
    page.wait_for_timeout(200)
    assert builder.state("selection") == ["body/0"]
    assert page.evaluate("document.activeElement.dataset.pointer") == "/body/0/mass"
    page.get_by_role("button", name="make m9 a parameter").first.click()
    builder.wait_checked()
    assert builder.state("data.parameters.m9") == "1"
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []


@pytest.mark.exhaustive
def test_selection_trees_and_picture_go_together(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("slider_crank")
    builder.wait("window.symbodyPicture.shown !== null")
    page.get_by_test_id("badge-A").click()
    assert page.evaluate("symbodyPicture.shown.player.viewer.selected.name") == "A"
    page.evaluate("symbodyPicture.shown.player.select('Rod')")
    assert builder.state("selection") == ["body/1"]
    page.get_by_role("tab", name="Trees").click()
    page.get_by_test_id("trees").get_by_role("checkbox", name="C in the rotation tree").click()
    assert builder.state("data.joint[2].tree") == {"rotation": False}
    assert builder.steps() == 1
    builder.wait_checked()
    live = page.get_by_test_id("live").inner_text()
    assert "error" in live or builder.state("check.summary.tree_choice.C.rotation") is False


@pytest.mark.exhaustive
def test_a_file_is_saved_as_it_was_and_changes_outside_are_seen(visit: Any, settings: Any) -> None:
    path = settings.roots[0] / "crank.toml"
    text = (examples_folder() / "slider_crank" / "slider_crank.toml").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    builder = visit(expected=("409",))
    page = builder.page
    page.evaluate(f"location.hash = 'open={path}'")
    page.reload()
    page.get_by_test_id("node-Crank").wait_for()
    builder.keys("Control+s")
    builder.wait("s.spoken.includes('saved')")
    assert path.read_text(encoding="utf-8") == text
    builder.wait_checked()
    page.get_by_test_id("node-Crank").click()
    builder.fill("Mass", "2*m1")
    assert page.get_by_test_id("dirty").count() == 1
    builder.keys("Control+s")
    builder.wait("s.data === s.saved")
    assert path.read_text(encoding="utf-8") == text.replace('mass = "m1"', 'mass = "2*m1"')
    path.write_text(text + "\n# by hand\n", encoding="utf-8")
    builder.wait("s.outside", 20)
    builder.fill("Mass", "3*m1")
    builder.keys("Control+s")
    builder.wait("s.spoken.includes('not saved')")
    assert page.locator(".outside").count() == 1 and page.get_by_test_id("notice").count() == 0  # said once
    assert page.locator(".doc-title b").inner_text() == "crank"
    assert path.read_text(encoding="utf-8").endswith("# by hand\n")


THEMES = ("dark", "contrast", "light")  # from the last of them the button leads through the others


@pytest.mark.exhaustive
def test_axe_finds_nothing(visit: Any) -> None:
    builder = visit()
    found, seen = [], set()
    for theme in THEMES:
        builder.page.evaluate(f"localStorage.setItem('symbody-theme', '{theme}')")
        builder.page.reload()
        builder.page.locator(".card").first.wait_for()
        found += accessibility_faults(builder.page)
    builder.open_example("slider_crank")
    builder.page.get_by_test_id("badge-A").click()
    for _ in THEMES:
        found += accessibility_faults(builder.page)
        seen.add(builder.page.evaluate("document.documentElement.dataset.theme"))
        builder.page.locator(".topbar").get_by_role("button", name="Light, dark, high contrast").click()
    assert found == [] and seen == set(THEMES)


@pytest.mark.exhaustive
@pytest.mark.parametrize("size", [(1440, 900), (1024, 768), (390, 844)])
def test_axe_finds_nothing_in_equations_and_curves(visit: Any, size: tuple[int, int]) -> None:
    builder = visit(viewport={"width": size[0], "height": size[1]})
    builder.open_example("slider_crank")
    builder.simulate()
    found = accessibility_faults(builder.page)
    builder.keys("F6")
    builder.page.locator(".equations h3").first.wait_for()
    found += accessibility_faults(builder.page)
    assert found == []


@pytest.mark.exhaustive
def test_axe_finds_nothing_in_any_panel_of_a_phone(visit: Any) -> None:
    builder = visit(viewport={"width": 390, "height": 844}, color_scheme="dark")
    found = accessibility_faults(builder.page)
    builder.open_example("spring_mass_damper")
    for panel in ("Diagram", "Picture", "Results", "Palette", "Properties"):
        builder.show(panel)
        found += accessibility_faults(builder.page)
    assert found == []
