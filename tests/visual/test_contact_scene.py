"""What is drawn of contacts, and where their forces act."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.visual.scene import make_motion, make_scene
from tests.tiers import cases

G, EDGES = 9.81, (0.2, 0.1, 0.5)


def table(normal: sb.NormalForce | str, lean: float = 0.0) -> sb.EquationSet:
    """Return a block that stands on ground, with gravity aslant by an angle towards x."""
    friction = sb.Friction(mu=0.9) if normal == "rigid" else sb.Friction(mu=0.9, v0=1e-3)
    box = sb.Body("Box", mass=2, inertia=(0.1, 0.1, 0.1))
    floor = sb.Contact("floor", "ground", box, ["plane", {"box": EDGES}], normal=normal, friction=friction)
    joint = sb.Planar("move", "ground", box, axis="y", coordinates=["z", "x", "tilt"])
    return sb.form_equations(
        sb.Model("table", [joint, floor], gravity=(G * np.sin(lean), 0, -G * np.cos(lean)))
    )


@pytest.mark.parametrize("lean", cases([0.0, 0.2], fast=[0.2]))
def test_the_force_of_a_block_at_rest_acts_below_its_weight(lean: float) -> None:
    """At rest the line of gravity through the centre of mass passes through the centre of pressure."""
    run = sb.simulate(table("rigid", lean), 0.1, {"z": 0.25, "x": 0.3, "tilt": 0.0})
    assert run["contact_point floor"][:, -1] == pytest.approx((0.3 + 0.25 * np.tan(lean), 0, 0), abs=1e-9)
    assert run["contact_force floor"][2, -1] == pytest.approx(2 * G * np.cos(lean), rel=1e-9)


def test_a_compliant_block_presses_in_its_middle_and_where_it_is_lowest_before() -> None:
    eqs = table(sb.NormalForce(stiffness=1e5, exponent=1))
    depth = 2 * G / 4 / 1e5
    run = sb.simulate(eqs, 0.01, {"z": 0.25 - depth, "x": 0.3, "tilt": 0.0})
    assert run["contact_point floor"][:2, 0] == pytest.approx((0.3, 0), abs=1e-12)
    above = sb.simulate(eqs, 0.01, {"z": 0.5, "x": 0.0, "tilt": 0.1})
    x = -0.25 * np.sin(0.1) + 0.1 * np.cos(0.1)  # of the lowest corners
    assert abs(above["contact_point floor"][0, 0]) == pytest.approx(abs(x), rel=1e-9)


def test_a_contact_is_drawn_once_with_its_force_where_it_acts() -> None:
    run = sb.simulate(table("rigid", 0.2), 0.1, {"z": 0.25, "x": 0.3, "tilt": 0.0})
    assert run.model is not None
    scene = make_scene(run.model)
    assert [solid.size for solid in scene.bodies[1].solids if solid.kind == "box"] == [EDGES]
    assert [solid.element for solid in scene.bodies[0].solids if solid.kind == "box"] == ["floor"]
    (vector,) = make_motion(run, scene).vectors
    assert vector.name == "contact floor" and vector.places is not None
    assert vector.places[-1] == pytest.approx((0.3 + 0.25 * np.tan(0.2), 0, 0), abs=1e-9)
    weight = 2 * G * np.array([np.sin(0.2), 0, -np.cos(0.2)])
    assert vector.values[-1] == pytest.approx(-weight, abs=1e-8)


def test_shapes_and_planes_that_the_model_draws_are_not_drawn_again() -> None:
    ball = sb.Body("Ball", mass=1, inertia=(1, 1, 1), shapes=[sb.Sphere("0.3")])
    floor = sb.Contact(
        "floor", "ground", ball, ["plane", {"sphere": 0.3}], normal=sb.NormalForce(stiffness=1e5)
    )
    scene = make_scene(sb.Model("ball", [sb.Free("move", "ground", ball), floor]))
    assert [solid.kind for solid in scene.bodies[1].solids] == ["sphere"]
