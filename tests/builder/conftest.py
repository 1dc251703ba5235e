"""A builder that runs: one server for all tests of a module, on a port of its own, with a page of two files."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import uvicorn

from symbody.builder.app import make_app
from symbody.builder.run import listening_socket
from symbody.builder.settings import BuilderSettings, ServerLimits, make_settings


@dataclass(frozen=True)
class Answer:
    """What came back."""

    status: int
    headers: Mapping[str, str]
    content: bytes

    @property
    def data(self) -> Any:
        return json.loads(self.content)

    @property
    def code(self) -> str:
        return str(self.data["problems"][0]["code"])


@dataclass(frozen=True)
class Builder:
    """A running builder, and requests to it."""

    settings: BuilderSettings
    folder: Path

    def send(
        self, method: str, path: str, body: bytes | None = None, headers: Mapping[str, str] | None = None
    ) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.settings.port, timeout=60)
        try:
            connection.request(method, path, body, dict(headers or {}))
            got = connection.getresponse()
            return Answer(got.status, {k.lower(): v for k, v in got.getheaders()}, got.read())
        finally:
            connection.close()

    def headers(self, **changes: str | None) -> dict[str, str]:
        usual = {"Content-Type": "application/json", "X-Symbody-Token": self.settings.token}
        changed = {name.replace("_", "-"): value for name, value in changes.items()}
        return {name: value for name, value in {**usual, **changed}.items() if value is not None}

    def ask(self, name: str, /, **content: Any) -> Answer:
        return self.send("POST", f"/api/{name}", json.dumps(content).encode(), self.headers())

    def get(self, name: str, /, **content: Any) -> Any:
        answer = self.ask(name, **content)
        assert answer.status == 200, answer.content
        return answer.data

    def finished(self, job: str) -> dict[str, Any]:
        """The state of a job that has ended; pages read it the same way."""
        state: dict[str, Any] = {"state": "running", "seen": -1}
        while state["state"] == "running":
            state = self.get("job_state", job=job, seen=state["seen"])
        return state


@pytest.fixture(scope="module")
def builder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Builder]:
    folder = tmp_path_factory.mktemp("builder")
    pages = folder / "pages"
    (pages / "assets").mkdir(parents=True)
    (pages / "index.html").write_text("<!doctype html><html><head><title>builder</title></head></html>")
    (pages / "assets" / "page.js").write_text("export {}")
    models = folder / "models"
    models.mkdir()
    listener = listening_socket(0)
    settings = make_settings(
        listener.getsockname()[1],
        roots=(models,),
        state=folder / "state",
        pages=pages,
        limits=ServerLimits(body=2_000_000, receive=1.0),
    )
    server = uvicorn.Server(uvicorn.Config(make_app(settings), log_level="critical", ws="none"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    yield Builder(settings, models.resolve())
    server.should_exit = True
    thread.join(20.0)
    assert not thread.is_alive()
