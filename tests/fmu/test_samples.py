"""FMUs of mechanisms with sampled signals and blocks: held values change at their instants."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.fmu.importer import KINDS, VERSIONS, Instance, check_archive, instance, simulate, states
from tests.mechanisms import example

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
START = {"theta": 0.1}


def relay() -> sb.EquationSet:
    """A heavy slider on a dry guide, pulled by a relay with a sampled measurement, that bounces at a wall."""
    body = sb.Body("Slider", mass="m")
    pull = sb.Drive(applied="relay - 2*x_dot + if(t < 0.35, 3, 0)")
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x", force=pull)
    switch = sb.Hysteresis("relay", "x", lower=-0.1, upper=0.15, low=6, high=-7, sample="T", initial=6)
    counter = sb.Signal("count", "count + 1", sample="3*T", initial=-1)
    last = sb.Signal("last", output="energy", sample=0.1)
    model = sb.Model(
        "relay", [body, slide, switch, counter, last], (0, 0, -9.81), {"m": 1.3, "T": 0.05}, [], {"x": 0.2}
    )
    return sb.form_equations(model)


def dry() -> sb.EquationSet:
    """A block on a dry plane whose pull is sampled: it sticks and slips at samples."""
    body = sb.Body("Block", mass=2)
    pull = sb.Drive(applied="pull")
    friction = sb.Friction(0.3, mu_static=0.4)
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x", friction=friction, force=pull)
    signal = sb.Signal("pull", "12*sin(3*t) - 5*x + F", sample=0.1)
    return sb.form_equations(sb.Model("block", [body, slide, signal], (0, 0, -9.81), {}, ["F"], {"x": 1.0}))


def held(run: sb.Trajectory) -> Any:
    assert run.held_values is not None
    return np.array([run[name] for name in run.held_values.names])


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> tuple[sb.EquationSet, sb.Fmu]:
    eqs = example("cart_pole_pid")
    return eqs, sb.save_fmu(eqs, tmp_path_factory.mktemp("cart") / "cart.fmu", initial=START)


def integrate(fmu: Instance, names: tuple[str, ...], end: float) -> list[list[float]]:
    """Integrate model exchange between time events, finely; return states and times of events."""
    update = fmu.fmu.newDiscreteStates if fmu.version == "2.0" else fmu.fmu.updateDiscreteStates
    rates = [f"der({name})" for name in names]

    def slope(t: float, x: list[float]) -> list[float]:
        fmu.fmu.setTime(t)
        fmu.set_states(list(x))
        return fmu.get(*rates)

    t, events = 0.0, []
    while t < end:
        *_, has_next, event = update()
        fmu.fmu.enterContinuousTimeMode()
        stop = min(event, end) if has_next else end
        x = solve_ivp(slope, (t, stop), fmu.get(*names), rtol=1e-9, atol=1e-11, method="DOP853").y[:, -1]
        slope(stop, x)
        t = stop
        events.append(t)
        fmu.fmu.enterEventMode()
    update()
    return [fmu.get(*names), events]


def test_digital_controller_holds_its_pole(cart: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = cart
    check_archive(made.path, "3.0")
    kinds = {v.name: (v.causality, v.variability) for v in made.variables}
    assert kinds["servo"] == kinds["lean"] == ("local", "discrete")
    assert kinds["dt"] == ("parameter", "fixed")  # a sample time cannot change in the course of a motion
    assert not any(v.causality == "input" for v in made.variables)
    run = sb.simulate(eqs, 2.0, initial=START, times=np.linspace(0.0, 2.0, 21), rtol=1e-9)
    names = [*eqs.state_names, *run.held_values.names]  # type: ignore[union-attr]
    seen = simulate(made.path, "CoSimulation", 2.0, names, 1e-8)
    np.testing.assert_allclose(seen, np.vstack([states(run), held(run)]), rtol=1e-6, atol=1e-7)


def test_time_events_are_the_instants_of_samples(cart: tuple[sb.EquationSet, sb.Fmu]) -> None:
    eqs, made = cart
    run = sb.simulate(eqs, 0.5, initial=START, rtol=1e-11)
    with instance(made.path, "ModelExchange") as fmu:
        fmu.initialize({"theta": 0.1})
        x, events = integrate(fmu, eqs.state_names, 0.5)
        assert events == pytest.approx([0.01 * k for k in range(1, 51)], abs=1e-15)
        assert x == pytest.approx(states(run)[:, -1].tolist(), abs=1e-8)
        assert fmu.get("servo") == pytest.approx([run["servo"][-1]], abs=1e-6)


def test_sample_times_and_values_before_the_first_sample_are_set_before_the_motion(
    cart: tuple[sb.EquationSet, sb.Fmu], capfd: pytest.CaptureFixture[str]
) -> None:
    eqs, made = cart
    run = sb.simulate(eqs, 0.5, initial={**START, "servo_integral": 2}, parameters={"dt": 0.02}, rtol=1e-10)
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize({"dt": 0.02, "servo_integral": 2.0}, tolerance=1e-10)
        fmu.steps([0.013 * k for k in range(38)] + [0.5])  # steps between samples
        assert fmu.get(*eqs.state_names) == pytest.approx(states(run)[:, -1].tolist(), abs=1e-7)
        for name in ("dt", "servo_integral"):
            with pytest.raises(Exception, match="fmi3SetFloat64"):
                fmu.set(name, 0.03)
    assert "set it before initialization mode ends" in "".join(capfd.readouterr())
    with instance(made.path, "CoSimulation") as fmu:
        with pytest.raises(Exception, match="fmi3ExitInitializationMode"):
            fmu.initialize({"dt": 0.0})
    assert "a time between samples is not positive" in "".join(capfd.readouterr())


def test_copies_hold_what_was_sampled(cart: tuple[sb.EquationSet, sb.Fmu]) -> None:
    _, made = cart
    with instance(made.path, "CoSimulation") as fmu:
        fmu.initialize()
        fmu.steps([0.0, 0.1, 0.216])
        kept = fmu.fmu.getFMUState()
        fmu.steps([0.216, 0.3, 0.4])
        first = fmu.get(*fmu.references)
        fmu.fmu.setFMUState(kept)
        fmu.steps([0.216, 0.3, 0.4])
        assert fmu.get(*fmu.references) == first
        fmu.fmu.freeFMUState(kept)


@pytest.mark.exhaustive
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("make", [relay, dry])
def test_relays_counters_and_friction(make: Any, version: str, tmp_path: Path) -> None:
    eqs = make()
    wall = [sb.Event("x + 0.15", -1, {"x_dot": "-0.8*x_dot"}, "wall")] if make is relay else []
    run = sb.simulate(eqs, 2.0, times=np.linspace(0.0, 2.0, 21), rtol=1e-10, events=wall)
    assert run.events
    made = sb.save_fmu(eqs, tmp_path / "sampled.fmu", version, events=wall)  # type: ignore[arg-type]
    check_archive(made.path, version)
    for kind in KINDS:
        names = [*eqs.state_names, *run.held_values.names]  # type: ignore[union-attr]
        seen = simulate(made.path, kind, 2.0, names, 1e-9)
        assert np.abs(seen - np.vstack([states(run), held(run)])).max() < 1e-4, kind


def test_vectors_are_not_sampled(tmp_path: Path) -> None:
    body = sb.Body("Slider", mass=1)
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x")
    signal = sb.Signal("place", output="frame r Slider ground ground", sample=0.1)
    eqs = sb.form_equations(sb.Model("slider", [body, slide, signal], (0, 0, 0), {}, [], {"x": 1.0}))
    with pytest.raises(sb.UsageError) as caught:
        sb.save_fmu(eqs, tmp_path / "slider.fmu")
    assert caught.value.problems[0].code == "signal.no_number"
