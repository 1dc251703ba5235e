"""Sampled controllers against simulations that know nothing of symbody, piece by piece between samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb

M, MP, L, G = 1.0, 0.1, 0.5, 9.81
GAINS = {"p": 60.0, "i": 20.0, "d": 8.0, "filter": 0.01}


def cart_pole(*elements: sb.Signal | sb.PID, force: str) -> sb.Model:
    """A pole on a cart; theta from upright, to the left."""
    cart, rod = (
        sb.Body("cart", mass=M),
        sb.Body("pole", mass=MP, inertia=[0, 0, MP * L**2 / 3], frames={"base": sb.Frame(at=[0, -L, 0])}),
    )
    joints = [
        sb.Prismatic("rail", "ground", cart, axis="x", coordinate="x", force=sb.Drive(applied=force)),
        sb.Revolute("hinge", cart, "pole.base", axis="z", coordinate="theta"),
    ]
    return sb.Model("cart-pole", [rod, *joints, *elements], gravity=[0, -G, 0], initial={"theta": 0.2})


def rate(_: float, y: np.ndarray, force: float) -> list[float]:
    """The accelerations of a cart-pole, as in a textbook: y = (x, theta, x', theta')."""
    _x, a, _v, w = y
    # (M + MP) x'' - MP L cos(a) a'' + MP L sin(a) w^2 = F;  4/3 MP L^2 a'' - MP L cos(a) x'' = MP G L sin(a)
    mass = np.array([[M + MP, -MP * L * np.cos(a)], [-MP * L * np.cos(a), 4 / 3 * MP * L**2]])
    load = np.array([force - MP * L * np.sin(a) * w**2, MP * G * L * np.sin(a)])
    return [y[2], y[3], *np.linalg.solve(mass, load)]


def piecewise(
    control: Callable[[np.ndarray], float], dt: float, t_end: float
) -> tuple[np.ndarray, list[float]]:
    """The last state and the forces of a cart-pole whose force is held between samples."""
    y, forces, k = np.array([0.0, 0.2, 0.0, 0.0]), [], 0
    while k * dt <= t_end * (1 + 1e-15):
        forces.append(control(y))
        end = min((k + 1) * dt, t_end)
        if end > k * dt:
            piece = solve_ivp(rate, (k * dt, end), y, "DOP853", rtol=1e-12, atol=1e-13, args=(forces[-1],))
            y = piece.y[:, -1]
        k += 1
    return y, forces


def digital_pid(dt: float, limit: float) -> Callable[[np.ndarray], float]:
    """A digital PID in the lines of a textbook, with back-calculation at its limits."""
    memory = {"integral": 0.0, "derivative": 0.0, "error": 0.0}

    def control(y: np.ndarray) -> float:
        error = -y[1]
        change = GAINS["d"] * (error - memory["error"])
        memory["derivative"] = (GAINS["filter"] * memory["derivative"] + change) / (GAINS["filter"] + dt)
        memory["error"] = error
        total = GAINS["p"] * error + memory["integral"] + memory["derivative"]
        limited = min(limit, max(-limit, total))
        back = (limited - total) * GAINS["i"] / GAINS["p"]
        memory["integral"] += dt * (GAINS["i"] * error + back)
        return limited

    return control


@pytest.mark.parametrize(("dt", "t_end"), [(0.02, 1.0), (0.013, 1.0)])
def test_a_sampled_pid_holds_a_pole_as_in_scipy(dt: float, t_end: float) -> None:
    servo = sb.PID("servo", "-theta", GAINS, limits=(-8, 8), sample=dt)
    eqs = sb.form_equations(cart_pole(servo, force="servo"))
    run = sb.simulate(eqs, t_end, rtol=1e-12, atol=1e-13)
    state, forces = piecewise(digital_pid(dt, 8.0), dt, t_end)
    ends = [run[name][-1] for name in ("x", "theta", "x_dot", "theta_dot")]
    np.testing.assert_allclose(ends, state, atol=1e-9)
    assert run.held_values is not None
    np.testing.assert_allclose(
        run.held_values.values[run.held_values.names.index("servo")], forces, atol=1e-9
    )
    assert min(forces) == -8.0 and -7.0 < max(forces) < 8.0  # a limit was met, and left


def test_a_sampled_pid_moves_the_same_by_fixed_steps_and_in_a_stepper() -> None:
    servo = sb.PID("servo", "-theta", GAINS, sample=0.02)
    eqs = sb.form_equations(cart_pole(servo, force="servo"))
    run = sb.simulate(eqs, 0.5, rtol=1e-10)
    fixed = sb.simulate(eqs, 0.5, integrator=sb.FixedStep(5e-4))
    stepper = sb.Stepper(eqs, 0.0125, rtol=1e-10)
    for _ in range(40):
        stepper.step()
    for name in ("x", "theta", "servo"):
        assert fixed[name][-1] == pytest.approx(run[name][-1], abs=1e-7)
        assert stepper[name] == pytest.approx(run[name][-1], abs=1e-8)


def test_a_sampled_lqr_equals_its_linear_equations() -> None:
    scipy_linalg = pytest.importorskip("scipy.linalg")
    dt = 0.02
    gains = {"x": 1.0, "theta": -40.0, "x_dot": 2.0, "theta_dot": -8.0}
    law = " + ".join(f"({gain})*{name}" for name, gain in gains.items())
    eqs = sb.form_equations(cart_pole(sb.Signal("F", law, sample=dt), force="F"))
    lin = sb.linearize(eqs, {"x": 0, "theta": 0}, inputs={"F": 0})
    block = np.block([[lin.A, lin.B], [np.zeros((1, 5))]])
    exact = scipy_linalg.expm(block * dt)
    K = np.array([gains[name] for name in lin.state_names])
    x = np.array([1e-5 if name == "theta" else 0.0 for name in lin.state_names])
    run = sb.simulate(eqs, 1.0, {"theta": 1e-5}, rtol=1e-12, atol=1e-16)
    for _ in range(50):
        x = exact[:4, :4] @ x + exact[:4, 4] * (K @ x)
    np.testing.assert_allclose([run[name][-1] for name in lin.state_names], x, atol=1e-12)


def test_a_controller_reads_forces_that_follow_from_what_it_holds() -> None:
    """The reaction of the rail is measured before the force changes: a sample opens the ring."""
    weight = sb.Signal("weight", output="reaction rail Fy", sample=0.1)
    run = sb.simulate(sb.form_equations(cart_pole(weight, force="0.1*weight")), 0.5)
    first = sb.simulate(sb.form_equations(cart_pole(force="0")), 0.5)["reaction rail Fy"][0]
    assert run["weight"][0] == pytest.approx(first, rel=1e-14)
    assert run["reaction rail Fy"][0] != pytest.approx(first, rel=1e-3)  # the force acts at once


def test_blocks_without_samples_make_linear_models() -> None:
    servo = sb.PID("servo", "-theta", GAINS, sample=0.01)
    sampled = cart_pole(servo, force="servo")
    plain = cart_pole(sb.PID("servo", "-theta", GAINS), force="servo")
    found, wanted = (
        sb.linearize(sb.form_equations(model), {"x": 0, "theta": 0})
        for model in (sb.without_sampling(sampled), plain)
    )
    np.testing.assert_array_equal(found.A, wanted.A)


@pytest.mark.parametrize(
    ("method", "digits"),
    [
        ({"integrator": sb.Stiff()}, 1e-7),
        pytest.param({"integrator": sb.GeneralizedAlpha()}, 1e-4, marks=pytest.mark.exhaustive),
        pytest.param({"constraints": sb.GGL()}, 1e-7, marks=pytest.mark.exhaustive),
        ({"constraints": sb.Partition()}, 1e-8),
    ],
)
def test_methods_without_samples_of_their_own_move_between_them(
    method: dict[str, Any], digits: float
) -> None:
    """Explicit steps take the same samples; a pendulum in two coordinates on a rod is a closed loop."""
    elements = [
        sb.Body("B", mass=1, inertia=(0, 0, 1)),
        sb.Planar("J", "ground", "B", coordinates=["x", "y", "a"]),
        sb.Distance("rod", "ground", "B", 1),
        sb.Signal("h", "-4*x", sample=0.1),
        sb.Force("push", "B", ("h", 0, 0)),
    ]
    model = sb.Model("held", elements, gravity=[0, -9.81, 0], initial={"x": 0.6, "y": -0.8})
    eqs, times = sb.form_equations(model), np.linspace(0, 1, 21)
    events: list[Any] = [
        sb.Event("h + 1", name="at a sample"),
        sb.Event("x", -1, {"a_dot": "1"}, name="below"),
    ]
    options = {"rtol": 1e-10, "times": times, "events": events}
    expected, run = sb.simulate(eqs, 1, **options), sb.simulate(eqs, 1, **options, **method)
    np.testing.assert_array_equal(run.t, times)
    for name in ("x", "y", "a", "h", "work"):
        np.testing.assert_allclose(run[name], expected[name], atol=20 * digits, err_msg=name)
    assert [event.name for event in run.events] == [event.name for event in expected.events]
    np.testing.assert_allclose([e.t for e in run.events], [e.t for e in expected.events], atol=20 * digits)
    assert run.events and run.held_values is not None and expected.held_values is not None
    np.testing.assert_array_equal(run.held_values.t, expected.held_values.t)
    sweep = sb.sweep(eqs, 1, {}, initial={"a": [0.0, 0.5]}, **options, **method)
    np.testing.assert_array_equal(sweep["x"][0], run["x"])
    stepper = sb.Stepper(eqs, 0.15, events=events, rtol=1e-10, **method)
    reference = sb.Stepper(eqs, 0.15, events=events, rtol=1e-10)
    for _ in range(4):
        stepper.step()
        reference.step()
        for name in ("x", "h"):
            assert stepper[name] == pytest.approx(reference[name], abs=40 * digits)
