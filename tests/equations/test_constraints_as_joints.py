"""Constraints that together make a joint: the same accelerations and the same wrench."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.model.constraint import ConstraintElement
from symbody.model.joint import Joint

EPS = float(np.finfo(float).eps)
A = sb.Body("A", mass=2, inertia=(1, 2, 2.5), frames={"P": sb.Frame(at=(0.4, 0, 0.3), rotate=[("x", "0.4")])})
B = sb.Body(
    "B", mass=1, inertia=(1, 1.5, 2), frames={"Q": sb.Frame(at=(0, -0.3, 0.7), rotate=[("y", "0.3")])}
)
ENDS = ("A.P", "B.Q")
PAIRS: list[tuple[Joint, list[ConstraintElement]]] = [
    (sb.Planar("j", *ENDS), [sb.PointOnPlane("c", *ENDS), sb.Parallel("d", *ENDS)]),
    (
        sb.Spherical("j", *ENDS),
        [sb.PointOnLine("c", *ENDS, axis=(1, 2, -1)), sb.PointOnPlane("d", *ENDS, axis=(1, 2, -1))],
    ),
    (
        sb.Prismatic("j", *ENDS, axis="x"),
        [sb.PointOnLine("c", *ENDS), sb.Parallel("d", *ENDS, axes=["x", "x"]),
         sb.Perpendicular("e", *ENDS, axes=["y", "z"])],
    ),
    (
        sb.Revolute("j", *ENDS),
        [sb.PointOnSurface("c", *ENDS, ["x", "y + z^3", "2*z"]), sb.Angle("d", *ENDS, ["y", "z"], "pi/2"),
         sb.Perpendicular("e", *ENDS, axes=["x", "z"])],
    ),
]  # fmt: skip


@pytest.mark.parametrize(("joint", "conditions"), PAIRS, ids=lambda x: type(x).__name__)
def test_conditions_make_a_joint(joint: Joint, conditions: list[ConstraintElement]) -> None:
    forces = [sb.Force("push", "B.Q", vector=(3, -2, 1)), sb.Torque("twist", "A", vector=(1, 2, -1))]
    gravity, float_ = (0.3, -9, 1), sb.Free("float", "ground", "A")
    one = sb.form_equations(sb.Model("one", [A, B, float_, joint, *forces], gravity=gravity), tree="absolute")
    two = sb.form_equations(
        sb.Model("two", [A, B, float_, *conditions, *forces], gravity=gravity), tree="absolute"
    )
    assert one.coordinate_names == two.coordinate_names
    assert len(two.multiplier_names) == len(one.multiplier_names)
    random = np.random.default_rng(3)
    guess = dict(zip(one.coordinate_names, random.normal(size=14), strict=True))
    guess |= dict(zip(one.speed_names, random.normal(size=12), strict=True))
    state = sb.assemble(one, {}, guess)
    q, u = np.array(list(state.q.values())), np.array(list(state.u.values()))
    found = []
    for eqs, names in ((one, ["j"]), (two, [condition.name for condition in conditions])):
        f = sb.compile(eqs, ["udot", *(f"reaction {name}" for name in names)])
        udot, *wrenches = f(0.0, q, u)
        found.append((udot, sum(wrenches)))
    # Positions hold to 1e-9, and rows of different forms part by as much; the conditions are of order 1e2.
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-6)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-6)
    assert EPS < np.abs(found[0][1]).max()


def test_gears_move_as_one_inertia() -> None:
    wheels = [sb.Body(f"W{k}", inertia=(0, 0, f"I{k}"), mass=1) for k in (1, 2, 3)]
    joints = [
        sb.Revolute(f"r{k}", "ground", wheel, coordinate=f"a{k}", torque=sb.Drive(applied=f"T{k}"))
        for k, wheel in enumerate(wheels, 1)
    ]
    parameters = {"I1": 1.0, "I2": 2.0, "I3": 3.0, "T1": 5.0, "T2": 1.0, "T3": -2.0}

    def accelerations(*conditions: ConstraintElement) -> np.ndarray:
        model = sb.Model("gears", [*wheels, *joints, *conditions], parameters=parameters)
        eqs = sb.form_equations(model)
        assert eqs.degrees_of_freedom == 3 - len(eqs.multiplier_names)
        return np.asarray(sb.compile(eqs, "udot")(0.0, np.zeros(3), np.zeros(3)))

    # first = -2 second: (I1 + I2/4) a1'' = T1 - T2/2
    gear = accelerations(sb.Gear("g", ["a1", "a2"], ratio=-2))
    np.testing.assert_allclose(gear, [4.5 / 1.5, -2.25 / 1.5, -2 / 3], rtol=1e-14)
    # a1 R1 = a2 R2 with R1 = 3 R2: a2 = 3 a1
    belt = accelerations(sb.Belt("b", ["a1", "a2"], radii=[3, 1]))
    np.testing.assert_allclose(belt[:2], np.array([1, 3]) * 8 / 19, rtol=1e-14)
    # 2 a1 = a2 + a3: M a = T + lambda (2, -1, -1)
    mass, row = np.diag([1.0, 2, 3, 0]), np.array([2.0, -1, -1])
    mass[:3, 3], mass[3, :3] = -row, row
    expected = np.linalg.solve(mass, [5, 1, -2, 0])[:3]
    np.testing.assert_allclose(accelerations(sb.Differential("d", ["a1", "a2", "a3"])), expected, rtol=1e-13)


def test_a_rack_outside_the_tree_feels_its_pinion() -> None:
    """The rack's joint is cut, so its displacement is measured; its wrench holds the share of the pinion."""
    rack, wheel = sb.Body("Rack", mass=2), sb.Body("Wheel", mass=1, inertia=(0, 0, 0.5))
    parts = [
        rack,
        wheel,
        sb.Revolute("axle", "ground", "Wheel", coordinate="a", torque=sb.Drive(applied=3)),
        sb.Prismatic("slide", "ground", "Rack", coordinate="s", axis="x"),
        sb.RackPinion("mesh", ["s", "a"], radius=0.25),
    ]
    model = sb.Model("rack", parts)
    for tree in (None, "absolute"):
        eqs = sb.form_equations(model, tree=tree)
        state = sb.assemble(eqs, {"a": 0.5})
        f = sb.compile(eqs, ["s_ddot", "a_ddot", "lambda", "reaction slide"])
        s, a, multipliers, wrench = f(0.0, np.array(list(state.q.values())), np.array(list(state.u.values())))
        # (I + m r^2) a'' = T
        np.testing.assert_allclose([s, a], [0.25 * 3 / 0.625, 3 / 0.625], rtol=1e-12)
        mesh = multipliers[eqs.multiplier_names.index("lambda_mesh_1")]
        np.testing.assert_allclose(mesh, 2 * 0.25 * 3 / 0.625, rtol=1e-12)
        np.testing.assert_allclose(wrench, 0.0, atol=1e-12)


def test_a_bead_on_a_parabola() -> None:
    """``(1 + 4 x^2) x'' + 4 x x'^2 + 2 g x = 0`` on y = x^2, by parameter, by equation, and as a surface."""
    bead = sb.Body("Bead", mass=0.7)
    joint = sb.Cartesian("free", "ground", "Bead", coordinates=["x", "y", "z"])
    ways = [
        sb.PointOnCurve("c", "ground", "Bead", ["s", "s^2", 0], parameter="s"),
        sb.PointOnSurface("c", "ground", "Bead", ["y - x^2", "z"]),
        sb.Constraint("c", ["y - x^2", "z"]),
        sb.Constraint("c", ["y_dot - 2*x*x_dot", "z_dot"]),
    ]
    x, v, g = 0.6, -1.1, 9.81
    for way in ways:
        eqs = sb.form_equations(sb.Model("bead", [bead, joint, way], gravity=(0, -g, 0)))
        values = {
            "x": x,
            "y": x**2,
            "z": 0.0,
            "s": x,
            "x_dot": v,
            "y_dot": 2 * x * v,
            "z_dot": 0.0,
            "s_dot": v,
        }
        state = sb.assemble(eqs, {name: values[name] for name in (*eqs.coordinate_names, *eqs.speed_names)})
        expected = -(4 * x * v**2 + 2 * g * x) / (1 + 4 * x**2)
        assert state.udot["x_ddot"] == pytest.approx(expected, rel=1e-12), way
        assert eqs.degrees_of_freedom == 1


def test_equations_that_are_not_of_first_degree_in_speeds_are_refused() -> None:
    bead = sb.Body("Bead", mass=1)
    joint = sb.Cartesian("free", "ground", "Bead", coordinates=["x", "y", "z"])
    model = sb.Model("bead", [bead, joint, sb.Constraint("even", "x_dot^2 + y_dot^2 - 1")])
    with pytest.raises(sb.FormulationError) as caught:
        sb.form_equations(model)
    problem = caught.value.problems[0]
    assert problem.code == "equations.nonlinear_in_speeds"
    assert problem.where == "constraint even, equations[0]"
    assert "x_dot" in problem.what and "2*x_dot" in problem.why
