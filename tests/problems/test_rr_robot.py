"""RR robot: checklist D-40 .. D-46; closed forms as they stand in the checklist, without any simplification.

L3: joint 1 to centre of mass 1, L4: on to joint 2, L5: on to centre of mass 2, L6: on to the tip P.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs
from tests.problems.mechanisms import EXAMPLES, equations_of

T = dynamicsymbols._t
b1, b2, T1, T2 = dynamicsymbols("beta_1 beta_2 T1 T2")
m1, m2, I1, I2, L3, L4, L5, L6, G = sp.symbols("m1 m2 I1 I2 L3 L4 L5 L6 G")
ONES = dict.fromkeys((m1, m2, I1, I2, L3, L4, L5, L6), 1) | {G: 10}


def test_mass_matrix_by_parallel_axes() -> None:
    eqs = equations_of("rr_robot")
    M = eqs.mass_matrix
    assert M[1, 1] == I2 + m2 * L5**2
    assert M[0, 1] == M[1, 0] == I2 + m2 * L5 * (L5 + (L3 + L4) * sp.cos(b2))
    # L5 first: SymPy would take 2 (L3 + L4) apart.
    assert M[0, 0] == I1 + m1 * L3**2 + I2 + m2 * ((L3 + L4) ** 2 + L5**2 + 2 * L5 * (L3 + L4) * sp.cos(b2))
    # The checklist's M12, multiplied out.
    assert sp.expand(M[0, 1]) == sp.expand(I2 + m2 * (L5**2 + (L3 + L4) * L5 * sp.cos(b2)))


def test_right_hand_side_is_the_moment_about_each_joint() -> None:
    eqs = equations_of("rr_robot")
    F = eqs.forcing
    d1, d2 = b1.diff(T), b2.diff(T)
    swing = m2 * L5 * (L3 + L4) * sp.sin(b2)
    weight = G * m2 * L5 * sp.cos(b1 + b2)
    elbow = T2 - weight - swing * d1**2
    shoulder = T1 - G * (m1 * L3 + m2 * (L3 + L4)) * sp.cos(b1) - weight + swing * d2 * (2 * d1 + d2)
    assert sp.expand(F[1] - elbow) == 0
    assert sp.expand(F[0] - shoulder) == 0
    assert F.has(sp.cos(b1 + b2)) and not F.has(sp.sin(b1))


def test_equations_read_in_the_seeds_words() -> None:
    built = BuildEQs(EXAMPLES / "rr_robot" / "rr_robot.toml", [])
    first, second = built.GetDynEQs()
    assert sp.expand((built.xM * built.vPdot - built.vF)[0] - (first.lhs - first.rhs)) == 0
    assert sp.expand((built.xM * built.vPdot - built.vF)[1] - (second.lhs - second.rhs)) == 0


def test_position_of_the_tip() -> None:
    for tip in (
        equations_of("rr_robot").frame_motion("r", "P", "ground", "ground"),
        BuildEQs(EXAMPLES / "rr_robot" / "rr_robot.toml").GetFrameMotion("r", "P", "Ground", "Ground"),
    ):
        assert tip[0] == (L3 + L4) * sp.cos(b1) + (L5 + L6) * sp.cos(b1 + b2)
        assert tip[1] == (L3 + L4) * sp.sin(b1) + (L5 + L6) * sp.sin(b1 + b2)
        assert tip[2] == 0


def test_forward_kinematics() -> None:
    built = BuildEQs(EXAMPLES / "rr_robot" / "rr_robot.toml")
    angle = sp.pi * T**2
    path = built.GetFrameMotion("r", "P", subs={b1: angle, b2: angle}).subs(ONES)
    for time, point in ((0, (4, 0)), (sp.Rational(1, 2), (1.41421356, 3.41421356)), (1, (0, 0))):
        found = [float(value) for value in path.subs(T, time)]
        assert found[:2] == pytest.approx(point, abs=5e-9)
    # Spirals in: the distance from the first joint, sqrt(8 + 8 cos beta_2), never grows.
    x, y = sp.lambdify(T, path[0]), sp.lambdify(T, path[1])
    t = np.linspace(0, 1, 101)
    assert np.all(np.diff(np.hypot(x(t), y(t))) < 0)
    # The tip's velocity is the derivative of its path.
    speed = built.GetFrameMotion("v", "P", subs=[sp.Eq(b1, angle), sp.Eq(b2, angle)]).subs(ONES)
    assert float((speed - path.diff(T)).subs(T, sp.Rational(1, 3)).norm()) < 1e-14


def test_inverse_dynamics() -> None:
    angle = sp.pi * T**2
    equations = [
        equation.subs(ONES).subs({b1: angle, b2: angle}).doit()
        for equation in equations_of("rr_robot").dynamic_equations()
    ]
    found = sp.solve(equations, [T1, T2], dict=True)[0]
    expected = {
        0: (140.530965, 47.699112), 0.25: (135.580744, 47.659180), 0.5: (68.829169, 47.976235),
        0.75: (-90.293881, 57.002201), 1: (5.132741, 22.566371),
    }  # fmt: skip
    for time, torques in expected.items():
        values = [float(found[torque].subs(T, sp.Rational(time))) for torque in (T1, T2)]
        assert values == pytest.approx(torques, abs=6e-7)


def test_torques_from_the_compiled_equations() -> None:
    """The same at t = 1/2, from M u' - F at T1 = T2 = 0."""
    eqs = equations_of("rr_robot")
    q, u, acceleration = [np.pi / 4] * 2, [np.pi] * 2, [2 * np.pi] * 2
    M, F = sb.compile(eqs, ["mass_matrix", "forcing"])(0.0, q, u, [0, 0])
    assert M @ acceleration - F == pytest.approx([68.829169, 47.976235], abs=6e-7)


def test_inverse_kinematics() -> None:
    """Both elbows for a tip within reach, from the printed position."""
    tip = equations_of("rr_robot").frame_motion("r", "P").subs(ONES)
    x, y = 1.3, 2.1
    bend = np.arccos((x * x + y * y - 8) / 8)
    for elbow in (bend, -bend):
        shoulder = np.arctan2(y, x) - elbow / 2
        found = [float(value) for value in tip.subs({b1: shoulder, b2: elbow})]
        assert found[:2] == pytest.approx([x, y], abs=1e-14)


def test_forward_dynamics_undoes_inverse_dynamics() -> None:
    angle = sp.pi * T**2
    equations = [
        equation.subs(ONES).subs({b1: angle, b2: angle}).doit()
        for equation in equations_of("rr_robot").dynamic_equations()
    ]
    found = sp.solve(equations, [T1, T2], dict=True)[0]
    inputs = {"T1": str(found[T1]), "T2": str(found[T2])}
    run = sb.simulate(equations_of("rr_robot"), 1.0, inputs=inputs, times=[0, 0.5, 1], rtol=1e-11, atol=1e-13)
    # Global error of rtol 1e-11 in a chaotic but short motion.
    assert run["beta_1"] == pytest.approx([0, np.pi / 4, np.pi], abs=1e-8)
    assert run["beta_2"] == pytest.approx([0, np.pi / 4, np.pi], abs=1e-8)
