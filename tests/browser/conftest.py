"""A browser for the tests of pages: required where SYMBODY_BROWSER_TESTS=1, left out with a reason elsewhere."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .builder_page import running_builder
from .builder_visits import Visit, visits

REPOSITORY = Path(__file__).parents[2]
PAGES = REPOSITORY / "src" / "symbody" / "visual" / "pages"
FIXTURES = REPOSITORY / "frontend" / "fixtures"
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
SOFTWARE_GL = "--enable-unsafe-swiftshader"
REQUIRED = os.environ.get("SYMBODY_BROWSER_TESTS") == "1"


def missing() -> str:
    """What a browser test lacks here, "" if nothing."""
    try:
        import axe_playwright_python  # noqa: F401
        import playwright  # noqa: F401
    except ImportError as error:
        return f"the package {error.name} is missing"
    if executable() is None:
        return "Chromium is missing"
    builder = REPOSITORY / "src" / "symbody" / "builder" / "pages" / "index.html"
    if not (PAGES / "player.html").exists() or not builder.exists():
        return "the pages are not built: cd frontend && npm ci && npm run build"
    return ""


def executable() -> str | None:
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for name in names if (path := shutil.which(name))), None)


@pytest.fixture(scope="session", autouse=True)
def tools() -> None:
    reason = missing()
    if reason and REQUIRED:
        pytest.fail(f"browser tests are required here, but {reason}")
    if reason:
        pytest.skip(reason)


class Surfer:
    """Opens pages in one browser; keeps what they complained about and what they tried to load."""

    def __init__(self, browser: Any, folder: Path) -> None:
        self.browser = browser
        self.folder = folder
        self.complaints: list[str] = []
        self.contexts: list[Any] = []

    def open_page(self, data: Any, *, size: tuple[int, int] = (900, 560), **options: Any) -> Any:
        """Return a page that shows data as a saved animation does."""
        template = (PAGES / "player.html").read_text(encoding="utf-8")
        holder = '<script type="application/json" id="symbody-data">{}</script>'
        text = data if isinstance(data, str) else json.dumps(data)
        assert template.count(holder.format("null")) == 1
        html = template.replace(holder.format("null"), holder.format(text.replace("</", "<\\/")))
        page = self.new_page(size, **options)
        page.goto(self.write("page.html", html).as_uri())
        return page

    def open_player(self, data: Any, **options: Any) -> Any:
        page = self.open_page(data, **options)
        wait_until(page, "window.symbodyPlayer !== undefined")
        return page

    def new_page(self, size: tuple[int, int], **options: Any) -> Any:
        context = self.browser.new_context(viewport={"width": size[0], "height": size[1]}, **options)
        context.set_default_timeout(60_000)  # Chromium beside other workers
        self.contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: self.complain(message.type == "error", message.text))
        page.on("pageerror", lambda error: self.complain(True, str(error)))
        page.on("request", lambda request: self.complain(is_foreign(request.url), f"loads {request.url}"))
        return page

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def complain(self, wrong: bool, text: str) -> None:
        if wrong:
            self.complaints.append(text)

    def close(self) -> None:
        for context in self.contexts:
            context.close()


def wait_until(page: Any, condition: str, seconds: float = 20.0) -> None:
    """Wait until an expression holds in the page (its own way of waiting needs eval, which pages forbid)."""
    limit = time.monotonic() + seconds
    while not page.evaluate(condition):
        assert time.monotonic() < limit, f"{condition} did not come true"
        page.wait_for_timeout(25)


def accessibility_faults(page: Any) -> list[str]:
    """Return what axe finds, of any impact."""
    from axe_playwright_python.sync_playwright import Axe

    violations = Axe().run(page).response["violations"]
    return [f"{each['impact']}, {each['id']}: {each['nodes'][0]['html'][:160]}" for each in violations]


def is_foreign(url: str) -> bool:
    return not url.startswith(("file:", "data:", "blob:"))


@pytest.fixture(scope="session")
def playwright_driver() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        yield driver


@pytest.fixture(scope="session")
def chromium(playwright_driver: Any) -> Iterator[Any]:
    browser = playwright_driver.chromium.launch(executable_path=executable(), args=[*FLAGS, SOFTWARE_GL])
    yield browser
    browser.close()


@pytest.fixture
def surfer(chromium: Any, tmp_path: Path) -> Iterator[Surfer]:
    """Pages of one test; at its end none may have complained or loaded anything."""
    surfer = Surfer(chromium, tmp_path)
    yield surfer
    surfer.close()
    assert not surfer.complaints, surfer.complaints


@pytest.fixture(scope="session")
def four_bar() -> Any:
    return json.loads((FIXTURES / "four_bar.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def chain() -> Any:
    return json.loads((FIXTURES / "chain.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A builder that runs: one for all modules, because the processes it starts take seconds to load."""
    with running_builder(tmp_path_factory.mktemp("builder")) as settings:
        yield settings


@pytest.fixture
def visit(chromium: Any, settings: Any) -> Iterator[Visit]:
    """Open pages; none may log an error or request anything elsewhere."""
    with visits(chromium, settings) as visit:
        yield visit
