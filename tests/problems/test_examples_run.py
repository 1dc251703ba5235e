"""Every example: its model file loads, its script runs and prints, and the two are a pair."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from symbody.cli import run
from tests.problems.mechanisms import EXAMPLES, equations_of
from tests.tiers import cases

FOLDERS = sorted(path.name for path in EXAMPLES.iterdir() if (path / f"{path.name}.py").is_file())


# Examples of each kind: a tree, a loop, rolling, signals, a fit, an analysis.
QUICK = {"projectile", "four_bar", "parameter_fit", "spinning_top"}


@pytest.mark.parametrize("name", cases(FOLDERS, fast=QUICK))
def test_script_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each checks its own figures, and leaves at least two pictures where it is run."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / name / f"{name}.py"), run_name="__main__")
    assert capsys.readouterr().out.count("\n") >= 3
    pictures = sorted(tmp_path.iterdir())
    assert len(pictures) >= 2
    for picture in pictures:
        assert picture.name.startswith(name) and picture.suffix == ".png"
        pixels = imread(picture)[..., :3]
        assert np.ptp(pixels, axis=2).max() > 0.5  # coloured lines, not axes alone


HEADINGS = ("Description", "Concepts", "# Modeling", "# Simulation", "# Check", "# References")


@pytest.mark.parametrize("name", FOLDERS)
def test_scripts_have_the_headings_of_the_manual(name: str) -> None:
    lines = (EXAMPLES / name / f"{name}.py").read_text(encoding="utf-8").splitlines()
    places = [lines.index(heading) for heading in HEADINGS]
    assert places == sorted(places)
    for start, stop in zip(places, [*places[1:], len(lines)], strict=True):
        assert any(line.strip("# ") for line in lines[start + 1 : stop])
    assert any(line.startswith("assert ") for line in lines[places[4] : places[5]])


SYMBOLS = {
    "spring_mass_damper": ("m d k", "x", "F"),
    "projectile": ("m Inertia G", "X Y theta", ""),
    "rr_robot": ("m1 m2 I1 I2 L3 L4 L5 L6 G", "beta_1 beta_2", "T1 T2"),
    "spinning_top": ("m L A C G", "zeta eta xi", ""),
    "spinning_top_omega": ("m L A C G", "zeta eta xi", ""),
    "slider_crank": ("m1 m2 m3 I1 I2 L1 L2 G", "theta beta s", "F"),
}


@pytest.mark.parametrize("name", SYMBOLS)
def test_the_symbols_of_the_manual(name: str) -> None:
    """And its frames: CoM on every body, P at the robot's tip, Base at the top's."""
    eqs, (parameters, coordinates, inputs) = equations_of(name), SYMBOLS[name]
    assert eqs.parameter_names == tuple(parameters.split())
    assert eqs.coordinate_names == tuple(coordinates.split()) and eqs.input_names == tuple(inputs.split())
    for body in eqs.model.bodies:
        assert eqs.frame_motion("r", f"{body.name}.CoM", "Ground").shape == (3, 1)
    for frame in {"rr_robot": ["P"], "spinning_top": ["Base"], "spinning_top_omega": ["Base"]}.get(name, []):
        assert eqs.frame_motion("r", frame, "Ground", "Ground").shape == (3, 1)


# Free bodies for every leg of the platform: 20 s for its degrees of freedom.
SLOW = {
    "stewart_platform", "bicycle", "four_legs", "spatial_four_bar", "four_bar", "cart_pole", "quarter_car", "parameter_fit",
    "projectile",
}  # fmt: skip


@pytest.mark.parametrize("name", cases(FOLDERS, fast=lambda name: name not in SLOW))
def test_commands_read_the_model(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    for path in sorted((EXAMPLES / name).glob("*.toml")):
        freedoms = set()
        for arguments in ([], ["--tree", "joints"], ["--tree", "absolute"]):
            assert run(["check", str(path), *arguments]) == 0
            told = capsys.readouterr().out
            freedoms |= {line for line in told.splitlines() if line.startswith("degrees of freedom: ")}
        assert len(freedoms) == 1 and "not counted" not in freedoms.pop()
        assert run(["equations", str(path), "--tree", "joints"]) == 0
        assert " = " in capsys.readouterr().out


def test_examples_are_copied_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "projectile", "--copy", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "projectile.py", "projectile.toml", "projectile_free.toml",
    }  # fmt: skip
    capsys.readouterr()
    assert run(["examples"]) == 0
    listed = capsys.readouterr().out.split()  # the course notes come last: test_notes_run.py
    assert listed[: len(FOLDERS)] == FOLDERS
    assert all(name.startswith("notes/") for name in listed[len(FOLDERS) :])
