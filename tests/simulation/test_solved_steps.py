"""Implicit steps beside a moment of enormous damping: what the solvers keep from there must hide no errors."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.formats import model_from_toml
from symbody.simulation.methods.implicit.stiff import SHARE_OF_STEP, WRONG, SolvedSteps
from symbody.simulation.methods.stepping import SHARES
from tests.simulation.loops import pushed_mass

# Both are driven along speeds of cos t by a brake whose coefficient falls from 1e14 at t = 0 to 1 at 1 s.
BRAKE = "({} - {})/(t^2 + 1e-14)"
PUSH = f"{BRAKE.format('cos(t)', 'x_dot')} - sin(t)"
# The same about a pin that is cut: 2.5 kg m^2 is the moment of inertia about it.
BOB = f"""
name = "braked"
gravity = ["0", "0", "0"]
[[body]]
name = "Bob"
mass = 2.0
inertia = ["0", "0", "0.5"]
[body.frames]
pivot = {{ at = ["0", "1", "0"] }}
[[joint]]
name = "pin"
type = "revolute"
between = ["ground", "Bob.pivot"]
axis = "z"
[[joint]]
name = "flight"
type = "planar"
between = ["ground", "Bob"]
coordinates = ["x", "y", "theta"]
[[torque]]
name = "brake"
on = "Bob"
vector = ["0", "0", "{BRAKE.format("cos(t)", "theta_dot")} - 2.5*sin(t)"]
[initial]
x = 1.0
theta = "90 deg"
theta_dot = 1.0
"""


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_a_slider_follows_its_brake_when_that_lets_go(rtol: float) -> None:
    eqs = pushed_mass(PUSH, 0.0, 1.0)
    run = sb.simulate(eqs, 1.0, integrator=sb.Stiff(), rtol=rtol, atol=rtol)
    assert run.success
    # Every step adds an error of rtol and atol at most, in speeds; those in x are their integrals over 1 s.
    tolerance = 2.0 * rtol * run.statistics.accepted
    assert np.abs(run["x_dot"] - np.cos(run.t)).max() < tolerance
    assert np.abs(run["x"] - np.sin(run.t)).max() < tolerance


@pytest.mark.parametrize("constraints", [sb.Projection(), sb.Baumgarte(), sb.GGL()])
def test_closed_loops_follow_their_brakes(constraints: sb.Projection | sb.Baumgarte | sb.GGL) -> None:
    trees = sb.Trees(rotation=["flight"], translation=["flight"])
    eqs = sb.form_equations(model_from_toml(BOB), tree=trees)
    run = sb.simulate(eqs, 1.0, integrator=sb.Stiff(), constraints=constraints, rtol=1e-6, atol=1e-6)
    assert run.success
    tolerance = 2e-6 * run.statistics.accepted
    assert np.abs(run["theta_dot"] - np.cos(run.t)).max() < tolerance
    assert np.abs(run["theta"] - np.pi / 2.0 - np.sin(run.t)).max() < tolerance


def test_the_correction_is_that_of_newton() -> None:
    """y' = -1000 y: where y is wrong at the end only, one correction removes it but for the share of the step."""
    length, rtol, slope = 1e-3, 1e-6, -1000.0
    solved = SolvedSteps(lambda t, x: slope * x, lambda t, x: np.array([[slope]]), rtol, 0.0)
    # A solution, and parabolas beside it whose end is right but has another slope: R = d, by (s - slope).
    exact = np.exp(slope * length * SHARES)[:, np.newaxis]
    assert solved(length, length, exact)
    allowed = WRONG * rtol * exact[-1, 0] * (SHARE_OF_STEP / length - slope)
    for share, expected in ((0.9, True), (1.1, False)):
        bent = exact + share * allowed * length * (SHARES * (SHARES - 1.0))[:, np.newaxis]
        assert solved(length, length, bent) is expected


def test_a_solver_that_does_not_get_on_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SolvedSteps, "__call__", lambda *_: False)
    run = sb.simulate(pushed_mass(PUSH, 0.0, 1.0), 1.0, integrator=sb.Stiff())
    assert run.status is sb.Status.STEP_COLLAPSE and "known up to" in run.notes[-1]
