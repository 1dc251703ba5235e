"""FMUs in FMPy at length: all examples, tolerances, events, parameters, threads, couplings, files."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

import symbody as sb
from tests.fmu.importer import (
    KINDS,
    NAMES,
    VERSIONS,
    check_archive,
    instance,
    pendulum,
    simulate,
    states,
)
from tests.mechanisms import example

pytestmark = [
    pytest.mark.exhaustive,
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_examples_are_valid(name: str, version: str, tmp_path: Path) -> None:
    made = sb.save_fmu(example(name), tmp_path / f"{name}.fmu", version, platforms=())
    check_archive(made.path, version)


def ball() -> sb.EquationSet:
    body = sb.Body("Ball", mass=1)
    slide = sb.Prismatic("fall", "ground", "Ball", axis="y", coordinate="y")
    return sb.form_equations(sb.Model("ball", [body, slide], (0, -9.81, 0), {"e": 0.7}, [], {"y": 1.0}))


BOUNCE = sb.Event("y", -1, {"y_dot": "-e*y_dot"}, "bounce")


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_ball_bounces_when_it_should(kind: str, version: str, tmp_path: Path) -> None:
    # The reference FMU: e = 0.7, h = 1 m, first contact at sqrt(2 h/g) = 0.451524 s, the next 2 e t later.
    made = sb.save_fmu(ball(), tmp_path / "ball.fmu", version, events=[BOUNCE])
    assert validate_fmu(str(made.path)) == []
    first = math.sqrt(2 / 9.81)
    end = 2.0
    t = np.linspace(0.0, end, 21)
    seen = simulate(made.path, kind, end, ["y", "y_dot"], 1e-10)
    y, start, speed = np.empty_like(t), 0.0, 0.0
    contacts = [first]
    while contacts[-1] < end:
        contacts.append(contacts[-1] + 2 * first * 0.7 ** len(contacts))
    for k, time in enumerate(t):
        n = sum(contact <= time for contact in contacts)
        start, speed = (contacts[n - 1], 9.81 * first * 0.7**n) if n else (0.0, 0.0)
        y[k] = (0.0 if n else 1.0) + speed * (time - start) - 9.81 / 2 * (time - start) ** 2
    assert np.abs(seen[0] - y).max() < 1e-7


@pytest.mark.parametrize("version", VERSIONS)
def test_event_that_stops_ends_the_motion(version: str, tmp_path: Path) -> None:
    made = sb.save_fmu(ball(), tmp_path / "ball.fmu", version, events=[sb.Event("y", -1, "stop", "ground")])
    result = fmpy.simulate_fmu(str(made.path), stop_time=2.0, output_interval=0.1, fmi_type="ModelExchange")
    assert result["time"][-1] < 0.5


@pytest.mark.parametrize("version", VERSIONS)
def test_parameter_changes_in_the_course_of_a_motion(version: str, tmp_path: Path) -> None:
    eqs = example("slider_crank")
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu", version)
    mass = 1.05 * float(sb.simulate(eqs, 0.0).parameters["m3"])
    x = dict(zip(eqs.state_names, states(sb.simulate(eqs, 1.0, rtol=1e-10))[:, -1], strict=True))
    free = {name: x[name] for name in ("theta", "theta_dot")}
    run = sb.simulate(eqs, 0.5, initial=free, guess=x, parameters={"m3": mass}, rtol=1e-10)
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize(tolerance=1e-10)
        fmu.steps(np.linspace(0.0, 1.0, 11).tolist())
        fmu.set("m3", mass)
        fmu.steps(np.linspace(1.0, 1.5, 6).tolist())
        assert fmu.get(*eqs.state_names) == pytest.approx(states(run)[:, -1], abs=1e-6)


@pytest.mark.parametrize("version", VERSIONS)
def test_parameter_changes_in_model_exchange(version: str, tmp_path: Path) -> None:
    eqs = example("slider_crank")
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu", version)  # type: ignore[arg-type]
    mass = 1.05 * float(sb.simulate(eqs, 0.0).parameters["m3"])
    x = dict(zip(eqs.state_names, states(sb.simulate(eqs, 1.0, rtol=1e-11))[:, -1], strict=True))
    free = {name: x[name] for name in ("theta", "theta_dot")}
    run = sb.simulate(eqs, 0.5, initial=free, guess=x, parameters={"m3": mass}, rtol=1e-11)
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize()
        update = fmu.fmu.newDiscreteStates if version == "2.0" else fmu.fmu.updateDiscreteStates
        rates = [f"der({name})" for name in eqs.state_names]

        def slope(t: float, x: list[float]) -> list[float]:
            fmu.fmu.setTime(t)
            fmu.set_states(list(x))
            return fmu.get(*rates)

        state = fmu.get(*eqs.state_names)
        for start, end in ((0.0, 1.0), (1.0, 1.5)):
            update()
            fmu.fmu.enterContinuousTimeMode()
            state = solve_ivp(slope, (start, end), state, rtol=1e-10, atol=1e-11, method="DOP853").y[:, -1]
            slope(end, state)
            fmu.fmu.enterEventMode()
            fmu.set("m3", mass)
        assert fmu.get(*eqs.state_names) == pytest.approx(states(run)[:, -1], abs=1e-6)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_length_of_a_loop_changes_in_the_course_of_a_motion(kind: str, version: str, tmp_path: Path) -> None:
    eqs = example("slider_crank")
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu", version)
    with instance(made.path, kind) as fmu:
        fmu.initialize()
        length = 1.05 * fmu.get("L1")[0]
        if kind == "CoSimulation":
            fmu.steps([0.0, 0.1])
            fmu.set("L1", length)
            fmu.steps([0.1, 0.1 + 1e-9])
        else:
            fmu.set("L1", length)  # in event mode
            update = fmu.fmu.newDiscreteStates if version == "2.0" else fmu.fmu.updateDiscreteStates
            assert update()[3]  # values of states changed
        assert fmu.get("constraint_violation")[0] < 1e-9
        assert fmu.get("L1") == [length]


def test_fixed_parameters_stay(tmp_path: Path) -> None:
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", fixed=["l"])
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize({"l": 1.2})
        fmu.set("m", 3.0)
        with pytest.raises(Exception, match="fmi3SetFloat64"):
            fmu.set("l", 1.3)


def test_threads_do_not_see_each_other(tmp_path: Path) -> None:
    eqs = example("slider_crank")
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu")
    results: dict[float, list[list[float]]] = {0.2: [], 0.9: []}
    times = np.linspace(0.0, 2.0, 201).tolist()
    with instance(made.path, "CoSimulation") as one, instance(made.path, "CoSimulation") as two:

        def run(fmu: object, angle: float) -> None:
            fmu.initialize({"theta": angle})  # type: ignore[attr-defined]
            fmu.steps(times)  # type: ignore[attr-defined]
            results[angle].append(fmu.get(*eqs.state_names))  # type: ignore[attr-defined]

        threads = [threading.Thread(target=run, args=pair) for pair in ((one, 0.2), (two, 0.9))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    for angle in results:
        with instance(made.path, "CoSimulation") as fmu:
            run(fmu, angle)
        assert results[angle][0] == results[angle][1]


def test_coupling_error_halves_with_the_step(tmp_path: Path) -> None:
    # A drive T = -k theta - d theta_dot beside a pendulum, and the same in one model.
    eqs = pendulum()
    made = sb.save_fmu(eqs, tmp_path / "pendulum.fmu")
    whole = sb.simulate(eqs, 1.0, inputs={"T": "-4*theta - 1*theta_dot"}, rtol=1e-11).q[0, -1]
    errors = []
    for count in (50, 100, 200):
        with instance(made.path, "CoSimulation") as fmu:
            fmu.initialize(tolerance=1e-10)
            for k in range(count):
                theta, rate = fmu.get("theta", "theta_dot")
                fmu.set("T", -4 * theta - rate)
                fmu.steps([k / count, (k + 1) / count])
            errors.append(abs(fmu.get("theta")[0] - whole))
    assert errors[0] > 1.8 * errors[1] > 3.2 * errors[2] > 0.0, errors


def shaft(coupled: bool) -> sb.EquationSet:
    """A driven rotor that turns a pendulum by an elastic shaft; alone the pendulum's angle is an input."""
    rotor = sb.Body("Rotor", mass=1, inertia=(0, 0, "J"))
    torque = (
        "M - k*(phi - theta) - d*(phi_dot - theta_dot)" if coupled else "M - k*(phi - a) - d*(phi_dot - b)"
    )
    drive = sb.Revolute("drive", "ground", "Rotor", coordinate="phi", torque=sb.Drive(applied=torque))
    values, inputs = {"J": 0.5, "M": 2.0, "k": 20.0, "d": 1.0}, [] if coupled else ["a", "b"]
    elements: list[sb.Body | sb.Revolute] = [rotor, drive]
    gravity, start = (0, -9.81, 0), {"phi": 0.3}
    if coupled:
        whole = pendulum().model
        back = sb.Drive(applied="k*(phi - theta) + d*(phi_dot - theta_dot)")
        pin = sb.Revolute("pin", "ground", "Rod.pin", coordinate="theta", torque=back)
        elements += [whole.body("Rod"), pin]
        values |= {"m": 2.0, "l": 1.5}
        start["theta"] = 0.3
    return sb.form_equations(sb.Model("shaft", elements, gravity, values, inputs, start))


def test_two_coupled_fmus_come_to_the_whole_model(tmp_path: Path) -> None:
    """A drive and a mechanism: with values held over a step the error halves with it."""
    torque = "k*(phi - a) + d*(phi_dot - b)"
    first = sb.save_fmu(shaft(coupled=False), tmp_path / "drive.fmu", outputs=[torque])
    second = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", "2.0")
    name = first.variables[-1].name
    whole = sb.simulate(shaft(coupled=True), 1.0, rtol=1e-11)
    errors = []
    for count in (100, 200, 400):
        with instance(first.path, "CoSimulation") as drive, instance(second.path, "CoSimulation") as arm:
            drive.initialize(tolerance=1e-10)
            arm.initialize(tolerance=1e-10)
            for k in range(count):
                theta, rate = arm.get("theta", "theta_dot")
                drive.set("a", theta)
                drive.set("b", rate)
                arm.set("T", drive.get(name)[0])
                for fmu in (drive, arm):
                    fmu.steps([k / count, (k + 1) / count])
            errors.append(abs(arm.get("theta")[0] - whole["theta"][-1]))
    assert errors[0] > 1.8 * errors[1] > 3.2 * errors[2] > 0.0, errors


def stiff() -> sb.EquationSet:
    """A swinging rod with a small mass on a stiff, damped spring in its middle."""
    end = sb.Body("End", mass=0.02)
    whole = pendulum().model
    pin = sb.Revolute("pin", "ground", "Rod.pin", coordinate="theta")
    spring = sb.Drive(stiffness="1e6", damping="1")
    slide = sb.Prismatic("slide", "Rod", end, axis="x", coordinate="s", force=spring)
    elements = [whole.body("Rod"), end, pin, slide]
    start = {"theta": 0.3, "s": 1e-4}
    return sb.form_equations(sb.Model("stiff", elements, (0, -9.81, 0), {"m": 2.0, "l": 1.5}, [], start))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("make", [stiff, lambda: example("slider_crank")], ids=["stiff", "crank"])
def test_generalized_alpha_in_co_simulation(make: object, version: str, tmp_path: Path) -> None:
    eqs = make()  # type: ignore[operator]
    free = dict.fromkeys(eqs.input_names, 0)
    made = sb.save_fmu(
        eqs,
        tmp_path / "implicit.fmu",
        version,
        integrator=sb.GeneralizedAlpha(),  # type: ignore[arg-type]
    )
    times = np.linspace(0.0, 0.2, 21)
    exact = states(sb.simulate(eqs, 0.2, times=times, rtol=1e-10, inputs=free, integrator=sb.Stiff()))
    ours = sb.simulate(eqs, 0.2, times=times, rtol=1e-5, inputs=free, integrator=sb.GeneralizedAlpha())
    seen = simulate(made.path, "CoSimulation", 0.2, eqs.state_names, 1e-5)
    sizes = np.abs(exact).max(axis=1, keepdims=True)
    error = np.abs(states(ours) - exact) / sizes
    assert (np.abs(seen - exact) / sizes).max() < 2.0 * error.max()


@pytest.mark.parametrize("version", VERSIONS)
def test_library_needs_the_c_library_alone(version: str, tmp_path: Path) -> None:
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", version)
    with zipfile.ZipFile(made.path) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".so"))
        archive.extract(name, tmp_path)
    defined = subprocess.run(
        ["nm", "-D", "--defined-only", str(tmp_path / name)], capture_output=True, text=True, check=True
    ).stdout
    symbols = {line.split()[-1] for line in defined.splitlines()}
    assert symbols and all(symbol.startswith(f"fmi{version[0]}") for symbol in symbols)
    dynamic = subprocess.run(
        ["readelf", "-d", str(tmp_path / name)], capture_output=True, text=True, check=True
    ).stdout
    needed = re.findall(r"NEEDED.*\[(.*)\]", dynamic)
    assert {library.partition(".")[0] for library in needed} <= {"libc", "libm"}
    data = subprocess.run(["nm", str(tmp_path / name)], capture_output=True, text=True, check=True).stdout
    changing = {line.split()[-1] for line in data.splitlines() if re.search(r" [bBcC] ", line)}
    assert not [name for name in changing if not name.startswith("completed")]  # of the compiler's own start


def test_crank_stays_closed_for_a_minute(tmp_path: Path) -> None:
    eqs = example("slider_crank")
    made = sb.save_fmu(eqs, tmp_path / "crank.fmu")
    result = fmpy.simulate_fmu(
        str(made.path), stop_time=60.0, output_interval=0.1, relative_tolerance=1e-6,
        fmi_type="ModelExchange", record_events=False, output=["theta", "beta", "constraint_violation"],
    )  # fmt: skip
    assert result["time"][-1] == pytest.approx(60.0)
    assert result["constraint_violation"].max() < 1e-6


@pytest.mark.parametrize("version", VERSIONS)
def test_sources_build_by_themselves(version: str, tmp_path: Path) -> None:
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", version, platforms=())
    subprocess.run(
        [sys.executable, "-m", "fmpy", "compile", str(made.path)], check=True, capture_output=True,
        env={**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"},
    )  # fmt: skip
    seen = simulate(made.path, "CoSimulation", 1.0, ["theta"], 1e-8)
    run = sb.simulate(pendulum(), 1.0, times=np.linspace(0.0, 1.0, 21))
    assert np.abs(seen[0] - run.q[0]).max() < 1e-6
