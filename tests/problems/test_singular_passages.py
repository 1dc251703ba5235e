"""Singular configurations of one-loop mechanisms: found, classified, and passed or ended at by name.

Four-bars with s + l = p + q lie flat somewhere (Grashof's limit); a slider-crank has its dead centres.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import symbody as sb
from tests.analysis.test_kinematics import four_bar
from tests.faults.test_constraint_rows import slider_crank

FOUND = 1e-6  # what is promised for places
# Crank, coupler, rocker, ground; where the crank lies flat; the sides that add up to the same.
FLAT = {
    "change point, stretched": ((1.0, 2.5, 2.0, 3.5), [math.pi]),
    "change point, folded": ((1.5, 2.0, 2.5, 2.0), [0.0]),
    "parallelogram": ((1.0, 3.0, 1.0, 3.0), [0.0, math.pi]),
    "kite": ((2.0, 2.0, 1.5, 1.5), [0.0, math.pi]),
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name.startswith("change") else [pytest.mark.exhaustive])
        for name in FLAT
    ],
)
def test_change_points_are_bifurcations_at_the_cut_joint(name: str) -> None:
    lengths, angles = FLAT[name]
    found = sb.singular_configurations(four_bar(*lengths), "theta", {"theta": (-1, 4)})
    assert [one.q["theta"] for one in found] == pytest.approx(angles, abs=FOUND)
    assert {(one.kind, one.joint) for one in found} == {("bifurcation", "C")}


@pytest.mark.parametrize("name", ["change point, stretched", "change point, folded", "parallelogram"])
def test_a_motion_passes_its_change_points(name: str) -> None:
    """And the note names the time at which the crank lies flat for the first time."""
    lengths, angles = FLAT[name]
    run = sb.simulate(four_bar(*lengths), 4.0, {"theta": 0.8, "theta_dot": 3.0}, guess={"phi": 1.0})
    (note,) = (note for note in run.notes if "change point" in note)
    assert run.success and "t = " in note
    assert np.ptp(run["theta"]) > 2 * math.pi  # past every flat position
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    # Without gravity and friction energy is kept: local errors of 1e-8 of it a step.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()
    time = float(note.split("t = ")[1].split(" s")[0])
    place = min(abs(math.remainder(run.at(time)["theta"] - angle, 2 * math.pi)) for angle in angles)
    assert place < 0.5  # at the step before or after it


def test_dead_centres_are_lock_ups_of_the_slider_alone() -> None:
    eqs = slider_crank()
    found = sb.singular_configurations(eqs, "s", {"theta": (-0.5, 4.0)}, guess={"s": 4.0})
    assert {(one.kind, one.joint) for one in found} == {("lock-up", "D")}
    # Stretched at 1 + 3 from the pivot, folded at 3 - 1, on both sides: both assemblies are followed.
    places = [(one.q["theta"], one.q["s"]) for one in found]
    assert len(places) == 4
    for place in ((0.0, -2.0), (0.0, 4.0), (math.pi, -4.0), (math.pi, 2.0)):
        assert min(np.abs(np.subtract(place, one)).max() for one in places) < FOUND
    assert sb.singular_configurations(eqs, "theta", {"theta": (-0.5, 4.0)}, guess={"s": 4.0}) == ()
    # Driven by the crank, or free, it turns through them.
    run = sb.simulate(eqs, 6.0, {"theta": 0.5, "theta_dot": 4.0}, guess={"s": 4.0})
    assert run.success and run["theta"][-1] > 4 * math.pi and run.constraint_violation.max() < 1e-9


def test_a_driven_lock_up_is_found_and_ends_the_motion_at_the_same_place() -> None:
    """A crank of 3 m on a rod of 1 m: sin(theta) = 1/3 is as far as it goes."""
    free, driven = (slider_crank(crank=3, rod=1, motion=motion) for motion in (None, "t"))
    found = sb.singular_configurations(free, "theta", {"theta": (0.0, 1.0)}, guess={"beta": -0.1, "s": 4.0})
    assert [one.q["theta"] for one in found] == pytest.approx([math.asin(1 / 3)], abs=FOUND)
    assert [(one.kind, one.joint, dict(one.limits)) for one in found] == [
        ("lock-up", "A", {"theta": "maximum"})
    ]
    run = sb.simulate(driven, 2.0, {}, guess={"beta": -0.1, "s": 4.0})
    assert not run.success and run.t[-1] == pytest.approx(found[0].q["theta"], abs=FOUND)
    assert "locks" in run.notes[-1] and "joint C" in run.notes[-1]
    table = sb.trace_positions(free, {"theta": np.linspace(0.0, 1.0, 21)}, {"beta": -0.1, "s": 4.0})
    assert not table.success and table.limits["theta"] == pytest.approx(found[0].q["theta"], abs=FOUND)
    assert "joint" in table.notes[0] and table.joint in "BCD"
