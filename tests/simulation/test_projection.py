"""Projection where rounding is larger than the tolerance: fast motions, and tolerances out of reach."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice

EXAMPLE = Path(__file__).parents[2] / "examples" / "slider_crank" / "slider_crank.toml"


@cache
def slider_crank(tree: TreeChoice) -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLE), tree=tree)


def turn(tree: TreeChoice, speed: float, **tolerances: float) -> sb.Trajectory:
    """One radian at a speed [rad/s]."""
    start = {"theta": 0.3, "theta_dot": speed}
    eqs = slider_crank(tree)
    return sb.simulate(eqs, 1.0 / speed, start, inputs={"F": 0}, rtol=1e-9, max_steps=500, **tolerances)


@pytest.mark.parametrize("speed", [1e3, 1e5, 1e6])
def test_a_fast_start_that_is_off_by_rounding_is_no_fault_of_the_first_step(speed: float) -> None:
    # In absolute coordinates speeds across the plane are 1e-16 of 1e5 m/s, and atol is below that.
    run = turn("absolute", speed, atol=1e-12)
    assert run.success and run["constraint_violation"].max() <= 1e-12
    reference = turn(None, speed, atol=1e-12)
    assert run["theta"][-1] == pytest.approx(reference["theta"][-1], abs=1e-8)
    assert run.statistics.accepted <= reference.statistics.accepted + 1


@pytest.mark.parametrize("tree", [None, "absolute"])
@pytest.mark.parametrize("atol", [1e-14, 1e-16, 1e-20])
def test_constraints_are_closed_to_rounding_where_atol_is_below_it(tree: TreeChoice, atol: float) -> None:
    run = turn(tree, 1.0, atol=atol)
    assert run.success
    # residuals add up a few offsets: some eps of the mechanism's size
    assert run["constraint_violation"].max() <= max(atol, 8 * np.finfo(float).eps)


def test_a_loop_that_turns_very_often_stays_closed_to_the_rounding_of_its_angle() -> None:
    start = {"theta": 1e4, "theta_dot": 5.0}
    run = sb.simulate(slider_crank(None), 2.0, start, inputs={"F": 0}, rtol=1e-9, atol=1e-14, max_steps=2000)
    assert run.success
    assert run["constraint_violation"].max() <= 3 * np.finfo(float).eps * 1e4
