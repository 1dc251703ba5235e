"""Scenes from models: laws of their geometry."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import symbody as sb
from symbody.errors import ModelError
from symbody.formats.native import model_from_toml
from symbody.visual.scene import coordinate_courses, make_scene, scene_to_json
from symbody.visual.scene.scene import Scene, SceneBody, Solid

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = sorted([*EXAMPLES.glob("*/*.toml"), *EXAMPLES.glob("*/*.urdf")])
CORPUS = sorted((Path(__file__).parents[1] / "corpus").glob("*.toml"))

Floats = NDArray[np.float64]


def load(path: Path) -> sb.Model:
    return sb.load_urdf(path) if path.suffix == ".urdf" else sb.load_model(path)


def body(scene: Scene, name: str) -> SceneBody:
    return next(each for each in scene.bodies if each.name == name)


def solids(scene: Scene, name: str, kind: str, element: str | None = None) -> list[Solid]:
    return [
        solid
        for solid in body(scene, name).solids
        if solid.kind == kind and (element is None or solid.element == element)
    ]


def axes(solid: Solid) -> Floats:
    w, x, y, z = solid.quaternion
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())


def ends(solid: Solid) -> Floats:
    """The ends of the axis of a capsule or cylinder in its body's axes."""
    half = 0.5 * solid.size[1] * axes(solid)[:, 2]
    return np.array([solid.at - half, solid.at + half])


def numbers(scene: Scene) -> Floats:
    """All sizes and places of a scene in one list."""
    found: list[float] = [scene.size]
    for each in scene.bodies:
        for solid in each.solids:
            found += [*solid.at, *(() if solid.kind == "mesh" else solid.size)]
        for frame in each.frames:
            found += frame.at
    for connector in scene.connectors:
        found += [*connector.start.at, *connector.end.at, connector.radius, connector.length]
    for mesh in scene.meshes:
        found += mesh.vertices.ravel().tolist()
    return np.array(found)


def pendulum(L: str = "L") -> sb.Model:
    arm = sb.Body(
        "Arm",
        "m",
        (0, 0, "m*L**2/12"),
        frames={"pin": sb.Frame((f"-{L}/2", 0, 0)), "tip": sb.Frame((f"{L}/2", 0, 0))},
    )
    bob = sb.Body("Bob", "m", (0, 0, "m*L**2/12"), frames={"pin": sb.Frame((f"-{L}/2", 0, 0))})
    return sb.Model(
        "pendulum",
        [sb.Revolute("hinge", "ground", arm["pin"]), sb.Revolute("elbow", arm["tip"], bob["pin"])],
        gravity=(0, -9.81, 0), parameters={"m": 1, "L": 2},
    )  # fmt: skip


@pytest.mark.parametrize("path", [*FILES, *CORPUS], ids=lambda path: path.stem)
def test_every_model_makes_a_scene(path: Path) -> None:
    scene = make_scene(load(path))
    assert np.all(np.isfinite(numbers(scene))) and scene.size > 0
    assert math.isclose(float(np.linalg.norm(scene.up)), 1.0)
    assert scene.bodies[0].name == "ground" and len(scene.bodies) == len(load(path).bodies) + 1
    for each in scene.bodies:
        for solid in each.solids:
            assert math.isclose(float(np.linalg.norm(solid.quaternion)), 1.0)
            assert all(size > 0.0 for size in solid.size)
            assert solid.mesh is None or solid.mesh < len(scene.meshes)
    for mesh in scene.meshes:
        assert mesh.triangles.size == 0 or mesh.triangles.max() < len(mesh.vertices)
    text = json.dumps(scene_to_json(scene), allow_nan=False)
    assert len(text) < 2_000_000


def test_rods_end_on_their_frames() -> None:
    scene = make_scene(pendulum())
    (rod,) = solids(scene, "Arm", "capsule")
    assert np.allclose(sorted(ends(rod).tolist()), [[-1, 0, 0], [1, 0, 0]])
    for each in solids(make_scene(load(EXAMPLES / "slider_crank" / "slider_crank.toml")), "Rod", "capsule"):
        assert np.allclose(sorted(ends(each)[:, 0]), [-0.5, 0.5])


def test_a_body_with_joints_in_a_plane_is_a_plate() -> None:
    corners = {name: sb.Frame(at) for name, at in (("a", (1, 0, 0)), ("b", (0, 1, 0)), ("c", (-1, -1, 0)))}
    plate = sb.Body("Plate", 1, (1, 1, 1), frames=corners)
    legs = [sb.Body(f"Leg{k}", 1, (1, 1, 1)) for k in range(3)]
    joints = [
        sb.Spherical(f"s{k}", plate[name], leg) for k, (name, leg) in enumerate(zip("abc", legs, strict=True))
    ]
    scene = make_scene(sb.Model("m", [sb.Free("f", "ground", plate), *joints]))
    found = np.array([ends(rod) for rod in solids(scene, "Plate", "capsule")]).reshape(-1, 3)
    for frame in body(scene, "Plate").frames:
        if frame.name != "CoM":
            assert np.min(np.linalg.norm(found - frame.at, axis=1)) < 1e-12


@pytest.mark.parametrize("axis", ["x", "y", "z", (1, 2, -1)])
def test_hinges_lie_along_their_axis_on_both_bodies(axis: str | tuple[int, int, int]) -> None:
    turned = sb.Frame((0, 1, 0), rotate=[("x", 0.3), ("z", -1)])
    arm = sb.Body("Arm", 1, (1, 1, 1), frames={"pin": turned})
    scene = make_scene(
        sb.Model("m", [sb.Revolute("hinge", "ground.base", arm["pin"], axis=axis)], ground={"base": turned})
    )
    letter = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}.get(str(axis), axis)
    direction = np.array(letter, dtype=float) / np.linalg.norm(letter)
    frame = Rotation.from_euler("XZ", [0.3, -1]).as_matrix()
    for name in ("ground", "Arm"):
        (hinge,) = solids(scene, name, "cylinder", "hinge")
        assert np.allclose(np.cross(axes(hinge)[:, 2], frame @ direction), 0.0, atol=1e-12)
        assert np.allclose(hinge.at, (0, 1, 0))


def test_joints_are_drawn_by_their_law() -> None:
    bodies = [sb.Body("B", 1, (1, 1, 1))]

    def kinds(
        joint: sb.Revolute | sb.Gimbal | sb.Spherical | sb.Cylindrical | sb.Planar,
    ) -> list[tuple[str, str]]:
        scene = make_scene(sb.Model("m", [*bodies, joint]))
        return sorted(
            (each.name, solid.kind) for each in scene.bodies for solid in each.solids
            if solid.element == joint.name and solid.color != "#8d96a3"
        )  # fmt: skip

    assert kinds(sb.Gimbal("j", "ground", "B")) == kinds(sb.Spherical("j", "ground", "B"))
    assert kinds(sb.Revolute("j", "ground", "B")) == [("B", "cylinder"), ("ground", "cylinder")]
    assert kinds(sb.Cylindrical("j", "ground", "B")) == [("B", "cylinder"), ("ground", "cylinder")]
    assert kinds(sb.Prismatic("j", "ground", "B")) == [("B", "box"), ("ground", "box")]


def test_a_guide_covers_what_moves_on_it() -> None:
    model = sb.Model("m", [sb.Prismatic("j", "ground", sb.Body("B", 1), axis="x", coordinate="s")])
    (rail,) = solids(make_scene(model, motion={"s": [2.0, -1.0, 5.0]}), "ground", "box", "j")
    low, high = rail.at[0] - 0.5 * rail.size[2], rail.at[0] + 0.5 * rail.size[2]
    assert low < -1.0 and high > 5.0


@pytest.mark.parametrize("substitute", [False, True])
def test_a_guide_covers_coordinates_that_couplings_and_motions_give(substitute: bool) -> None:
    bodies = [sb.Body(name, 1) for name in "ABC"]
    slides = [
        sb.Prismatic("a", "ground", bodies[0], axis="x", coordinate="x"),
        sb.Prismatic("b", "ground", bodies[1], axis="y", coordinate="y"),
        sb.Prismatic("c", "ground", bodies[2], axis="z", coordinate="z", motion="3*sin(t)"),
    ]
    rope = sb.Constraint("rope", ["x + y - 1"])
    eqs = sb.form_equations(sb.Model("m", [*bodies, *slides, rope]), substitute=substitute)
    run = sb.simulate(eqs, 5.0, {"x": 0, "x_dot": 2})
    courses = coordinate_courses(run)
    assert np.allclose(courses["x"] + courses["y"], 1)
    scene = make_scene(eqs.model, motion=courses)
    for name, axis, reach in (("b", 1, -9.0), ("c", 2, -2.8)):
        (rail,) = solids(scene, "ground", "box", name)
        assert rail.at[axis] - 0.5 * rail.size[2] < reach


def test_lengths_scale_the_scene() -> None:
    small, large = make_scene(pendulum()), make_scene(pendulum(), {"L": 2000})
    assert np.allclose(numbers(large), 1000 * numbers(small))


def test_names_change_no_geometry() -> None:
    model = load(EXAMPLES / "slider_crank" / "slider_crank.toml")
    text = (EXAMPLES / "slider_crank" / "slider_crank.toml").read_text()
    for old, new in (("Crank", "Zed"), ("Rod", "Alpha"), ("Piston", "Mid"), ('name = "A"', 'name = "Q"')):
        text = text.replace(old, new)
    assert np.array_equal(numbers(make_scene(model_from_toml(text))), numbers(make_scene(model)))


def test_planar_mechanisms_are_seen_from_the_front() -> None:
    planar = {"slider_crank", "rr_robot", "projectile", "spring_mass_damper"}
    for path in FILES:
        if path.stem in planar:
            assert make_scene(load(path)).normal == (0.0, 0.0, 1.0), path
    for name in ("bicycle", "stewart_platform", "spinning_top", "spatial_four_bar"):
        assert make_scene(load(EXAMPLES / name / f"{name}.toml")).normal is None


def test_up_is_against_gravity() -> None:
    assert make_scene(pendulum()).up == (0.0, 1.0, 0.0)
    level = sb.Model("m", [sb.Revolute("j", "ground", sb.Body("B", 1, (1, 1, 1)))], gravity=(0, 0, -9.81))
    scene = make_scene(level)
    assert (
        scene.normal == (0.0, 0.0, 1.0) and scene.up == (0.0, 1.0, 0.0) and scene.gravity == (0.0, 0.0, -9.81)
    )


def test_parameters_without_value_are_noted() -> None:
    body = sb.Body("B", "m", (0, 0, "J"), frames={"pin": sb.Frame(("L", 0, 0))})
    model = sb.Model(
        "m", [sb.Revolute("j", "ground", body["pin"])], parameters={"m": None, "L": None, "J": "m*L"}
    )
    scene = make_scene(model)
    assert scene.notes == ("m, L have no value: the picture uses 1",)
    assert np.all(np.isfinite(numbers(scene)))


def test_values_of_no_parameter_are_refused() -> None:
    with pytest.raises(ModelError, match=r"the model has no parameter 'l'"):
        make_scene(pendulum(), {"l": 3})


def test_bodies_without_lengths_are_seen() -> None:
    scene = make_scene(sb.Model("m", [sb.Body("B", 1)], gravity=(0, 0, -1)))
    assert scene.size == 1.0 and body(scene, "B").solids


def test_a_uniform_solid_is_found_from_its_inertia() -> None:
    a, b, c, m = 0.3, 0.2, 0.6, 2.0
    moments = (m * (b * b + c * c) / 12, m * (a * a + c * c) / 12, m * (a * a + b * b) / 12)
    scene = make_scene(sb.Model("m", [sb.Body("B", m, moments)]))
    (box,) = solids(scene, "B", "box")
    assert np.allclose(box.size, (a, b, c))
    r, h = 0.2, 0.5
    across = m * (3 * r * r + h * h) / 12
    scene = make_scene(sb.Model("m", [sb.Body("B", m, (across, m * r * r / 2, across))]))
    tin = solids(scene, "B", "cylinder")[0]
    assert np.allclose(tin.size, (r, h)) and np.allclose(np.abs(axes(tin)[:, 2]), (0, 1, 0))


def test_shapes_of_users_take_the_place_of_the_usual_ones() -> None:
    shape = sb.Cylinder("L/10", "L", at=("L/2", 0, 0), rotate=[("y", "90 deg")], color="teal", opacity=0.5)
    arm = sb.Body("Arm", 1, (1, 1, 1), frames={"pin": sb.Frame((-1, 0, 0))}, shapes=[shape])
    model = sb.Model(
        "m", [sb.Revolute("j", "ground", arm["pin"])], parameters={"L": 2}, ground_shapes=[sb.Box((1, 2, 3))]
    )
    scene = make_scene(model, {"L": 4})
    (tube,) = [solid for solid in body(scene, "Arm").solids if solid.element == "Arm"]
    assert (tube.kind, tube.color, tube.opacity) == ("cylinder", "#008080", 0.5)
    assert np.allclose(tube.size, (0.4, 4)) and np.allclose(tube.at, (2, 0, 0))
    assert np.allclose(axes(tube)[:, 2], (1, 0, 0))
    assert solids(scene, "Arm", "cylinder", "j") and solids(scene, "ground", "box", "ground")


def test_springs_and_dampers_are_both_seen() -> None:
    arm = sb.Body("Arm", 1, (1, 1, 1), frames={"tip": sb.Frame((1, 0, 0))})
    spring = sb.SpringDamper(
        "strut", "ground.roof", arm["tip"], stiffness=1, damping=1, applied="F", free=0.7
    )
    model = sb.Model(
        "m", [sb.Revolute("j", "ground", arm), spring], inputs=["F"], ground={"roof": sb.Frame((1, 1, 0))}
    )
    scene = make_scene(model)
    assert [connector.kind for connector in scene.connectors] == ["spring", "damper", "actuator"]
    coil = scene.connectors[0]
    assert (coil.start.body, coil.end.body, coil.length) == (0, 1, 0.7) and coil.end.at == (1.0, 0.0, 0.0)
    assert coil.coils > 2 and coil.radius > scene.connectors[1].radius


def test_ropes_hang_and_rods_are_straight() -> None:
    ball = sb.Body("Ball", 1)
    for rope, kind in ((True, "rope"), (False, "line")):
        scene = make_scene(
            sb.Model("m", [ball, sb.Distance("d", "ground", "Ball", 1.5, rope=rope)], initial={"Ball_x": 1})
        )
        (connector,) = scene.connectors
        assert (connector.kind, connector.length) == (kind, 1.5)


def test_what_rolls_has_its_radius_and_a_floor() -> None:
    disc = sb.Body("Disc", 1, (1, 2, 1))
    model = sb.Model(
        "m", [disc, sb.Rolling("roll", "ground", "Disc", 0.4, axis="y")], initial={"Disc_z": 0.4}
    )
    scene = make_scene(model)
    (tyre,) = solids(scene, "Disc", "mesh", "roll")
    assert tyre.mesh is not None
    reach = np.linalg.norm(scene.meshes[tyre.mesh].vertices[:, :2], axis=1).max()
    assert math.isclose(reach, 0.4) and np.allclose(np.abs(axes(tyre)[:, 2]), (0, 1, 0))
    (floor,) = solids(scene, "ground", "box", "roll")
    assert floor.opacity < 1 and math.isclose(floor.at[2] + 0.5 * floor.size[2], 0.0, abs_tol=1e-12)


def test_a_floor_is_as_large_as_the_motion_and_drawn_once() -> None:
    model = load(EXAMPLES / "bicycle" / "bicycle.toml")
    scene = make_scene(model, motion={"x": np.linspace(0, 30, 9), "z": [0.3], "rear": np.zeros(9)})
    (floor,) = [solid for solid in body(scene, "ground").solids if solid.kind == "box"]
    assert floor.at[0] - 0.5 * floor.size[0] < -0.3 and floor.at[0] + 0.5 * floor.size[0] > 31


def test_wheels_with_shapes_of_users_have_no_others() -> None:
    disc = sb.Body("Disc", 1, (1, 2, 1), shapes=[sb.Sphere(0.4)])
    scene = make_scene(sb.Model("m", [disc, sb.Rolling("roll", "ground", "Disc", 0.4, axis="y")]))
    assert [solid.kind for solid in body(scene, "Disc").solids] == ["sphere"]
    assert [solid.kind for solid in body(scene, "ground").solids] == ["box"]


def test_numbers_beyond_any_picture_do_no_harm() -> None:
    far = sb.Body("B", "1e299", (0, 0, 1), frames={"pin": sb.Frame(("1e200", "1e-200", 0))})
    scene = make_scene(sb.Model("m", [sb.Revolute("j", "ground", far["pin"])]))
    assert np.all(np.isfinite(numbers(scene))) and scene.size == 1.0


@pytest.mark.parametrize("length", [1e-9, 1e9])
def test_mechanisms_of_any_size_look_alike(length: float) -> None:
    usual, other = make_scene(pendulum(), {"L": 1}), make_scene(pendulum(), {"L": length})
    assert np.allclose(numbers(other) / length, numbers(usual))


def test_points_of_a_surface_fulfil_its_equation() -> None:
    bead = sb.Body("Bead", 1)
    model = sb.Model(
        "m", [bead, sb.PointOnSurface("bowl", "ground", "Bead", "x**2 + y**2 + z**2 - R**2")],
        parameters={"R": 1}, initial={"Bead_x": 1},
    )  # fmt: skip
    scene = make_scene(model)
    (bowl,) = solids(scene, "ground", "mesh", "bowl")
    assert bowl.mesh is not None
    mesh = scene.meshes[bowl.mesh]
    assert np.allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=0.01)
    edges = np.sort(
        np.vstack([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]]), axis=1
    )
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert np.all(uses == 2)  # closed


@pytest.mark.parametrize("plane", ["x", "y", "z"])
@pytest.mark.parametrize("upwards", ["x", "y", "z"])
def test_a_planar_mechanism_is_seen_with_an_axis_to_the_right(plane: str, upwards: str) -> None:
    if plane == upwards:
        pytest.skip("gravity across the plane")
    gravity = tuple(-9.81 * (axis == upwards) for axis in "xyz")
    rod = sb.Body("Rod", 1, (0.1, 0.1, 0.1), frames={"end": sb.Frame(at=(0.5, 0.5, 0.5))})
    scene = make_scene(
        sb.Model("m", [rod, sb.Revolute("pin", "ground", "Rod.end", axis=plane)], gravity=gravity)
    )
    assert scene.normal is not None
    right = np.cross(scene.up, scene.normal)
    assert np.allclose(np.abs(right).max(), 1) and right.max() > 0.99
