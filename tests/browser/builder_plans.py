"""Mechanisms that are built by mouse from an empty page: what is dropped where, joined, and written into fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .builder_page import BuilderPage

Place = tuple[str, ...]


@dataclass(frozen=True)
class PlannedBody:
    """A body: where it is dropped, its fields, and the components of its frames that are not 0."""

    at: tuple[int, int]
    mass: str
    inertia: str
    frames: Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class PlannedJoint:
    """What is drawn from port to port, and its fields; `groups` are opened before."""

    element: str
    start: str
    end: str
    name: str = ""
    fields: Mapping[str, str] = field(default_factory=dict)
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """A mechanism."""

    title: str
    bodies: Mapping[str, PlannedBody]
    joints: tuple[PlannedJoint, ...]
    parameters: Mapping[str, str]
    inputs: tuple[str, ...] = ()
    initial: Mapping[str, str] = field(default_factory=dict)
    ground: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def build(builder: BuilderPage, plan: Plan) -> None:
    """Build a mechanism with the mouse; texts are typed."""
    builder.new()
    for name, body in plan.bodies.items():
        builder.drop("body", *body.at)
        builder.rename("node-Body1", name)
        builder.fill("Mass", body.mass)
        for label in ("xx", "yy", "zz"):
            builder.fill(f"Inertia {label}", body.inertia if label == "zz" else "0")
        _frames(builder, body.frames)
    if plan.ground:
        builder.page.get_by_test_id("node-Ground").click(position={"x": 12, "y": 12})
        _frames(builder, plan.ground)
    _clear(builder)
    builder.fill("Name", plan.title)
    builder.fill("Gravity y", "-G")
    for name, value in plan.parameters.items():
        builder.press_button("Add a parameter")
        builder.fill("Name of p1", name)
        builder.fill(name, value)
    for k, name in enumerate(plan.inputs, 1):
        builder.press_button("Add an input")
        builder.fill(f"Input {k}", name)
    for joint in plan.joints:
        _join(builder, joint)
    builder.wait_checked()
    _clear(builder)
    for number, (name, value) in enumerate(plan.initial.items()):
        builder.press_button("Add an initial value")
        row = builder.page.get_by_test_id("initial").locator(".table-row").nth(number).locator("input")
        row.nth(0).fill(name)
        row.nth(1).fill(value)
        row.nth(1).press("Enter")
    builder.wait_checked()


def _join(builder: BuilderPage, joint: PlannedJoint) -> None:
    builder.join(joint.start, joint.end, joint.element)
    if joint.name:
        builder.fill("Name", joint.name)
    for group in joint.groups:
        builder.press_button(group)
    for label, value in joint.fields.items():
        builder.fill(label, value)


def _frames(builder: BuilderPage, frames: Mapping[str, Mapping[str, str]]) -> None:
    page = builder.page
    for number, (name, place) in enumerate(frames.items()):
        builder.press_button("Add a frame")
        row = page.get_by_test_id("properties").locator(".map-row").nth(number).locator("input")
        row.first.fill(name)
        row.first.press("Enter")
        for axis, value in place.items():
            builder.fill(f"{name} at {axis}", value)


def _clear(builder: BuilderPage) -> None:
    builder.keys("Escape", "Escape")
    builder.page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})


def simulate_with(builder: BuilderPage, seconds: float, inputs: Mapping[str, str]) -> None:
    """Simulate by the window that has duration and inputs."""
    page = builder.page
    page.get_by_role("button", name="Simulate with other settings").click()
    page.get_by_label("Duration", exact=True).fill(str(seconds))
    for name, formula in inputs.items():
        page.get_by_label(f"Input {name}", exact=True).fill(formula)
    page.get_by_role("button", name="Simulate", exact=True).last.click()
    builder.wait("s.simulated !== null || s.notice.some(p => p.severity === 'error')", 300)
    assert builder.state("simulated") is not None, builder.state("notice")
    builder.wait("window.symbodyPicture.shown.base.curves.length > 0")


def save_as(builder: BuilderPage, name: str) -> str:
    """Save under a new name and return the path of the file."""
    builder.keys("Control+Shift+s")
    builder.page.get_by_label("File name").fill(name)
    builder.page.get_by_role("button", name="Save", exact=True).last.click()
    builder.wait("s.document.path !== null && s.saved === s.data")
    return str(builder.state("document.path"))


def errors_of(builder: BuilderPage) -> list[Any]:
    return [each for each in builder.state("check.problems") if each["severity"] == "error"]
