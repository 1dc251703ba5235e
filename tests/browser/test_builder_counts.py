"""What one gesture costs in a diagram of a hundred bodies: what is drawn, requested and made anew."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import symbody as sb
from benchmarks.editor import linkage

from .builder_page import BuilderPage, overlaps, running_builder
from .builder_visits import visits

pytestmark = pytest.mark.exhaustive  # the fast tier builds a mechanism with the mouse

BODIES = 100


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with running_builder(tmp_path_factory.mktemp("builder")) as settings:
        sb.save_model(linkage(BODIES), settings.roots[0] / "chain.toml")
        yield settings


@pytest.fixture
def builder(chromium: Any, settings: Any) -> Iterator[BuilderPage]:
    with visits(chromium, settings) as visit:
        builder: BuilderPage = visit()
        path = settings.roots[0] / "chain.toml"
        builder.page.evaluate(f"location.hash = 'open={path}'")
        builder.page.reload()
        builder.page.get_by_test_id("node-Ground").wait_for()
        builder.wait("s.checked === s.data && window.symbodyPicture && window.symbodyPicture.shown", 120)
        builder.page.wait_for_timeout(800)  # sizes of nodes are measured, and the view glides to them
        yield builder


def spent(builder: BuilderPage, before: dict[str, int]) -> dict[str, int]:
    """Return what was counted since; looking after the file and drafts goes on by the clock."""
    now = builder.counts()
    clockwork = ("changed", "draft", "recent", "formula")
    return {
        name: count - before.get(name, 0)
        for name, count in now.items()
        if count != before.get(name, 0) and name not in clockwork
    }


def test_a_key_in_a_parameter_asks_once_for_the_picture_and_redraws_nothing_else(
    builder: BuilderPage,
) -> None:
    page = builder.page
    assert builder.state("check.summary.bodies") == BODIES
    page.get_by_test_id("parameters").get_by_label("L", exact=True).click()
    page.wait_for_timeout(300)
    builder.wait("!window.symbodyPicture.shown.player.viewer.stale")
    before = builder.counts()
    size = page.evaluate("symbodyPicture.shown.player.viewer.scene.size")
    page.keyboard.press("End")
    page.keyboard.press("5")
    builder.wait(f"window.symbodyPicture.shown.player.viewer.scene.size > {size}")
    first = spent(builder, before)
    builder.wait_checked()
    page.wait_for_timeout(300)
    assert {**first, "check": 1} == {"redraw": 1, "check": 1}
    assert spent(builder, before) == {"redraw": 1, "check": 1}


def test_a_drag_draws_one_body_and_its_joints_and_asks_for_nothing(builder: BuilderPage) -> None:
    page = builder.page
    x, y = builder.middle("node-B50")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 1, y + 6)  # it is selected, and the drag begins
    page.mouse.move(x + 2, y + 12)
    page.wait_for_timeout(400)
    before = builder.counts()
    steps = 12
    for k in range(1, steps + 1):
        page.mouse.move(x + 2, y + 12 + 10 * k)
        page.wait_for_timeout(30)
    during = spent(builder, before)
    page.mouse.up()
    page.wait_for_timeout(500)
    assert set(during) <= {"node", "edge"}
    assert during.get("node", 0) <= 2 * steps
    assert during.get("edge", 0) <= 3 * 2 * steps
    after = spent(builder, before)
    assert after.get("check", 0) == 0 and after.get("player", 0) == 0
    assert builder.steps() == 1


def test_a_click_draws_what_is_selected_and_what_was(builder: BuilderPage) -> None:
    page = builder.page
    page.get_by_test_id("node-B50").click()
    page.wait_for_timeout(300)
    before = builder.counts()
    page.get_by_test_id("node-B52").click()
    page.wait_for_timeout(300)
    assert spent(builder, before).get("node", 0) <= 6
    assert spent(builder, before).get("edge", 0) == 0


def test_a_hundred_bodies_are_arranged_without_overlap(builder: BuilderPage) -> None:
    assert overlaps(builder.page, ".body-node") == []
    assert overlaps(builder.page, ".edge-badge") == []
