"""What is kept of compiled loops: damaged, foreign and unwritable files are done without; results never change."""

from __future__ import annotations

import importlib.util
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

from symbody.simulation.native.interface import compile_loop

Function = Callable[[float], float]
SOURCE = "def loop(x):\n    for k in range(3):\n        x = 2.0 * x + k\n    return x\n"
# 2 (2 (2 x + 0) + 1) + 2
RESULT = 8.0 * 0.5 + 4.0


@pytest.fixture
def place(tmp_path: Path) -> Path:
    path = tmp_path / "small_loop.py"
    path.write_text(SOURCE)
    return path


def loop(place: Path) -> Function:
    """The function as the next process has it."""
    spec = importlib.util.spec_from_file_location("small_loop", place)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return compile_loop(module.loop)


def hits(function: Function) -> int:
    return sum(function.stats.cache_hits.values())  # type: ignore[attr-defined]


def kept(place: Path) -> Path:
    (path,) = (place.parent / "__pycache__").glob("*.loop")
    return path


def check_made_anew(place: Path) -> None:
    """The function is compiled, gives what it should, and is found by the next process."""
    function = loop(place)
    assert function(0.5) == RESULT and hits(function) == 0
    after = loop(place)
    assert after(0.5) == RESULT and hits(after) == 1


def damaged(content: bytes, source: random.Random) -> bytes:
    kind = source.randrange(4)
    at = source.randrange(len(content))
    if kind == 0:
        return content[:at]
    if kind == 1:
        return content + source.randbytes(1 + at % 20)
    if kind == 2:
        return content[:at] + source.randbytes(min(16, len(content) - at)) + content[at + 16 :]
    return content[:at] + bytes([content[at] ^ (1 << source.randrange(8))]) + content[at + 1 :]


def test_a_loop_is_kept_and_found(place: Path) -> None:
    check_made_anew(place)


def check_damages(place: Path, seed: int, count: int) -> None:
    source = random.Random(seed)
    assert loop(place)(0.5) == RESULT
    whole = kept(place).read_bytes()
    for _ in range(count):
        broken = damaged(whole, source)
        if broken == whole:
            continue
        kept(place).write_bytes(broken)
        check_made_anew(place)
        kept(place).write_bytes(whole)


def test_damaged_files_are_made_anew(place: Path) -> None:
    check_damages(place, 0, 25)
    kept(place).write_bytes(b"")
    check_made_anew(place)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(1, 21))
def test_many_damaged_files_are_made_anew(place: Path, seed: int) -> None:
    check_damages(place, seed, 100)


@pytest.mark.skipif(os.name != "posix", reason="links and owners are those of POSIX")
def test_links_in_place_of_files_are_as_good_as_what_they_lead_to(place: Path, tmp_path: Path) -> None:
    assert loop(place)(0.5) == RESULT
    path, other = kept(place), tmp_path / "elsewhere"
    whole = path.read_bytes()
    for content in (whole, whole[:-1], b""):
        other.write_bytes(content)
        path.unlink()
        path.symlink_to(other)
        function = loop(place)
        assert function(0.5) == RESULT and hits(function) == (content is whole)
        if content is not whole:
            assert not kept(place).is_symlink() and other.read_bytes() == content  # what it led to is let be
    for link in (tmp_path / "nowhere", path, tmp_path):  # to nothing, to itself, to a folder
        kept(place).unlink()
        path.symlink_to(link)
        assert loop(place)(0.5) == RESULT
        if path.is_symlink():
            path.unlink()
        loop(place)(0.5)


@pytest.mark.skipif(os.name != "posix", reason="owners are those of POSIX")
def test_a_file_that_others_can_write_is_not_read(place: Path) -> None:
    assert loop(place)(0.5) == RESULT
    kept(place).chmod(0o666)
    function = loop(place)
    assert function(0.5) == RESULT and hits(function) == 0


def test_a_changed_source_leaves_no_files_behind(place: Path) -> None:
    assert loop(place)(0.5) == RESULT
    before = kept(place)
    place.write_text(SOURCE.replace("2.0 * x", "4.0 * x "))
    assert loop(place)(0.5) == 64.0 * 0.5 + 4.0 + 2.0
    assert kept(place) != before


WITHOUT = """
import resource, sys
from pathlib import Path
sys.path.insert(0, {folder!r})
from symbody.simulation.native.interface import compile_loop
{limit}
import small_loop
assert compile_loop(small_loop.loop)(0.5) == {result}
print("files:", len(list(Path({folder!r}).rglob("*.loop"))))
"""


def run_without(place: Path, limit: str) -> str:
    code = WITHOUT.format(folder=str(place.parent), limit=limit, result=RESULT)
    command = [sys.executable, "-B", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd="/")
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="limits are those of Linux")
def test_a_full_disk_is_done_without(place: Path) -> None:
    """A file may not grow: writing to it fails as on a full disk, with another number of the error."""
    limit = "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))"
    assert run_without(place, limit) == "files: 0\n"
    assert not list((place.parent / "__pycache__").iterdir())  # no half file either
    check_made_anew(place)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root becomes another user")
def test_a_read_only_installation_of_another_user_without_a_home(place: Path) -> None:
    """Neither the folder of the source nor a home can be written to by the user, who loaded numba before."""
    for folder in place.parents:
        if folder.is_relative_to(tempfile.gettempdir()) and folder != Path(tempfile.gettempdir()):
            folder.chmod(0o755)
    user = "import os; os.environ['HOME'] = '/nonexistent'; compile_loop(lambda x: x)(0.5)\n"
    user += "os.setgroups([]); os.setgid(65534); os.setuid(65534)"
    assert run_without(place, user) == "files: 0\n"
