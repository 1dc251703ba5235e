"""A save that ends in the middle, as by a power cut: the file is the one before or the one after, never another.

The process that saves is killed by the system call before, or after, each of those that write. The calls are
replaced in the process that dies, not in the product.
"""

from __future__ import annotations

import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from symbody.builder.documents import Documents
from symbody.builder.model_text import data_from_text
from symbody.builder.requests import OpenRequest, SaveRequest
from symbody.builder.settings import BuilderSettings

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")

OLD = '# mine\nname = "old"\ngravity = [0, 0, 0]\n\n[[body]]\nname = "A"\nmass = 1  # kg\n'
NEW = OLD.replace('"old"', '"new"').replace("mass = 1", "mass = 2.5")
CALLS = ((tempfile, "mkstemp"), (os, "fsync"), (shutil, "copymode"), (os, "replace"))


def kill_here() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def deadly(call: Callable[..., Any], turn: int, after: bool) -> Callable[..., Any]:
    """Return a call whose process does not survive a certain turn of it."""
    seen = 0

    def called(*arguments: Any, **options: Any) -> Any:
        nonlocal seen
        seen += 1
        if seen == turn and not after:
            kill_here()
        result = call(*arguments, **options)
        if seen == turn:
            kill_here()
        return result

    return called


def died(work: Callable[[], object], place: Any, name: str, turn: int, after: bool) -> bool:
    """Run some work in a process of its own in which a call kills; return whether it came to that."""
    process = os.fork()
    if process == 0:
        try:
            setattr(place, name, deadly(getattr(place, name), turn, after))
            work()
        finally:
            os._exit(0)
    _, status = os.waitpid(process, 0)
    return os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL


@pytest.fixture
def settings(tmp_path: Path) -> BuilderSettings:
    folder = tmp_path / "models"
    folder.mkdir()
    return BuilderSettings(8137, tmp_path, tmp_path, (folder.resolve(),), tmp_path / "state")


def changed_data(opened: dict[str, Any]) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(json.dumps(opened["data"]))
    data["name"], data["body"][0]["mass"] = "new", "2.5"
    return data


def points() -> Iterator[tuple[Any, str, int, bool]]:
    for place, name in CALLS:
        for turn in (1, 2, 3, 4):
            for after in (False, True):
                yield place, name, turn, after


@pytest.mark.exhaustive
def test_a_file_is_old_or_new_wherever_a_save_ends(settings: BuilderSettings) -> None:
    path = settings.roots[0] / "a.toml"
    ends: dict[str, int] = {OLD: 0, NEW: 0}
    for place, name, turn, after in points():
        path.write_text(OLD, encoding="utf-8")
        documents = Documents(settings)
        opened = documents.open(OpenRequest(path=str(path)))
        request = SaveRequest(
            document=opened["document"],
            path=str(path),
            data=changed_data(opened),
            fingerprint=opened["fingerprint"],
        )
        if not died(lambda: documents.save(request), place, name, turn, after):  # noqa: B023
            continue
        text = path.read_text(encoding="utf-8")
        assert text in (OLD, NEW), (name, turn, after)
        ends[text] += 1
        kept = path.with_name("a.toml.bak")
        assert not kept.exists() or kept.read_text(encoding="utf-8") in (OLD, NEW)
        again = Documents(settings)  # the next run opens and saves it, whatever lies beside it
        reopened = again.open(OpenRequest(path=str(path)))
        assert [each["name"] for each in again.folder(str(settings.roots[0]))["entries"]] == ["a.toml"]
        again.save(
            SaveRequest(
                document=reopened["document"], path=str(path), data=changed_data(reopened),
                fingerprint=reopened["fingerprint"],
            )
        )  # fmt: skip
        assert path.read_text(encoding="utf-8") == NEW
    assert ends[OLD] >= 8 and ends[NEW] >= 2  # before the last renaming, and after it


def test_a_draft_is_one_of_those_stored_wherever_storing_ends(settings: BuilderSettings) -> None:
    for place, name, turn, after in points():
        documents = Documents(settings)
        opened = documents.new()
        first, second = ({**opened["data"], "name": word} for word in ("first", "second"))
        documents.save_draft(opened["document"], first)
        if not died(lambda: documents.save_draft(opened["document"], second), place, name, turn, after):  # noqa: B023
            continue
        recovered = Documents(settings).open(OpenRequest(draft=opened["document"]))
        assert recovered["data"]["name"] in ("first", "second"), (name, turn, after)


def test_what_another_program_wrote_meanwhile_outlives_a_recovered_draft(settings: BuilderSettings) -> None:
    path = settings.roots[0] / "a.toml"
    path.write_text(OLD, encoding="utf-8")
    documents = Documents(settings)
    opened = documents.open(OpenRequest(path=str(path)))
    documents.save_draft(opened["document"], changed_data(opened))
    by_hand = OLD + "# by hand\n"
    path.write_text(by_hand, encoding="utf-8")
    later = Documents(settings)  # the run of before has ended
    recovered = later.open(OpenRequest(draft=opened["document"]))
    assert recovered["fingerprint"] == opened["fingerprint"]
    assert later.has_changed(recovered["document"], recovered["fingerprint"]) == {"changed": True}
    request = SaveRequest(
        document=recovered["document"],
        path=str(path),
        data=recovered["data"],
        fingerprint=recovered["fingerprint"],
    )
    with pytest.raises(Exception, match="another program"):
        later.save(request)
    assert path.read_text(encoding="utf-8") == by_hand
    later.save(request.model_copy(update={"overwrite": True}))
    assert path.read_text(encoding="utf-8") == NEW + "# by hand\n"


@pytest.mark.exhaustive
def test_a_server_that_is_killed_while_it_saves_leaves_whole_files(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    long = OLD + "".join(f'\n[[body]]\nname = "B{k}"\nmass = 1\n' for k in range(2000))
    path.write_text(long, encoding="utf-8")
    texts = {long}
    for pause in (0.0, 0.01, 0.05, 0.2):
        command = [sys.executable, "-m", "symbody", "builder", str(path), "--no-browser", "--port", "0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path) as server:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1]
            texts |= _saves_until_killed(server, address, path, pause)
        text = path.read_text(encoding="utf-8")
        assert text in texts
        assert data_from_text(text, "a.toml").problems == []


def _saves_until_killed(server: Any, address: str, path: Path, pause: float) -> set[str]:
    """Save one change after the other, kill the server during one of them; return the texts that were saved."""
    host, key = re.match(r"http://([^/]+)/\?key=([^#]+)", address).groups()  # type: ignore[union-attr]
    page = _get(host, "/", {"Cookie": f"symbody-{host.split(':')[1]}={key}"})
    token = re.search(r'symbody-token" content="([^"]+)"', page).group(1)  # type: ignore[union-attr]
    opened = _post(host, token, "open", {"path": str(path)})
    texts: set[str] = set()
    deadline = time.monotonic() + 1.0 + pause
    mark = opened["fingerprint"]
    before = path.read_text(encoding="utf-8")
    for k in range(10_000):
        data = {**opened["data"], "name": f"name {k}"}
        texts.add(re.sub(r'^name = ".*"$', f'name = "name {k}"', before, count=1, flags=re.M))
        if time.monotonic() > deadline:
            body = {"document": opened["document"], "path": str(path), "data": data, "fingerprint": mark}
            connection = _send(host, token, "save", body)
            time.sleep(pause)
            server.kill()
            connection.close()
            break
        mark = _post(
            host, token, "save",
            {"document": opened["document"], "path": str(path), "data": data, "fingerprint": mark},
        )["fingerprint"]  # fmt: skip
    return texts


def _send(host: str, token: str, name: str, body: Any) -> http.client.HTTPConnection:
    connection = http.client.HTTPConnection(host, timeout=60)
    headers = {"Content-Type": "application/json", "X-Symbody-Token": token}
    connection.request("POST", f"/api/{name}", json.dumps(body), headers)
    return connection


def _post(host: str, token: str, name: str, body: Any) -> Any:
    connection = _send(host, token, name, body)
    try:
        return json.loads(connection.getresponse().read())
    finally:
        connection.close()


def _get(host: str, path: str, headers: dict[str, str]) -> str:
    connection = http.client.HTTPConnection(host, timeout=60)
    try:
        connection.request("GET", path, headers=headers)
        return connection.getresponse().read().decode()
    finally:
        connection.close()
