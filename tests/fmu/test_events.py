"""Events in FMUs are found, judged and told as by `simulate`, whatever steps an importer takes."""

from __future__ import annotations

import ctypes
import re
import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest

import symbody as sb
from tests.fmu.importer import KINDS, VERSIONS, instance, simulate
from tests.fmu.test_switching import swing
from tests.problems.test_stick_slip import belt
from tests.tiers import cases

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
STARTS = {"slip": 0.0, "slip_dot": 0.0}


def oscillator() -> sb.EquationSet:
    """x = cos(t), and a force."""
    body = sb.Body("Block", mass=1)
    pull = sb.Drive(applied="F", stiffness=1)
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x", force=pull)
    return sb.form_equations(sb.Model("oscillator", [body, slide], inputs=["F"], initial={"x": 1.0}))


def told(path: Path, kind: str, end: float, steps: int, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return what an FMU logs."""
    capsys.readouterr()
    fmpy.simulate_fmu(
        str(path), stop_time=end, output_interval=end / steps, relative_tolerance=1e-10, fmi_type=kind,
        debug_logging=True, record_events=False,
    )  # fmt: skip
    return re.findall(r"\[OK\] (?:\[\w+\] )?(.* at t = .*|at t = .*)", capsys.readouterr().out)


@pytest.mark.parametrize("steps", cases([1, 100], fast=[1]))
def test_all_zeros_of_a_step_are_found_and_touches_too(
    steps: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A value that oscillates within a step, one that touches zero at 2 pi, one that comes to zero at pi/2."""
    events = [
        sb.Event("sin(40*t - 1)", name="fast"),
        sb.Event("x - 1", name="top"),
        sb.Event("x", -1, "stop", "end"),
    ]
    run = sb.simulate(oscillator(), 9.0, inputs={"F": 0.0}, events=events[:2], rtol=1e-10)
    assert len(run.events) > 100
    assert [event.t for event in run.events if event.name == "top"][-1] == pytest.approx(2 * np.pi, abs=1e-4)
    path = sb.save_fmu(oscillator(), tmp_path / "zeros.fmu", events=events[:2], sources=False).path
    logged = [
        re.fullmatch(r"event\.(\w+) at t = (\S+)", line)
        for line in told(path, "CoSimulation", 9.0, steps, capsys)
    ]
    seen = [(match[1], float(match[2])) for match in logged if match]
    assert [name for name, _ in seen] == [event.name for event in run.events]
    fast = np.array([t for name, t in seen if name == "fast"])
    assert np.abs(fast - [event.t for event in run.events if event.name == "fast"]).max() < 1e-12
    path = sb.save_fmu(oscillator(), tmp_path / "ends.fmu", events=events[2], sources=False).path
    with instance(path, "CoSimulation") as fmu:
        fmu.initialize(tolerance=1e-10)
        _, ends, _, reached = fmu.fmu.doStep(0.0, 9.0)
        assert ends and reached == pytest.approx(np.pi / 2, abs=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
def test_an_input_that_changes_before_an_event_that_lies_ahead(version: str, tmp_path: Path) -> None:
    """Steps lead beyond t = 0.5, where the value would pass zero 1e-4 later; with another input it does elsewhere."""
    eqs = oscillator()
    hit = sb.Event("x - cos(0.5001)", -1, {"x_dot": "-x_dot/2"}, "hit")
    law = {"F": "if(t < 0.5, 0, 30)"}
    run = sb.simulate(eqs, 1.5, times=[0.0, 0.5, 0.9, 1.5], inputs=law, events=hit, rtol=1e-11)
    assert {event.name for event in run.events} == {"hit"}
    path = sb.save_fmu(eqs, tmp_path / "hit.fmu", version, events=hit, sources=False).path
    with instance(path, "CoSimulation") as fmu:
        fmu.initialize(tolerance=1e-11)
        fmu.steps([0.0, 0.5])
        fmu.set("F", 30.0)
        fmu.steps([0.5, 0.9])
        # an FMU keeps its atol, 1e-10 of the size, at each of some hundred steps
        assert np.abs(np.array(fmu.get("x", "x_dot")) - [run["x"][-2], run["x_dot"][-2]]).max() < 1e-7
        kept = fmu.fmu.getFMUState() if version == "3.0" else fmu.fmu.getFMUstate()
        fmu.steps([0.9, 1.5])
        once = fmu.get("x", "x_dot")
        assert np.abs(np.array(once) - [run["x"][-1], run["x_dot"][-1]]).max() < 1e-7
        (fmu.fmu.setFMUState if version == "3.0" else fmu.fmu.setFMUstate)(kept)
        fmu.steps([0.9, 1.5])
        assert fmu.get("x", "x_dot") == once
        free = fmu.fmu.freeFMUState if version == "3.0" else fmu.fmu.freeFMUstate
        free(kept if isinstance(kept, ctypes.c_void_p) else ctypes.c_void_p(kept))


@pytest.mark.parametrize("kind", cases(KINDS, fast=["CoSimulation"]))
def test_stick_slip_belt_is_that_of_simulate(kind: str, tmp_path: Path) -> None:
    """den Hartog's oscillator: ten switches, whose times `tests/problems/test_stick_slip.py` has in closed form."""
    run = sb.simulate(belt(), 20.0, STARTS, times=np.linspace(0.0, 20.0, 21), rtol=1e-10, atol=1e-12)
    assert len(run.modes) > 5
    path = sb.save_fmu(belt(), tmp_path / "belt.fmu", initial=STARTS, sources=False).path
    seen = simulate(path, kind, 20.0, ["slip", "slip_dot"], 1e-10)
    error = np.abs(seen[0] - run["slip"]).max()
    assert error < (1e-8 if kind == "CoSimulation" else 1e-6)


@pytest.mark.parametrize("kind", cases(KINDS, fast=["ModelExchange"]))
def test_impacts_of_ropes_are_told_as_by_simulate(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = sb.simulate(swing("L", "1.1*L"), 1.5, rtol=1e-12, atol=1e-13)
    impacts = [note for note in run.notes if "impact" in note]
    assert len(impacts) == 3
    path = sb.save_fmu(swing("L", "1.1*L"), tmp_path / "swing.fmu", sources=False).path
    seen = [line for line in told(path, kind, 1.5, 15, capsys) if "impact" in line]
    numbers = re.compile(r"[-+0-9.e]*\d")
    assert len(seen) == len(impacts)
    for line, note in zip(seen, impacts, strict=True):
        words, expected = (numbers.sub("#", text) for text in (line, note))
        assert words == expected
        values, exact = ([float(x) for x in numbers.findall(text)] for text in (line, note))
        assert values == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("kind", cases(KINDS, fast=["ModelExchange"]))
def test_a_ball_bounces_as_by_simulate(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    limits = sb.Limits(low=0, rigid=True, restitution="e")
    rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=0.3), axis="z", coordinate="z", limits=limits)
    model = sb.Model("ball", [rail], (0, 0, -9.81), parameters={"e": 0.7}, initial={"z": 1.0})
    eqs = sb.form_equations(model)
    run = sb.simulate(eqs, 1.5, times=np.linspace(0.0, 1.5, 21), rtol=1e-10)
    path = sb.save_fmu(eqs, tmp_path / "ball.fmu", sources=False).path
    seen = simulate(path, kind, 1.5, ["z"], 1e-10)
    assert seen[0] == pytest.approx(run["z"], abs=1e-6)
    told_impacts = [
        line for line in told(path, kind, 1.5, 15, capsys) if "stops close with an impact" in line
    ]
    assert len(told_impacts) == sum(event.name == "rail low impact" for event in run.events) >= 2
    assert "rail low by 2.2" in told_impacts[0]  # m v (1 + e), up to the digits that follow


def test_a_mode_and_what_ends_it_have_names_of_their_own(tmp_path: Path) -> None:
    made = sb.save_fmu(belt(), tmp_path / "a.fmu", outputs=["mode contact"], platforms=())
    names = [variable.name for variable in made.variables if "mode" in variable.name]
    assert names == ["mode.contact", "mode_end.contact"]
