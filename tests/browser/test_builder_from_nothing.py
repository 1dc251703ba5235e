"""What a newcomer builds from an empty page: by keys alone, by mouse, in a narrow window; each moves as it should."""

from __future__ import annotations

import numpy as np
import pytest

from .builder_keys import type_rows
from .builder_page import BuilderPage
from .builder_plans import errors_of
from .builder_visits import Visit

SIZES = ((1440, 900), (1024, 768))
PLACES = ((330, 60), (560, 130), (330, 250))
GAINS = {"p": "100", "i": "20", "d": "25", "filter": "0.02"}
LEAN = "pi/2 - J2"  # of the pole, towards x


def start_by_keys(builder: BuilderPage) -> None:
    builder.page.locator(".card").first.wait_for()
    builder.go_to("New model")
    builder.keys("Enter")
    builder.page.get_by_test_id("node-Ground").wait_for()


def type_name(builder: BuilderPage, name: str) -> None:
    """Name what has just been added, from the diagram."""
    builder.keys("F4", "Control+a")
    builder.page.keyboard.type(name)
    builder.keys("Enter")


def back_to_the_model(builder: BuilderPage) -> None:
    builder.keys("Escape", "Escape")
    builder.wait_checked()


def assert_upright(builder: BuilderPage) -> None:
    builder.wait_checked()
    assert errors_of(builder) == []
    builder.simulate()
    _, angle = builder.curve("J2")
    leans = np.pi / 2 - np.array(angle)  # curves are in single precision
    assert leans[0] == pytest.approx(np.deg2rad(10), abs=1e-6)
    assert np.max(np.abs(leans)) < 0.2 and abs(leans[-1]) < 0.02


def assert_all_in_view(builder: BuilderPage) -> None:
    """Nobody placed the bodies or moved the view: the page shows them all."""
    builder.page.wait_for_timeout(500)  # the view glides
    view = builder.page.get_by_test_id("diagram").bounding_box()
    boxes = [each.bounding_box() for each in builder.page.locator(".react-flow__node").all()]
    assert len(boxes) == 4
    assert all(
        view["x"] <= box["x"] and box["x"] + box["width"] <= view["x"] + view["width"] for box in boxes
    )


def assert_turns(builder: BuilderPage) -> None:
    """A crank of 0.4 m, links and ground of 1 m: one degree of freedom, the loop closed, a swing under gravity."""
    builder.wait_checked()
    assert errors_of(builder) == [] and builder.state("check.summary.freedoms") == 1
    assert [each["between"] for each in builder.state("data.joint")] == [
        ["ground", "Link1.A"],
        ["Link1.B", "Link2.A"],
        ["Link2.B", "Link3.A"],
        ["ground.D", "Link3.B"],
    ]
    builder.simulate()
    crank, coupler, rocker = (np.array(builder.curve(name)[1]) for name in ("J1", "J2", "J4"))
    gaps = 0.4 * np.exp(1j * crank) + np.exp(1j * (crank + coupler)) + np.exp(1j * rocker) - 1
    assert np.max(np.abs(gaps)) < 1e-5 and np.ptp(crank) > 0.5  # angles in single precision


@pytest.mark.exhaustive
def test_a_cart_pole_with_a_pid_block_by_keys_alone(visit: Visit) -> None:
    builder = visit()
    start_by_keys(builder)
    for element in ("slider", "prismatic", "force", "link", "revolute", "signal"):
        builder.insert(element)
    type_name(builder, "lean")
    builder.type_into("Value", LEAN)
    builder.keys("Escape")
    builder.insert("pid")
    type_name(builder, "servo")
    builder.type_into("Input", "lean")
    for name, gain in GAINS.items():
        builder.type_into(f"Gains {name}", gain)
    builder.keys("Escape", "Escape")
    builder.go_to("force F1")
    builder.keys("Enter", "F4")
    builder.type_into("Vector x", "servo")
    back_to_the_model(builder)
    type_rows(builder, "Add an initial value", {"J2": "80 deg"})
    assert_upright(builder)


@pytest.mark.exhaustive
def test_a_cart_pole_with_a_pid_block_by_mouse_in_a_narrow_window(visit: Visit) -> None:
    builder = visit(viewport={"width": 1024, "height": 768})
    builder.new()
    builder.drop("slider", 400, 60)
    builder.drop("link", 640, 60)
    builder.join("Ground", "Slider1", "prismatic")
    builder.join("Slider1", "Link1.A", "revolute")
    builder.drop("signal", 400, 220)
    builder.rename("node-signal1", "lean")
    builder.fill("Value", LEAN)
    builder.drop("pid", 640, 220)
    builder.rename("node-pid1", "servo")
    builder.fill("Input", "lean")
    for name, gain in GAINS.items():
        builder.fill(f"Gains {name}", gain)
    builder.join("Ground", "Slider1", "force")
    builder.fill("Vector x", "servo")
    builder.show("")
    builder.page.locator(".react-flow__pane").click(position={"x": 20, "y": 250})
    builder.press_button("Add an initial value")
    row = builder.page.get_by_test_id("initial").locator("input")
    assert row.nth(0).input_value() == "J1"  # proposed: the first click selects it
    row.nth(0).click()
    builder.page.keyboard.type("J2")
    row.nth(1).fill("80 deg")
    row.nth(1).press("Enter")
    assert_upright(builder)


@pytest.mark.exhaustive
@pytest.mark.parametrize("size", SIZES)
def test_a_four_bar_with_a_ground_link_by_mouse(visit: Visit, size: tuple[int, int]) -> None:
    builder = visit(viewport={"width": size[0], "height": size[1]})
    builder.new()
    builder.page.get_by_test_id("node-Ground").click(position={"x": 12, "y": 12})
    builder.press_button("Add a frame")
    builder.fill("Name of A", "D")
    builder.fill("D at x", "1")
    for place in PLACES:
        builder.drop("link", *place)
    for start, end in (
        ("Ground", "Link1.A"),
        ("Link1.B", "Link2.A"),
        ("Link2.B", "Link3.A"),
        ("Ground.D", "Link3.B"),
    ):
        builder.join(start, end, "revolute")
    builder.page.locator(".react-flow__pane").click(position={"x": 20, "y": 250})
    builder.fill("L1", "0.4")
    assert_turns(builder)


@pytest.mark.exhaustive
def test_a_four_bar_with_a_ground_link_by_keys_alone(visit: Visit) -> None:
    builder = visit()
    start_by_keys(builder)
    builder.go_to("ground Ground")
    builder.keys("Enter", "Shift+f", "F4")
    builder.type_into("Name of A", "D")
    builder.keys("Enter")
    builder.type_into("D at x", "1")
    builder.keys("Escape")
    for element in ("link", "revolute", "link", "revolute", "link", "revolute", "revolute"):
        builder.insert(element)
    back_to_the_model(builder)
    assert_all_in_view(builder)
    builder.keys("F4")
    builder.type_into("L1", "0.4")
    builder.keys("Escape")
    assert_turns(builder)
