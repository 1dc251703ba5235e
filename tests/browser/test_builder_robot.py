"""A robot of thirty joints from a URDF file: it opens, its coordinates move it, and it is simulated."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .builder_page import BuilderPage, overlaps, running_builder
from .builder_visits import visits

pytestmark = pytest.mark.exhaustive  # the fast tier builds a mechanism with the mouse

JOINTS = 30
PLACES = (
    "Array.from(symbodyPicture.shown.player.viewer.contents.instant.matrices, m => m.elements.slice(12, 15))"
)


def robot_text(joints: int) -> str:
    """Return a URDF robot: two arms of links on hinges about y and z by turns."""
    parts = ['<?xml version="1.0"?>\n<robot name="two arms">\n  <link name="base"/>']
    for k in range(joints):
        parent = "base" if k % (joints // 2) == 0 else f"link{k - 1}"
        axis = "0 1 0" if k % 2 else "0 0 1"
        side = 1 if k < joints // 2 else -1
        parts.append(
            f'  <link name="link{k}"><inertial><origin xyz="0.05 0 0"/><mass value="0.4"/>'
            '<inertia ixx="1e-4" iyy="4e-4" izz="4e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
            '<visual><origin xyz="0.05 0 0"/><geometry><box size="0.1 0.03 0.03"/></geometry></visual></link>\n'
            f'  <joint name="joint{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/>'
            f'<origin xyz="{0.1 if parent != "base" else 0.0} {0.1 * side if parent == "base" else 0.0} 0"/>'
            f'<axis xyz="{axis}"/><limit lower="-2" upper="2" effort="10" velocity="3"/></joint>'
        )
    return "\n".join([*parts, "</robot>\n"])


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with running_builder(tmp_path_factory.mktemp("builder")) as settings:
        (settings.roots[0] / "arms.urdf").write_text(robot_text(JOINTS), encoding="utf-8")
        yield settings


@pytest.fixture
def builder(chromium: Any, settings: Any) -> Iterator[BuilderPage]:
    with visits(chromium, settings) as visit:
        yield visit()


def open_by_dialog(builder: BuilderPage, name: str) -> None:
    builder.page.locator(".card").first.wait_for()
    builder.keys("Control+o")
    builder.page.get_by_role("button", name=name).click()
    builder.page.get_by_test_id("node-Ground").wait_for()
    builder.wait("s.checked === s.data && window.symbodyPicture && window.symbodyPicture.shown", 120)


def places(builder: BuilderPage) -> Any:
    return np.array(builder.page.evaluate(PLACES))


def test_a_robot_of_thirty_joints_opens_and_its_coordinates_move_it(builder: BuilderPage) -> None:
    page = builder.page
    open_by_dialog(builder, "arms.urdf")
    assert builder.state("check.summary.freedoms") == JOINTS
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    assert overlaps(page, ".body-node") == [] and overlaps(page, ".edge-badge") == []
    sliders = page.get_by_test_id("positions").get_by_role("slider")
    assert sliders.count() == JOINTS
    page.wait_for_timeout(500)
    before = places(builder)
    sliders.first.focus()
    for _ in range(3):
        page.keyboard.press("PageUp")
    for _ in range(100):
        page.wait_for_timeout(50)
        if np.abs(places(builder) - before).max() > 0.05:
            break
    moved = np.linalg.norm(places(builder) - before, axis=1) > 1e-5
    assert moved[2 : JOINTS // 2 + 1].all() and not moved[JOINTS // 2 + 1 :].any()  # one arm, the other not


def robot_of_others() -> Path | None:
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        return None
    return next((Path(str(each.locate())) for each in files if each.name == "ur5_robot.urdf"), None)


def test_a_robot_that_others_made_opens_and_moves(chromium: Any, tmp_path: Path) -> None:
    path = robot_of_others()
    if path is None:
        pytest.skip("the robots of example-robot-data are not here")
    with running_builder(tmp_path) as settings, visits(chromium, settings) as visit:
        (settings.roots[0] / "ur5.urdf").write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
        builder = visit()
        open_by_dialog(builder, "ur5.urdf")
        assert builder.state("check.summary.freedoms") == 6
