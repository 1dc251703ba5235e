"""The example of docs/code_generation.md that calls C by ctypes, run as it stands there."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[3] / "docs" / "code_generation.md"


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_example_computes_what_symbody_computes(tmp_path: Path) -> None:
    section = PAGE.read_text(encoding="utf-8").partition("\n## C\n")[2]
    found = re.search(r"```python\n(.*?)```", section, re.DOTALL)
    assert found is not None
    (tmp_path / "example.py").write_text(found[1], encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "example.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    through_c, ours = (
        [float(x) for x in re.findall(r"-?\d+\.\d*", line)] for line in done.stdout.splitlines()
    )
    assert len(through_c) == 2 and through_c == pytest.approx(ours, rel=1e-6)
