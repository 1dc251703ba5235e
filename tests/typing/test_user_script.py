"""A user's script passes mypy --strict, with the types it says, and runs."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

import symbody as sb

SCRIPT = Path(__file__).with_name("user_script.py")
SOURCE = Path(sb.__file__).parents[1]


def said_types() -> dict[int, str]:
    lines = SCRIPT.read_text(encoding="utf-8").splitlines()
    return {
        k: line.partition("#")[2].strip()
        for k, line in enumerate(lines, 1)
        if "reveal_type(" in line and "  #" in line
    }


@pytest.mark.exhaustive
def test_mypy_sees_the_types(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mypy import api  # a second to import, which collecting need not take

    # Away from the configuration of this project, as a user's script is.
    monkeypatch.setenv("MYPYPATH", str(SOURCE))
    options = ["--strict", "--follow-imports=silent", "--config-file=", f"--cache-dir={tmp_path}"]
    text, faults, _ = api.run([*options, str(SCRIPT)])
    own = [line for line in text.splitlines() if "user_script.py:" in line]
    assert faults == "" and [line for line in own if ": error:" in line] == []
    revealed = {int(k): kind for k, kind in re.findall(r'py:(\d+): note: Revealed type is "(.*)"', text)}
    short = {
        k: re.sub(r"(?<![\w.])(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", kind).replace("builtins.", "")
        for k, kind in revealed.items()
    }
    assert short == said_types()
    assert len(short) > 40


def test_it_uses_many_names() -> None:
    names = {*re.findall(r"\bsb\.(\w+)", SCRIPT.read_text(encoding="utf-8"))}
    assert len(names & {*sb.__all__}) >= 40


@pytest.mark.exhaustive
def test_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("builtins.reveal_type", lambda value: value, raising=False)
    runpy.run_path(str(SCRIPT), run_name="__main__")
