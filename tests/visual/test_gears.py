"""Wheels, racks and belts of scenes: teeth mesh wherever the equations of the model are fulfilled."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.path import Path as Polygon
from numpy.typing import NDArray

import symbody as sb
from symbody.visual.scene.basis import scene_basis
from symbody.visual.scene.from_model import make_scene
from symbody.visual.scene.numbers import model_numbers
from symbody.visual.scene.poses import RigidTransform, rotation_matrix
from symbody.visual.scene.shapes.belts import belt_line
from symbody.visual.scene.shapes.gear_profile import gear_outline, ring_outlines

Floats = NDArray[np.float64]


def outlines(model: sb.Model, coordinates: dict[str, float]) -> dict[str, Floats]:
    """The meshes (N, 2) of all bodies in the plane of ground, at some coordinates."""
    scene = make_scene(model)
    places = scene_basis(
        model, model_numbers(model, {}), {k: np.array([v]) for k, v in coordinates.items()}
    ).bodies
    found = {}
    for body in scene.bodies[1:]:
        for solid in body.solids:
            if solid.kind == "mesh" and solid.mesh is not None:
                own = RigidTransform(np.array(solid.at), rotation_matrix(solid.quaternion))
                found[body.name] = (places[body.name] @ own).point(scene.meshes[solid.mesh].vertices)[:, :2]
    return found


def rim(points: Floats) -> Floats:
    """The outline of a wheel: a prism has it four times, and the centre twice."""
    return points[: (len(points) - 2) // 4]


def dense(outline: Floats) -> Floats:
    after = np.roll(outline, -1, axis=0)
    return np.vstack([outline + share * (after - outline) for share in np.linspace(0, 1, 5, endpoint=False)])


def turned(outline: Floats, angle: float, at: tuple[float, float] = (0.0, 0.0)) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(outline @ np.array([[c, s], [-s, c]]) + at)


@pytest.mark.parametrize("teeth", [(15, 15), (15, 40), (22, 33), (15, 240)])
def test_outlines_of_wheels_do_not_cut_each_other(teeth: tuple[int, int]) -> None:
    n1, n2 = teeth
    r1, r2 = n1 / 2, n2 / 2  # of module 1
    first, second = gear_outline(r1, n1), gear_outline(r2, n2)
    for angle in np.linspace(0, 2 * math.pi / n1, 24):
        one = turned(first, angle)
        two = turned(second, math.pi + math.pi / n2 - angle * n1 / n2, (r1 + r2, 0.0))
        assert not Polygon(one).contains_points(dense(two)).any()
        assert not Polygon(two).contains_points(dense(one)).any()


@pytest.mark.parametrize("teeth", [(15, 45), (20, 80)])
def test_a_wheel_turns_inside_a_ring(teeth: tuple[int, int]) -> None:
    n1, n2 = teeth
    r1, r2 = n1 / 2, n2 / 2
    wheel, (inner, outer) = gear_outline(r1, n1), ring_outlines(r2, n2)
    assert np.linalg.norm(outer, axis=1).min() > np.linalg.norm(inner, axis=1).max()
    for angle in np.linspace(0, 2 * math.pi / n1, 24):
        inside = turned(dense(wheel), angle, (r2 - r1, 0.0))
        hole = Polygon(turned(inner, angle * n1 / n2))
        assert hole.contains_points(inside).all()


def pair(ratio: float, offset: float, sign: int = 1) -> sb.Model:
    return sb.Model(
        "pair",
        [
            sb.Revolute("j1", "ground", sb.Body("W1", 1, (0, 0, 1)), coordinate="a"),
            sb.Revolute("j2", "ground.c", sb.Body("W2", 1, (0, 0, 1)), coordinate="b", axis=(0, 0, sign)),
            sb.Gear("g", ["a", "b"], ratio=ratio, offset=offset),
        ],
        ground={"c": sb.Frame((2, 0.7, 0), rotate=[("z", 0.4)])},
    )


@pytest.mark.parametrize(
    ("ratio", "offset", "sign"), [(-1.5, 0.3, 1), (-0.4, 0, 1), (2, 1, -1), (-math.sqrt(2), 0.1, 1)]
)
def test_teeth_of_a_model_mesh_at_every_angle(ratio: float, offset: float, sign: int) -> None:
    model = pair(ratio, offset, sign)
    centre = np.array([2.0, 0.7])
    for angle in np.linspace(0, 0.5, 7):
        found = outlines(model, {"b": angle, "a": ratio * angle + offset})
        first, second = rim(found["W1"]), rim(found["W2"])
        assert not Polygon(first).contains_points(second).any()
        assert not Polygon(second).contains_points(first).any()
        apart = np.linalg.norm(first[:, None] - second[None], axis=-1).min()
        assert apart < 0.2 * np.linalg.norm(centre)
        reach = np.linalg.norm(first, axis=1).max() + np.linalg.norm(second - centre, axis=1).max()
        assert reach > np.linalg.norm(centre)  # teeth stand in gaps


def test_a_train_keeps_its_teeth() -> None:
    wheels = [sb.Body(f"W{k}", 1, (0, 0, 1)) for k in range(3)]
    joints = [sb.Revolute(f"j{k}", f"ground.c{k}", wheels[k], coordinate=f"q{k}") for k in range(3)]
    gears = [sb.Gear("g0", ["q0", "q1"], ratio=-2), sb.Gear("g1", ["q2", "q1"], ratio=-3, offset=0.7)]
    places = {"c0": (0, 0, 0), "c1": (0, 3, 0), "c2": (2.0, 5, 0)}
    model = sb.Model("train", [*joints, *gears], ground={k: sb.Frame(at) for k, at in places.items()})
    scene = make_scene(model)
    meshes = [solid for body in scene.bodies[1:] for solid in body.solids if solid.kind == "mesh"]
    # The wheel in the middle has two sizes, as distances and ratios say: a step wheel.
    assert len(meshes) == 4
    straight = sb.Model("train", [*joints, *gears], ground={
        "c0": sb.Frame((0, 0, 0)), "c1": sb.Frame((0, 3, 0)), "c2": sb.Frame((0, 3 + 2 * (1 + 1 / 3), 0)),
    })  # fmt: skip
    assert sum(solid.kind == "mesh" for body in make_scene(straight).bodies[1:] for solid in body.solids) == 3
    for angle in np.linspace(0, 0.4, 5):
        found = outlines(straight, {"q1": angle, "q0": -2 * angle, "q2": -3 * angle + 0.7})
        rims = [rim(found[f"W{k}"]) for k in range(3)]
        for one, two in ((0, 1), (1, 2)):
            assert not Polygon(rims[one]).contains_points(rims[two]).any()
            assert not Polygon(rims[two]).contains_points(rims[one]).any()


@pytest.mark.parametrize("radius", [0.5, -0.5])
def test_a_rack_meshes_with_its_pinion(radius: float) -> None:
    model = sb.Model(
        "rack",
        [
            sb.Revolute("turn", "ground.c", sb.Body("Pinion", 1, (0, 0, 1)), coordinate="a"),
            sb.Prismatic("slide", "ground", sb.Body("Rack", 1), axis="x", coordinate="x"),
            sb.RackPinion("mesh", ["x", "a"], radius=radius, offset=0.1),
        ],
        ground={"c": sb.Frame((0, 1, 0))},
    )  # fmt: skip
    for angle in np.linspace(0, 0.6, 7):
        found = outlines(model, {"a": angle, "x": radius * angle + 0.1})
        wheel = rim(found["Pinion"])
        assert not Polygon(wheel).contains_points(found["Rack"]).any()
        assert abs(abs(found["Rack"][:, 1] - 1.0).min() - 0.5) < 0.05  # teeth reach beyond the pitch circle


@pytest.mark.parametrize("is_crossed", [False, True])
def test_belts_touch_their_pulleys_and_do_not_cut_them(is_crossed: bool) -> None:
    line = belt_line(0.5, 0.2, 2.0, is_crossed)
    to_first = np.linalg.norm(line, axis=1)
    to_second = np.linalg.norm(line - [2.0, 0.0], axis=1)
    assert np.allclose(np.minimum(np.abs(to_first - 0.5), np.abs(to_second - 0.2)), 0.0)
    closed = np.vstack([line, line[:1]])
    between = np.vstack([closed[:-1] * (1 - s) + closed[1:] * s for s in np.linspace(0, 1, 9)])
    assert np.linalg.norm(between, axis=1).min() > 0.49
    assert np.linalg.norm(between - [2.0, 0.0], axis=1).min() > 0.19


@pytest.mark.parametrize(("ratio", "height"), [(-1.5, 1.0), (2.0, 1.0), (-0.5, -0.7), (-1.0, 0.0)])
def test_wheels_on_crossing_axes_are_cones_with_one_tip(ratio: float, height: float) -> None:
    model = sb.Model(
        "bevel",
        [
            sb.Revolute("j1", "ground.a", sb.Body("W1", 1, (0, 0, 1)), coordinate="a"),
            sb.Revolute("j2", "ground", sb.Body("W2", 1, (0, 0, 1)), coordinate="b", axis="x"),
            sb.Gear("g", ["a", "b"], ratio=ratio),
        ],
        ground={"a": sb.Frame((0, 0, height))},
    )
    for angle in (0.0, 0.1, 0.2, 0.3):
        scene = make_scene(model)
        coordinates = {"b": np.array([angle]), "a": np.array([ratio * angle])}
        places = scene_basis(model, model_numbers(model, {}), coordinates).bodies
        points = []
        for body in scene.bodies[1:]:
            (solid,) = (each for each in body.solids if each.kind == "mesh")
            assert solid.mesh is not None
            own = places[body.name] @ RigidTransform(np.array(solid.at), rotation_matrix(solid.quaternion))
            mesh = scene.meshes[solid.mesh].vertices
            points.append(own.point(mesh[: (len(mesh) - 2) // 4]))  # the outline of the large end
        centres = [outline.mean(axis=0) for outline in points]
        touch = centres[0] + centres[1]  # for axes at right angles with one tip in the origin
        side = np.cross(centres[0], centres[1]) / np.linalg.norm(np.cross(centres[0], centres[1]))
        phases, numbers = [], []
        for outline, centre in zip(points, centres, strict=True):
            radii = np.linalg.norm(outline - centre, axis=1)
            tips = (outline - centre)[radii > radii.max() - 1e-9]
            forward = (touch - centre) / np.linalg.norm(touch - centre)
            numbers.append(len(tips) // 2)
            angles = np.arctan2(tips @ side, tips @ forward)
            phases.append(np.angle(np.exp(1j * numbers[-1] * angles).sum()) / (2 * math.pi))
        # Teeth of one stand half a pitch beside those of the other where they touch.
        assert math.isclose((phases[0] - phases[1]) % 1.0, 0.5, abs_tol=1e-6)
        assert math.isclose(numbers[1] / numbers[0], abs(ratio))
        assert math.isclose(np.linalg.norm(centres[0]) / np.linalg.norm(centres[1]), abs(ratio))


@pytest.mark.parametrize("teeth", [6, 9, 16, 30, 41, 80])
def test_outlines_turn_on_round_the_centre(teeth: int) -> None:
    """Seen from the centre every side has a width, so that no triangle of a face is a line: each would show an edge."""
    x, y = gear_outline(1.0, teeth).T
    angles = np.unwrap(np.arctan2(y, x))
    assert (np.diff(np.append(angles, angles[0] + 2 * math.pi)) > 1e-3 / teeth).all()
