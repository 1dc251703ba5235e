"""Pages and films of motions: time to make and to open them, their size, and how fluently they play.

The browser is Chromium without a graphics card, so frames a second are those of its software renderer.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import symbody as sb
from benchmarks.editor import gestures
from benchmarks.mechanisms import EXAMPLES
from benchmarks.table import Table, seconds_text
from benchmarks.timing import Settings, processor_seconds, seconds

_BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome")
_FLAGS: Final = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
_COLUMNS: Final = ("motion", "page made", "size", "opens", "time set", "frames a second", "1 s of film")
_SECONDS: Final = 3.0
_DRAWN: Final = 20  # frames whose number a second is counted


def example(name: str) -> sb.Model:
    """Return the model of an example."""
    return sb.load_model(EXAMPLES / name / f"{name}.toml")


def chain(links: int) -> sb.Model:
    """Return links on hinges that turn about x and y by turns, hung from the ground."""
    ends = {"a": sb.Frame((0, 0, 0.05)), "b": sb.Frame((0, 0, -0.05))}
    bodies = [sb.Body(f"B{k}", 1, (1e-3, 1e-3, 1e-4), frames=ends) for k in range(links)]
    joints = [
        sb.Revolute(
            f"J{k}", f"B{k - 1}.b" if k else "ground", f"B{k}.a", axis="xy"[k % 2], coordinate=f"q{k}"
        )
        for k in range(links)
    ]
    return sb.Model(
        "chain", [*bodies, *joints], gravity=(0, 0, -9.81), initial={f"q{k}": 0.3 for k in range(0, links, 7)}
    )


MOTIONS: Final[Mapping[str, Callable[[], sb.Model]]] = MappingProxyType(
    {
        "four_bar": lambda: example("four_bar"),
        "stewart_platform": lambda: example("stewart_platform"),
        "200 bodies": lambda: chain(200),
    }
)


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of pages and films, and where there is a browser that of the editor."""
    yield pages(settings, tuple(MOTIONS))
    executable = _browser()
    if executable is not None:
        yield from gestures(executable)


def pages(settings: Settings, names: tuple[str, ...]) -> Table:
    """Return the table of some of the motions; what no browser measures is left out."""
    with tempfile.TemporaryDirectory() as folder:
        rows = [_row(name, Path(folder)) for name in names]
    notes = () if _browser() else ("the browser's figures need Chromium and playwright",)
    return Table("pages and films of motions", _COLUMNS, tuple(rows), notes)


def _row(name: str, folder: Path) -> tuple[str, ...]:
    run = sb.simulate(sb.form_equations(MOTIONS[name]()), _SECONDS)
    path, film = folder / f"{name}.html", folder / f"{name}.gif"
    made = seconds(lambda: sb.animate(run, path))
    drawn = processor_seconds(
        lambda: sb.save_animation(run, film, times=(0.0, 1.0), size=(960, 540), progress=False)
    )
    shown = _opened(path) if _browser() else ("", "", "")
    return name, seconds_text(made), f"{path.stat().st_size / 1e6:.2f} MB", *shown, seconds_text(drawn)


def _browser() -> str | None:
    """Return the browser's program, if it can be led."""
    try:
        import playwright  # noqa: F401
    except ImportError:
        return None
    return next((path for name in _BROWSERS if (path := shutil.which(name))), None)


def _opened(path: Path) -> tuple[str, str, str]:
    """Return how long a page takes to open and to show another time, and its frames a second."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=_browser(), args=[*_FLAGS])
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        opens = seconds(lambda: (page.goto(path.as_uri()), _wait(page, "symbodyPlayer.state().frames > 0")))
        page.evaluate("symbodyPlayer.setPlaying(false)")
        spent = page.evaluate(
            "(() => { const start = performance.now();"
            " for (let k = 0; k < 50; k++) symbodyPlayer.setTime(k / 50);"
            " return (performance.now() - start) / 50e3; })()"
        )
        page.evaluate("symbodyPlayer.setPlaying(true)")
        first = page.evaluate("symbodyPlayer.state().frames")
        took = seconds(lambda: _wait(page, f"symbodyPlayer.state().frames >= {first + _DRAWN}"))
        browser.close()
    return seconds_text(opens), seconds_text(spent), f"{_DRAWN / took:.1f}"


def _wait(page: Any, condition: str) -> None:
    """Wait until a condition holds; the page forbids the browser's own way, which needs eval."""
    while not page.evaluate(f"window.symbodyPlayer !== undefined && {condition}"):
        page.wait_for_timeout(10)
