"""Programs along whose motions more happens: events, samples, prescribed rates that jump."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from tests.tiers import cases

COMMANDS = {
    "c": ("m.c", [["cc", "-std=c99", "-O1", "-ffp-contract=off", "m.c", "-o", "m", "-lm"], ["./m"]]),
    "javascript": ("m.js", [["node", "m.js"]]),
    "python": ("m.py", [[sys.executable, "-I", "m.py"]]),
}
TIMES = np.linspace(0.0, 2.0, 9)


def run_program(folder: Path, language: str, text: str) -> tuple[np.ndarray, list[str], int]:
    """Samples, lines of the error output, and the exit status."""
    file, commands = COMMANDS[language]
    (folder / file).write_text(text, encoding="utf-8")
    for command in commands:
        if shutil.which(command[0]) is None and command[0] != "./m":
            pytest.skip(f"needs {command[0]}")
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    rows = [[float(word) for word in line.split(",")] for line in done.stdout.strip().split("\n")[1:]]
    return np.array(rows), done.stderr.strip().split("\n"), done.returncode


def ball(*parts: sb.Element, force: str = "0") -> sb.EquationSet:
    slide = sb.Prismatic(
        "slide", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z", force=sb.Drive(applied=force)
    )
    return sb.form_equations(sb.Model("ball", [slide, *parts], gravity=(0, 0, -9.81)))


FLOOR = sb.Event("z", -1, {"z_dot": "-0.8*z_dot"}, name='the "floor"\\?')


@pytest.mark.parametrize("language", COMMANDS)
def test_events_happen_as_in_simulate_and_are_listed(language: str, tmp_path: Path) -> None:
    events = [FLOOR, sb.Event("z_dot", -1, name="top"), sb.Event("t - 1.7", 1, "stop", name="enough")]
    text = sb.generate_simulation(ball(), 2.0, language, initial={"z": 1.0}, times=TIMES, events=events)
    samples, lines, status = run_program(tmp_path, language, text)
    run = sb.simulate(ball(), 2.0, {"z": 1.0}, times=TIMES, events=events)
    assert status == 0
    np.testing.assert_array_equal(samples[:, 0], run.t)
    np.testing.assert_allclose(samples[:, 2], run["z"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(samples[:, 3], run["work"], rtol=1e-12)
    assert [line.rpartition(": t = ")[0] for line in lines] == [f"event {event.name}" for event in run.events]
    times = [float(line.rpartition(" = ")[2]) for line in lines]
    np.testing.assert_allclose(times, [event.t for event in run.events], rtol=1e-14)


@pytest.mark.parametrize("language", cases(COMMANDS, fast=["c"]))
def test_a_motion_ended_by_a_fault_of_an_event_fails(language: str, tmp_path: Path) -> None:
    """Bounces of a ball end: their times converge, which is chattering."""
    text = sb.generate_simulation(ball(), 20.0, language, initial={"z": 1.0}, times=[0, 20], events=FLOOR)
    samples, lines, status = run_program(tmp_path, language, text)
    run = sb.simulate(ball(), 20.0, {"z": 1.0}, events=FLOOR)
    assert run.status is sb.Status.CHATTERING
    assert status == 1
    assert lines[-1] == f"{FLOOR.name} ended the motion (code 10)"
    assert len(lines) - 1 == len(run.events)
    assert samples[-1, 0] == pytest.approx(run.t[-1], rel=1e-9)


def test_functions_return_what_happened(tmp_path: Path) -> None:
    events = [FLOOR, sb.Event("z_dot", -1, name="top")]
    text = sb.generate_simulation(ball(), 1.0, "python", initial={"z": 1.0}, events=events)
    space: dict[str, object] = {"__name__": "motion"}
    exec(compile(text, "motion.py", "exec"), space)  # noqa: S102
    code, rows, happened, culprit = space["simulate"]()  # type: ignore[operator]
    assert (code, len(rows), culprit) == (2, 101, "")
    fall = float(np.sqrt(2 / 9.81))
    assert [name for name, _, _ in happened] == [FLOOR.name, "top"]
    assert happened[0][1] == pytest.approx(fall, rel=1e-12)
    np.testing.assert_allclose(happened[0][2][:2], [-9.81 * fall, 0.0], atol=1e-12)
    if shutil.which("node") is None:
        return
    text = sb.generate_simulation(ball(), 1.0, "javascript", initial={"z": 1.0}, events=events)
    (tmp_path / "m.cjs").write_text(text)
    call = "const r = require('./m.cjs').simulate(); console.log(JSON.stringify(r))"
    done = subprocess.run(["node", "-e", call], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert [tuple(each.values())[:2] for each in found["events"]] == [each[:2] for each in happened]


@pytest.mark.parametrize("language", cases(COMMANDS, fast=["javascript"]))
def test_thousands_of_steps_samples_and_events_fit_into_the_room(language: str, tmp_path: Path) -> None:
    """A fast clock, and a force that is sampled at it: room for steps, samples and events is used again."""
    count = 700 if language == "python" else 5000
    push = sb.Signal("push", "9.81 - 20*z - z_dot", sample=1 / 1000)
    eqs, end = ball(push, force="push"), count / 1000
    clock = sb.Event("sin(1000*pi*t)", 0, name="clock")
    text = sb.generate_simulation(eqs, end, language, initial={"z": 1.0}, times=[0, end], events=clock)
    samples, lines, status = run_program(tmp_path, language, text)
    run = sb.simulate(eqs, end, {"z": 1.0}, times=[0, end], events=clock)
    assert status == 0
    assert len(lines) == len(run.events) >= count - 1
    np.testing.assert_allclose(samples[-1, 1:3], [run["z_dot"][-1], run["z"][-1]], rtol=1e-7)


def carried(as_constraint: bool) -> sb.EquationSet:
    """A pendulum on a cart whose rate jumps at t = 1."""
    bar = sb.Body("Bar", mass=1.5, inertia=(0.1,) * 3, frames={"eye": sb.Frame(at=(0, 0, 0.7))})
    parts = [
        bar,
        sb.Prismatic("slide", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
                     motion="if(t < 1, 0, 1.5*(t - 1))", as_constraint=as_constraint),
        sb.Revolute("pin", "Cart", "Bar.eye", axis="y", coordinate="th"),
    ]  # fmt: skip
    return sb.form_equations(sb.Model("struck", parts, gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("events", [(), sb.Event("th_dot - 1", 1, name="jumped")], ids=["plain", "watched"])
@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("span", cases([(0.0, 2.0), (0.0, 1.0), (0.25, 1.5)], fast=[(0.25, 1.5)]), ids=str)
def test_rates_that_jump_strike_as_in_simulate(
    events: sb.Event | tuple[()], as_constraint: bool, span: tuple[float, float], tmp_path: Path
) -> None:
    eqs, times = carried(as_constraint), np.linspace(*span, 9)
    options = {"times": times, "events": events, "rtol": 1e-10}
    text = sb.generate_simulation(eqs, span, "javascript", initial={"th": 0.4}, **options)  # type: ignore[arg-type]
    samples, lines, status = run_program(tmp_path, "javascript", text)
    run = sb.simulate(eqs, span, {"th": 0.4}, **options)  # type: ignore[arg-type]
    assert status == 0
    np.testing.assert_array_equal(samples[:, 0], run.t)
    np.testing.assert_allclose(samples[:, -1], run["work"], rtol=0, atol=1e-8)
    for name in ("th", "th_dot"):
        place = [*eqs.state_names].index(name)
        np.testing.assert_allclose(samples[:, 1 + place], run[name], rtol=0, atol=1e-8)
    found = [float(line.rpartition(" = ")[2]) for line in lines if line]
    if events:  # the rate passes 1 at the jump, also where that is the end of the motion
        assert min(abs(t - 1.0) for t in found) < 1e-12
    if span[1] != 1.0:
        np.testing.assert_allclose(found, [event.t for event in run.events], rtol=1e-9)


def stiff_ball(*parts: sb.Element) -> sb.EquationSet:
    """A ball that hops on a floor, with a mass on a stiff damped spring."""
    ball = sb.Prismatic("slide", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z")
    spring = sb.Drive(applied="-4e6*y - 4e3*y_dot")
    mass = sb.Prismatic("shake", "Ball", sb.Body("Mass", mass=0.1), axis="y", coordinate="y", force=spring)
    model = sb.Model("stiff", [ball, mass, *parts], gravity=(0, -20, -9.81), initial={"z": 1.0, "y": 1e-3})
    return sb.form_equations(model)


@pytest.mark.exhaustive
def test_stiff_motions_by_generalized_alpha_in_every_language(tmp_path: Path) -> None:
    """The same bits in all, and the motion of `simulate` by this method, to the tolerance of each."""
    options = {"times": TIMES, "events": FLOOR, "rtol": 1e-6, "integrator": sb.GeneralizedAlpha()}
    run = sb.simulate(stiff_ball(), 2.0, **options)  # type: ignore[arg-type]
    assert len(run.events) > 1
    printed = []
    for language in COMMANDS:
        text = sb.generate_simulation(stiff_ball(), 2.0, language, **options)  # type: ignore[arg-type]
        samples, lines, status = run_program(tmp_path, language, text)
        assert status == 0 and len(lines) == len(run.events)
        printed.append(samples)
    np.testing.assert_array_equal(printed[0], printed[1])
    np.testing.assert_array_equal(printed[0], printed[2])
    np.testing.assert_allclose(printed[0][:, 1:-1].T, np.vstack([run.u, run.q]), rtol=0, atol=1e-5)


@pytest.mark.parametrize("step", cases([None, 1e-3], fast=[None]))
def test_rates_jump_in_programs_by_generalized_alpha(step: float | None, tmp_path: Path) -> None:
    eqs, times = carried(as_constraint=True), np.linspace(0.25, 1.5, 6)
    method = sb.GeneralizedAlpha(step=step)
    text = sb.generate_simulation(
        eqs, (0.25, 1.5), "c", initial={"th": 0.4}, times=times, integrator=method, rtol=1e-7
    )
    samples, _, status = run_program(tmp_path, "c", text)
    exact = sb.simulate(eqs, (0.25, 1.5), {"th": 0.4}, times=times, rtol=1e-10)
    own = sb.simulate(eqs, (0.25, 1.5), {"th": 0.4}, times=times, integrator=method, rtol=1e-7)
    assert status == 0
    error = np.abs(samples[:, 1:-1].T - np.vstack([exact.u, exact.q])).max()
    assert error < 2 * np.abs(np.vstack([own.u - exact.u, own.q - exact.q])).max() < 1e-3


def test_what_programs_do_not_take_is_refused() -> None:
    with pytest.raises(sb.UsageError, match="is not an event"):
        sb.generate_simulation(ball(), 1.0, events=["z"])  # type: ignore[list-item]
    with pytest.raises(sb.UsageError, match="another event has this name"):
        sb.generate_simulation(ball(), 1.0, events=[sb.Event("z"), sb.Event("z")])
    with pytest.raises(sb.UsageError, match="s is a sampled signal"):
        sb.generate_simulation(ball(sb.Signal("s", "z", sample=0.1)), 1.0, inputs={"s": 1.0})
    with pytest.raises(sb.UsageError, match="time runs backward, but these values are sampled: s"):
        sb.generate_simulation(ball(sb.Signal("s", "z", sample=0.1)), (1.0, 0.0))
