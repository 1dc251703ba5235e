"""Shapes, cameras and lines against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from symbody.errors import UsageError
from symbody.visual.film.camera import Camera, fit_camera
from symbody.visual.film.connector_shapes import coil, coil_points, rope_points
from symbody.visual.film.facets import Facets, facets_of, weld
from symbody.visual.film.solid_facets import facets_of_solid, rotation_of
from symbody.visual.scene.scene import Anchor, Connector, SceneMesh, Solid
from tests.visual.film_scenes import scene_of

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def volume(facets: Facets) -> float:
    a, b, c = (facets.vertices[facets.triangles[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c))) / 6


@pytest.mark.parametrize(
    "kind, size, exact",
    [
        ("box", (1.0, 2.0, 3.0), 6.0),
        ("cylinder", (0.5, 2.0), np.pi * 0.5),
        ("cone", (0.5, 3.0), np.pi * 0.25),
        ("sphere", (1.0,), 4 * np.pi / 3),
        ("capsule", (0.5, 2.0), np.pi * 0.5 + 4 * np.pi / 3 * 0.125),
    ],
)
def test_solids_have_their_volume_and_face_outwards(kind: str, size: tuple[float, ...], exact: float) -> None:
    facets = facets_of_solid(Solid("it", kind, size), ())  # type: ignore[arg-type]
    # A polygon of n sides lacks 2 pi^2 / 3 n^2 of its circle; a sphere lacks it along both angles.
    assert_allclose(volume(facets), exact, rtol=0.01)
    assert (facets.neighbours >= 0).all()  # closed
    middles = facets.vertices[facets.triangles].mean(axis=1)
    assert (np.einsum("tki,ti->tk", facets.normals, middles) > 0.0).all()


def test_edges_of_solids() -> None:
    assert facets_of_solid(Solid("it", "box", (1.0, 1.0, 1.0)), ()).creases.sum() == 12
    assert facets_of_solid(Solid("it", "sphere", (1.0,)), ()).creases.sum() == 0
    cylinder = facets_of_solid(Solid("it", "cylinder", (1.0, 2.0)), ())
    rims = cylinder.vertices[cylinder.edges[cylinder.creases]]
    assert_allclose(np.abs(rims[..., 2]), 1.0)
    assert_allclose(np.hypot(rims[..., 0], rims[..., 1]), 1.0)


def test_solids_stand_where_they_are_placed() -> None:
    quaternion = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)  # z becomes x
    solid = Solid("it", "cylinder", (0.1, 2.0), (1.0, 2.0, 3.0), quaternion)
    vertices = facets_of_solid(solid, ()).vertices
    assert_allclose(vertices.min(axis=0), [0.0, 1.9, 2.9], atol=1e-3)
    assert_allclose(vertices.max(axis=0), [2.0, 2.1, 3.1], atol=1e-3)
    assert_allclose(rotation_of(quaternion) @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-15)


def test_vertices_of_a_mesh_that_stand_twice_are_welded() -> None:
    sheet = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    vertices, triangles = weld(sheet, np.array([[0, 1, 2], [3, 4, 5], [0, 0, 1]]))
    assert len(vertices) == 4 and len(triangles) == 2
    facets = facets_of(vertices, triangles, closed=False)
    assert facets.creases.sum() == 4  # its rim
    mirrored = Solid("it", "mesh", (-1.0, 1.0, 1.0), mesh=0)
    mesh = SceneMesh(sheet, np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32))
    assert_allclose(facets_of_solid(mirrored, (mesh,)).normals[0, 0], [0.0, 0.0, 1.0])


def test_points_are_projected() -> None:
    camera = Camera(np.eye(3), np.array([1.0, 2.0, 3.0]), np.array([100.0, 50.0]), 10.0)
    assert_allclose(camera.project(np.array([2.0, 4.0, 8.0])), [110.0, 30.0, -5.0])
    near = Camera(np.eye(3), np.zeros(3), np.zeros(2), 10.0, 4.0)
    # Half way to the eye all is twice as large.
    assert_allclose(near.project(np.array([1.0, 0.0, 2.0]))[:2], [20.0, 0.0])
    ends = near.project(np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 1.0], [4.0, 2.0, 2.0]]))
    assert abs(np.linalg.det(np.column_stack([ends[1] - ends[0], ends[2] - ends[0], [0, 0, 1]]))) < 1e-9
    straight = np.cross(ends[1] - ends[0], ends[2] - ends[0])
    assert_allclose(straight, 0.0, atol=1e-9)  # lines stay lines, depth included


@pytest.mark.parametrize(
    "view, right, up",
    [
        ("front", (1, 0, 0), (0, 0, 1)),
        ("back", (-1, 0, 0), (0, 0, 1)),
        ("left", (0, -1, 0), (0, 0, 1)),
        ("right", (0, 1, 0), (0, 0, 1)),
        ("top", (1, 0, 0), (0, 1, 0)),
        ("bottom", (1, 0, 0), (0, -1, 0)),
        ((0.0, -2.0, 0.0), (1, 0, 0), (0, 0, 1)),
        ({"direction": "top", "up": (1, 0, 0)}, (0, -1, 0), (1, 0, 0)),
    ],
)
def test_named_views(view: object, right: tuple[int, ...], up: tuple[int, ...]) -> None:
    camera = fit_camera(scene_of(), view, CORNERS, (200.0, 100.0), 10.0)  # type: ignore[arg-type]
    assert_allclose(camera.axes[:2], [right, up], atol=1e-12)
    assert_allclose(np.cross(camera.axes[0], camera.axes[1]), camera.axes[2], atol=1e-12)
    seen = camera.project(CORNERS)
    assert_allclose([seen[:, 1].min(), seen[:, 1].max()], [10.0, 90.0])  # the room between the margins
    assert_allclose((seen[:, 0].min() + seen[:, 0].max()) / 2, 100.0)


def test_default_views_and_zoom() -> None:
    planar = scene_of(normal=(0.0, -1.0, 0.0))
    assert_allclose(fit_camera(planar, None, CORNERS, (100.0, 100.0), 0.0).axes[2], [0.0, -1.0, 0.0])
    lying = scene_of(normal=(0.0, 0.0, 1.0))  # up is along the normal: y is drawn upwards
    assert_allclose(fit_camera(lying, None, CORNERS, (9.0, 9.0), 0.0).axes[1], [0.0, 1.0, 0.0])
    spatial = fit_camera(scene_of(), None, CORNERS, (100.0, 100.0), 0.0)
    assert_allclose(spatial.axes[2], np.array([1.0, -1.0, 1.0]) / np.sqrt(3.0))
    twice = fit_camera(scene_of(), {"zoom": 2}, CORNERS, (100.0, 100.0), 0.0)
    assert_allclose(twice.scale, 2 * spatial.scale)
    far = fit_camera(scene_of(), {"perspective": True}, CORNERS, (100.0, 100.0), 0.0)
    assert far.distance > np.sqrt(3.0)  # no corner is behind the eye
    assert_allclose(np.ptp(far.project(CORNERS)[:, :2], axis=0).max(), 100.0)


@pytest.mark.parametrize(
    "view", ["abve", (0.0, 0.0, 0.0), (1.0, 2.0), {"zom": 2.0}, {"zoom": -1.0}, {"direction": "abve"}, ("x",)]
)
def test_views_that_do_not_exist(view: object) -> None:
    with pytest.raises(UsageError, match=r"\[film.view\]") as error:
        fit_camera(scene_of(), view, CORNERS, (100.0, 100.0), 0.0)  # type: ignore[arg-type]
    assert error.value.problems[0].fix


def test_a_spring_shows_its_colour() -> None:
    """Outlines as wide as the wire would leave nothing of it, and on dark paper nothing at all."""
    ends = Anchor(0, (0.0, 0.0, 0.0)), Anchor(1, (0.0, 0.0, 0.0))
    spring = Connector("spring", "spring", *ends, 0.1, 1.5, 8)
    drawn = coil(np.zeros(3), np.array([0.0, 0.0, 1.0]), spring, np.array([1.0, 0.0, 0.0]))
    assert len(drawn.triangles) > 0 and len(drawn.edges) == 0


def test_coil_is_as_long_as_its_turns() -> None:
    start, end = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 3.0])
    points, outwards = coil_points(start, end, 0.2, 10, np.array([1.0, 0.0, 0.0]))
    assert_allclose(points[[0, -1]], [start, end], atol=1e-12)
    radii = np.hypot(points[:, 0], points[:, 1])
    full = np.flatnonzero(radii > 0.2 * (1 - 1e-9))
    wire = points[full[0] : full[-1] + 1]
    turns = len(wire) - 1
    # A helix of radius r and pitch p has sqrt((2 pi r)^2 + p^2) of wire in a turn; chords of 18 degrees
    # lack (pi / 20)^2 / 6 of it.
    pitch = 0.8 * 2.0 / 10
    exact = turns / 20 * np.hypot(2 * np.pi * 0.2, pitch)
    assert_allclose(np.linalg.norm(np.diff(wire, axis=0), axis=1).sum(), exact, rtol=0.006)
    assert_allclose(turns / 20, 9.5)  # all but the first and the last quarter
    assert_allclose(np.linalg.norm(outwards, axis=1), 1.0)


@pytest.mark.parametrize("end", [(2.0, 0.0, 0.5), (0.3, 0.4, -1.0), (1e-3, 0.0, 0.0), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("length", [2.2, 3.0, 10.0])
def test_rope_hangs_with_its_length(end: tuple[float, ...], length: float) -> None:
    start, stop = np.array([0.2, 0.1, 1.0]), np.array([0.2, 0.1, 1.0]) + end
    points = rope_points(start, stop, length, np.array([0.0, 0.0, -1.0]))
    assert_allclose(points[[0, -1]], [start, stop], atol=1e-9)
    assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1).sum(), length, rtol=2e-3)
    # It stays in the vertical plane of its ends, and hangs below their connecting line.
    across = np.cross(np.array([0.0, 0.0, 1.0]), stop - start)
    assert_allclose((points - start) @ across, 0.0, atol=1e-9)


def test_rope_hangs_as_a_catenary_and_is_straight_when_taut() -> None:
    a = 0.7  # between points at -1 and 1 it is 2 a sinh(1 / a) long and sags a (cosh(1 / a) - 1)
    ends = np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    points = rope_points(*ends, 2 * a * np.sinh(1 / a), np.array([0.0, 0.0, -1.0]))
    assert_allclose(points[:, 2], a * (np.cosh(points[:, 0] / a) - np.cosh(1 / a)), atol=1e-9)
    assert len(rope_points(*ends, 2.0, np.array([0.0, 0.0, -1.0]))) == 2
    assert len(rope_points(*ends, 1.0, np.array([0.0, 0.0, -1.0]))) == 2
