"""Projectile: checklist D-30 .. D-33; a planar joint, a free joint, no joint.

Reference values: ``X = v0 cos(pi/6) t``, ``Y = v0 sin(pi/6) t - G t^2/2``, ``theta = 10 t``.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs
from tests.problems.mechanisms import equations_of, model_of

T = dynamicsymbols._t
TIMES = [0, 0.25, 0.5, 1]
# The motion is a polynomial of degree 2 in t: the integrator commits rounding errors only.
EXACT = 1e-12


def test_three_equations() -> None:
    eqs = equations_of("projectile")
    X, Y, theta = dynamicsymbols("X Y theta")
    m, inertia, G = sp.symbols("m Inertia G")
    assert eqs.coordinates == (X, Y, theta) and eqs.speeds == (X.diff(T), Y.diff(T), theta.diff(T))
    assert eqs.dynamic_equations() == [
        sp.Eq(m * X.diff(T, 2), 0, evaluate=False),
        sp.Eq(m * Y.diff(T, 2), -m * G, evaluate=False),
        sp.Eq(inertia * theta.diff(T, 2), 0, evaluate=False),
    ]
    assert eqs.mass_matrix == sp.diag(m, m, inertia)
    assert eqs.degrees_of_freedom == 3 and eqs.constraints.rows == 0


def test_motion_in_the_plane() -> None:
    run = sb.simulate(equations_of("projectile"), 1.0, times=TIMES)
    assert run.success
    t = run.t
    assert run["X"] == pytest.approx(5 * np.sqrt(3) * t, abs=EXACT)
    assert run["Y"] == pytest.approx(5 * t - 5 * t**2, abs=EXACT)
    assert run["theta"] == pytest.approx(10 * t, abs=EXACT)
    assert run["X"][-1] == pytest.approx(8.660254, abs=1e-6)  # the printed digits
    assert run["Y"][2] == pytest.approx(1.25, abs=EXACT) and run["Y_dot"][2] == pytest.approx(0, abs=EXACT)
    assert run["theta_dot"] == pytest.approx(10, abs=EXACT)


def test_a_free_joint_gives_six_coordinates_and_the_same_motion() -> None:
    eqs = equations_of("projectile/projectile_free")
    assert eqs.coordinate_names == ("X", "Y", "Z", "phi", "chi", "theta") and eqs.degrees_of_freedom == 6
    plane = sb.simulate(equations_of("projectile"), 1.0, times=TIMES)
    space = sb.simulate(eqs, 1.0, times=TIMES)
    for name in ("X", "Y", "theta"):
        assert space[name] == pytest.approx(plane[name], abs=EXACT)
    for name in ("Z", "phi", "chi"):
        assert space[name] == pytest.approx(0, abs=EXACT)


def _without_joint() -> sb.Model:
    free = model_of("projectile/projectile_free")
    return sb.Model("alone", free.bodies, gravity=free.gravity, parameters=free.parameters)


def test_no_joint_gives_position_and_quaternion() -> None:
    eqs = sb.form_equations(_without_joint())
    assert eqs.coordinate_names == tuple(f"Body_{word}" for word in ("x", "y", "z", "qw", "qx", "qy", "qz"))
    assert eqs.speed_names == tuple(f"Body_{word}" for word in ("vx", "vy", "vz", "wx", "wy", "wz"))
    assert eqs.degrees_of_freedom == 6
    m, I1, I2, inertia = sp.symbols("m I1 I2 Inertia")
    assert eqs.mass_matrix == sp.diag(m, m, m, I1, I2, inertia)
    assert eqs.invariants == (sum(q**2 for q in eqs.coordinates[3:]),)
    assert any("Body" in note for note in eqs.notes)
    # At rest in no plane: the same accelerations as in the plane.
    udot = sb.compile(eqs, "udot")(0.0, [0, 0, 0, 1, 0, 0, 0], [8.0, 5.0, 0, 0, 0, 10.0])
    assert udot == pytest.approx([0, -10, 0, 0, 0, 0], abs=0)


def test_no_joint_in_dynaflexpro_gives_six_coordinates() -> None:
    built = BuildEQs(_without_joint())
    assert built.equations.coordinate_names == tuple(
        f"Body_{word}" for word in ("x", "y", "z", "alpha", "beta", "gamma")
    )
    assert built.equations.degrees_of_freedom == 6
    start = {"Body_x_dot": "10*cos(pi/6)", "Body_y_dot": "10*sin(pi/6)", "Body_gamma_dot": 10}
    run = sb.simulate(built.equations, 1.0, initial=start, times=TIMES)
    assert run["Body_y"] == pytest.approx(5 * run.t - 5 * run.t**2, abs=EXACT)
    assert run["Body_gamma"] == pytest.approx(10 * run.t, abs=EXACT)
