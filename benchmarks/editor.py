"""The diagram editor: how long a key and a drag take to be seen.

The page is the one that users have, in Chromium without a graphics card; the server is a process of its own.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

import symbody as sb
from benchmarks.processor import spent_between, spent_by_process
from benchmarks.table import Table, seconds_text
from benchmarks.timing import processor_seconds
from symbody.builder.tasks.check import check_model
from symbody.builder.tasks.redraw import redraw_model
from symbody.formats.native import to_data

_FLAGS: Final = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
_COLUMNS: Final = ("bodies", "opens", "key to picture", "p95", "goal", "frame of a drag", "p95", "goal")
_KINDS: Final = ("page", "graphics", "browser", "server", "workers")
_SHARES: Final = (
    "bodies",
    "picture in its worker",
    "check in its worker",
    *(f"all: {kind}" for kind in _KINDS),
)
_KEYS: Final = 24
_STEPS: Final = 60  # of the pointer in a drag
_PAUSE: Final = 600  # between keys [ms]: the check that follows a rest is under way at some of them
_KEY_GOAL, _FRAME_GOAL = 0.150, 0.050
# Notes when a key came, and when the pixels of the picture with its scene are there. Nothing runs between.
_WATCH: Final = """() => {
  const watch = window.benchmark = { keys: [], frames: [] };
  let key = null;
  let { shown } = symbodyPicture;
  document.addEventListener("input", () => { key = performance.now(); }, true);
  const drawn = () => {
    const { canvas } = shown.player.viewer;
    canvas.getContext("webgl2").readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    watch.keys.push(performance.now() - key);
    key = null;
  };
  Object.defineProperty(symbodyPicture, "shown", {
    get: () => shown,
    set: (next) => { shown = next; if (key !== null) requestAnimationFrame(drawn); },
  });
}"""
_WATCH_FRAMES: Final = """() => {
  let last = performance.now();
  const tick = (now) => {
    benchmark.frames.push(now - last);
    last = now;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}"""


def linkage(bodies: int) -> sb.Model:
    """Return links on hinges that turn about x and y by turns, all of a length L."""
    ends = {"a": sb.Frame((0, 0, "L/2")), "b": sb.Frame((0, 0, "-L/2"))}
    links = [sb.Body(f"B{k}", "m", ("J", "J", 1e-4), frames=ends) for k in range(bodies)]
    hinges = [
        sb.Revolute(
            f"J{k}", f"B{k - 1}.b" if k else "ground", f"B{k}.a", axis="xy"[k % 2], coordinate=f"q{k}"
        )
        for k in range(bodies)
    ]
    return sb.Model(
        "chain", [*links, *hinges], gravity=(0, 0, -9.81), parameters={"L": 0.1, "m": 1, "J": "m*L^2/12"},
        initial={f"q{k}": 0.3 for k in range(0, bodies, 7)},
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Gestures:
    """How long the page takes to open, each key, and each frame of a drag [s].

    Attributes
    ----------
    spent : mapping of kind to float
        Processor time of each kind of process for a key: picture, check, draft, and what browsers do besides.
    """

    opens: float
    keys: list[float]
    frames: list[float]
    spent: Mapping[str, float]


def gestures(executable: str, sizes: tuple[int, ...] = (10, 30, 100)) -> tuple[Table, Table]:
    """Return the times of keys and drags, and the processor time of a key."""
    measured = {bodies: _measured(executable, bodies) for bodies in sizes}
    notes = (
        f"p95: 19 of 20 are shorter; {_KEYS} keys in a parameter, a drag of {_STEPS} steps",
        "key to picture: from the key to the pixels, which a processor draws here",
    )
    shares = (
        "all: of each process, for the picture, the check that follows and all that a browser does besides"
    )
    return (
        Table("the editor", _COLUMNS, tuple(_times(n, each) for n, each in measured.items()), notes),
        Table(
            "the editor: processor time of a key", _SHARES,
            tuple(_processor_times(bodies, each.spent) for bodies, each in measured.items()), (shares,),
        ),
    )  # fmt: skip


def _times(bodies: int, measured: _Gestures) -> tuple[str, ...]:
    keys, frames = measured.keys, measured.frames
    return (
        str(bodies), seconds_text(measured.opens),
        *(seconds_text(float(np.percentile(keys, share))) for share in (50, 95)), seconds_text(_KEY_GOAL),
        *(seconds_text(float(np.percentile(frames, share))) for share in (50, 95)), seconds_text(_FRAME_GOAL),
    )  # fmt: skip


def _processor_times(bodies: int, spent: Mapping[str, float]) -> tuple[str, ...]:
    tasks = (_task_seconds(task, bodies) for task in (redraw_model, check_model))
    return (str(bodies), *map(seconds_text, tasks), *(seconds_text(spent.get(kind, 0.0)) for kind in _KINDS))


def _task_seconds(task: Callable[[Mapping[str, Any], Any], object], bodies: int) -> float:
    """Return the processor time of a task for a value of a parameter that is typed anew, the median."""
    data = to_data(linkage(bodies))
    samples = []
    for k in range(_KEYS):
        typed = {**data, "parameters": {**data["parameters"], "L": f"0.1{k}"}}
        samples.append(processor_seconds(partial(task, {"data": typed, "folder": "/"}, lambda *_: None)))
    return statistics.median(samples[1:])


@contextmanager
def _served(path: Path) -> Iterator[str]:
    """Run a builder and yield its address."""
    command = [sys.executable, "-m", "symbody", "builder", str(path), "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().split()[-1]
        finally:
            server.terminate()


def _measured(executable: str, bodies: int) -> _Gestures:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "chain.toml")
        sb.save_model(linkage(bodies), path)
        with _served(path) as address:
            return _led(executable, address)


def _led(executable: str, address: str) -> _Gestures:
    """Return what a user waits for at the page of an address."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=executable, args=[*_FLAGS])
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        _wait(page, "document.querySelectorAll('.body-node').length > 1")
        opens = page.evaluate("performance.now()")
        _wait(page, "symbodyBuilder.state().check?.summary && window.symbodyPicture?.shown")
        page.evaluate(_WATCH)
        field = page.get_by_test_id("parameters").get_by_label("L", exact=True)
        field.click()
        page.wait_for_timeout(3000)  # as long as one looks before one types
        before = spent_by_process()
        for k in range(_KEYS):
            page.keyboard.press("End")
            page.keyboard.press("Backspace" if k % 2 else str(1 + k // 2 % 9))
            _wait(page, f"benchmark.keys.length > {k}")
            page.wait_for_timeout(_PAUSE)
        spent = spent_between(before, spent_by_process())
        frames = _frames_of_drag(page)
        keys = page.evaluate("benchmark.keys")
        browser.close()
    return _Gestures(
        opens / 1e3,
        [each / 1e3 for each in keys],
        frames,
        {kind: seconds / _KEYS for kind, seconds in spent.items()},
    )


def _frames_of_drag(page: Any) -> list[float]:
    """Return the times between the frames of a drag in the diagram [s]."""
    box = page.locator(".body-node").nth(1).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(_WATCH_FRAMES)
    for k in range(_STEPS):
        page.mouse.move(x + 2 * k, y + k)
    frames = [each / 1e3 for each in page.evaluate("benchmark.frames")]
    page.mouse.up()
    return frames


def _wait(page: Any, condition: str) -> None:
    """Wait until a condition holds; the page forbids the browser's own way, which needs eval."""
    while not page.evaluate(f"window.symbodyBuilder !== undefined && Boolean({condition})"):
        page.wait_for_timeout(10)
