"""What differs on Windows and macOS, put into the way of the code here: drives, files in use, code pages, processes.

The systems themselves are tried by the workflows in `.github`.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NoReturn

import pytest

import symbody as sb
from symbody import storage
from symbody.errors import FormatError, ModelError
from symbody.formats import find_mesh, robot_from_text
from symbody.formats.urdf.file import meshes
from symbody.formats.writing import write_text
from symbody.model.tables.inner_path import inner_path, path_from

SOURCES = Path(sb.__file__).parent
PENDULUM = """\
name = "pendulum"
parameters = { L = 1.0, m = 1.0 }
gravity = ["0", "-9.81", "0"]
[[body]]
name = "Pendel \u2192 \u03b8"
mass = "m"
frames = { pivot = { at = ["0", "L", "0"] } }
[[joint]]
name = "A"
type = "revolute"
between = ["ground", "Pendel \u2192 \u03b8.pivot"]
axis = "z"
coordinate = "\u03b8"
"""


@pytest.fixture
def files_in_use(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], list[float]]:
    """A Windows on which the first replacements of a file fail, and the pauses that are made."""
    pauses: list[float] = []
    replace = os.replace

    def after(failures: int) -> list[float]:
        left = [failures]

        def replace_later(source: str, target: Path) -> None:
            if left[0] > 0:
                left[0] -= 1
                raise PermissionError(13, "the process cannot access the file", str(target))
            replace(source, target)

        monkeypatch.setattr(sys, "platform", "win32")
        monkeypatch.setattr(os, "replace", replace_later)
        monkeypatch.setattr(time, "sleep", pauses.append)
        return pauses

    return after


def test_a_file_that_another_program_has_open_for_an_instant_is_replaced(
    tmp_path: Path, files_in_use: Callable[[int], list[float]]
) -> None:
    (tmp_path / "model.toml").write_text("before")
    pauses = files_in_use(3)
    write_text(tmp_path / "model.toml", "after", keep=False)
    assert (tmp_path / "model.toml").read_text() == "after" and len(pauses) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]


def test_a_file_that_stays_open_is_told_and_stays_as_it_is(
    tmp_path: Path, files_in_use: Callable[[int], list[float]]
) -> None:
    (tmp_path / "model.toml").write_text("before")
    pauses = files_in_use(1000)
    with pytest.raises(FormatError, match="cannot be saved"):
        write_text(tmp_path / "model.toml", "after", keep=False)
    assert (tmp_path / "model.toml").read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]
    assert sum(pauses) < 2.0  # nobody waits longer to be told


def test_results_that_cannot_be_stored_are_no_fault(
    tmp_path: Path, files_in_use: Callable[[int], list[float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(storage.VARIABLE, str(tmp_path))
    files_in_use(1000)
    storage.store(b"key", b"content")
    assert storage.load_stored(b"key") is None and list(tmp_path.iterdir()) == []


@pytest.fixture
def another_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that is compared lies on another drive."""

    def fail(*_: object) -> NoReturn:
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    monkeypatch.setattr(os.path, "relpath", fail)
    monkeypatch.setattr(os.path, "commonpath", fail)


@pytest.mark.usefixtures("another_drive")
def test_files_on_another_drive_are_named_whole_or_refused(tmp_path: Path) -> None:
    place = tmp_path / "a.csv"
    place.write_text("0,0\n1,1\n")
    assert path_from(str(place), "", str(tmp_path / "other")) == place.as_posix()
    with pytest.raises(ModelError, match="leaves the folder"):
        inner_path("a.csv", str(tmp_path), "table a")


def test_a_model_with_files_on_another_drive_is_not_saved(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    home, away = tmp_path / "home", tmp_path / "away"
    for folder in (home, away):
        folder.mkdir()
    (home / "part.toml").write_text(PENDULUM, "utf-8")
    (home / "a.csv").write_text("0,0\n1,1\n")
    (home / "with_part.toml").write_text('name = "a"\n[[include]]\nfile = "part.toml"\nprefix = "p"\n')
    (home / "with_table.toml").write_text(
        PENDULUM + '[[table]]\nname = "law"\nfile = "a.csv"\nargument = "\u03b8"\n', "utf-8"
    )
    models = [sb.load_model(home / name) for name in ("with_part.toml", "with_table.toml")]
    request.getfixturevalue("another_drive")
    for model in models:
        with pytest.raises(FormatError, match="outside the folder in which the model is saved"):
            sb.save_model(model, away / "saved.toml")


@pytest.mark.filterwarnings("ignore:nturl2path is deprecated")
def test_addresses_of_files_may_name_a_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    windows = import_module("nturl2path").url2pathname
    asked: list[str] = []

    def is_file(path: Path) -> bool:
        asked.append(str(path))
        return False

    monkeypatch.setattr(meshes, "url2pathname", windows)
    monkeypatch.setattr(meshes, "_is_file", is_file)
    mesh = '<visual><geometry><mesh filename="file:///C:/my%20robots/arm.stl"/></geometry></visual>'
    robot = robot_from_text(f'<robot name="r"><link name="A">{mesh}</link></robot>', "r.urdf")
    assert find_mesh(robot, robot.links["A"].visuals[0]) is None
    assert asked == ["C:\\my robots\\arm.stl"]


def test_output_into_a_file_keeps_letters_that_its_code_page_lacks(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(PENDULUM, "utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"}  # as in many a Windows
    done = subprocess.run(
        [sys.executable, "-m", "symbody", "check", "a.toml"],
        cwd=tmp_path, env=environment, capture_output=True, timeout=200,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "\\u2192" in done.stdout.decode("cp1252")


def test_processes_are_started_afresh_whatever_the_system_does_by_itself() -> None:
    """Linux copies the process before Python 3.14, macOS and Windows start it: the code shall not see which."""
    found = []
    for path in SOURCES.rglob("*.py"):
        text = path.read_text("utf-8")
        if not any(name in text for name in ("ProcessPoolExecutor", "get_context", "fork", "Pool")):
            continue
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.Call):
                continue
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            keywords = {each.arg for each in node.keywords}
            if name == "ProcessPoolExecutor" and "mp_context" not in keywords:
                found.append(f"{path}:{node.lineno}: without mp_context")
            if name == "get_context" and [ast.unparse(each) for each in node.args] != ["'spawn'"]:
                found.append(f"{path}:{node.lineno}: not by spawn")
            if name == "fork" or (name == "Pool" and not isinstance(node.func, ast.Name)):
                found.append(f"{path}:{node.lineno}: {name}")
    assert found == []


def test_text_is_read_and_written_in_one_encoding_everywhere(tmp_path: Path) -> None:
    """Python tells each place that leaves the encoding to the system, where one of them is run."""
    (tmp_path / "a.toml").write_text(PENDULUM, "utf-8")
    script = (
        "import symbody as sb\n"
        "model = sb.load_model('a.toml'); eqs = sb.form_equations(model); run = sb.simulate(eqs, 0.1)\n"
        "sb.save_model(model, 'b.toml'); run.save('run.npz'); run.to_csv('run.csv')\n"
        "sb.Trajectory.load('run.npz'); sb.save_report(eqs, 'report.html'); sb.save_report(eqs, 'report.tex')\n"
        "sb.save_urdf(model, 'r.urdf'); sb.load_urdf('r.urdf')\n"
        "sb.plot(run).figure.savefig('p.svg')\n"
    )
    done = subprocess.run(
        [sys.executable, "-X", "warn_default_encoding", "-W", "default::EncodingWarning", "-c", script],
        cwd=tmp_path, capture_output=True, text=True, encoding="utf-8", timeout=200,
    )  # fmt: skip
    ours = [line for line in done.stderr.splitlines() if "EncodingWarning" in line and "symbody" in line]
    assert done.returncode == 0, done.stderr
    assert ours == []
