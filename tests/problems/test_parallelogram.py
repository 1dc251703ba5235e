"""A parallelogram four-bar through its flat positions, where it might become an antiparallelogram."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import symbody as sb

START = {"a": 1.0, "a_dot": 8.0}
GUESS = {"b": -1.0, "d": 1.0}


@cache
def parallelogram(base: float = 2.0) -> sb.EquationSet:
    """Cranks of 1 m and a rod of 2 m; with a base of 2 m all lie on one line twice in a turn."""
    bodies = [
        sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), frames={"tip": sb.Frame(at=(length, 0, 0))})
        for name, length in (("Crank", 1.0), ("Rod", 2.0), ("Rocker", 1.0))
    ]
    joints = [
        sb.Revolute("A", "ground", "Crank", coordinate="a"),
        sb.Revolute("B", "Crank.tip", "Rod", coordinate="b"),
        sb.Revolute("D", "ground.post", "Rocker", coordinate="d"),
        sb.Revolute("C", "Rod.tip", "Rocker.tip"),
    ]
    ground = {"post": sb.Frame(at=(base, 0, 0))}
    return sb.form_equations(
        sb.Model("parallelogram", [*bodies, *joints], ground=ground, gravity=(0, "-9.81", 0))
    )


def pendulum() -> sb.EquationSet:
    """What the parallelogram is in one coordinate: cranks in their pivots, and a rod that does not turn.

    Bodies stand with their centres in the pivots, but the rod, whose centre goes in a circle.
    """
    body = sb.Body("One", mass=1, inertia=(0, 0, 0.2), frames={"pivot": sb.Frame(at=(-1, 0, 0))})
    joint = sb.Revolute("A", "ground", "One.pivot", coordinate="a")
    return sb.form_equations(sb.Model("pendulum", [body, joint], gravity=(0, -9.81, 0)))


def check(run: sb.Trajectory) -> None:
    assert run.success
    (note,) = (note for note in run.notes if "change point" in note)
    assert "sb.Partition()" in note
    # On the branch of the parallelogram both cranks turn alike; the other has d = a on the line only.
    assert np.abs(run["a"] - run["d"]).max() < 1e-9
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()


@pytest.mark.parametrize("rtol", [1e-8, 1e-11])
def test_stays_on_its_branch(rtol: float) -> None:
    run = sb.simulate(parallelogram(), 5.0, START, guess=GUESS, rtol=rtol, atol=rtol / 100)
    check(run)
    one = sb.simulate(pendulum(), 5.0, START, rtol=1e-12, atol=1e-13)
    # Errors in the speed grow in proportion to time and to the number of steps.
    assert run["a"][-1] == pytest.approx(one["a"][-1], abs=1e2 * rtol * run.statistics.accepted)


@pytest.mark.exhaustive
@pytest.mark.parametrize("rtol", [1e-8, 1e-11])
def test_stays_on_its_branch_for_a_minute(rtol: float) -> None:
    run = sb.simulate(parallelogram(), 60.0, START, guess=GUESS, rtol=rtol, atol=rtol / 100)
    check(run)
    assert run["a"][-1] > 150 * math.pi


def test_events_are_told_once() -> None:
    flat = sb.Event("sin(a)", name="flat")
    run = sb.simulate(parallelogram(), 2.0, START, guess=GUESS, events=flat)
    check(run)
    turned = math.floor(run["a"][-1] / math.pi)
    assert [event.name for event in run.events] == ["flat"] * turned


def test_what_is_asked_for_is_done() -> None:
    """Without a change point nothing is changed, nor where a way to hold constraints is given."""
    beside = sb.simulate(parallelogram(1.9), 2.0, {"a": 1.0, "a_dot": 8.0}, guess={"b": -1.0, "d": 1.0})
    asked = sb.simulate(parallelogram(), 0.5, START, guess=GUESS, constraints=sb.Projection())
    for run in (beside, asked):
        assert not any("Partition" in note for note in run.notes)
