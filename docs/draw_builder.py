"""Draw all examples in the diagram editor: a sheet in light colours and one in dark, and one with its wires.

    python docs/draw_builder.py

The sheets are docs/pictures/builder_light.webp and builder_dark.webp, the one window builder_signals.webp;
`python docs/draw_builder.py FOLDER` leaves every window in its full size in a folder. Needs Chromium,
playwright and pillow.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from PIL import Image
from playwright.sync_api import sync_playwright

PICTURES: Final = Path(__file__).parent / "pictures"
THEMES: Final = ("light", "dark")
_FLAGS: Final = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
_WINDOW: Final = (1440, 900)
_CELL: Final = (720, 450)
_COLUMNS: Final = 2
_EXAMPLES: Final = (
    'section:has(h2:text-is("Examples")) .card'  # not those of the gallery, which has pictures of its own
)
_SIGNALS: Final = "dc_motor_arm"
_QUALITY: Final = 40  # of the compression: the sheets stay below 300 kB


@contextmanager
def address() -> Iterator[str]:
    """Run a builder and yield its address."""
    command = [sys.executable, "-m", "symbody", "builder", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().split()[-1]
        finally:
            server.terminate()


def wait(page: Any, condition: str) -> None:
    """Wait until a condition of the page's state `s` holds."""
    while not page.evaluate(f"(s => Boolean({condition}))(window.symbodyBuilder?.state() ?? {{}})"):
        page.wait_for_timeout(50)


def windows(theme: str) -> Iterator[tuple[str, Image.Image]]:
    """Yield each example's name and the window that shows it."""
    with address() as place, sync_playwright() as driver:
        program = next(path for name in ("chromium", "google-chrome") if (path := shutil.which(name)))
        browser = driver.chromium.launch(executable_path=program, args=[*_FLAGS])
        page = browser.new_page(viewport={"width": _WINDOW[0], "height": _WINDOW[1]}, reduced_motion="reduce")
        page.on("dialog", lambda dialog: dialog.accept())
        page.goto(place)
        page.locator(".card").first.wait_for()
        page.evaluate(f"localStorage.setItem('symbody-theme', '{theme}')")
        page.reload()
        page.locator(".card").first.wait_for()
        names = [str(each.get_attribute("data-testid")) for each in page.locator(_EXAMPLES).all()]
        for name in names:
            page.get_by_test_id(name).click()
            page.get_by_test_id("node-Ground").wait_for()
            wait(page, "s.checked === s.data && s.check?.picture && window.symbodyPicture?.shown")
            page.wait_for_timeout(1500)  # nodes are measured, the diagram fits, the picture is drawn
            yield name.removeprefix("example-"), Image.open(io.BytesIO(page.screenshot()))
            page.locator(".brand").click()
            page.get_by_role("menuitem", name="Examples and recent files").click()
            page.locator(".card").first.wait_for()
        browser.close()


def sheet(cells: list[Image.Image]) -> Image.Image:
    """Return windows side by side."""
    rows = -(-len(cells) // _COLUMNS)
    whole = Image.new("RGB", (_COLUMNS * _CELL[0], rows * _CELL[1]), cells[0].convert("RGB").getpixel((0, 0)))
    for k, cell in enumerate(cells):
        small = cell.convert("RGB").resize(_CELL, Image.Resampling.LANCZOS)
        whole.paste(small, (k % _COLUMNS * _CELL[0], k // _COLUMNS * _CELL[1]))
    return whole


def main(folder: Path | None = None) -> None:
    """Draw both sheets."""
    for theme in THEMES:
        cells = []
        for name, window in windows(theme):
            cells.append(window)
            if (name, theme) == (_SIGNALS, "light"):
                window.convert("RGB").save(PICTURES / "builder_signals.webp", quality=_QUALITY, method=6)
            if folder is not None:
                window.save(folder / f"{name}_{theme}.png")
        path = PICTURES / f"builder_{theme}.webp"
        sheet(cells).save(path, quality=_QUALITY, method=6)
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
