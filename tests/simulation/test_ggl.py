"""The formulation of index 2: the same motion as the others, constraints held in positions and velocities."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from tests.simulation.loops import (
    damped_slider,
    example,
    held_pendulum,
    turning_pendulum,
    twice_held_pendulum,
)
from tests.tiers import cases

# IDA ends Newton's method where the weighted root mean square of what is left is below this (Hindmarsh et al.,
# User Documentation for IDA, section 2.1, nonlinear solver convergence coefficient).
EPCON = 0.33


def newton_leaves(run: sb.Trajectory, rtol: float) -> float:
    """How far Newton's method may leave a pin of 1 m open: all of the norm may stand in one combination.

    The norm is over n states, 2 multipliers and 2 pushes; a coordinate q weighs rtol of itself and atol, which
    is 1e-10 of 1 m and 1 rad. By x, y and the angle a row of J is at most (1, 0, 1) or (0, 1, 1) long.
    """
    n = run.q.shape[0] + run.u.shape[0] + 4
    place, turn = (rtol * np.abs(run[name]).max() + 1e-10 for name in ("x", "theta"))
    return float(EPCON * np.sqrt(n) * np.hypot(place, turn))


@pytest.mark.exhaustive
def test_pendulum_of_ten_seconds() -> None:
    run = sb.simulate(held_pendulum(), 10.0, constraints=sb.GGL(), rtol=1e-8)
    reference = sb.simulate(turning_pendulum(), 10.0, times=run.t, rtol=1e-12, atol=1e-12)
    assert run.success
    assert run["constraint_violation"].max() < newton_leaves(run, 1e-8)
    # Of some 6,000 steps with 1e-8 each.
    assert np.abs(run["theta"] - reference["theta"]).max() < 6e-5
    # The pin carries what it carries for the pendulum in one coordinate; forces are of 60 N.
    force = np.abs(run.reaction("pin") - reference.reaction("pin"))[:3]
    assert force.max() < 6e-5 * 60.0


@pytest.mark.parametrize("name", cases(["slider_crank", "spatial_four_bar"], fast=["slider_crank"]))
def test_all_ways_to_hold_constraints_give_one_motion(name: str) -> None:
    eqs = example(name)
    times = np.linspace(0.0, 1.0, 6)
    reference = sb.simulate(eqs, 1.0, times=times, rtol=1e-11, atol=1e-12)
    # What each leaves in 1 s: errors a step of 1e-8, some tens of explicit and a thousand implicit steps.
    ways = {sb.Projection(): 1e-6, sb.Baumgarte(): 1e-6, sb.Partition(): 1e-6, sb.GGL(): 5e-5}
    for way, tolerance in ways.items():
        run = sb.simulate(eqs, 1.0, times=times, constraints=way)
        assert run.success
        assert np.abs(run.q - reference.q).max() < tolerance, way
        assert np.abs(run.u - reference.u).max() < 20.0 * tolerance, way  # rates of some 10/s


def test_redundant_constraints_are_left_out_with_a_note() -> None:
    """Two pins on one axis: the second repeats the first."""
    run = sb.simulate(twice_held_pendulum(), 1.0, constraints=sb.GGL())
    reference = sb.simulate(turning_pendulum(), 1.0, rtol=1e-11)
    assert run.success and any("follow from the other constraints" in note for note in run.notes)
    assert abs(run["theta"][-1] - reference["theta"][-1]) < 1e-5


def test_events_and_laws() -> None:
    """A pendulum whose speed is halved when it passes the bottom, driven by an expression."""
    event = sb.Event(
        "x", direction=-1, action={"x_dot": "x_dot/2", "y_dot": "y_dot/2", "theta_dot": "theta_dot/2"}
    )
    options = {"events": event, "inputs": {}, "times": np.linspace(0.0, 3.0, 7)}
    run = sb.simulate(held_pendulum(), 3.0, constraints=sb.GGL(), **options)
    reference = sb.simulate(held_pendulum(), 3.0, rtol=1e-11, **options)
    assert run.success and len(run.events) == len(reference.events) >= 1
    assert np.abs(run["theta"] - reference["theta"]).max() < 5e-5


def test_trees_need_no_multipliers() -> None:
    run = sb.simulate(damped_slider(), 1.0, constraints=sb.GGL())
    assert run.success and any("sb.Stiff()" in note for note in run.notes)


def test_explicit_steps_cannot_hold_it() -> None:
    with pytest.raises(sb.UsageError, match="sb.Stiff"):
        sb.simulate(held_pendulum(), 1.0, constraints=sb.GGL(), integrator=sb.Explicit())
