"""A server that is killed and started again on the same port: the page goes on, and no edit is lost."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from symbody.formats.model_files import examples_folder

from .builder_page import BuilderPage
from .builder_visits import HARMLESS, listen
from .conftest import REPOSITORY

pytestmark = pytest.mark.exhaustive  # minutes; the fast tier builds and drags a mechanism

# What a browser says of a server that is gone, or of another run.
ABSENT = (
    "ERR_CONNECTION_REFUSED",
    "ERR_CONNECTION_RESET",
    "ERR_EMPTY_RESPONSE",
    "401",
    "403",
    "ERR_CONNECTION_CLOSED",
)


@dataclass
class OwnServer:
    """A builder in a process of its own, on a port that stays."""

    home: Path
    port: int
    address: str = ""
    processes: list[subprocess.Popen[str]] = field(default_factory=list)

    def start(self) -> None:
        path = os.pathsep.join([str(REPOSITORY / "src"), os.environ.get("PYTHONPATH", "")])
        environment = {
            **os.environ,
            "HOME": str(self.home),
            "SYMBODY_STATE": str(self.home / "state"),
            "PYTHONPATH": path,
        }
        command = [sys.executable, "-m", "symbody", "builder", "--no-browser", "--port", str(self.port)]
        process = subprocess.Popen(command, cwd=self.home, env=environment, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        self.processes.append(process)
        self.address = process.stdout.readline().split(": ", 1)[1].strip()

    def kill(self) -> None:
        process = self.processes[-1]
        process.kill()
        process.communicate(timeout=20)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[OwnServer]:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    own = OwnServer(tmp_path, port)
    own.start()
    yield own
    own.kill()


@pytest.fixture
def browser_tabs(chromium: Any, server: OwnServer) -> Iterator[Any]:
    """Open tabs of one browser, which share cookies and storage."""
    complaints: list[str] = []
    context = chromium.new_context(viewport={"width": 1280, "height": 720})
    context.set_default_timeout(30_000)

    def open_tab() -> BuilderPage:
        page = context.new_page()
        listen(page, server.port, complaints, (*HARMLESS, *ABSENT))
        page.goto(server.address)
        page.get_by_test_id("start").wait_for()
        return BuilderPage(page)

    yield open_tab
    context.close()
    assert not complaints, complaints


def open_crank(builder: BuilderPage, home: Path) -> Path:
    path = home / "crank.toml"
    path.write_bytes((examples_folder() / "slider_crank" / "slider_crank.toml").read_bytes())
    builder.page.evaluate(f"location.hash = 'open={path}'")
    builder.page.reload()
    builder.page.get_by_test_id("node-Crank").wait_for()
    builder.wait_checked()
    builder.page.get_by_test_id("node-Crank").click()
    return path


def test_the_page_goes_on_with_a_server_that_was_started_again(server: OwnServer, browser_tabs: Any) -> None:
    builder = browser_tabs()
    page = builder.page
    path = open_crank(builder, server.home)
    builder.fill("Mass", "2*m1")
    server.kill()
    builder.fill("Mass", "3*m1")
    builder.wait("s.server === 'gone'")
    bar = page.get_by_test_id("server-bar")
    assert f"symbody builder --port {server.port}" in bar.inner_text()
    page.get_by_test_id("node-Rod").click()
    builder.fill("Mass", "5*m2")  # edits go on

    server.start()
    builder.wait("s.server === 'other'", 30)
    assert "open the address that the new run prints" in bar.inner_text().lower()
    assert builder.state("data.body[1].mass") == "5*m2"

    other = browser_tabs()  # as the new run does itself
    builder.wait("s.server === 'here'", 30)
    builder.wait_checked()
    assert bar.count() == 0
    assert builder.state("check.summary.freedoms") == 1
    assert [builder.state(f"data.body[{k}].mass") for k in (0, 1)] == ["3*m1", "5*m2"]
    assert other.state("document") is None
    builder.keys("Control+s")
    builder.wait("s.data === s.saved", 20)
    saved = path.read_text(encoding="utf-8")
    assert 'mass = "3*m1"' in saved and 'mass = "5*m2"' in saved and "# " in saved
    builder.keys("Control+z")
    assert builder.state("data.body[1].mass") == "m2"
    builder.simulate()


def test_edits_are_recovered_where_page_and_server_both_end(server: OwnServer, browser_tabs: Any) -> None:
    builder = browser_tabs()
    path = open_crank(builder, server.home)
    text = path.read_text(encoding="utf-8")
    server.kill()
    builder.fill("Mass", "7*m1")
    builder.wait("s.server === 'gone'")
    builder.page.close(run_before_unload=True)
    server.start()
    later = browser_tabs()
    later.page.get_by_role("heading", name="Unsaved edits").wait_for()
    later.page.locator(".drafts button").first.click()
    later.page.get_by_test_id("node-Crank").wait_for()
    later.wait_checked()
    assert later.state("data.body[0].mass") == "7*m1" and later.state("document.path") == str(path)
    assert later.page.get_by_test_id("dirty").count() == 1
    assert path.read_text(encoding="utf-8") == text
    later.keys("Control+s")
    later.wait("s.data === s.saved", 20)
    assert path.read_text(encoding="utf-8") == text.replace('mass = "m1"', 'mass = "7*m1"')
    assert later.page.evaluate("Object.keys(localStorage).filter(k => k.startsWith('symbody-draft-'))") == []


def test_another_page_is_not_let_in(server: OwnServer, browser_tabs: Any, chromium: Any) -> None:
    """A browser that was not given the new key never gets the new token."""
    builder = browser_tabs()
    open_crank(builder, server.home)
    server.kill()
    server.start()
    builder.fill("Mass", "2*m1")
    builder.wait("s.server === 'other'", 30)
    builder.page.wait_for_timeout(4000)
    assert builder.state("server") == "other" and builder.state("checked.body[0].mass") == "m1"
    stranger = chromium.new_context()
    answer = stranger.request.get(f"http://127.0.0.1:{server.port}/")
    assert answer.status == 403 and "symbody-token" not in answer.text()
    stranger.close()
