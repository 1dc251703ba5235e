"""Draw docs/pictures/live_page.png: `python docs/draw_live_page.py` opens a page that simulates itself.

Chromium and the package playwright are needed.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Final

from playwright.sync_api import sync_playwright

import symbody as sb

HERE: Final = Path(__file__).resolve().parent
MODEL: Final = HERE.parent / "examples" / "slider_crank" / "slider_crank.toml"
FLAGS: Final = ("--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
SLIDERS: Final = {"m2": (0.5, 3), "L2": (0.6, 2), "F": (-50, 50), "theta": (-1, 1)}


def main() -> None:
    """Write the page, pull its piston, and keep what is seen."""
    eqs = sb.form_equations(sb.load_model(MODEL))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as tools:
        path = Path(folder) / "live.html"
        sb.animate(eqs, path, live=True, sliders=SLIDERS)
        browser = tools.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1200, "height": 680})
        page.goto(path.as_uri())
        page.wait_for_timeout(1500)
        page.keyboard.press(" ")  # what stands still can be pressed
        x, y = page.evaluate(
            "(() => { const p = symbodyLive.simulation.computePose().positions; "
            "return symbodyLive.player.viewer.pagePlace([p[6], p[7], p[8]]); })()"
        )
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 70, y - 90, steps=4)
        page.wait_for_timeout(2500)
        page.screenshot(path=HERE / "pictures" / "live_page.png")
        browser.close()


if __name__ == "__main__":
    main()
