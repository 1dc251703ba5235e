"""Every example: its model file loads, its script runs and prints, and the two are a pair."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from symbody.cli import run
from tests.problems.mechanisms import EXAMPLES

FOLDERS = sorted(path.name for path in EXAMPLES.iterdir() if path.is_dir())


@pytest.mark.parametrize("name", FOLDERS)
def test_script_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / name / f"{name}.py"), run_name="__main__")
    assert capsys.readouterr().out.count("\n") >= 3


@pytest.mark.parametrize("name", FOLDERS)
def test_commands_read_the_model(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    for path in sorted((EXAMPLES / name).glob("*.toml")):
        freedoms = set()
        for arguments in ([], ["--tree", "joints"], ["--tree", "absolute"]):
            assert run(["check", str(path), *arguments]) == 0
            told = capsys.readouterr().out
            freedoms |= {line for line in told.splitlines() if line.startswith("degrees of freedom: ")}
        assert len(freedoms) == 1 and "not counted" not in freedoms.pop()
        assert run(["equations", str(path), "--tree", "joints"]) == 0
        assert " = " in capsys.readouterr().out


def test_examples_are_copied_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "projectile", "--copy", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "projectile.py", "projectile.toml", "projectile_free.toml",
    }  # fmt: skip
    assert run(["examples"]) == 0
    assert capsys.readouterr().out.split()[-len(FOLDERS) :] == FOLDERS
