"""The generalized-alpha method: order 2 on all kinds of mechanisms, damping as `rho` says, loops, events, faults."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj

import symbody as sb
from tests.simulation.loops import damped_slider, example, held_pendulum, pushed_mass, turning_pendulum
from tests.tiers import cases

MODULUS = 0.5  # sine of half the amplitude of a pendulum
HELD = 1e-5  # rad, from where stiff springs let go
RADII = (0.0, 0.5, 0.9, 1.0)


def states(run: sb.Trajectory) -> np.ndarray:
    """Speeds, coordinates and signals at the end."""
    return np.concatenate([run.u[:, -1], run.q[:, -1], run.s[:, -1]])


def observed_order(
    eqs: sb.EquationSet, end: float, steps: tuple[float, float], rho: float, **more: Any
) -> float:
    """The order by which errors shrink from the first step to the second, from motions far more exact."""
    best = states(sb.simulate(eqs, end, times=[end], rtol=1e-12, atol=1e-13, **more))
    errors = []
    for step in steps:
        method = sb.GeneralizedAlpha(rho=rho, step=step)
        run = sb.simulate(eqs, end, times=[end], integrator=method, rtol=1e-10, atol=1e-12, **more)
        assert run.success, run.notes
        errors.append(np.abs(states(run) - best).max())
    return float(np.log(errors[0] / errors[1]) / np.log(steps[0] / steps[1]))


def heavy_top() -> sb.EquationSet:
    """A top on a ball joint: quaternion and angular velocity."""
    top = sb.Body("Top", mass=1, inertia=(0.2, 0.2, 0.1), frames={"tip": sb.Frame(at=(0, 0, -0.5))})
    joint = sb.Spherical("pivot", "ground", "Top.tip")
    initial = {"pivot_wx": 1, "pivot_wy": 0.3, "pivot_wz": 20}
    return sb.form_equations(sb.Model("top", [top, joint], gravity=(0, 0, -9.81), initial=initial))


def driven_arm() -> sb.EquationSet:
    """A pendulum driven by a torque T."""
    body = sb.Body("Arm", mass=2, inertia=(0, 0, 0.5), frames={"pivot": sb.Frame(at=(0, 1, 0))})
    drive = sb.Drive(applied="T")
    hinge = sb.Revolute("hinge", "ground", "Arm.pivot", axis="z", coordinate="theta", torque=drive)
    model = sb.Model("arm", [body, hinge], gravity=(0, -9.81, 0), inputs=["T"], initial={"theta": 1.2})
    return sb.form_equations(model)


def spring(stiffness: float) -> sb.EquationSet:
    """A mass of 1 kg on a spring, at rest 1 m beside its place."""
    return pushed_mass(f"-{stiffness!r}*x", 1.0, 0.0)


@pytest.mark.parametrize("rho", RADII)
def test_order_2_on_the_pendulum_in_closed_form(rho: float) -> None:
    bob = sb.Body("Bob", mass=1, frames={"pivot": sb.Frame(at=(0, 9.81, 0))})
    pin = sb.Revolute("pin", "ground", "Bob.pivot", axis="z", coordinate="theta")
    initial = {"theta": 0, "theta_dot": 2 * MODULUS}
    eqs = sb.form_equations(sb.Model("pendulum", [bob, pin], gravity=(0, -9.81, 0), initial=initial))
    times = np.linspace(0.0, 10.0, 7)
    sn, cn, _, _ = ellipj(times, MODULUS**2)
    exact = np.array([2 * MODULUS * cn, 2 * np.arcsin(MODULUS * sn)])
    errors = []
    for step in (0.04, 0.02):
        method = sb.GeneralizedAlpha(rho=rho, step=step)
        run = sb.simulate(eqs, 10.0, times=times, integrator=method, rtol=1e-10)
        errors.append(np.abs(np.concatenate([run.u, run.q]) - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("rho", RADII)
@pytest.mark.parametrize(
    ("name", "step"), [("slider_crank", 2e-3), ("spinning_top_omega", 2e-3), ("dc_motor_arm", 2.5e-4)]
)
def test_order_2_with_loops_quasi_speeds_and_signals(name: str, step: float, rho: float) -> None:
    assert observed_order(example(name), 0.5, (step, 0.5 * step), rho) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("rho", RADII)
def test_order_2_with_a_quaternion_whose_norm_stays(rho: float) -> None:
    assert observed_order(heavy_top(), 1.0, (2e-3, 1e-3), rho) == pytest.approx(2.0, abs=0.1)
    run = sb.simulate(heavy_top(), 1.0, integrator=sb.GeneralizedAlpha(rho=rho, step=2e-3))
    assert np.abs(np.linalg.norm(run.q, axis=0) - 1.0).max() < 1e-14


def test_order_2_with_jumps_that_no_step_meets_and_slopes_of_work() -> None:
    table = sb.Table([0.0, 0.3123, 0.3123, 1.0], [0.0, 1.0, 6.0, 2.0])
    order = observed_order(driven_arm(), 1.0, (4e-3, 2e-3), 0.9, inputs={"T": table})
    assert order == pytest.approx(2.0, abs=0.1)
    errors = []
    for step in (4e-3, 2e-3):
        method = sb.GeneralizedAlpha(step=step)
        run = sb.simulate(driven_arm(), 1.0, inputs={"T": table}, integrator=method)
        energy = np.asarray(run["energy"]) - np.asarray(run["work"])
        errors.append(np.ptp(energy))
    assert errors[1] < 0.3 * errors[0] < 1e-3


def held_hinge(stiffness: float) -> tuple[sb.EquationSet, str]:
    """A body whose three coordinates a hinge holds by two constraints, on a spring; and its angle."""
    body = sb.Body("Arm", mass=1, inertia=(0, 0, 0.5), frames={"pivot": sb.Frame(at=(0, 1, 0))})
    flight = sb.Planar("flight", "ground", "Arm", axis="z", coordinates=("x", "y", "a"))
    spring = sb.Torque("spring", "Arm", (0, 0, f"-{stiffness!r}*a"))
    pin = sb.Revolute("pin", "ground", "Arm.pivot", axis="z")
    initial = {"a": HELD, "x": np.sin(HELD), "y": -np.cos(HELD)}
    model = sb.Model("hinge", [body, flight, pin, spring], gravity=(0, 0, 0), initial=initial)
    return sb.form_equations(model, tree=sb.Trees(rotation=["flight"], translation=["flight"])), "a"


def held_ball(stiffness: float) -> tuple[sb.EquationSet, str]:
    """A ball in a socket by quaternion and angular velocity, on a spring; and half its angle."""
    spring = sb.Torque("spring", "Ball", [f"-{2 * stiffness!r}*e{axis}" for axis in "xyz"])
    socket = sb.Spherical("socket", "ground", "Ball", coordinates=("ew", "ex", "ey", "ez"))
    initial = {"ew": np.cos(0.5 * HELD), "ex": np.sin(0.5 * HELD)}
    body = sb.Body("Ball", mass=1, inertia=(1, 1, 1))
    return sb.form_equations(sb.Model("ball", [body, socket, spring], initial=initial)), "ex"


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("held", [held_hinge, held_ball])
def test_of_fast_turns_rho_remains_with_loops_and_quaternions(held: Any, rho: float) -> None:
    eqs, name = held(1e5)
    run = sb.simulate(eqs, 200.0, integrator=sb.GeneralizedAlpha(rho=rho, step=1.0))
    assert run.success, run.notes
    sizes = np.abs(run[name])
    if rho == 0.0:
        assert sizes[5:].max() < 1e-6 * sizes[0]
        return
    # The two roots of each motion are not quite equal: what they leave swells and fades.
    first, last = (sizes[k : k + 40].max() for k in (40, 160))
    assert (last / first) ** (1.0 / 120.0) == pytest.approx(rho, rel=0.05)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_of_what_is_too_fast_rho_remains(rho: float) -> None:
    # The roots at infinite frequency are equal: powers of rho come with those of the step's number.
    run = sb.simulate(spring(1e10), 400.0, integrator=sb.GeneralizedAlpha(rho=rho, step=1.0))
    sizes = np.abs(run["x"])
    if rho == 0.0:
        assert sizes[5:].max() < 1e-6 * sizes[0]
        return
    first, second = 100, 200
    share = (sizes[second] / sizes[first]) ** (1.0 / (second - first))
    assert share == pytest.approx(rho, rel=0.03)
    assert f"by a factor of {rho:g} per step" in run.notes[-1]


def test_rho_1_damps_nothing() -> None:
    run = sb.simulate(spring(25.0), 200.0, integrator=sb.GeneralizedAlpha(rho=1.0, step=0.1), rtol=1e-11)
    energy = 0.5 * run["x_dot"] ** 2 + 12.5 * run["x"] ** 2
    assert np.ptp(energy[1:]) < 1e-8 * energy[0]
    assert "adds no damping" in run.notes[-1]


@pytest.mark.parametrize(
    "name", cases(["slider_crank", "spatial_four_bar", "stewart_platform"], fast=["slider_crank"])
)
@pytest.mark.parametrize("step", [None, 5e-3])
def test_loops_stay_closed(name: str, step: float | None) -> None:
    run = sb.simulate(example(name), 0.5, integrator=sb.GeneralizedAlpha(step=step), rtol=1e-5)
    assert run.success
    assert run["constraint_violation"].max() < 1e-10
    assert run["velocity_violation"].max() < 1e-10


def test_tolerances_decide_how_exact_it_is() -> None:
    best = states(sb.simulate(turning_pendulum(), 3.0, times=[3.0], rtol=1e-12, atol=1e-13))
    errors, steps = [], []
    for rtol in (1e-4, 1e-7):
        run = sb.simulate(
            turning_pendulum(), 3.0, integrator=sb.GeneralizedAlpha(), rtol=rtol, atol=0.1 * rtol
        )
        errors.append(np.abs(states(run) - best).max())
        steps.append(run.statistics.accepted)
    # Errors of a step go with its third power, their sum with its second.
    assert steps[1] / steps[0] == pytest.approx(10.0, rel=0.3)
    assert errors[0] < 0.05 and errors[1] < errors[0] / 50.0


def test_stiff_slider_takes_few_steps() -> None:
    run = sb.simulate(damped_slider(), 5.0, times=[5.0], integrator=sb.GeneralizedAlpha(), rtol=1e-5)
    assert run.success and run.statistics.accepted < 500
    assert run["x"][-1] == pytest.approx(np.exp(-5.0), rel=1e-3)


def test_a_start_that_steps_cannot_resolve_is_left_out() -> None:
    for rho in RADII:
        method = sb.GeneralizedAlpha(rho=rho, step=0.01)
        run = sb.simulate(damped_slider(), 2.0, times=[1.0], integrator=method, rtol=1e-6)
        assert run["x"][-1] == pytest.approx(np.exp(-1.0), rel=0.03)


def test_events_act_between_steps() -> None:
    ball, fall = pushed_mass("-9.81", 1.0, 0.0), np.sqrt(2.0 / 9.81)
    hit = sb.Event("x", -1, {"x_dot": "-x_dot/2"}, "hit")
    for step in (None, 0.01):
        run = sb.simulate(ball, 0.85, events=hit, integrator=sb.GeneralizedAlpha(step=step), rtol=1e-6)
        assert [event.t for event in run.events] == pytest.approx([fall])
        assert run["x_dot"][-1] == pytest.approx(0.5 * 9.81 * fall - 9.81 * (0.85 - fall))
    stopped = sb.simulate(
        ball, 2.0, events=sb.Event("x", action="stop"), integrator=sb.GeneralizedAlpha(step=0.01)
    )
    assert stopped.status is sb.Status.STOPPED and stopped.t[-1] == pytest.approx(fall)


def test_functions_of_python_drive_and_their_faults_are_raised() -> None:
    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        return float(3.0 * np.sin(5.0 * t) - 0.5 * u[0])

    formula = sb.simulate(driven_arm(), 1.0, times=[1.0], inputs={"T": "3*sin(5*t) - theta_dot/2"})
    method = sb.GeneralizedAlpha(step=0.005)
    run = sb.simulate(driven_arm(), 1.0, times=[1.0], inputs={"T": law}, integrator=method)
    assert run["theta"] == pytest.approx(formula["theta"], abs=1e-3)
    with pytest.raises(sb.SymbodyError, match=r"simulation\.input"):
        sb.simulate(driven_arm(), 1.0, inputs={"T": lambda t, q, u: 1 / 0}, integrator=method)


def test_motions_run_backwards_and_end_where_steps_run_out() -> None:
    there = sb.simulate(turning_pendulum(), 1.0, integrator=sb.GeneralizedAlpha(step=1e-3))
    values = {"theta": there["theta"][-1], "theta_dot": there["theta_dot"][-1]}
    back = sb.simulate(turning_pendulum(), (1.0, 0.0), values, integrator=sb.GeneralizedAlpha(step=1e-3))
    assert back["theta"][-1] == pytest.approx(there["theta"][0], abs=1e-4)
    short = sb.simulate(turning_pendulum(), 1.0, integrator=sb.GeneralizedAlpha(), max_steps=10)
    assert short.status is sb.Status.TOO_MANY_STEPS
    still = sb.simulate(turning_pendulum(), 0.0, integrator=sb.GeneralizedAlpha())
    assert still.success and still.t.tolist() == [0.0]


def test_sweep_and_stepper_take_it() -> None:
    method = sb.GeneralizedAlpha(step=0.01)
    eqs, masses = example("spring_mass_damper"), [1.0, 2.0]
    table = sb.sweep(eqs, 1.0, {"m": masses}, initial={"x": 0.1}, integrator=method)
    for case, mass in enumerate(masses):
        own = sb.simulate(eqs, 1.0, {"x": 0.1}, parameters={"m": mass}, integrator=method)
        exact = sb.simulate(eqs, 1.0, {"x": 0.1}, parameters={"m": mass}, rtol=1e-11)
        assert table["x"][case, -1] == pytest.approx(own["x"][-1], rel=1e-12)
        assert abs(own["x"][-1] - exact["x"][-1]) > 1e-8  # what only this method's steps are wrong by
    stepper = sb.Stepper(driven_arm(), dt=0.1, integrator=method)
    alone = sb.simulate(driven_arm(), 0.1, inputs={"T": 2.0}, integrator=method)
    assert stepper.step(T=2.0)["theta"] == pytest.approx(alone["theta"][-1], abs=1e-12)


def test_other_ways_to_hold_constraints() -> None:
    method = sb.GeneralizedAlpha(step=1e-3)
    run = sb.simulate(held_pendulum(), 1.0, integrator=method, constraints=sb.Baumgarte())
    assert run.success and 1e-12 < run["constraint_violation"].max() < 1e-4
    for way in (sb.GGL(), sb.Partition()):
        with pytest.raises(sb.UsageError, match=r"simulation\.combination"):
            sb.simulate(held_pendulum(), 1.0, integrator=method, constraints=way)


def test_sampled_controllers_move_what_explicit_steps_move() -> None:
    body = sb.Body("Mass", mass=1)
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x", force=sb.Drive(applied="pull"))
    control = sb.Signal("pull", "-x_dot", sample=0.1)
    eqs = sb.form_equations(sb.Model("sampled", [body, slide, control], initial={"x_dot": 1}))
    times = np.linspace(0, 1, 21)
    runs = [sb.simulate(eqs, 1.0, times=times, integrator=method) for method in (sb.GeneralizedAlpha(), None)]
    # Each sample takes a tenth of the rate there.
    np.testing.assert_allclose(runs[1]["x_dot"][::2], 0.9 ** np.arange(11), atol=1e-9)
    np.testing.assert_allclose(runs[0]["x_dot"], runs[1]["x_dot"], atol=1e-5)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"rho": 1.5}, "simulation.rho"),
        ({"rho": -0.1}, "simulation.rho"),
        ({"step": 0.0}, "simulation.implicit_step"),
        ({"max_step": float("inf")}, "simulation.implicit_step"),
    ],
)
def test_values_without_meaning_are_refused(arguments: dict[str, float], code: str) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.GeneralizedAlpha(**arguments)
    assert [problem.code for problem in caught.value.problems] == [code]
