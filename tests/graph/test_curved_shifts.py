"""Joints that shift along a curve are in the translation tree, or refused as chords."""

from __future__ import annotations

import itertools
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.graph.curved_shifts import is_curved
from tests.tiers import cases

RECIPE = Path(__file__).parents[2] / "docs" / "extending_joint.md"


@pytest.fixture(name="circle", scope="module")
def circle_fixture(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The class of the recipe: the place on a circle, and three angles."""
    file = tmp_path_factory.mktemp("recipe") / "point_on_circle.py"
    text = RECIPE.read_text(encoding="utf-8").partition("```python\n")[2].partition("```")[0]
    file.write_text(text, encoding="utf-8")
    return runpy.run_path(str(file))["PointOnCircle"]


def model(ring: object, order: tuple[int, ...] = (0, 1, 2)) -> sb.Model:
    """A bead on a ring of 1 m that slides along an arm, which turns about a point beside the centre."""
    bead, arm = (
        sb.Body(name, mass=mass, inertia=(0.1, 0.1, 0.1)) for name, mass in (("Bead", 1), ("Arm", 2))
    )
    joints = [
        ring,
        sb.Revolute("hinge", "ground.pivot", "Arm", coordinate="theta"),
        sb.Prismatic("slide", "Arm", "Bead", axis="x", coordinate="d"),
    ]
    pivot = {"pivot": sb.Frame(at=(0.5, 0, 0))}
    elements = [bead, arm, *(joints[k] for k in order)]
    return sb.Model("ring", elements, ground=pivot, gravity=(0, -9.81, 0))


@pytest.mark.parametrize("order", cases(itertools.permutations(range(3)), fast=[(0, 1, 2), (2, 0, 1)]))
def test_automatic_trees_do_not_cut_it(circle: Any, order: tuple[int, ...]) -> None:
    """The motion is that of the same curve as a constraint."""
    start = {"theta": 0.3, "theta_dot": 1.0}
    guess, rates = {"d": 0.5, "s": 0.2}, {"a": 0.0, "b": 0.0, "c": 0.3}
    own = circle("ring", "ground", "Bead", 1.0, coordinates=["s", "a", "b", "c"])
    eqs = sb.form_equations(model(own, order))
    assert "s" in eqs.coordinate_names
    run = sb.simulate(eqs, 1.0, start, guess={**guess, **rates}, times=np.linspace(0.0, 1.0, 11))
    held = sb.PointOnCurve("ring", "ground", "Bead", curve=("cos(p)", "sin(p)", 0), parameter="p")
    other = sb.simulate(
        sb.form_equations(model(held)),
        1.0,
        start,
        guess={"d": 0.5, "p": 0.2},
        times=np.linspace(0.0, 1.0, 11),
    )
    assert run.success and other.success, (run.notes, other.notes)
    assert np.abs(run["theta"] - other["theta"]).max() < 1e-6
    assert np.abs(run["s"] - other["p"]).max() < 1e-6


@pytest.mark.parametrize("tree", ["absolute", sb.Trees(rotation=["hinge"], translation=["hinge", "slide"])])
def test_a_chord_is_refused_with_its_cure(circle: Any, tree: Any) -> None:
    own = circle("ring", "ground", "Bead", 1.0, coordinates=["s", "a", "b", "c"])
    with pytest.raises(sb.TopologyError, match=r"topology.curved_chord.*joint ring(.|\n)*PointOnCurve"):
        sb.form_equations(model(own), tree=tree)


def test_joints_of_the_package_are_straight() -> None:
    for joint in (
        sb.Screw("j", "ground", "B", pitch="p", coordinate="a"),
        sb.Telescoping("j", "ground", "B", coordinates=["a", "b", "c", "s"]),
        sb.Planar("j", "ground", "B"),
        sb.Free("j", "ground", "B"),
    ):
        assert not is_curved(joint)
