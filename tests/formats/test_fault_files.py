"""Bad model files: each begins with the codes it must raise, and text of the line each belongs to."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from symbody.errors import FormatError, ModelError
from symbody.formats import load_model, model_from_toml

FOLDER = Path(__file__).parents[1] / "faults" / "model_files"
FILES = sorted(FOLDER.glob("*.toml"))
EXPECTED = re.compile(r"# expect (\S+) ?(.*)")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_fault_is_told_with_its_line(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").split("\n")
    expected = [found.groups() for line in lines if (found := EXPECTED.match(line))]
    assert expected
    with pytest.raises((FormatError, ModelError)) as caught:
        load_model(path)
    problems = caught.value.problems
    assert sorted(problem.code for problem in problems) == sorted(code for code, _ in expected)
    for code, text in expected:
        places = " ".join(problem.where for problem in problems if problem.code == code)
        numbers = [k + 1 for k, line in enumerate(lines) if text in line and not line.startswith("#")]
        if text:
            assert any(re.search(f"{path.name}:{number}\\b", places) for number in numbers), places
    for problem in problems:
        assert problem.what and problem.where.startswith(str(path))
        assert problem.fix, f"{problem.code} has no cure"


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("gravity = -9.81", 'write gravity = ["0", "-9.81", "0"]'),
        ("[joint]\ntype = 'revolute'", "write [[joint]] instead of [joint]"),
        ("[[body]]\nname = 'B'\ninertia = 'I'", "write the moments about x, y and z of the body"),
        (
            "[[joint]]\nname = 'A'\ntype = 'revolute'\nbetween = ['ground', 'B']\nforce = {applied = 'F'}",
            "the key is called 'torque'",
        ),
    ],
)
def test_what_newcomers_write_is_answered_by_what_to_write(text: str, cure: str) -> None:
    with pytest.raises(FormatError) as caught:
        model_from_toml(f"name = 'm'\n{text}\n")
    assert any(problem.fix.startswith(cure) for problem in caught.value.problems)
