"""`symbody builder` and `symbody edit`: what they print, what they serve, and how they end."""

from __future__ import annotations

import queue
import socket
import subprocess
import sys
import webbrowser
from pathlib import Path
from urllib.parse import unquote

import pytest

from symbody.builder import run, settings
from symbody.builder.settings import BuilderSettings
from symbody.cli.entry import run as run_command


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[BuilderSettings]:
    """The settings that would be served."""
    seen: list[BuilderSettings] = []

    def serve(given: BuilderSettings, listener: socket.socket) -> None:
        seen.append(given)
        listener.close()

    (tmp_path / "index.html").write_text("<html></html>")
    monkeypatch.setattr(settings, "pages_folder", lambda: tmp_path)
    monkeypatch.setattr(run, "serve", serve)
    return seen


@pytest.mark.parametrize("word", ["builder", "edit"])
def test_the_command_prints_an_address_that_opens_the_model(
    word: str, served: list[BuilderSettings], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "a model.toml"
    model.write_text('name = "m"\n')
    assert run_command([word, str(model), "--no-browser", "--port", "0"]) == 0
    (given,) = served
    address, _, opened = capsys.readouterr().out.split()[2].partition("#open=")
    assert address == f"http://127.0.0.1:{given.port}/?key={given.key}"
    assert unquote(opened) == str(model.resolve())
    assert any(model.resolve().is_relative_to(root) for root in given.roots)
    assert given.token != given.key and given.token not in repr(given)


def test_the_browser_is_opened_with_the_same_address(
    served: list[BuilderSettings], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: queue.Queue[str] = queue.Queue()
    monkeypatch.setattr(webbrowser, "open", opened.put)
    run.run_builder(port=0)
    assert opened.get(timeout=30) == served[0].address()


def test_ctrl_c_and_a_port_that_is_taken(
    served: list[BuilderSettings], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with run.listening_socket(0) as taken:
        assert run_command(["builder", "--no-browser", "--port", str(taken.getsockname()[1])]) == 5
    assert "builder.port" in capsys.readouterr().err

    def interrupted(given: BuilderSettings, listener: socket.socket) -> None:
        listener.close()
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "serve", interrupted)
    assert run_command(["builder", "--no-browser", "--port", "0"]) == 130


def test_other_commands_load_nothing_of_the_builder() -> None:
    code = (
        "import sys, symbody.cli; symbody.cli.app; print(sorted({'fastapi', 'uvicorn'} & sys.modules.keys()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.strip() == "[]"
