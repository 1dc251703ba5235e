"""Every joint in motion: as a branch of the trees and cut, a body goes the same way for a second."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import Trees
from symbody.model.joint import Joint
from tests.joint_library import straight_joints

ENDS = ("Arm.tip", "Load.eye")
ARM = sb.Body("Arm", mass=1.2, inertia=(0.2, 0.3, 0.25),
              frames={"tip": sb.Frame(at=(0.5, 0.1, -0.2), rotate=[("y", "0.4"), ("x", "-0.3")])})  # fmt: skip
LOAD = sb.Body("Load", mass=0.8, inertia=(0.1, 0.15, 0.12),
               frames={"eye": sb.Frame(at=(-0.3, 0.2, 0.1), rotate=[("z", "0.7")])})  # fmt: skip
AXES: dict[str, dict[str, Any]] = {
    "revolute": {"axis": (1, 2, 2)},
    "prismatic": {"axis": (2, 1, -2)},
    "cylindrical": {"axis": (1, 2, 2)},
    "spherical": {"angles": "123"},
    "free": {"angles": "123"},
}
JOINTS = straight_joints(*ENDS, AXES)
FAST = ("screw",)
TIMES = np.linspace(0.0, 1.0, 11)


def motion(joint: Joint, tree: Trees) -> sb.Trajectory:
    """From 0.4, 0.5, ... of its coordinates, which change with 0.3, 0.4, ...; a spring holds the load."""
    parts = [
        ARM, LOAD, sb.Revolute("hip", "ground", "Arm", axis="y", coordinate="a", torque=sb.Drive(damping=0.1)),
        joint, sb.SpringDamper("hold", "ground.nail", LOAD, stiffness=30, damping=0.4, free=0.3),
    ]  # fmt: skip
    model = sb.Model("m", parts, gravity=(0, 0, -9.81), ground={"nail": sb.Frame(at=(0.2, -0.4, 0.6))})
    start = {"a": 0.3, "a_dot": -0.7}
    for k, name in enumerate(joint.coordinates):
        start |= {name: 0.4 + 0.1 * k, f"{name}_dot": 0.3 + 0.1 * k}
    return sb.simulate(sb.form_equations(model, tree=tree), 1.0, start, times=TIMES, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize(
    "kind", [kind if kind in FAST else pytest.param(kind, marks=pytest.mark.exhaustive) for kind in JOINTS]
)
def test_branch_and_chord_move_alike(kind: str) -> None:
    joint = JOINTS[kind]
    branch = motion(joint, Trees(["hip", "J"], ["hip", "J"]))
    chord = motion(joint, Trees(["hip"], ["hip"]))
    assert branch.success and chord.success
    # Local errors of 1e-10 of rates up to some 10/s in some hundred steps.
    for name in ("frame r Load", "frame R Load", "frame v Load", "frame w Load", "a"):
        assert np.abs(branch[name] - chord[name]).max() < 1e-7, name
    for name in joint.coordinates:  # by name whatever the tree
        for word, close in ((name, 1e-7), (f"{name}_dot", 1e-6)):
            assert np.abs(branch[word] - chord[word]).max() < close, word
    # Forces of some 100 N follow from accelerations.
    assert np.abs(branch["reaction J"] - chord["reaction J"]).max() < 1e-5
    for run in (branch, chord):
        assert run.constraint_violation.max(initial=0.0) < 1e-10 and run.energy_drift < 1e-7


def test_a_motion_that_ends_where_nothing_is_free_says_so() -> None:
    pin = sb.Revolute("pin", "ground", sb.Body("Arm", 1, (0, 0, 1)), coordinate="phi", motion="t**0.5")
    run = sb.simulate(sb.form_equations(sb.Model("arm", [pin])), 1.0)
    assert not run.success and "not finite" in str(run.status.value)
