"""Blades, balls and discs against closed forms."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest

import symbody as sb
from tests.tiers import cases

TIGHT = {"rtol": 1e-11, "atol": 1e-13}


def test_blade_on_an_incline_draws_a_cycloid() -> None:
    """Neimark & Fufaev, Dynamics of Nonholonomic Systems (1972), chapter 1: it never slides far down."""
    slope, spin = 9.81 * sin(0.3), 1.7
    plane = sb.Planar("plane", "ground", "Skate", coordinates=["x", "y", "phi"])
    skate = sb.Body("Skate", mass=2.5, inertia=(0, 0, 0.4))
    model = sb.Model("skate", [skate, plane, sb.KnifeEdge("blade", "ground", "Skate")], gravity=[slope, 0, 0])
    run = sb.simulate(sb.form_equations(model), 6.0, initial={"phi_dot": spin}, **TIGHT)
    t, scale = run.t, slope / (2 * spin**2)
    # A hundred steps of 1e-11 each, on motions of size 1.
    np.testing.assert_allclose(run["x"], scale * np.sin(spin * t) ** 2, atol=1e-8)
    np.testing.assert_allclose(run["y"], scale * (spin * t - np.sin(2 * spin * t) / 2), atol=1e-8)
    assert run["velocity_violation"].max() < 1e-9
    # The edge holds 2 m v omega across: twice Coriolis' force.
    v = slope / spin * np.sin(spin * t)
    along = -slope * np.sin(spin * t)
    np.testing.assert_allclose(run["lambda_blade_1"], 2.5 * (v * spin - along), atol=1e-6)


def test_ball_on_an_incline_falls_at_five_sevenths() -> None:
    ball = sb.Body("Ball", mass="m", inertia=("2/5*m*R^2", "2/5*m*R^2", "2/5*m*R^2"))
    parameters = {"m": 2.0, "R": 0.2}
    rolling = sb.Rolling("track", "ground", "Ball", radius="R")
    model = sb.Model("ball", [ball, rolling], parameters=parameters, gravity=[3.0, 0, -9.0])
    eqs = sb.form_equations(model)
    assert (len(eqs.constraints), len(eqs.multiplier_names), eqs.degrees_of_freedom) == (1, 3, 3)
    run = sb.simulate(eqs, 2.0, initial={"Ball_vy": 0.3, "Ball_wz": 2.0}, **TIGHT)
    np.testing.assert_allclose(run["Ball_x"], 3.0 * 5 / 7 * run.t**2 / 2, atol=1e-8)
    np.testing.assert_allclose(run["Ball_y"], 0.3 * run.t, atol=1e-8)
    assert np.ptp(run["energy"] - run["work"]) < 1e-8
    # Normal force m 9; friction 2/7 of the weight along the incline.
    np.testing.assert_allclose(run["reaction track Fz"], 18.0, atol=1e-6)
    across = np.hypot(run["reaction track Fx"], run["reaction track Fy"])
    np.testing.assert_allclose(across, 2 / 7 * 6.0, atol=1e-6)
    np.testing.assert_allclose(run["frame r track ground ground"][2], 0.0, atol=1e-9)


@pytest.mark.parametrize("lean", [radians(60), radians(80), radians(110)])
def test_leaning_disc_runs_in_a_circle(lean: float) -> None:
    """Steady motions of a disc: O'Reilly, The dynamics of rolling disks and sliding disks (1996), section 4.

    With the axle at an angle `lean` from the vertical, precession Omega, and the spin w about the axle:
    ``(C + m R^2) w Omega sin(lean) - A Omega^2 sin(lean) cos(lean) + m g R cos(lean) = 0``.
    """
    m, radius, g, precession = 1.3, 0.4, 9.81, 2.0
    axial, across = m * radius**2 / 2, m * radius**2 / 4
    spin = (across * precession**2 * sin(lean) * cos(lean) - m * g * radius * cos(lean)) / (
        (axial + m * radius**2) * precession * sin(lean)
    )
    disc = sb.Body("Disc", mass=m, inertia=(across, across, axial))
    angles = sb.Free(
        "free", "ground", "Disc", angles="313", coordinates=["x", "y", "z", "psi", "theta", "phi"]
    )
    rolling = sb.Rolling("road", "ground", "Disc", radius=radius, axis="z")
    eqs = sb.form_equations(sb.Model("disc", [disc, angles, rolling], gravity=[0, 0, -g]))
    fixed = {
        "psi": 0.4,
        "theta": lean,
        "phi": 0.0,
        "psi_dot": precession,
        "theta_dot": 0.0,
        "phi_dot": spin - precession * cos(lean),
        "x": 0.0,
        "y": 0.0,
    }
    state = sb.assemble(eqs, fixed, {"z": radius * sin(lean)})
    assert state.udot["theta_ddot"] == pytest.approx(0.0, abs=1e-9)
    run = sb.simulate(eqs, 2 * pi / precession, initial=fixed, guess={"z": radius * sin(lean)}, **TIGHT)
    np.testing.assert_allclose(run["theta"], lean, atol=1e-8)
    np.testing.assert_allclose(run.q[:2, -1], 0.0, atol=1e-7)  # once around
    assert run["constraint_violation"].max() < 1e-9
    assert run["velocity_violation"].max() < 1e-9


def wheel_set(hinged: bool) -> sb.Model:
    """An axle with two wheels, on hinges or rigid, on a plane that slopes along x."""
    m, radius, half = 2.0, 0.3, 0.5
    ends = {"L": sb.Frame(at=(0, half, 0)), "R": sb.Frame(at=(0, -half, 0))}
    wheel = {"mass": 0.8, "inertia": (0.02, 0.036, 0.02)}
    parts: list[sb.Body | sb.Free | sb.Revolute | sb.Weld | sb.Rolling] = [
        sb.Body("Axle", m, (0.2, 0.05, 0.2), frames=ends),
        sb.Free("f", "ground", "Axle", angles="321", coordinates=["x", "y", "z", "yaw", "pitch", "roll"]),
    ]
    for side in "LR":
        parts.append(sb.Body(f"Wheel{side}", **wheel))
        hinge = sb.Revolute(f"h{side}", f"Axle.{side}", f"Wheel{side}", axis="y", coordinate=f"spin{side}")
        parts.append(hinge if hinged else sb.Weld(f"h{side}", f"Axle.{side}", f"Wheel{side}"))
        parts.append(sb.Rolling(f"r{side}", "ground", f"Wheel{side}", radius=radius, axis="y"))
    return sb.Model("wheel set", parts, gravity=(1.5, 0, -9.0), initial={"z": radius})


@pytest.mark.parametrize("hinged", cases([True, False], fast=[True]))
def test_a_wheel_set_rolls_down_as_one_mass(hinged: bool) -> None:
    """Both discs hold the same lateral velocity: one of six rows is redundant, and named."""
    eqs = sb.form_equations(wheel_set(hinged))
    found = sb.redundancy(eqs)
    # Hinged: along, about the vertical, and the axle about itself. Rigid: along.
    assert found.degrees_of_freedom == (3 if hinged else 1)
    assert len(found.dropped) == 1 and found.dropped[0].removeprefix("lambda_r") in ("L_3", "R_3")
    run = sb.simulate(eqs, 1.0, guess={"z": 0.3}, rtol=1e-10, atol=1e-12)
    whole, turning = 2.0 + 2 * 0.8, 2 * 0.036 + (0.0 if hinged else 0.05)
    rate = whole * 1.5 / (whole + turning / 0.3**2)
    assert run.success
    np.testing.assert_allclose(run["x"], rate * run.t**2 / 2, atol=1e-8)
    assert run["constraint_violation"].max() < 1e-9 and run["velocity_violation"].max() < 1e-9


def test_wheels_of_different_speed_turn_the_axle() -> None:
    """Heading changes by R (right - left) / width, and the middle goes round in a circle."""
    model = wheel_set(True)
    eqs = sb.form_equations(sb.Model("level", model.elements, gravity=(0, 0, -9.0), initial=model.initial))
    start = {"yaw": 0.0, "x": 0.0, "y": 0.0, "spinL": 0.0, "spinR": 0.0, "pitch": 0.0}
    run = sb.simulate(
        eqs, 2.0, start | {"spinL_dot": 2.0, "spinR_dot": 4.0, "pitch_dot": 0.0}, guess={"z": 0.3}, **TIGHT
    )
    yaw, forward = 0.3 * (4 - 2) / 1.0, 0.3 * 3.0
    np.testing.assert_allclose(run["yaw"], yaw * run.t, atol=1e-8)
    np.testing.assert_allclose(run["x"], forward / yaw * np.sin(yaw * run.t), atol=1e-8)
    np.testing.assert_allclose(run["y"], forward / yaw * (1 - np.cos(yaw * run.t)), atol=1e-8)
