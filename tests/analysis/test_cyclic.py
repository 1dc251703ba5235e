"""Cyclic coordinates: nothing may depend on them, anywhere along the motion that changes them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.problems.mechanisms import equations_of
from tests.problems.test_bicycle import CYCLIC, UPRIGHT


@cache
def rotor_and_slider(force: str = "0", torque: str = "0") -> sb.EquationSet:
    """A rotor beside a mass of 1 kg on a slide; what couples them is given in x, x_dot, phi, phi_dot."""
    rotor, mass = sb.Body("Rotor", mass=1, inertia=(1, 1, 1)), sb.Body("Mass", mass=1)
    return sb.form_equations(sb.Model("rotor and slider", [
        rotor, mass,
        sb.Revolute("axle", "ground", "Rotor", axis="z", coordinate="phi", torque=sb.Drive(applied=torque)),
        sb.Prismatic("slide", "ground", "Mass", axis="x", coordinate="x", force=sb.Drive(applied=force)),
    ], gravity=(0, 0, 0), inputs=["F"]))  # fmt: skip


SPINNING = {"phi": 0, "x": 0, "phi_dot": 2, "x_dot": 0}


def test_a_stiffness_that_changes_with_the_angle_is_seen() -> None:
    """x'' + 4 (1 + 0.2 cos 2 phi) x = 0 with phi = 2 t: Mathieu's equation at its first resonance.

    With z = 2 t it reads x_zz + (1 + 0.2 cos 2 z) x = 0, a = 1, q = -0.1, inside the first tongue a = 1 +- |q|
    (McLachlan, Theory and Application of Mathieu Functions): x grows as exp(|q| z / 2) = exp(0.1 t).
    At x = 0 the force has no derivative by phi, whatever phi is.
    """
    eqs = rotor_and_slider("-4*(1 + 0.2*cos(2*phi))*x")
    with pytest.raises(sb.AssemblyError, match=r"phi is not cyclic: the rate of x_dot") as caught:
        sb.linearize(eqs, SPINNING, cyclic=["phi"])
    assert caught.value.problems[0].code == "linearize.not_cyclic"
    run = sb.simulate(eqs, 40.0, SPINNING | {"x": 1e-6}, rtol=1e-10, atol=1e-16)
    energy = run["x"] ** 2 + (run["x_dot"] / 2) ** 2
    growth = np.log(energy[-1] / energy[0]) / 2 / 40
    # The decaying solution and the change within a period are left after 40 s: less than log(4) / 2 / 40.
    assert growth == pytest.approx(0.1, abs=math.log(4) / 80)


@pytest.mark.parametrize(
    ("force", "torque"),
    [
        ("0", "-phi**3"),  # of third order at phi = 0
        ("0", "if(phi > 2 and phi < 2.2, 1, 0)"),  # elsewhere alone, for less than a step
        ("0", "1e-10*sin(phi)**3"),
        ("if(phi < 3, 0, -x)", "0"),
        ("0", "floor(phi)"),
        ("F*cos(phi)", "0"),
    ],
)
@pytest.mark.parametrize("spin", [0.0, 2.0])
def test_what_depends_on_the_angle_elsewhere_is_seen(force: str, torque: str, spin: float) -> None:
    with pytest.raises(sb.AssemblyError, match="phi is not cyclic"):
        sb.linearize(rotor_and_slider(force, torque), SPINNING | {"phi_dot": spin}, cyclic=["phi"])


@pytest.mark.parametrize(
    ("force", "torque"),
    [
        ("-4*x", "-0.1*phi_dot"),
        ("-(sin(phi)**2 + cos(phi)**2)*x", "0"),
        ("-4*x*phi_dot**2 + F", "x_dot*phi_dot"),
        ("-cos(phi + x)*cos(phi) - sin(phi + x)*sin(phi)", "0"),
    ],
)
def test_what_cancels_identically_is_cyclic(force: str, torque: str) -> None:
    lin = sb.linearize(rotor_and_slider(force, torque), SPINNING, cyclic=["phi"], outputs="x_ddot")
    assert lin.state_names == ("phi_dot", "x_dot", "x")
    assert not any("can be cyclic" in note for note in lin.notes)


def test_outputs_may_not_change_with_the_angle() -> None:
    """cos(phi) has no derivative at phi = 0, and one further on."""
    with pytest.raises(sb.AssemblyError, match="phi is not cyclic"):
        sb.linearize(rotor_and_slider(), SPINNING, cyclic=["phi"], outputs="cos(phi)")


@pytest.mark.parametrize("yaw", [0.3, 2.5])
def test_a_bicycle_at_rest_may_stand_anywhere(yaw: float) -> None:
    """Rates of a bicycle at rest hold rounding of 1e-31 alone in rows and columns that vanish."""
    eqs = equations_of("bicycle")
    place = {"x": 1.7, "y": -0.4, "yaw": yaw, "rear": 0.3, "front": 5.1}
    lin = sb.linearize(eqs, UPRIGHT | place | {"rear_dot": 0.0}, cyclic=CYCLIC)
    assert lin.is_stationary and lin.verdict == "unstable"
    # Meijaard et al. 2007, table 2: at v = 0 the bicycle falls as two inverted pendulums.
    growing = sorted(mode.eigenvalue.real for mode in lin.modes if mode.eigenvalue.real > 1e-6)
    assert growing == pytest.approx([3.13164324790656, 5.53094371765393], rel=1e-9)


def test_a_yaw_that_shows_by_elimination_alone_is_noted() -> None:
    lin = sb.linearize(equations_of("bicycle"), UPRIGHT | {"rear_dot": 5 / 0.3}, cyclic=CYCLIC)
    assert [
        note
        for note in lin.notes
        if note.startswith("yaw can be cyclic: nothing else changes at 60 positions")
    ]


@cache
def ball_top(speeds: str, inertia: tuple[float, float, float] = (1, 1, 1)) -> sb.EquationSet:
    """A top of 1 kg on a default ball joint, 1 m below its centre of mass."""
    top = sb.Body("Top", mass=1, inertia=inertia, frames={"o": sb.Frame(at=(0, 0, -1))})
    pivot = sb.Spherical("pivot", "ground", "Top.o", speeds=speeds)
    return sb.form_equations(sb.Model("ball top", [top, pivot], gravity=(0, 0, -9.8)))


@pytest.mark.parametrize("named", [(), ("pivot_rz",)])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_top_on_a_ball_joint_needs_spin(share: float, named: tuple[str, ...]) -> None:
    """Upright it is stable from C w = 2 sqrt(A m g L), with A = 2 about the fixed point and C = 1.

    In axes that do not spin A x'' + C w y' = m g L x, A y'' - C w x' = m g L y; with z = x + i y
    s = i (C w +- sqrt((C w)^2 - 4 A m g L)) / 2 A, in axes that spin with w less by i w.
    """
    spin = share * 2 * math.sqrt(2 * 9.8)
    lin = sb.linearize(ball_top("end"), {"pivot_wz": spin}, cyclic=named)
    assert lin.is_stationary == bool(named)
    assert lin.verdict == ("unstable" if share < 1 else "marginal" if named else "drifting")
    root = np.sqrt(complex(spin**2 - 4 * 2 * 9.8))
    wanted = [1j * (spin + sign * root) / 4 - 1j * spin for sign in (1, -1)]
    for value in (*wanted, *np.conj(wanted)):
        assert np.abs(lin.eigenvalues - value).min() < 1e-9


def test_speeds_in_axes_that_do_not_turn_with_deviations_are_refused() -> None:
    """Angular velocities in start axes beside deviations in end axes: their equations change as the top turns."""
    with pytest.raises(sb.AssemblyError, match="speeds='end'"):
        sb.linearize(ball_top("start"), {"pivot_wz": 8.0}, cyclic=["pivot_rz"])
    assert sb.linearize(ball_top("start"), {}, cyclic=["pivot_rz"]).is_stationary


def test_a_spinning_body_turns_the_axes_of_its_deviations() -> None:
    """r' = d omega - Omega x r: at 2 rad/s about z a deviation about x goes to -2 about y per second."""
    for joint in (sb.Free("base", "ground", "Body"), sb.Spherical("base", "ground", "Body")):
        body = sb.Body("Body", mass=1, inertia=(1, 2, 2.5))
        eqs = sb.form_equations(sb.Model("body", [body, joint]))
        lin = sb.linearize(eqs, {"base_wz": 2.0})
        rows = [lin.state_names.index(f"base_r{axis}") for axis in "xyz"]
        wanted = [[0, 2, 0], [-2, 0, 0], [0, 0, 0]]
        np.testing.assert_allclose(lin.A[np.ix_(rows, rows)], wanted, rtol=0, atol=1e-14)
