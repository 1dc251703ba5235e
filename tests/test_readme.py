"""The README's file and scripts, run as they stand."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from symbody.cli import run

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SCRIPTS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_the_file_shown_is_the_example() -> None:
    (shown,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    example = ROOT / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"
    assert tomllib.loads(shown) == tomllib.loads(example.read_text(encoding="utf-8"))


@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_run(script: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "spring_mass_damper", "--copy", str(tmp_path / "demo")]) == 0
    capsys.readouterr()
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout
