"""How many clicks, drags and keys the slider-crank takes from an empty page, counted by the browser itself.

The way of counting stands in docs/builder.md, with the figures that this test holds.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .builder_page import BuilderPage, running_builder
from .builder_visits import visits
from .test_builder import assert_same_motion

DOCUMENT = Path(__file__).parents[2] / "docs" / "builder.md"
# A press that leads more than 4 pixels away is a drag, whoever takes it; a double click is two clicks.
WATCH = """() => {
  const counts = window.gestures = { clicks: 0, drags: 0, keys: 0 };
  let from = null;
  const far = event => Math.hypot(event.clientX - from[0], event.clientY - from[1]) > 4;
  addEventListener("pointerdown", event => { from = [event.clientX, event.clientY]; }, true);
  addEventListener("pointerup", event => { if (from) counts[far(event) ? "drags" : "clicks"] += 1; from = null; }, true);
  addEventListener("dragend", () => { counts.drags += 1; from = null; }, true);
  addEventListener("keydown", event => {
    if (!["Shift", "Control", "Alt", "Meta"].includes(event.key)) counts.keys += 1;
  }, true);
}"""


@pytest.fixture
def builder(chromium: Any, tmp_path: Path) -> Iterator[BuilderPage]:
    with running_builder(tmp_path) as settings, visits(chromium, settings) as visit:
        yield visit()


class Hands:
    """A user who clicks into a field, types, and goes on with Tab where the next field is the next one."""

    def __init__(self, builder: BuilderPage) -> None:
        self.builder = builder
        self.page = builder.page
        self.fields = builder.page.get_by_test_id("properties")

    def type(self, *texts: str) -> None:
        """Type into the field that has the focus, and those after it."""
        for k, text in enumerate(texts):
            if k:
                self.page.keyboard.press("Tab")
            self.page.keyboard.press("Control+a")
            self.page.keyboard.type(text)

    def at(self, label: str, *texts: str) -> None:
        self.fields.get_by_label(label, exact=True).click()
        self.type(*texts)

    def press(self, name: str) -> None:
        self.fields.get_by_role("button", name=name, exact=True).click()
        self.page.wait_for_timeout(150)  # the focus goes to what is new


def draw_bodies_and_joints(hands: Hands) -> None:
    builder, page = hands.builder, hands.page
    page.get_by_role("button", name="New model").click()
    page.get_by_test_id("node-Ground").wait_for()
    page.wait_for_timeout(300)
    bodies = {
        "Crank": ((330, 50), "m1", "I1", {"A": "-L1/2", "B": "L1/2"}),
        "Rod": ((560, 130), "m2", "I2", {"B": "-L2/2", "C": "L2/2"}),
        "Piston": ((330, 270), "m3", "0", {}),
    }
    for name, (place, mass, inertia, frames) in bodies.items():
        builder.drop("body", *place)
        hands.at("Name", name)
        hands.at("Mass", mass)
        hands.at("Inertia zz", inertia)
        for frame, x in frames.items():
            hands.press("Add a frame")
            latest = list(builder.state("data.body.at(-1).frames"))[-1]
            if latest != frame:
                hands.at(f"Name of {latest}", frame)
                page.keyboard.press("Enter")
            hands.at(f"{frame} at x", x)
    for start, end, element, coordinate in (
        ("Ground", "Crank.A", "revolute", "theta"),
        ("Crank.B", "Rod.B", "revolute", ""),
        ("Piston", "Rod.C", "revolute", "beta"),
        ("Ground", "Piston", "prismatic", "s"),
    ):
        builder.join(start, end, element)
        if coordinate:
            hands.at("Coordinate", coordinate)
            page.keyboard.press("Enter")


def give_values(hands: Hands) -> None:
    page = hands.page
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    hands.at("Gravity y", "-9.81")
    values = {"m1": "1", "m2": "1.5", "m3": ".8", "I1": ".02", "I2": ".15", "L1": ".4", "L2": "1"}
    for name, value in values.items():
        hands.press("Add a parameter")
        hands.type(name, value)
    for name, value in {"theta": "30 deg", "beta": "-12 deg", "s": "1.3", "theta_dot": "5"}.items():
        hands.press("Add an initial value")
        row = page.get_by_test_id("initial").locator(".table-row").last.locator("input")
        row.nth(0).click()
        hands.type(name, value)


@pytest.mark.exhaustive
def test_the_slider_crank_takes_as_many_gestures_as_the_document_says(builder: BuilderPage) -> None:
    builder.page.locator(".card").first.wait_for()
    builder.page.evaluate(WATCH)
    hands = Hands(builder)
    draw_bodies_and_joints(hands)
    drawn = builder.page.evaluate("({...window.gestures})")
    give_values(hands)
    builder.wait_checked()
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    builder.simulate()
    whole = builder.page.evaluate("window.gestures")
    assert_same_motion(builder)
    text = DOCUMENT.read_text(encoding="utf-8")
    rows = [f"| {each['clicks']} | {each['drags']} | {each['keys']} |" for each in (drawn, whole)]
    assert f"| symbody, bodies and joints {rows[0]}" in text, rows
    assert f"| symbody, all of it to the motion {rows[1]}" in text, rows
