"""Every script of the course notes runs, prints, draws coloured pictures and is laid out like the others."""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

import symbody as sb
from symbody import mbsymba as mb
from symbody.cli import run
from symbody.visual.scene import make_scene
from tests.problems.mechanisms import EXAMPLES

NOTES = EXAMPLES / "notes"
NAMES = sorted(path.name for path in NOTES.iterdir() if path.is_dir())
# Two seconds and more each.
SLOW = {
    "constraints", "position_velocity", "index_reduction", "simulation", "virtual_work", "four_bar_spring",
    "slider_crank_four_ways", "quick_return", "inverted_pendulum", "inverse_dynamics", "linearization",
}  # fmt: skip
HEADINGS = ("Description", "Concepts", "# Modeling", "# Simulation", "# Check", "# References")


@pytest.fixture(autouse=True)
def no_gravity() -> Iterator[None]:
    yield
    mb.set_gravity(None)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.exhaustive] if name in SLOW else []) for name in NAMES]
)
def test_script_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each checks its own figures."""
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(NOTES / name / f"{name}.py"), run_name="__main__")
    for equations in filter(lambda value: isinstance(value, sb.EquationSet), names.values()):
        assert all(
            np.isfinite(frame.at).all()
            for body in make_scene(equations.model).bodies
            for frame in body.frames
        )
    assert capsys.readouterr().out.count("\n") >= 3
    pictures = sorted(tmp_path.iterdir())
    assert pictures
    for picture in pictures:
        assert picture.name.startswith(name) and picture.suffix == ".png"
        assert np.ptp(imread(picture)[..., :3], axis=2).max() > 0.5  # coloured lines, not axes alone
    assert mb.gravitational_energy([mb.make_BODY(mb.translate(0, 1, 0), 1)]) == 0  # gravity is put away


@pytest.mark.parametrize("name", NAMES)
def test_scripts_have_the_headings_of_the_others(name: str) -> None:
    lines = (NOTES / name / f"{name}.py").read_text(encoding="utf-8").splitlines()
    places = [lines.index(heading) for heading in HEADINGS]
    assert places == sorted(places)
    for start, stop in zip(places, [*places[1:], len(lines)], strict=True):
        assert any(line.strip("# ") for line in lines[start + 1 : stop])
    assert any(line.lstrip().startswith("assert ") for line in lines[places[4] : places[5]])
    assert f"| `{name}` |" in (NOTES / "README.md").read_text(encoding="utf-8")


def test_they_are_listed_printed_and_copied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert {f"notes/{name}" for name in NAMES} < set(listed) and "robot_arm" in listed
    assert run(["examples", "notes/friction"]) == 0
    assert capsys.readouterr().out == (NOTES / "friction" / "friction.py").read_text(encoding="utf-8")
    assert run(["examples", "notes/friction", "--copy", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["friction.py"]
    assert run(["examples", "friction"]) == 2
    assert "'notes/friction'" in capsys.readouterr().err
