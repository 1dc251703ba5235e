"""Visits to a builder that runs: pages that may neither complain nor load anything from elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from .builder_page import BuilderPage

HARMLESS = ("GPU stall", "GroupMarkerNotSet")
Visit = Callable[..., BuilderPage]


@contextmanager
def visits(chromium: Any, settings: Any) -> Iterator[Visit]:
    """Hand out what opens pages; at the end none may have complained.

    `expected` are parts of complaints that a test provokes; all else goes to the browser's context.
    """
    contexts: list[Any] = []
    complaints: list[str] = []

    def open_page(expected: tuple[str, ...] = (), **options: Any) -> BuilderPage:
        context = chromium.new_context(**{"viewport": {"width": 1280, "height": 720}, **options})
        context.set_default_timeout(60_000)  # Chromium beside other workers
        contexts.append(context)
        page = context.new_page()
        listen(page, settings.port, complaints, (*HARMLESS, *expected))
        page.goto(settings.address())
        page.get_by_test_id("start").wait_for()
        return BuilderPage(page)

    try:
        yield open_page
    finally:
        for context in contexts:
            context.close()
    assert not complaints, complaints


def listen(page: Any, port: int, complaints: list[str], ignored: tuple[str, ...]) -> None:
    """Collect what a page complains of and loads from elsewhere; its questions are answered with yes."""

    def note(text: str) -> None:
        if not any(each in text for each in ignored):
            complaints.append(text)

    home = f"http://127.0.0.1:{port}/"
    page.on("pageerror", lambda error: note(str(error)))
    # Half a formula is refused where a pause in typing lets it be sent: how fast tests type is not theirs to say.
    page.on(
        "console",
        lambda said: (
            note(said.text)
            if said.type == "error" and not said.location["url"].endswith("/api/formula")
            else None
        ),
    )
    page.on(
        "request",
        lambda sent: note(sent.url) if not sent.url.startswith((home, "data:", "blob:")) else None,
    )
    page.on("dialog", lambda dialog: dialog.accept())
