"""Every motion of the gallery as a page: it moves, is light and dark, complains of nothing and needs nothing."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.browser.conftest import PAGES, REPOSITORY, Surfer, wait_until

MOST_BYTES = 1_000_000  # of a page without its data
DATA = re.compile(r'id="symbody-data">(.*?)</script>', re.DOTALL)


def gallery() -> ModuleType:
    spec = importlib.util.spec_from_file_location("draw_gallery", REPOSITORY / "docs" / "draw_gallery.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look there
    spec.loader.exec_module(module)
    return module


GALLERY = gallery()


def open_page(surfer: Surfer, path: Path) -> Any:
    page = surfer.new_page(GALLERY.WINDOW)
    page.goto(path.as_uri())
    wait_until(page, "window.symbodyPlayer !== undefined", 60.0)
    return page


def test_nothing_is_left_out() -> None:
    names = {
        group: {each.name for each in GALLERY.EXHIBITS if each.group == group} for group in GALLERY.GROUPS
    }
    examples = {path.parent.name for path in GALLERY.EXAMPLES.glob("*/*.py")} - {"gallery"}
    notes = {path.parent.name for path in GALLERY.EXAMPLES.glob("notes/*/*.py")}
    assert names["examples"] == examples
    assert names["notes"] | GALLERY.STILL.keys() == notes
    assert len(names["robots"]) >= 5


@pytest.mark.exhaustive
@pytest.mark.parametrize("exhibit", GALLERY.EXHIBITS, ids=lambda each: f"{each.group}-{each.name}")
def test_exhibit(surfer: Surfer, exhibit: Any) -> None:
    if exhibit.group == "robots" and GALLERY.robots_folder() is None:
        pytest.skip("example-robot-data is not installed")
    run = exhibit.run()
    path = surfer.folder / "page.html"
    sb.animate(run, path, **exhibit.options)
    text = path.read_text(encoding="utf-8")
    data = DATA.search(text)
    assert data is not None and len(text) - len(data[1]) < MOST_BYTES
    assert (PAGES / "player.html").stat().st_size < MOST_BYTES
    pictures = GALLERY.photograph(open_page(surfer, path))
    first = {}
    for theme, shown in pictures.items():
        arrays = [np.asarray(each, dtype=np.int16) for each in shown]
        first[theme] = arrays[0]
        stage = [each[: GALLERY.WINDOW[1] // 2] for each in arrays]  # above the curves
        assert len(np.unique(stage[0].reshape(-1, 3), axis=0)) > 50
        assert np.ptp(stage[0], axis=2).max() > 60  # something has a colour
        for before, after in zip(stage, stage[1:], strict=False):
            # The scripts of the notes may rest at one of the three times.
            assert (np.abs(after - before).max(axis=2) > 24).sum() > 20 or exhibit.group == "notes"
        assert (np.abs(stage[2] - stage[0]).max(axis=2) > 24).sum() > 20
    assert first["light"].mean() > first["dark"].mean() + 100


@pytest.mark.exhaustive
def test_200_bodies_play_without_new_geometry(surfer: Surfer, chain: Any) -> None:
    page = surfer.open_player(chain)
    page.evaluate("symbodyPlayer.setPlaying(true)")
    before = page.evaluate("symbodyPlayer.state()")
    wait_until(page, f"symbodyPlayer.state().frames > {before['frames'] + 20}", 60.0)
    after = page.evaluate("symbodyPlayer.state()")
    assert after["time"] != before["time"] and after["rebuilt"] == before["rebuilt"]
