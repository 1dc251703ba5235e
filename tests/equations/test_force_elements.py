"""Force elements: torsion springs, bushings, laws and curves, against drives, momentum and energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import symbody as sb

EPS = float(np.finfo(float).eps)
FRAMES = {"a": sb.Frame(at=(-0.5, 0.1, 0)), "b": sb.Frame(at=(0.5, 0, 0.2), rotate=[("z", 0.3), ("x", 0.2)])}
COORDINATES = ["x", "y", "z", "a", "b", "c"]


def body(name: str) -> sb.Body:
    return sb.Body(name, mass=1.5, inertia=(0.1, 0.2, 0.25), frames=FRAMES)


def udot(elements: Sequence[object], state: np.ndarray, tree: str | None = None) -> np.ndarray:
    eqs = sb.form_equations(sb.Model("m", elements, gravity=(0, 0, -9.81)), tree=tree)
    q, u = state
    return np.array(sb.compile(eqs, "udot")(0.3, q, u))


def carried(*extra: object, **drives: object) -> list[object]:
    """A free body on a turning one: joint `J` measures what a bushing between its frames does."""
    free = sb.Free("J", "A.b", "B.a", angles="xyz", coordinates=COORDINATES, speeds="rates", **drives)
    return [body("A"), body("B"), sb.Revolute("R", "ground", "A.a", axis="y", coordinate="r"), free, *extra]


def states(count: int = 3) -> list[np.ndarray]:
    return [np.random.default_rng(k).uniform(-0.8, 0.8, (2, 7)) for k in range(count)]


def test_a_bushing_is_six_drives_of_a_free_joint() -> None:
    k, d, free = [3, 4, 5, 0.6, 0.7, 0.8], [0.3, 0.2, 0.1, 0.05, 0.06, 0.07], [0.1, 0, 0.2, 0, 0.3, 0]
    drives = {
        name: sb.Drive(stiffness=k[i], damping=d[i], free=free[i]) for i, name in enumerate(COORDINATES)
    }
    forces, torques = ({name: drives[name] for name in part} for part in (COORDINATES[:3], COORDINATES[3:]))
    bushing = sb.Bushing("S", "A.b", "B.a", stiffness=k, damping=d, free=free)
    for state in states():
        expected = udot(carried(force=forces, torque=torques), state)
        # 7 equations, condition below 1e3, angles from about 20 operations on a rotation matrix.
        assert udot(carried(bushing), state) == pytest.approx(expected, abs=1e5 * EPS)


def test_a_bushing_with_a_matrix_couples_its_directions() -> None:
    half = np.random.default_rng(7).uniform(-1, 1, (6, 6)).round(3)
    matrices = [half @ half.T + 3 * np.eye(6), half]  # the second has no potential
    for K in matrices:
        rows = [" + ".join(f"({K[i, j]!r})*{name}" for j, name in enumerate(COORDINATES)) for i in range(6)]
        rows = [row.replace("np.float64", "") for row in rows]
        drives = {name: sb.Drive(applied=f"-({row})") for name, row in zip(COORDINATES, rows, strict=True)}
        parts = ({name: drives[name] for name in part} for part in (COORDINATES[:3], COORDINATES[3:]))
        force, torque = parts
        bushing = sb.Bushing("S", "A.b", "B.a", stiffness=K.tolist())
        for state in states(2):
            expected = udot(carried(force=force, torque=torque), state)
            assert udot(carried(bushing), state) == pytest.approx(expected, abs=1e6 * EPS)


def test_outputs_of_a_bushing() -> None:
    k = [3, 4, 5, 0.6, 0.7, 0.8]
    eqs = sb.form_equations(sb.Model("m", carried(sb.Bushing("S", "A.b", "B.a", stiffness=k))))
    q, u = states()[0]
    words = ["x", "y", "z", "rx", "ry", "rz"]
    names = [f"{'length' if i < 3 else 'angle'} S {word}" for i, word in enumerate(words)]
    found = np.array(sb.compile(eqs, [*names, *(f"effort S {word}" for word in words)])(0.0, q, u))
    assert found[:6] == pytest.approx(q[1:], abs=100 * EPS)
    assert found[6:] == pytest.approx(-np.array(k) * q[1:], abs=1000 * EPS)
    assert [eqs.units[name] for name in (*names[2:4], "effort S z", "effort S rx")] == [
        "m",
        "rad",
        "N",
        "N m",
    ]


LOOSE = [
    sb.TorsionSpring("S", "A.b", "B.a", axis=(1, 2, 2), stiffness=2, damping=0.3, free="20 deg", applied=0.2),
    sb.Bushing("S", "A.b", "B.a", [3, 4, 5, 0.6, 0.7, 0.8], [0.3, 0.2, 0.1, 0.05, 0.06, 0.07]),
    sb.SpringDamper("S", "A.b", "B.a", free=0.4, law="-2*(length - 0.5)^3 - length_rate*abs(length_rate)"),
]


@pytest.mark.parametrize("element", LOOSE, ids=lambda element: type(element).__name__)
def test_two_loose_bodies_keep_their_momentum(element: object) -> None:
    """The wrenches are opposite: linear and angular momentum of both bodies together do not change."""
    eqs = sb.form_equations(sb.Model("loose", [body("A"), body("B"), element]))
    run = sb.simulate(
        eqs, 1.5, initial=dict(A_x=-1.0, A_vy=0.3, A_wz=0.4, B_x=0.4, B_y=0.7, B_wy=0.5, B_wx=-0.2)
    )
    inertia = np.diag([0.1, 0.2, 0.25])
    linear, angular = np.zeros((3, run.t.size)), np.zeros((3, run.t.size))
    for name in "AB":
        r, v, w = (run[f"frame {kind} {name} ground ground"] for kind in "rvw")
        R = run[f"frame R {name} ground"]
        linear += 1.5 * v
        spin = np.einsum("ijn,jk,lkn,ln->in", R, inertia, R, w)
        angular += spin + 1.5 * np.cross(r.T, v.T).T
    for momentum in (linear, angular):
        # Errors of integration at rtol 1e-8 over some hundred steps.
        assert np.ptp(momentum, axis=1) == pytest.approx(0, abs=1e-6)
    assert np.ptp(run.energy - run.work) < 1e-6
    assert np.ptp(run["effort S"] if not isinstance(element, sb.Bushing) else run["effort S rz"]) > 1e-2


def hinge(*extra: object) -> sb.Model:
    joints = [
        sb.Revolute("R", "ground", "A.a", axis="y", coordinate="r"),
        sb.Revolute("Q", "A.b", "B.a", axis=(1, 2, 2), coordinate="q"),
    ]
    return sb.Model("hinge", [body("A"), body("B"), *joints, *extra], gravity=(0, 0, -9.81))


@pytest.mark.parametrize("reverse", [False, True])
def test_a_torsion_spring_at_a_hinge_is_its_drive_and_counts_its_turns(reverse: bool) -> None:
    sign = -1 if reverse else 1
    ends = ("B.a", "A.b") if reverse else ("A.b", "B.a")
    spring = sb.TorsionSpring(
        "S", *ends, axis=(1, 2, 2), stiffness=2, damping=0.3, free=0.4 * sign, law="-0.1*angle^3"
    )
    drive = sb.Drive(stiffness=2, damping=0.3, free=0.4, applied="-0.1*q^3")
    driven = sb.Model(
        "hinge",
        [body("A"), body("B"), sb.Revolute("R", "ground", "A.a", axis="y", coordinate="r"),
         sb.Revolute("Q", "A.b", "B.a", axis=(1, 2, 2), coordinate="q", torque=drive)],
        gravity=(0, 0, -9.81),
    )  # fmt: skip
    q, u = [0.3, 7.5], [0.2, -0.4]  # more than a turn
    expected = sb.compile(sb.form_equations(driven), ["udot", "potential_energy", "power", "effort Q"])(
        0, q, u
    )
    names = ["udot", "potential_energy", "power", "effort S", "angle S"]
    found = sb.compile(sb.form_equations(hinge(spring)), names)(0, q, u)
    assert found[0] == pytest.approx(expected[0], rel=1e4 * EPS)
    assert list(map(float, found[1:3])) == pytest.approx(list(map(float, expected[1:3])), rel=100 * EPS)
    assert found[3] == pytest.approx(sign * expected[3], rel=100 * EPS)
    assert found[4] == pytest.approx(sign * 7.5, rel=10 * EPS)


def test_a_torsion_spring_does_not_depend_on_the_trees() -> None:
    """The angle of a cut hinge is a variable: 4 rad and half a turn less are not the same."""
    spring = sb.TorsionSpring("S", "A.b", "B.a", axis=(1, 2, 2), stiffness=2, damping=0.3, free=0.4)
    ends = []
    for tree in (None, "absolute"):
        eqs = sb.form_equations(hinge(spring), tree=tree)
        assert not any("is measured within" in note for note in eqs.notes)
        ends.append(sb.simulate(eqs, 1.0, initial={"r": 0.2, "q": 4.0})["angle S"][-1])
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


def test_a_measured_angle_lies_within_half_a_turn_of_the_relaxed_one() -> None:
    spring = sb.TorsionSpring("S", "ground", "A", axis="z", stiffness=2, free=3)
    eqs = sb.form_equations(sb.Model("ball", [body("A"), spring]))
    assert any("torsion_spring S" in note and "within half a turn of 3" in note for note in eqs.notes)
    f = sb.compile(eqs, ["angle S", "effort S"])
    for angle in (-0.1, 0.1, 3.0, 6.0, 3 + np.pi - 1e-6):
        q = [0, 0, 0, np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
        expected = angle if angle > 3 - np.pi else angle + 2 * np.pi
        assert np.array(f(0, q, np.zeros(6))) == pytest.approx([expected, -2 * (expected - 3)], abs=100 * EPS)


@pytest.mark.parametrize("tree", [None, "absolute"])
def test_a_nonlinear_drive_in_the_tree_and_cut(tree: str | None) -> None:
    law = "-3*s^3 - 0.2*s_dot*abs(s_dot)"
    drive = sb.Drive(applied=law)
    block = sb.Prismatic("P", "ground", body("A"), axis="x", coordinate="s", force=drive)
    eqs = sb.form_equations(sb.Model("block", [block]), tree=tree)
    run = sb.simulate(eqs, 3.0, initial={"s": 0.8, "s_dot": 0.5})
    s, rate = run["s"], run["s_dot"]
    assert run["effort P"] == pytest.approx(-3 * s**3 - 0.2 * rate * abs(rate), abs=1e-9)
    assert np.ptp(run.energy - run.work) < 1e-7
    plain = sb.simulate(sb.form_equations(sb.Model("block", [block])), 3.0, initial={"s": 0.8, "s_dot": 0.5})
    assert s[-1] == pytest.approx(plain["s"][-1], abs=1e-7)


def test_the_length_of_a_spring_and_its_effort() -> None:
    block = sb.Prismatic("P", "ground", body("A"), axis="x", coordinate="s")
    ground = {"post": sb.Frame(at=(0, 2, 0))}
    spring = sb.SpringDamper(
        "post spring", "ground.post", "A", stiffness=3, damping=0.5, free=1.5, applied=0.1,
        law={"x": [1, 2, 3], "y": [0.2, 0.1, -0.4]},
    )  # fmt: skip
    f = sb.compile(
        sb.form_equations(sb.Model("m", [block, spring], ground=ground)),
        ["length post spring", 'effort "post spring"', "udot"],
    )
    s, v = 1.2, 0.7
    length = np.hypot(s, 2)
    effort = 0.1 + np.interp(length, [1, 2, 3], [0.2, 0.1, -0.4]) - 3 * (length - 1.5) - 0.5 * v * s / length
    found = f(0, [s], [v])
    assert list(map(float, found[:2])) == pytest.approx([length, effort], rel=10 * EPS)
    assert found[2] == pytest.approx([effort * s / length / 1.5], rel=10 * EPS)


@pytest.mark.parametrize("kind", ["linear", "pchip"])
@pytest.mark.parametrize("outside", ["hold", "slope"])
def test_a_curve_is_what_its_points_say(kind: str, outside: str) -> None:
    rng = np.random.default_rng(3)
    x, y = np.cumsum(rng.uniform(0.1, 1, 12)).round(3), rng.uniform(-2, 2, 12).round(3)
    y[5] = y[4]
    drive = sb.Drive(law=sb.Curve(x.tolist(), y.tolist(), kind=kind, outside=outside))
    block = sb.Prismatic("P", "ground", sb.Body("A", mass=1), axis="x", coordinate="s", force=drive)
    f = sb.compile(sb.form_equations(sb.Model("m", [block])), "udot")
    places = np.concatenate([np.linspace(x[0], x[-1], 501), x])
    found = f(0.0, places[:, None], np.zeros((places.size, 1)))[:, 0]
    inside = np.interp(places, x, y) if kind == "linear" else PchipInterpolator(x, y)(places)
    assert found == pytest.approx(inside, abs=100 * EPS)
    beyond = np.array([x[0] - 2, x[-1] + 2])
    slopes = (
        np.diff(y)[[0, -1]] / np.diff(x)[[0, -1]]
        if kind == "linear"
        else PchipInterpolator(x, y).derivative()(x[[0, -1]])
    )
    expected = y[[0, -1]] + (np.array([-2, 2]) * slopes if outside == "slope" else 0)
    assert f(0.0, beyond[:, None], np.zeros((2, 1)))[:, 0] == pytest.approx(expected, abs=1000 * EPS)
    assert np.isnan(f(0.0, [np.nan], [0.0])[0])


def test_a_curve_over_an_angle_counts_turns_in_every_tree() -> None:
    curve = sb.Curve([0, 4, 8], [1, -1, 5])
    pin = sb.Revolute("R", "ground", "A.a", axis="y", coordinate="r", torque=sb.Drive(law=curve))
    found = []
    for tree in (None, "absolute"):
        eqs = sb.form_equations(sb.Model("m", [body("A"), pin]), tree=tree)
        found.append(sb.simulate(eqs, 0.5, initial={"r": 6.0})["effort R"][[0, -1]])
    assert found[0][0] == pytest.approx(2.0) and found[0] == pytest.approx(found[1], abs=1e-6)
