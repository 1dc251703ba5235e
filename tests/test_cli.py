"""The command line: what it prints, what it writes, and its exit codes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from symbody.cli import run


@pytest.fixture
def model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert run(["examples", "spring_mass_damper", "--copy", str(tmp_path)]) == 0
    capsys.readouterr()
    return tmp_path / "spring_mass_damper.toml"


def test_simulate_prints_the_equation_and_draws(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", str(model)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "m x'' + d x' + k x = F"
    assert any("input F has no value and is 0" in line for line in lines)
    picture = model.with_suffix(".png")
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000
    assert run(["simulate", str(model)]) == 0  # again: its own picture is made anew


def test_simulate_as_json_and_csv(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = model.with_suffix(".csv")
    arguments = [
        "simulate",
        str(model),
        "--json",
        "--end",
        "1",
        "-p",
        "d=2",
        "-i",
        "F=0",
        "--csv",
        str(table),
    ]
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["success"] is True and result["t"][-1] == 1.0
    assert result["states"]["x"][-1] == pytest.approx(2 * np.exp(-1), abs=1e-7)  # critical damping
    rows = table.read_text(encoding="utf-8").splitlines()
    assert rows[0].split(",")[0] == "t" and len(rows) == len(result["t"]) + 1


def test_equations_as_text_and_latex(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["equations", str(model)]) == 0
    assert capsys.readouterr().out == "m x'' + d x' + k x = F\n"
    assert run(["equations", str(model), "--latex"]) == 0
    assert r"\ddot{x}" in capsys.readouterr().out


def test_check_tells_what_the_model_is(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", str(model)]) == 0
    text = capsys.readouterr().out
    for fact in (
        "bodies: Mass",
        "slider (prismatic)",
        "coordinates: x",
        "inputs: F",
        "degrees of freedom: 1",
    ):
        assert fact in text


def test_code_goes_to_a_file_that_is_not_overwritten(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = model.with_suffix(".c")
    assert run(["code", str(model), "--out", str(target)]) == 0
    before = target.read_text(encoding="utf-8")
    assert run(["code", str(model), "--out", str(target)]) == 2
    assert "cli.file_exists" in capsys.readouterr().err
    assert run(["code", str(model), "--out", str(target), "--force"]) == 0
    assert target.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (["simulate", "MISSING.toml"], 3, "MISSING.toml"),
        (["frobnicate"], 2, "frobnicate"),
        (["simulate", "MODEL", "--end", "soon"], 2, "--end"),
        (["simulate", "MODEL", "-p", "k"], 2, "cli.assignment"),
        (["simulate", "MODEL", "-p", "kk=3"], 3, "did you mean 'k'"),
        (["simulate", "MODEL", "-i", "F=sin(omega*t)"], 3, "omega"),
        (["simulate", "MODEL", "--initial", "y=3"], 4, "'y'"),
        (["code", "MODEL", "-l", "cobol"], 3, "cobol"),
        (["examples", "spring"], 2, "spring_mass_damper"),
    ],
)
def test_faults_end_in_a_message_and_an_exit_code(
    model: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, word: str
) -> None:
    given = [str(model) if argument == "MODEL" else argument for argument in arguments]
    assert run(given) == code
    shown = capsys.readouterr()
    assert word in shown.err and "Traceback" not in shown.err


def test_a_typing_error_in_the_file_is_told_with_line_and_cure(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = model.read_text(encoding="utf-8").replace('stiffness = "k"', 'stifness = "k"')
    model.write_text(text, encoding="utf-8")
    assert run(["check", str(model)]) == 3
    shown = capsys.readouterr().err
    line = next(k for k, row in enumerate(text.splitlines(), 1) if "stifness" in row)
    assert f"spring_mass_damper.toml:{line}" in shown
    assert "stiffness" in shown


def test_help_and_version_of_the_installed_command() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from symbody.cli import main; main()", "--help"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0
    for command in ("simulate", "equations", "check", "code", "examples"):
        assert command in done.stdout
