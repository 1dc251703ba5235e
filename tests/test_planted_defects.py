"""The tool that plants defects: what it marks, which mistakes it makes, and that tests are asked about them."""

from __future__ import annotations

import builtins
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests import planted_defects
from tests.planted_defects import Record, draw, judge, mark_blocks, mistakes, plant

TEXT = '''"""A page."""


def size(plans, name, x, y):
    """Return a size."""
    if x[0] > 0:
        return x[1] - y
    total = 0.0
    for value in x:
        total += -value
    return plans.get(("size", name), lambda: total + y) and x or y


def never():
    return 1
'''


def test_blocks_that_run_are_marked_and_the_module_does_the_same() -> None:
    tree, blocks = mark_blocks(TEXT, "page.py", 3)
    marks = bytearray(3 + len(blocks))
    names: dict[str, object] = {}
    setattr(builtins, planted_defects.MARKS, marks)
    try:
        exec(compile(tree, "page.py", "exec"), names)
        assert not any(marks)
        assert names["size"]({}, "a", [2, 5], 1) == 4  # type: ignore[operator]
    finally:
        delattr(builtins, planted_defects.MARKS)
    done = [block for block, mark in zip(blocks, marks[3:], strict=True) if mark]
    assert done == [("page.py", 6, 7), ("page.py", 7, 7)]
    assert names["size"].__doc__ == "Return a size."


def test_mistakes_of_each_kind() -> None:
    made = {(place.kind, place.before, place.after) for place in mistakes(TEXT, "page.py")}
    assert made == {
        ("sign", "x[1] - y", "(x[1] + y)"), ("term", "x[1] - y", "(x[1])"),
        ("sign", "total + y", "(total - y)"), ("term", "total + y", "(total)"), ("sign", "-value", "(value)"),
        ("index", "x[0]", "x[1]"), ("index", "x[1]", "x[2]"),
        ("cache", 'plans.get(("size", name), lambda: total + y)', "plans.get(('size',), lambda: total + y)"),
        ("term", 'plans.get(("size", name), lambda: total + y) and x or y',
         "(plans.get(('size', name), lambda: total + y) and x)"),
        ("term", 'plans.get(("size", name), lambda: total + y) and x',
         "(plans.get(('size', name), lambda: total + y))"),
    }  # fmt: skip


@pytest.fixture
def package(tmp_path: Path) -> Path:
    (tmp_path / "page.py").write_text(TEXT)
    return tmp_path


RECORD = Record(
    {
        ("page.py", 6, 7): frozenset({"tests/a.py"}),
        ("page.py", 7, 7): frozenset({"tests/b.py", "tests/a.py"}),
    },
    {"tests/a.py": 3.0, "tests/b.py": 2.0},
)


def test_places_are_drawn_by_the_seed_from_blocks_that_run(package: Path) -> None:
    drawn = draw(RECORD, 1, 30, package)
    assert drawn == draw(RECORD, 1, 30, package)
    assert {place.line for place in drawn} <= {6, 7} and {place.kind for place in drawn} == {
        "sign",
        "index",
        "term",
    }
    (place,) = (place for place in drawn if place.kind == "sign")
    assert RECORD.tests_of(place) == ["tests/b.py", "tests/a.py"]
    plant(place, package)
    assert (package / "page.py").read_text() == TEXT.replace("x[1] - y", "(x[1] + y)")
    with pytest.raises(ValueError, match="changed"):
        plant(place, package)


def test_the_first_test_that_fails_finds_a_defect() -> None:
    file = next(
        path
        for path in sorted(planted_defects.PACKAGE.glob("spatial/*.py"))
        if mistakes(path.read_text(), "")
    )
    place = mistakes(file.read_text(), str(file.relative_to(planted_defects.PACKAGE)))[0]
    asked: list[tuple[bool, list[str]]] = []

    def run(command: list[str], *, env: dict[str, str], **more: object) -> object:
        tests = [word for word in command if word.startswith("tests/")]
        is_planted = (Path(env["PYTHONPATH"]) / "symbody" / place.file).read_bytes() != file.read_bytes()
        asked.append((is_planted, tests))
        fails = "tests/k.py" in tests[:3] or "tests/a.py::test_anywhere" in tests[:1]
        name = "tests/k.py::test_it" if "tests/k.py" in tests else "tests/a.py::test_anywhere"
        is_first = len(asked) == 1 or fails
        return SimpleNamespace(returncode=int(is_first), stdout=f"FAILED {name} - assert 0\n")

    files = [f"tests/{letter}.py" for letter in "abcdefghijk"]
    assert judge(place, files, 60.0, run) == "tests/k.py::test_it"
    anywhere = "tests/a.py::test_anywhere"
    assert asked == [
        (True, files[:8]), (False, [anywhere]), (True, [*files[:8], anywhere]),
        (True, [*files[8:], anywhere]), (False, ["tests/k.py::test_it"]),
    ]  # fmt: skip

    def wait(command: list[str], **more: object) -> object:
        raise subprocess.TimeoutExpired(command, 1.0)

    assert judge(place, files, 60.0, wait) == ""
