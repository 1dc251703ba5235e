"""Loops closed by a file beside the robot."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.faults.refusals import refused
from tests.formats.urdf.robots import joint, link, robot

# A parallelogram: two cranks of length 1 on pins 2 apart; the coupler hangs on the first.
ROBOT = robot(
    '<link name="base"/>', link("A"), link("B"), link("C"),
    joint("a", "continuous", "base", "A", '<axis xyz="0 1 0"/>'),
    joint("b", "continuous", "A", "B", '<origin xyz="0 0 -1"/>', '<axis xyz="0 1 0"/>'),
    joint("c", "continuous", "base", "C", '<origin xyz="2 0 0"/>', '<axis xyz="0 1 0"/>'),
)  # fmt: skip
LOOPS = """
[[body]]
name = "B"
[body.frames]
end = { at = [2, 0, 0] }
[[body]]
name = "C"
[body.frames]
end = { at = [0, 0, -1] }
[[joint]]
name = "close"
type = "revolute"
between = ["B.end", "C.end"]
axis = "y"
"""


def load(folder: Path, loops: str) -> sb.Model:
    (folder / "r.urdf").write_text(ROBOT)
    (folder / "loops.toml").write_text(loops)
    return sb.load_urdf(folder / "r.urdf", loops=folder / "loops.toml")


def test_a_loop_is_closed_between_points_of_links(tmp_path: Path) -> None:
    eqs = sb.form_equations(load(tmp_path, LOOPS))
    state = sb.assemble(eqs, fixed={"a": 0.3}, guess={"b": -0.3, "c": 0.3})
    assert (
        np.abs([state["b"] + 0.3, state["c"] - 0.3]).max() < 1e-9
    )  # a parallelogram: the coupler stays level


def test_a_rod_between_links_by_their_frames(tmp_path: Path) -> None:
    rod = '[[constraint]]\nname = "rod"\ntype = "distance"\nbetween = ["B", "C"]\nvalue = "L"\n[parameters]\nL = 2.5\n'
    eqs = sb.form_equations(load(tmp_path, rod))
    state = sb.assemble(eqs, guess={"a": 0.2})
    # The origins of B and C are sqrt(5 + 4 sin(a)) apart.
    assert len(eqs.multiplier_names) == 1 and abs(state["a"] - math.asin(0.3125)) < 1e-9


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ('[[joint]]\nname = "x"\ntype = "weld"\nbetween = ["A", "nobody"]\n', "model.unknown_place", 4),
        ('[[body]]\nname = "D"\n', "urdf.unknown_link", 1),
        ('[[body]]\nname = "A"\nmass = 3\n', "urdf.loops_key", 1),
        ("gravity = [0, 0, 0]\n", "urdf.loops_key", 1),
        ('[[joint]]\nname = "x"\ntype = "wild"\nbetween = ["A", "C"]\n', "file.unknown_type", 1),
        ('[[joint]]\nname = "a"\ntype = "weld"\nbetween = ["A", "C"]\n', "names.duplicate", 2),
    ],
)
def test_faults_are_told_with_their_line(text: str, code: str, line: int, tmp_path: Path) -> None:
    ((found, where),) = refused(lambda: load(tmp_path, text))
    assert found == code and f"loops.toml:{line}" in where
