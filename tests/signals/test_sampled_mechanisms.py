"""Sampled forces on closed loops, on joints that stick, on ropes, and beside rates that jump."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats.model_files import examples_folder
from symbody.model.element import Element


def sliding(*elements: Element, x: float = 0.0) -> sb.EquationSet:
    """A cart of 1 kg whose rail holds up to 2 N; the signal n pushes it."""
    joint = sb.Prismatic(
        "slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(applied="n"),
        friction=sb.Friction(force=2.0),
    )  # fmt: skip
    return sb.form_equations(sb.Model("cart", [joint, *elements], initial={"x": x}))


def test_a_sampled_force_breaks_a_joint_away() -> None:
    eqs = sliding(sb.Signal("n", "n + 1", sample=0.25))
    run = sb.simulate(eqs, 2.0)
    assert [(event.name, event.t) for event in run.events] == [("slide slips forward", 0.5)]
    assert run["x_dot"][-1] == pytest.approx(0.25 * (1 + 2 + 3 + 4 + 5 + 6), rel=1e-12)
    stepper = sb.Stepper(eqs, 0.1)
    for _ in range(20):
        stepper.step()
    assert stepper["x_dot"] == pytest.approx(run["x_dot"][-1], rel=1e-9)


def test_a_force_from_the_first_sample_on_moves_at_once() -> None:
    eqs = sliding(sb.Signal("n", "if(t < 1, 5, -5)", sample=0.1))
    run = sb.simulate(eqs, 3.0, times=np.linspace(0, 3, 31))
    assert run["x_dot"][10] == pytest.approx(3.0, rel=1e-12)
    turned = 1.0 + 3.0 / 7.0
    assert [event.name for event in run.events] == ["slide slips backward"]
    assert run.events[0].t == pytest.approx(turned, rel=1e-10)
    assert run["x_dot"][-1] == pytest.approx(-3.0 * (3.0 - turned), rel=1e-9)


def test_a_sampled_controller_against_friction_comes_to_rest() -> None:
    run = sb.simulate(sliding(sb.Signal("n", "-8*x - 2*x_dot", sample=0.05), x=1.0), 5.0)
    assert [event.name for event in run.events] == ["slide sticks"]
    assert run["x_dot"][-1] == 0.0 and abs(run["n"][-1]) <= 2.0


def test_a_rope_falls_slack_at_a_sample() -> None:
    ball = sb.Body("Ball", mass=1, frames={"c": sb.Frame()})
    joint = sb.Prismatic("fall", "ground", ball, axis="y", coordinate="y", force=sb.Drive(applied="lift"))
    rope = sb.Distance("rope", "ground.top", "Ball.c", value=1, rope=True)
    lift = sb.Signal("lift", "if(t < 0.5, 0, 15)", sample=0.2)
    model = sb.Model("hung", [joint, rope, lift], gravity=[0, -9.81, 0], initial={"y": -1},
                     ground={"top": sb.Frame()})  # fmt: skip
    run = sb.simulate(sb.form_equations(model), 0.8)
    assert [event.name for event in run.events] == ["rope slack"]
    assert run.events[0].t == pytest.approx(0.6, rel=1e-12)
    assert run["y"][-1] == pytest.approx(-1 + (15 - 9.81) * 0.2**2 / 2, rel=1e-9)


@pytest.mark.parametrize("constraints", [None, sb.Baumgarte(20)], ids=["projection", "baumgarte"])
def test_a_sampled_torque_drives_a_closed_loop(constraints: sb.Baumgarte | None) -> None:
    plain = sb.load_model(examples_folder() / "four_bar" / "four_bar.toml")
    torque = sb.Signal("T", "3*sin(4*t) - 0.5*theta_dot", sample=0.02)
    driven = sb.Model("driven", [*plain.elements, torque], plain.gravity, plain.parameters, (), plain.initial,
                      plain.ground)  # fmt: skip
    run = sb.simulate(sb.form_equations(driven), 1.5, {"theta": 1.0}, constraints=constraints, rtol=1e-10)
    stepper = sb.Stepper(sb.form_equations(plain), 0.02, initial={"theta": 1.0}, rtol=1e-10)
    for k in range(75):
        stepper.step(T=3 * np.sin(0.08 * k) - 0.5 * float(stepper["theta_dot"]))
    assert run["theta"][-1] == pytest.approx(stepper["theta"], abs=1e-8)
    assert run["constraint_violation"].max() < 1e-9


def test_prescribed_rates_may_jump_between_samples() -> None:
    """A carriage that jerks, with a sampled spring to a cart on it."""
    carriage = sb.Prismatic("jerk", "ground", sb.Body("Carriage", mass=1), coordinate="a",
                            motion="if(t < 0.33, 0, t - 0.33)")  # fmt: skip
    cart = sb.Prismatic("slide", "Carriage", sb.Body("Cart", mass=1), coordinate="b",
                        force=sb.Drive(applied="pull"))  # fmt: skip
    pull = sb.Signal("pull", "-5*b", sample=0.1)
    run = sb.simulate(
        sb.form_equations(sb.Model("jerked", [carriage, cart, pull])), 1.0, times=[0, 0.33, 1.0]
    )
    b, v, held, t = 0.0, 0.0, 0.0, 0.0
    for k in range(10):
        held = -5 * b
        for end in sorted({(k + 1) / 10, *([0.33] if k == 3 else [])}):
            h = end - t
            b, v, t = b + v * h + held * h * h / 2, v + held * h, end
            v -= 1.0 if end == 0.33 else 0.0  # the cart stays, the carriage goes
    assert run["b"][-1] == pytest.approx(b, abs=1e-9)
    assert run["b_dot"][-1] == pytest.approx(v, abs=1e-9)


def test_samples_read_what_fmus_compute(tmp_path: Path) -> None:
    rail = sb.Prismatic("rail", "ground", sb.Body("Block", mass=1), coordinate="y")
    clock = sb.form_equations(sb.Model("clock", [rail, sb.Signal("w", "3 + t")]))
    sb.save_fmu(clock, tmp_path / "clock.fmu", outputs=["w"])
    joint = sb.Prismatic(
        "slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(applied="n")
    )
    eqs = sb.form_equations(sb.Model("cart", [joint, sb.Signal("n", "F - x", sample=0.05)], inputs=["F"]))
    law = sb.FmuInput(tmp_path / "clock.fmu", "w", step=0.1)
    run = sb.simulate(eqs, 1.0, inputs={"F": law})
    instants = np.arange(1, 20) * 0.05
    before, behind = run.at(instants - 1e-9), run.at(instants + 0.02)
    np.testing.assert_allclose(behind["n"], before["F"] - before["x"], atol=1e-7)
    assert run["n"][0] == pytest.approx(3.1)


@pytest.mark.parametrize("push", ["F", "F + 0*n"], ids=["logged", "read"])
def test_fmus_read_what_is_sampled(tmp_path: Path, push: str) -> None:
    """A sampled measurement in front of a controller, whether a load reads it too or not; one that logs."""
    gain = sb.form_equations(sb.Model("gain", [sb.Signal("w", "1 - 2*x")], inputs=["x"]))
    sb.save_fmu(gain, tmp_path / "gain.fmu", outputs=["w"])
    joint = sb.Prismatic(
        "slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(applied=push)
    )
    signals = [sb.Signal("n", "x", sample=0.1, initial=50), sb.Signal("log", "F", sample=0.1, initial=7)]
    eqs = sb.form_equations(sb.Model("cart", [joint, *signals], inputs=["F"]))
    law = sb.FmuInput(tmp_path / "gain.fmu", "w", {"x": "n"}, step=0.1)
    run = sb.simulate(eqs, 1.05, {"x": 0.3}, inputs={"F": law})
    x, v, forces = 0.3, 0.0, [0.0]
    for k in range(11):
        h = min(0.1, 1.05 - 0.1 * k)
        force = 1 - 2 * x
        x, v = x + v * h + force * h * h / 2, v + force * h
        forces.append(force)
    assert run["x"][-1] == pytest.approx(x, abs=1e-9)
    held = run.held_values
    assert held is not None
    np.testing.assert_allclose(held.values_at("log", np.arange(11) * 0.1), forces[:11], atol=1e-9)
