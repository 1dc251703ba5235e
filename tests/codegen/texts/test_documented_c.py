"""The way from a model to numbers in C by ctypes, as it is documented: run to the letter, and with a robot."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symbody as sb

ROOT = Path(__file__).parents[3]
EXAMPLE = next(
    block
    for block in re.findall(
        r"```python\n(.*?)```", (ROOT / "docs/code_generation.md").read_text(encoding="utf-8"), re.DOTALL
    )
    if "ctypes" in block
)

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None or sys.platform == "win32", reason="there is no C compiler"
)


def run(text: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, check=False
    )
    assert not done.stderr
    return done.stdout


def test_the_documented_example_prints_what_symbody_computes(tmp_path: Path) -> None:
    first, second = run(EXAMPLE, tmp_path).splitlines()
    numbers = [float(x) for x in re.findall(r"-?\d+\.\d*", first)]
    assert numbers == [float(x) for x in re.findall(r"-?\d+\.\d*", second)]
    assert numbers[1] == 1.0


@pytest.mark.exhaustive
def test_a_robot_takes_the_same_way(tmp_path: Path) -> None:
    urdf = ROOT / "examples/robot_arm/robot_arm.urdf"
    text, count = re.subn(
        r"rod = .*?\neqs", f"model = sb.load_urdf({str(urdf)!r})\neqs", EXAMPLE, flags=re.DOTALL
    )
    assert count == 1
    text = text.replace('["udot", "effort pin"]', '["udot", "mass_matrix"]').replace(
        "[0.0] * 2", "[0.0] * 12"
    )
    text = text[: text.index("print(")]
    text += (
        "print(*accelerations(0.0, [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [1.0, 2.0, 3.0], values), sep='\\n')\n"
    )
    eqs = sb.form_equations(sb.load_urdf(urdf))
    assert not eqs.parameter_names
    udot, mass = sb.compile(eqs, ["udot", "mass_matrix"])(
        0.0, [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [1.0, 2.0, 3.0]
    )
    assert [float(x) for x in run(text, tmp_path).split()] == pytest.approx([*udot, *np.ravel(mass)])
