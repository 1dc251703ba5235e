"""A user's script: it runs, and mypy finds nothing in it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("user_script.py")
ROOT = SCRIPT.parents[2]


@pytest.mark.exhaustive
def test_the_script_runs(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPT)], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "Equilibrium, stable" in done.stdout and "θ1''" in done.stdout
    assert (tmp_path / "pendulum.csv").read_text().startswith("t,theta1,reaction A Fx")
    assert (tmp_path / "pendulum.png").stat().st_size > 1000


@pytest.mark.exhaustive
def test_mypy_finds_nothing_in_it(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(SCRIPT)],
        cwd=ROOT, capture_output=True, text=True, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
