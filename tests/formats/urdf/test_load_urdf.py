"""Models from small robots written by hand: joints, axes, angles, inertia, names, followers."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats import model_from_toml, model_from_urdf, model_to_toml
from symbody.model.numbers import formula_value
from tests.formats.urdf.robots import arm, joint, link, robot
from tests.oracles.comparison import Floats, computed

TEXT = 1e-15  # of numbers that are rounded when they are written as decimals


def numbers(formulas: tuple[object, ...]) -> list[float]:
    return [float(formula_value(formula)) for formula in formulas]  # type: ignore[arg-type]


def turned(axis: str, angle: float) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    rows = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}  # fmt: skip
    return np.array(rows[axis])


def tensor(body: sb.Body) -> Floats:
    xx, yy, zz = numbers(body.inertia)
    xy, xz, yz = numbers(body.products)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize(
    ("kind", "coordinates", "inputs"),
    [
        ("revolute", ("q",), ("tau_q",)),
        ("continuous", ("q",), ("tau_q",)),
        ("prismatic", ("q",), ("tau_q",)),
        ("planar", ("q_1", "q_2", "q_3"), ("tau_q_1", "tau_q_2", "tau_q_3")),
        ("floating", ("q_x", "q_y", "q_z", "q_qw", "q_qx", "q_qy", "q_qz"), ()),
        ("fixed", (), ()),
    ],
)
def test_every_type_of_joint(kind: str, coordinates: tuple[str, ...], inputs: tuple[str, ...]) -> None:
    model = model_from_urdf(arm(kind))
    assert model.coordinates == coordinates and model.inputs == inputs
    assert [float(formula_value(x)) for x in model.gravity] == [0, 0, -9.81]  # type: ignore[arg-type]


def test_floating_base_has_the_names_of_the_contract() -> None:
    model = model_from_urdf(arm("revolute"), floating_base=True)
    eqs = sb.form_equations(model_from_urdf(robot(link("A")), floating_base=True))
    assert model.coordinates == (*(f"base_{k}" for k in ("x", "y", "z", "qw", "qx", "qy", "qz")), "q")
    assert eqs.speed_names == tuple(f"base_{k}" for k in ("vx", "vy", "vz", "wx", "wy", "wz"))


def test_a_thrown_link_turns_and_falls() -> None:
    # m (v' + w x v) = m g in base axes, at the origin of the link, which is not the centre of mass: at rest
    # and level the whole falls with g.
    q = {"base_x": 0, "base_y": 0, "base_z": 0, "base_qw": 1, "base_qx": 0, "base_qy": 0, "base_qz": 0}
    u = {f"base_{k}": 0.0 for k in ("vx", "vy", "vz", "wx", "wy", "wz")}
    found, _ = computed(model_from_urdf(robot(link("A")), floating_base=True), {**q, **u}, "udot")
    assert np.abs(found["udot"] - [0, 0, -9.81, 0, 0, 0]).max() < 1e-13


def test_a_pendulum_with_axis_of_any_length() -> None:
    # theta'' (I + m l^2) = - m g l sin(theta) - d theta' + tau, with I about the axis (1, 1, 0)/sqrt 2:
    # (ixx + iyy)/2 + ixy. A negative angle about it lifts the link like a positive one.
    model = model_from_urdf(arm("revolute", '<axis xyz="2 2 0"/>', '<dynamics damping="0.5"/>'))
    found, _ = computed(model, {"q": 0.4, "q_dot": 0.3, "tau_q": 0.2}, "udot")
    expected = (0.2 - 0.5 * 0.3 - 2 * 9.81 * 0.25 * math.sin(0.4)) / ((0.3 + 0.4) / 2 + 0.01 + 2 * 0.25**2)
    assert found["udot"][0] == pytest.approx(expected, rel=1e-13)
    assert any("normalized" in note for note in model.notes)


def test_rpy_turns_about_fixed_axes() -> None:
    origin = '<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/>'
    model = model_from_urdf(arm("revolute", origin, '<axis xyz="0 0 1"/>'))
    frame = model.ground["q"]
    R = np.eye(3)
    for axis, angle in frame.rotate:
        assert isinstance(axis, str)
        R = R @ turned(axis, float(formula_value(angle)))  # type: ignore[arg-type]
    assert np.abs(R - turned("z", 0.3) @ turned("y", 0.2) @ turned("x", 0.1)).max() < 4e-16
    assert numbers(frame.at) == [0.1, 0.2, 0.3]


@pytest.mark.parametrize("k", range(-12, 13))
def test_angles_near_twelfths_of_pi_are_exact(k: int) -> None:
    angle = k * math.pi / 12 + (1e-11 if k % 2 else -1e-11)
    model = model_from_urdf(arm("revolute", f'<origin rpy="0 0 {angle!r}"/>'))
    turns = model.ground["q"].rotate
    texts = [formula.text for _, formula in turns]
    assert texts == ([] if k == 0 else [texts[0]]) and all("pi" in text for text in texts)
    if k:
        assert float(formula_value(turns[0][1])) == pytest.approx(k * math.pi / 12, rel=1e-15)  # type: ignore[arg-type]


def test_snapping_further_is_asked_for_and_told() -> None:
    text = arm("revolute", '<origin rpy="1.5708 0 0"/>')
    plain, snapped = model_from_urdf(text), model_from_urdf(text, snap_angles=1e-5)
    assert plain.ground["q"].rotate[0][1].text == "1.5708"
    assert snapped.ground["q"].rotate[0][1].text == "pi/2"
    assert any("snap_angles" in note for note in plain.notes)
    assert any("rounded to the nearest multiple of pi/12" in note for note in snapped.notes)


def test_inertia_given_in_turned_axes() -> None:
    inertial = ('<inertial><origin xyz="1 0 0" rpy="0.3 -0.5 0.7"/><mass value="2"/>'
                '<inertia ixx="0.3" iyy="0.4" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial>')  # fmt: skip
    model = model_from_urdf(robot(f'<link name="A">{inertial}</link>'), floating_base=True)
    R = turned("z", 0.7) @ turned("y", -0.5) @ turned("x", 0.3)
    assert np.abs(tensor(model.bodies[0]) - R @ np.diag([0.3, 0.4, 0.2]) @ R.T).max() < TEXT
    assert numbers(model.bodies[0].frames["A"].at) == [-1, 0, 0]


def test_fixed_chains_are_one_body_by_the_parallel_axis_theorem() -> None:
    text = robot(
        link("A"), link("B"), link("C"), '<link name="tip"/>',
        joint("f", "fixed", "A", "B", '<origin xyz="1 2 3" rpy="0.3 0.2 0.1"/>'),
        joint("g", "fixed", "B", "C", '<origin xyz="-1 0 1" rpy="0 0.4 0"/>'),
        joint("h", "fixed", "C", "tip", '<origin xyz="0 0 1"/>'),
    )  # fmt: skip
    model = model_from_urdf(text, floating_base=True)
    (body,) = model.bodies
    own = np.array([[0.3, 0.01, -0.02], [0.01, 0.4, 0.03], [-0.02, 0.03, 0.2]])
    R1 = turned("z", 0.1) @ turned("y", 0.2) @ turned("x", 0.3)
    R2 = R1 @ turned("y", 0.4)
    places = {"A": (np.eye(3), np.zeros(3)), "B": (R1, np.array([1.0, 2, 3]))}
    places["C"] = (R2, places["B"][1] + R1 @ [-1, 0, 1])
    centres = [r + R @ [0, 0, -0.25] for R, r in places.values()]
    centre = sum(centres) / 3
    total = np.zeros((3, 3))
    for (R, _), c in zip(places.values(), centres, strict=True):
        d = c - centre
        total += R @ own @ R.T + 2 * (d @ d * np.eye(3) - np.outer(d, d))
    assert float(formula_value(body.mass)) == 6  # type: ignore[arg-type]
    assert np.abs(tensor(body) - total).max() < 1e-14 * np.abs(total).max()
    tip = places["C"][1] + R2 @ [0, 0, 1] - centre
    assert np.abs(np.array(numbers(body.frames["tip"].at)) - tip).max() < 1e-14
    assert set(body.frames) == {"A", "B", "C", "tip"}


def test_right_angles_leave_lumps_exact() -> None:
    half = repr(math.pi / 2)
    text = robot(
        link("A"), link("B"), joint("f", "fixed", "A", "B", f'<origin xyz="0.5 0 0" rpy="{half} 0 {half}"/>')
    )
    (body,) = model_from_urdf(text, floating_base=True).bodies
    # B's z axis is A's x axis, its x axis A's y axis: the centres are at (0, 0, -1/4) and (1/4, 0, 0).
    assert [formula_value(x) for x in body.frames["A"].at] == [Fraction(-1, 8), 0, Fraction(1, 8)]


def test_symbolic_links_keep_their_parameters() -> None:
    text = robot(
        '<link name="base"/>', link("A"), link("tool"), joint("q", "revolute", "base", "A", '<axis xyz="0 1 0"/>'),
        joint("f", "fixed", "A", "tool", '<origin xyz="0 0 -0.5"/>'),
    )  # fmt: skip
    model = model_from_urdf(text, symbolic=["tool"])
    parts = ("m", "cx", "cy", "cz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
    assert tuple(model.parameters) == tuple(f"tool_{part}" for part in parts)
    state = {"q": 0.7, "q_dot": -0.4, "tau_q": 0.3}
    numeric, symbolic = (computed(m, state, "udot")[0]["udot"][0] for m in (model_from_urdf(text), model))
    assert symbolic == pytest.approx(numeric, rel=1e-13)


@pytest.mark.parametrize(
    ("kinds", "law"),
    [(("revolute", "revolute"), sb.Gear), (("revolute", "prismatic"), sb.RackPinion),
     (("prismatic", "prismatic"), sb.Constraint), (("prismatic", "revolute"), sb.Constraint)],
)  # fmt: skip
def test_followers_follow(kinds: tuple[str, str], law: type) -> None:
    # Two links side by side: (M11 + k^2 M22) p'' = tau + k 0 with p the leader, in a world without gravity.
    text = robot(
        '<link name="base"/>', link("A"), link("B"), link("C"),
        joint("p", kinds[0], "base", "A", '<axis xyz="0 0 1"/>'),
        joint("f", kinds[1], "base", "B", '<axis xyz="0 0 1"/>', '<mimic joint="p" multiplier="-2" offset="0.1"/>'),
        joint("c", kinds[1], "base", "C", '<axis xyz="0 0 1"/>', '<mimic joint="f" multiplier="0.5"/>'),
    )  # fmt: skip
    model = model_from_urdf(text, gravity=(0, 0, 0))
    assert model.inputs == ("tau_p",) and [type(c) for c in model.constraints] == [law, law]
    state = {"p": 0.3, "p_dot": 0.0, "f": -0.5, "f_dot": 0.0, "c": -0.25, "c_dot": 0.0, "tau_p": 1.5}
    found, names = computed(model, state, "udot", "constraints")
    inertia = {"revolute": 0.2, "prismatic": 2.0}
    p = 1.5 / (inertia[kinds[0]] + 5 * inertia[kinds[1]])
    expected = {"p_dot": p, "f_dot": -2 * p, "c_dot": -p}
    assert found["udot"] == pytest.approx([expected[name] for name in names], rel=1e-12)
    assert np.abs(found["constraints"]).max() < 1e-15


def test_a_follower_that_never_moves() -> None:
    text = robot('<link name="base"/>', link("A"), link("B"), joint("p", "revolute", "base", "A"),
                 joint("f", "revolute", "A", "B", '<mimic joint="p" multiplier="0" offset="0.4"/>'))  # fmt: skip
    model = model_from_urdf(text)
    assert sb.form_equations(model).coordinate_names == ("p",) and not model.constraints


@pytest.mark.parametrize("axis", ["1 0 0", "0 -1 0", "0 0 -1", "-1 0 0", "1 2 -3"])
def test_planar_joints_about_any_normal(axis: str) -> None:
    model = model_from_urdf(arm("planar", f'<axis xyz="{axis}"/>'))
    eqs = sb.form_equations(model)
    f = sb.compile(eqs, ["frame w A ground ground", "frame v A.A ground ground"])
    w, v = f(0.0, np.array([0.1, 0.2, 0.5]), np.array([0.3, -0.4, 2.0]), np.zeros(3))
    n = np.array(axis.split(), float) / np.linalg.norm(np.array(axis.split(), float))
    assert np.abs(w - 2.0 * n).max() < 1e-14
    assert abs(v @ n) < 1e-15 and np.linalg.norm(v) == pytest.approx(0.5, rel=1e-14)


def test_names_of_any_alphabet_and_shared_names() -> None:
    text = robot('<link name="пол"/>', link("рука.1"), link("12"), link("q"), joint("q", "revolute", "пол", "рука.1"),
                 joint("t", "revolute", "рука.1", "12"), joint("t_dot", "prismatic", "12", "q"))  # fmt: skip
    model = model_from_urdf(text)
    assert [body.name for body in model.bodies] == ["рука_1", "_12", "q"]
    assert [j.name for j in model.joints] == ["q_joint", "t", "t_dot"]
    assert model.coordinates == ("q", "_t", "t_dot")
    assert sum("is called" in note or "has the symbol" in note for note in model.notes) == 4


def test_what_was_assumed_or_ignored_is_told() -> None:
    text = robot('<link name="base"/>', link("A"), joint("q", "revolute", "base", "A"), "<transmission/>", "<gazebo/>",
                 '<link name="B"/>', joint("p", "revolute", "A", "B"))  # fmt: skip
    notes = " | ".join(model_from_urdf(text).notes)
    for words in ("without <axis> has 1 0 0 (2 times)", "<transmission> has no effect", "<gazebo>", "no <limit>",
                  "body B is massless", "the joints p move no mass"):  # fmt: skip
        assert words in notes


def test_an_impossible_inertia_is_taken_with_a_warning(tmp_path: Path) -> None:
    text = arm("revolute").replace('izz="0.2"', 'izz="2"')
    model = model_from_urdf(text)
    assert any("link A: no body can have this inertia" in note for note in model.notes)
    again = model_from_toml(model_to_toml(model))
    assert again == model and again.bodies[0].unphysical


@pytest.mark.parametrize("friction", ["0.3"])
def test_friction_is_a_strength(friction: str) -> None:
    found = model_from_urdf(arm("revolute", f'<dynamics friction="{friction}"/>')).joints[0].friction
    assert found is not None and found.force is not None and found.force.text == friction
