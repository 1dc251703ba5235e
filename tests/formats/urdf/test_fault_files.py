"""Bad robots: each begins with the codes it must raise, and text of the line each belongs to."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import symbody as sb
from symbody.errors import FormatError, ModelError, UsageError
from symbody.formats import model_from_urdf
from tests.effort import limited
from tests.faults.refusals import refused
from tests.formats.urdf.robots import arm, joint, link, robot

FILES = sorted((Path(__file__).parents[2] / "faults" / "robot_files").glob("*.urdf"))
EXPECTED = re.compile(r"<!-- expect (\S+) (.*) -->")  # "[" stands for "<"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_fault_is_told_with_its_line(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").split("\n")
    expected = [found.groups() for line in lines if (found := EXPECTED.match(line))]
    before = path.read_bytes()
    with limited(2):  # the limit promised for any input
        found = refused(lambda: sb.load_urdf(path), (FormatError, ModelError))  # type: ignore[arg-type]
    assert path.read_bytes() == before
    assert sorted(code for code, _ in found) == sorted(code for code, _ in expected)
    for code, text in expected:
        numbers = [k for k, line in enumerate(lines, 1)
                   if text.replace("[", "<") in line and not line.startswith("<!-- expect")]  # fmt: skip
        places = [where for own, where in found if own == code]
        assert any(re.search(f"{path.name}:{n}\\b", where) for n in numbers for where in places), places


def test_faults_of_the_call() -> None:
    text = arm("revolute")
    assert refused(lambda: model_from_urdf(text, symbolic=["B"]), UsageError, "no link 'B'")
    assert refused(lambda: model_from_urdf(text, snap_angles=3), UsageError)
    twice = robot('<link name="world"/>', link("A"), joint("q", "floating", "world", "A"))
    assert refused(lambda: model_from_urdf(twice, floating_base=True), UsageError, "floating base already")
    assert refused(lambda: sb.load_urdf("no_such_robot.urdf"), FormatError) == [
        ("file.missing", "no_such_robot.urdf")
    ]


def test_many_elements_are_bounded() -> None:
    assert refused(lambda: model_from_urdf(robot("<a/>" * 200_001))) == [("file.too_complex", "robot:2")]


def test_long_chains_are_no_recursion() -> None:
    links = [f'<link name="L{k}"/>' for k in range(3000)]
    joints = [joint(f"J{k}", "fixed", f"L{k}", f"L{k + 1}", '<origin xyz="0 0 1"/>') for k in range(2999)]
    frame = model_from_urdf(robot(*links, *joints)).ground["L2999"]
    assert frame.at[2].text == "2999"
