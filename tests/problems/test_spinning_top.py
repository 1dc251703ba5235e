"""Spinning top: checklist D-50 .. D-55, in rates of Euler angles and in the angular velocity.

Reference values of the simulation: closed-form integrals of the symmetric top (Goldstein, section 5.7).
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs
from symbody.formats.native import from_data
from tests.problems.mechanisms import EXAMPLES, data_of, equations_of, model_of

T = dynamicsymbols._t
zeta, eta, xi = dynamicsymbols("zeta eta xi")
m, L, A, C, G = sp.symbols("m L A C G")
FILES = ("spinning_top", "spinning_top_omega")


def test_mass_matrix_in_euler_rates() -> None:
    M = equations_of("spinning_top").mass_matrix
    assert M == sp.Matrix(
        [
            [A * sp.sin(eta) ** 2 + C * sp.cos(eta) ** 2, 0, C * sp.cos(eta)],
            [0, A, 0],
            [C * sp.cos(eta), 0, C],
        ]
    )


def test_gravity_acts_on_the_nutation_alone() -> None:
    eqs = equations_of("spinning_top")
    at_rest = {speed: 0 for speed in eqs.speeds}
    assert eqs.forcing.subs(at_rest) == sp.Matrix([0, m * G * L * sp.sin(eta), 0])
    assert eqs.potential_energy == m * G * L * sp.cos(eta)


def test_equations_by_lagrange() -> None:
    """The three equations from the two energies, by SymPy's own differentiation."""
    eqs = equations_of("spinning_top")
    dz, de, dx = (angle.diff(T) for angle in (zeta, eta, xi))
    kinetic = (A * (de**2 + dz**2 * sp.sin(eta) ** 2) + C * (dx + dz * sp.cos(eta)) ** 2) / 2
    lagrangian = kinetic - m * G * L * sp.cos(eta)
    for equation, angle in zip(eqs.dynamic_equations(), (zeta, eta, xi), strict=True):
        lagrange = lagrangian.diff(angle.diff(T)).diff(T) - lagrangian.diff(angle)
        difference = (lagrange - equation.lhs + equation.rhs).subs(
            sp.sin(2 * eta), 2 * sp.sin(eta) * sp.cos(eta)
        )
        assert sp.expand(difference) == 0


def test_inertia_about_the_centre_of_mass_reads_naturally_too() -> None:
    """A given about the centre of mass: A + m L^2 takes the place of A."""
    data = data_of("spinning_top")
    data["body"][0]["inertia"] = ["A", "A", "C"]
    M = sb.form_equations(from_data(data)).mass_matrix
    whole = A + m * L**2
    assert M[1, 1] == whole and M[2, 2] == C and M[0, 2] == C * sp.cos(eta)
    assert M[0, 0] == whole * sp.sin(eta) ** 2 + C * sp.cos(eta) ** 2


def test_angular_velocity_in_the_top_makes_the_mass_matrix_constant() -> None:
    eqs = equations_of("spinning_top_omega")
    wx, wy, wz = dynamicsymbols("omega_x omega_y omega_z")
    assert eqs.speeds == (wx, wy, wz) and eqs.coordinates == (zeta, eta, xi)
    assert eqs.mass_matrix == sp.diag(A, A, C)
    assert eqs.forcing == sp.Matrix(
        [
            wy * wz * (A - C) + m * G * L * sp.sin(eta) * sp.cos(xi),
            -wx * wz * (A - C) - m * G * L * sp.sin(eta) * sp.sin(xi),
            0,
        ]
    )


def test_angle_rates_from_the_angular_velocity() -> None:
    built = BuildEQs(EXAMPLES / "spinning_top_omega" / "spinning_top_omega.toml")
    wx, wy, wz = built.vP
    across = wx * sp.sin(xi) + wy * sp.cos(xi)
    expected = [
        across / sp.sin(eta),
        wx * sp.cos(xi) - wy * sp.sin(xi),
        wz - across * sp.cos(eta) / sp.sin(eta),
    ]
    assert [equation.lhs for equation in built.GetKinTrans()] == list(built.vQdot)
    assert [equation.rhs for equation in built.GetKinTrans()] == expected == list(built.vKinTransRHS)
    ((joint, singular),) = built.GetKinTransSingularities().items()
    assert joint == "pivot" and singular in (sp.sin(eta), -sp.sin(eta))
    assert any("sin(eta)" in note for note in built.notes)


def test_resolved_in_the_start_frame_too() -> None:
    """Other speeds, other mass matrix, the same motion of the top."""
    data = data_of("spinning_top_omega")
    data["joint"][0]["speeds"] = "start"
    data.pop("initial")
    space, body = sb.form_equations(from_data(data)), equations_of("spinning_top_omega")
    q, omega = [0.4, 1.1, -0.7], np.array([0.9, -1.3, 2.2])
    (R,) = (sb.compile(body, "frame R Top ground")(0.0, q, omega),)
    for output in ("qdot", "frame wdot Top ground ground", "reaction pivot", "kinetic_energy"):
        there = sb.compile(space, output)(0.0, q, R @ omega)
        # A handful of operations on numbers of order 10.
        assert there == pytest.approx(sb.compile(body, output)(0.0, q, omega), abs=1e-13)


@pytest.mark.parametrize("name", FILES)
def test_cuspidal_motion(name: str) -> None:
    run = sb.simulate(equations_of(name), 10.0, times=[0, 5, 10], rtol=1e-12, atol=1e-13)
    assert run.success
    # Printed digits: 6 decimals of a degree, 8 of a metre. rtol 1e-12 keeps the global error below 1e-9.
    # 0.2377754006 is of a Taylor series in 25 digits.
    assert np.degrees(run["eta"]) == pytest.approx([90, 106.323844, 101.361144], abs=6e-7)
    assert run["zeta"][-1] == pytest.approx(9.38110645, abs=6e-9)
    centre = run["frame r Top.CoM ground ground"]
    assert centre[:, 1] == pytest.approx([-0.92976594, 0.2377754006, -0.28106611], abs=6e-9)
    assert centre[:, 2] == pytest.approx([0.04280216, 0.97947023, -0.19699251], abs=6e-9)
    assert run["energy"] == pytest.approx(50, abs=1e-9)


@pytest.mark.parametrize("name", FILES)
def test_nutation_stays_between_its_bounds(name: str) -> None:
    run = sb.simulate(equations_of(name), 10.0, times=np.linspace(0, 10, 20001), rtol=1e-11, atol=1e-12)
    degrees = np.degrees(run["eta"])
    lowest = np.degrees(np.arccos((25 - np.sqrt(625 + 4 * 9.8**2)) / 19.6))
    assert lowest == pytest.approx(110.198237, abs=5e-7)
    # A maximum is missed by at most eta'' h^2 / 8 with eta'' < 10, h = 5e-4: 2e-5 degrees.
    assert degrees.min() == pytest.approx(90, abs=1e-6) and degrees.max() == pytest.approx(lowest, abs=2e-5)
    inner = (degrees[1:-1] > degrees[:-2]) & (degrees[1:-1] >= degrees[2:])
    tops = run.t[1:-1][inner]
    # Each maximum is found to within one sample.
    assert np.diff(tops).mean() == pytest.approx(1.14639, abs=2 * 5e-4 / len(tops) + 1e-5)
    # Cusps: at the upper bound the precession stands still.
    assert np.abs(run["zeta_dot"]).min() == pytest.approx(0, abs=1e-6)


def test_speeds_first_in_the_state() -> None:
    model = model_of("spinning_top")
    assert sb.form_equations(model).state_names == ("zeta_dot", "eta_dot", "xi_dot", "zeta", "eta", "xi")
