"""The mechanisms of examples/gallery as pages: those that simulate move and keep their loops closed; the others play."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from docs import draw_mechanisms
from tests.browser.conftest import Surfer, wait_until

PATHS = {path.stem: path for path in draw_mechanisms.MECHANISMS}
POSE = "(() => { const { positions, axes } = symbodyLive.simulation.computePose(); return [...positions, ...axes]; })()"
TIMES = (0.35, 1.1, 2.3)  # s, at which a page that simulates is looked at


def open_page(surfer: Surfer, path: Path, ready: str) -> Any:
    page = surfer.new_page((960, 640))
    page.goto(path.as_uri())
    wait_until(page, ready, 60.0)
    return page


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(PATHS.keys() - draw_mechanisms.PLAYED.keys()))
def test_page_simulates(name: str, surfer: Surfer) -> None:
    path = surfer.folder / "live.html"
    draw_mechanisms.write_motion_page(PATHS[name], path)
    page = open_page(surfer, path, "window.symbodyLive !== undefined && symbodyLive.simulation.time > 0")
    page.keyboard.press(" ")
    poses = []
    for time in TIMES:
        page.evaluate(f"symbodyLive.simulation.advanceTo(Math.max(symbodyLive.simulation.time, {time}))")
        poses.append(np.array(page.evaluate(POSE)))
        assert np.isfinite(poses[-1]).all()
        assert page.evaluate("symbodyLive.simulation.violation()") < 1e-6
    assert all(np.abs(after - before).max() > 1e-3 for before, after in pairwise(poses))


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(draw_mechanisms.PLAYED))
def test_page_plays_the_motion(name: str, surfer: Surfer) -> None:
    path = surfer.folder / "played.html"
    draw_mechanisms.write_motion_page(PATHS[name], path)
    page = open_page(surfer, path, "window.symbodyPlayer !== undefined")
    start, end = page.evaluate("[symbodyPlayer.clock.start, symbodyPlayer.clock.end]")
    pictures = []
    for share in (0.0, 0.4, 0.8):
        page.evaluate("t => symbodyPlayer.setTime(t)", start + share * (end - start))
        page.wait_for_timeout(80)
        pictures.append(page.screenshot(clip={"x": 0, "y": 0, "width": 960, "height": 320}))
    assert len(set(pictures)) == 3
