"""The builder's page in a browser: examples, gestures, messages, files, and what assistive programs find."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.formats.model_files import examples_folder

from .builder_page import BuilderPage, overlaps, running_builder

PAGES = "src/symbody/builder/pages/index.html"
HARMLESS = ("GPU stall", "GroupMarkerNotSet")


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with running_builder(tmp_path_factory.mktemp("builder")) as settings:
        yield settings


@pytest.fixture
def visit(chromium: Any, settings: Any) -> Iterator[Any]:
    """Open pages; at the end none may have complained or asked for anything elsewhere."""
    contexts: list[Any] = []
    complaints: list[str] = []

    def open_page(expected: tuple[str, ...] = (), **options: Any) -> BuilderPage:
        context = chromium.new_context(viewport={"width": 1280, "height": 720}, **options)
        contexts.append(context)
        page = context.new_page()
        ignored = (*HARMLESS, *expected)

        def note(text: str) -> None:
            if not any(each in text for each in ignored):
                complaints.append(text)

        page.on("pageerror", lambda error: note(str(error)))
        page.on("console", lambda said: note(said.text) if said.type == "error" else None)
        home = f"http://127.0.0.1:{settings.port}/"
        page.on("request", lambda sent: note(sent.url) if not sent.url.startswith((home, "data:", "blob:")) else None)
        page.on("dialog", lambda dialog: dialog.accept())
        page.goto(settings.address())
        page.get_by_test_id("start").wait_for()
        return BuilderPage(page)

    yield open_page
    for context in contexts:
        context.close()
    assert not complaints, complaints


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
        for frame, place in frames.items():
            builder.press_button("Add a frame")
            row = page.get_by_test_id("properties").locator(".map-row").last.locator("input")
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
    for name, value in INITIAL.items():
        builder.press_button("Add an initial value")
        row = page.get_by_test_id("initial").locator(".table-row").last.locator("input")
        row.nth(0).fill(name)
        row.nth(1).fill(value)
        row.nth(1).press("Enter")
    builder.wait_checked()
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    builder.simulate()
    assert_same_motion(builder)
