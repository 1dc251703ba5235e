"""What is drawn of contacts, and where their forces act."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.visual.film.annotations import footprint_marks, vector_marks, vector_scales
from symbody.visual.film.camera import fit_camera
from symbody.visual.film.drawing import Filled
from symbody.visual.film.palette import LIGHT
from symbody.visual.film.stage import make_stage, pose_at
from symbody.visual.film.studio import level_direction
from symbody.visual.scene import make_motion, make_scene
from symbody.visual.scene.motion import coordinate_courses
from symbody.visual.scene.scene import Anchor, MotionVector, Scene, SceneMotion
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


def foot(*sizes: float) -> tuple[Scene, SceneMotion]:
    """Return a scene and forces of these sizes at x = 0, 1, 2, .. m, one a second."""
    scene = make_scene(sb.Model("foot", [sb.Free("move", "ground", sb.Body("Foot", 1, inertia=(1, 1, 1)))]))
    count = len(sizes)
    values, places = np.zeros((count, 3)), np.zeros((count, 3))
    values[:, 2], places[:, 0] = sizes, np.arange(count)
    vector = MotionVector("contact foot", "force", Anchor(1, (0.0, 0.0, 0.0)), values, places, True)
    poses = np.zeros((count, 1, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (count, 1, 1))
    return scene, SceneMotion(np.arange(count, dtype=float), *poses, (), (vector,))


def test_the_scale_is_that_of_what_a_contact_bears_not_of_an_impact() -> None:
    scene, motion = foot(*[0.0] * 5, 900.0, *[10.0] * 20)
    assert vector_scales(motion, 2.0)["force"] == pytest.approx(0.25 * 2.0 / 10.0)
    camera = fit_camera(scene, "front", motion.vectors[0].places, (400.0, 300.0), 10.0)
    pose = pose_at(motion, 0)
    scales = vector_scales(motion, 2.0)
    assert vector_marks(camera, pose, motion.vectors, 0, scales, 2.0) == []  # nothing touches
    impact = vector_marks(camera, pose_at(motion, 5), motion.vectors, 5, scales, 2.0)
    corners = np.concatenate([each.corners for each in impact if isinstance(each, Filled)])
    # cut off at half of the size, not 45 m long; the point of contact is a dot of 2.2 points
    assert np.ptp(corners[:, 1]) == pytest.approx(0.5 * 2.0 * camera.scale + 2.2)


def test_footprints_are_where_something_has_touched_and_fade() -> None:
    scene, motion = foot(5.0, 5.0, 0.0, 0.0, 5.0, 5.0, 5.0, 0.0, 0.0, 0.0, 0.0)
    camera = fit_camera(scene, "front", motion.vectors[0].places, (400.0, 300.0), 10.0)

    def prints(time: float, size: float) -> list[float]:
        marks = [
            each
            for each in footprint_marks(camera, motion, time, size, LIGHT, 0.4)
            if isinstance(each, Filled)
        ]
        points = [each.corners.mean(axis=0) for each in marks]
        zero, one = (camera.project(np.array([[x, 0.0, 0.0]]))[0, 0] for x in (0.0, 1.0))
        return [round(float((x - zero) / (one - zero)), 6) for x, _ in points]

    assert prints(1.0, 1.0) == [0.0, 1.0]
    assert prints(1.0, 100.0) == [0.0]  # so near that they are one
    assert prints(4.5, 1.0) == [1.0, 4.0]  # four seconds old is gone
    assert prints(10.0, 1.0) == []


def test_a_ball_bounces_in_a_level_picture_above_its_floor() -> None:
    ball = sb.Body("Ball", mass=1, inertia=(0.004,) * 3)
    floor = sb.Contact("floor", "ground", ball, ["plane", {"sphere": 0.1}], normal="rigid", restitution=0.7)
    joint = sb.Planar("move", "ground", ball, axis="y", coordinates=["z", "x", "turn"])
    for elements, up in (([ball, joint, floor], [0, 0, 1]), ([ball, joint], None)):
        model = sb.Model("ball", elements, gravity=(0, 0, -G))
        run = sb.simulate(sb.form_equations(model), 1.0, {"z": 1.0, "x_dot": 3.0})
        scene = make_scene(model, {}, coordinate_courses(run))
        motion = make_motion(run, scene)
        poses = [pose_at(motion, k) for k in range(len(motion.times))]
        level = level_direction(make_stage(scene, motion), poses)
        assert (None if level is None else level.tolist()) == up


def test_the_ground_of_a_planar_mechanism_is_a_strip_with_its_bumps() -> None:
    """What is across the plane would cover the wheel; a bump of 0.2 m is seen on a road of 20 m."""
    wheel = sb.Body("Wheel", mass=5, inertia=(0.05, 0.1, 0.05))
    shapes = [{"height": "0.03*exp(-((x - 1)/0.1)^2)"}, {"sphere": 0.2}]
    road = sb.Contact("road", "ground", wheel, shapes, normal=sb.NormalForce(stiffness=1e5))
    plane = sb.Planar("move", "ground", wheel, axis="y", coordinates=["z", "x", "turn"])
    model = sb.Model("wheel", [wheel, plane, road], gravity=(0, 0, -G))
    scene = make_scene(model, {}, {"z": np.full(2, 0.2), "x": np.array([0.0, 20.0])})
    (solid,) = (solid for solid in scene.bodies[0].solids if solid.kind == "mesh")
    assert solid.mesh is not None
    vertices = scene.meshes[solid.mesh].vertices
    assert np.ptp(vertices[:, 0]) > 20.0 and np.ptp(vertices[:, 1]) < scene.size
    assert vertices[:, 2].max() > 0.025
