"""A builder that runs, its page in a browser, and what a user does there with the mouse or the keys alone."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn

from symbody.builder.app import make_app
from symbody.builder.run import listening_socket
from symbody.builder.settings import BuilderSettings, make_settings


@contextmanager
def running_builder(folder: Path) -> Iterator[BuilderSettings]:
    """Serve a builder from a thread; files are read and written in one folder."""
    listener = listening_socket(0)
    home = folder / "home"
    home.mkdir()
    settings = make_settings(listener.getsockname()[1], (home,), folder / "state")
    server = uvicorn.Server(uvicorn.Config(make_app(settings), log_level="error", ws="none"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    yield settings
    server.should_exit = True
    thread.join(20)


class BuilderPage:
    """The page, and gestures on it."""

    def __init__(self, page: Any) -> None:
        self.page = page

    def state(self, expression: str) -> Any:
        """Return a part of the page's state, such as ``data.body``."""
        text = self.page.evaluate(f"JSON.stringify(symbodyBuilder.state().{expression})")
        return None if text is None else json.loads(text)

    def steps(self) -> int:
        """Return how many steps can be undone."""
        return int(self.page.evaluate("symbodyBuilder.steps()"))

    def counts(self) -> dict[str, int]:
        """Return how often nodes, edges and pictures were drawn, and requests sent, since the page loaded."""
        return {
            name: int(count) for name, count in self.page.evaluate("({...symbodyBuilder.counts})").items()
        }

    def wait(self, expression: str, seconds: float = 60.0) -> None:
        """Wait until an expression in the state ``s`` is true."""
        for _ in range(int(seconds / 0.05)):
            if self.page.evaluate(f"(s => Boolean({expression}))(symbodyBuilder.state())"):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"{expression} did not come true: {self.state('notice')}")

    def wait_checked(self) -> None:
        """Wait until the check is of the model as it is now."""
        self.wait("s.checked === s.data")

    def new(self) -> None:
        self.page.get_by_role("button", name="New model").click()
        self.page.get_by_test_id("node-Ground").wait_for()
        self.page.wait_for_timeout(300)  # the diagram glides to its place

    def open_example(self, name: str) -> None:
        self.page.get_by_test_id(f"example-{name}").click()
        self.page.get_by_test_id("node-Ground").wait_for()
        self.wait_checked()
        self.page.wait_for_timeout(300)

    def middle(self, test_id: str) -> tuple[float, float]:
        box = self.page.get_by_test_id(test_id).bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    # with the mouse

    def show(self, panel: str) -> None:
        """Open a side where the window is too narrow for all, or close the one that is open with ""."""
        for button in self.page.locator(".panels button").all():
            is_asked = button.inner_text() == panel
            if button.is_visible() and (button.get_attribute("aria-pressed") == "true") != is_asked:
                button.click()

    def drop(self, element: str, x: float, y: float) -> None:
        """Drag an element from the palette to a place of the diagram."""
        self.show("Palette")
        target = self.page.get_by_test_id("diagram")
        self.page.get_by_test_id(f"palette-{element}").drag_to(target, target_position={"x": x, "y": y})

    def join(self, start: str, end: str, element: str) -> None:
        """Drag from port to port and choose what joins them."""
        self.show("")
        self.page.mouse.move(*self.middle(f"port-{start}"))
        self.page.mouse.down()
        self.page.mouse.move(*self.middle(f"port-{end}"), steps=6)
        self.page.mouse.up()
        self.page.get_by_test_id(f"choose-{element}").click()

    def fill(self, label: str, value: str) -> None:
        self.show("Properties")
        self.page.get_by_test_id("properties").get_by_label(label, exact=True).fill(value)
        self.page.keyboard.press("Enter")

    def press_button(self, name: str) -> None:
        self.show("Properties")
        self.page.get_by_test_id("properties").get_by_role("button", name=name, exact=True).click()
        self.wait("s.focusPointer === null")  # a new row takes the focus

    def rename(self, test_id: str, name: str) -> None:
        self.show("")
        self.page.get_by_test_id(test_id).dblclick()
        self.page.locator(".name-editor").fill(name)
        self.page.keyboard.press("Enter")

    # with the keys

    def keys(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def insert(self, words: str) -> None:
        """Add an element by ``/`` and a search."""
        self.keys("/")
        self.page.keyboard.type(words)
        self.keys("Enter")

    def go_to(self, label: str) -> None:
        """Go on with Tab until the focus is on a control of this name."""
        found = (
            "(() => { const e = document.activeElement;"
            "return e.getAttribute('aria-label') ?? e.labels?.[0]?.firstChild?.textContent ?? e.textContent ?? '' })()"
        )
        for _ in range(120):
            self.keys("Tab")
            if self.page.evaluate(found).strip() == label:
                return
        where = self.page.evaluate("document.activeElement.outerHTML.slice(0, 200)")
        selected = self.state("selection")
        raise AssertionError(f"Tab does not lead to {label}, but to {where}; selected: {selected}")

    def type_into(self, label: str, value: str) -> None:
        self.go_to(label)
        self.keys("Control+a")
        self.page.keyboard.type(value)

    # results

    def curve(self, name: str) -> tuple[list[float], list[float]]:
        """Return times and values of a curve of the last simulation, as the picture has them."""
        base = "window.symbodyPicture.shown.base"
        times = self.page.evaluate(f"Array.from({base}.times)")
        values = self.page.evaluate(
            f"Array.from({base}.curves.find(c => c.name === {json.dumps(name)}).values)"
        )
        return times, values

    def simulate(self) -> None:
        self.keys("F5")
        self.wait(
            "s.simulated !== null && s.simulated.of === s.data || s.notice.some(p => p.severity === 'error')",
            120,
        )
        assert self.state("simulated") is not None, self.state("notice")
        self.wait("window.symbodyPicture.shown.base.curves.length > 0")


def overlaps(page: Any, selector: str) -> list[tuple[str, str]]:
    """Return pairs of elements that lie on each other."""
    script = (
        "(selector => Array.from(document.querySelectorAll(selector)).map(e => "
        "{ const r = e.getBoundingClientRect(); return [e.textContent, r.left, r.top, r.right, r.bottom] }))"
    )
    boxes = page.evaluate(f"{script}({json.dumps(selector)})")
    return [
        (one[0], other[0])
        for index, one in enumerate(boxes)
        for other in boxes[:index]
        if min(one[3], other[3]) - max(one[1], other[1]) > 2
        and min(one[4], other[4]) - max(one[2], other[2]) > 2
    ]
