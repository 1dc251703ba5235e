"""``symbody doctor``: it runs whatever is broken, and says what."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from symbody.cli import doctor, run


def test_every_part_works_here(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SYMBODY_CACHE", str(tmp_path))
    assert run(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("symbody ") and lines[1].startswith("Python ")
    assert lines[-1] == "everything works"
    for name in doctor.TESTS:
        assert any(line.startswith((f"  {name}: ok, ", f"  {name}: not there")) for line in lines)
    assert any(str(tmp_path) in line for line in lines)


def test_a_broken_part_is_named_and_the_others_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> str:
        raise ImportError("no\nlibrary")

    lines = dict(doctor.doctor_lines({"first": broken, "second": lambda: "fine"}))
    assert lines["  first: FAILED, ImportError: no library"] is False
    assert any(line.startswith("  second: ok, ") and line.endswith(", fine") for line in lines)


def test_a_wrong_result_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("symbody.storage.load_stored", lambda key: b"something else")
    monkeypatch.setattr(doctor, "TESTS", {"stored results": doctor.TESTS["stored results"]})
    assert run(["doctor"]) == 5
    assert "stored results: FAILED" in capsys.readouterr().out


def test_it_runs_where_the_compilers_cannot_be_loaded(tmp_path: Path) -> None:
    for name in ("llvmlite", "numba"):
        (tmp_path / f"{name}.py").write_text("raise ImportError('broken here')\n")
    script = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from symbody.cli import run; sys.exit(run(['doctor']))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300)
    assert done.returncode == 5, done.stderr
    assert "  object code: FAILED" in done.stdout and "broken here" in done.stdout, done.stdout
    assert "  stored results: ok" in done.stdout, done.stdout


def test_without_storage_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYMBODY_CACHE", "off")
    lines = [line for line, _ in doctor.doctor_lines({"stored results": doctor.TESTS["stored results"]})]
    assert any(line.startswith("cache: off") for line in lines)
    assert any(line.startswith("  stored results: ok") and line.endswith("off") for line in lines)
