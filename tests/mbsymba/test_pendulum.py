"""The pendulum of section 4.10: Lagrange, first order, linear, state space, three motions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import sympy as sp
from sympy import cos, sin
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from tests.mbsymba.spots import all_same, same, t

theta, theta_dot = dynamicsymbols("theta theta_dot")
L, m, iz, g, theta0, dottheta0 = sp.symbols("L m iz g theta0 dottheta0")
DATA = {L: 1, m: sp.Rational(1, 10), iz: sp.Rational(8, 100), g: sp.Rational(981, 100)}


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -g, 0))
    yield
    mb.set_gravity(None)


def pendulum(*inertia: sp.Expr) -> mb.BODY:
    return mb.make_BODY(mb.make_POINT(mb.rotate("Z", theta), 0, -L, 0), m, *inertia)


def equations() -> mb.Equations:
    with pytest.warns(UserWarning, match="Izz"):  # the trap of the notes: iz goes to Iyy
        body = pendulum(0, iz)
    return mb.lagrange_equations({body}, [theta], t)


def first_order() -> tuple[list[sp.Expr], list[sp.Expr]]:
    return mb.first_order(equations(), [theta], t, "flag")


def test_equation_of_motion() -> None:
    (found,) = equations()
    assert same(found, m * L**2 * theta.diff(t, 2) + m * sin(theta) * L * g)
    (turning,) = mb.lagrange_equations([pendulum(0, 0, iz)], [theta], t)
    assert same(turning, (m * L**2 + iz) * theta.diff(t, 2) + m * sin(theta) * L * g)


def test_first_order() -> None:
    newvars, eqns = first_order()
    assert newvars == [theta, theta_dot]
    wanted = [m * L**2 * theta_dot.diff() + m * sin(theta) * L * g, theta.diff() - theta_dot]
    assert all_same(eqns, wanted)
    rest = [e.subs(theta_dot, 0).doit() for e in eqns]
    assert sp.solveset(rest[0].subs(theta, sp.Symbol("x")), sp.Symbol("x"), sp.Interval(-1, 4)) == {0, sp.pi}


def test_linear_equations() -> None:
    _, eqns = first_order()
    linear = mb.linearize(eqns, {theta: theta0, theta_dot: dottheta0})
    top = m * L**2 * theta_dot.diff() + m * sin(theta0) * L * g + m * cos(theta0) * (theta - theta0) * L * g
    assert all_same(linear, [top, theta.diff() - theta_dot])
    at_zero = linear[0].subs({**DATA, theta0: 0})
    assert same(at_zero, 0.1 * theta_dot.diff() + 0.981 * theta)
    at_pi = linear[0].subs({**DATA, theta0: sp.pi})
    assert same(at_pi, 0.1 * theta_dot.diff() + 0.981 * sp.pi - 0.981 * theta)
    assert float(0.981 * sp.pi) == pytest.approx(3.081902394, abs=1.1e-9)  # the notes round on the way


def test_state_space_and_eigenvalues() -> None:
    _, eqns = first_order()
    linear = mb.linearize(eqns, {theta: theta0, theta_dot: dottheta0})
    aa, bb, cc = mb.state_space(linear, t, [theta, theta_dot])
    assert all_same(aa, [0, m * L**2, 1, 0])
    assert all_same(bb, [-m * g * L * cos(theta0), 0, 0, 1])
    assert all_same(cc, [m * g * L * (sin(theta0) - theta0 * cos(theta0)), 0])
    # what the notes print with other signs: aa x' = bb x - cc
    x = sp.Matrix([theta, theta_dot])
    assert all_same(aa * x.diff(t) - bb * x + cc, linear)
    by_hand, rest = mb.GenerateMatrix(linear, mb.diff([theta, theta_dot], t))
    again, constant = mb.GenerateMatrix(list(rest), [theta, theta_dot])
    assert all_same([*by_hand, *again, *constant], [*aa, *bb, *cc])
    A = sp.simplify(aa.inv() * bb)
    assert A == sp.Matrix([[0, 1], [-cos(theta0) * g / L, 0]])
    down = [complex(e) for e in A.subs({**DATA, theta0: 0}).eigenvals()]
    up = sorted(float(e) for e in A.subs({**DATA, theta0: sp.pi}).eigenvals())
    assert sorted(e.imag for e in down) == pytest.approx([-3.132091953, 3.132091953], abs=5.1e-10)
    assert max(abs(e.real) for e in down) == 0 and up == pytest.approx(
        [-3.132091953, 3.132091953], abs=5.1e-10
    )


def test_a_stationary_motion_is_a_point_too() -> None:
    x, y = dynamicsymbols("x y")
    w, r = sp.symbols("w r")
    found = mb.linearize([y.diff() - x * y**2 + x.diff() ** 2], {x: r, y: w, x.diff(t): 2})
    assert same(found[0], y.diff() - r * w**2 + 4 - w**2 * (x - r) - 2 * r * w * (y - w) + 4 * (x.diff() - 2))


def test_motions() -> None:
    eqs = equations().equation_set
    numbers = {str(name): float(number) for name, number in DATA.items()}
    run = sb.simulate(
        eqs, 1.0, initial={"theta": 0.1, "theta_dot": 0.1}, parameters=numbers, rtol=1e-10, atol=1e-12
    )
    assert run.success
    found = [run["theta"][-1], run["theta_dot"][-1]]
    assert found == pytest.approx([-0.09962075, -0.10364098], abs=5.1e-9)
    w = np.sqrt(9.81)  # the linear equations in closed form
    linear = [0.1 * np.cos(w) + 0.1 / w * np.sin(w), 0.1 * np.cos(w) - 0.1 * w * np.sin(w)]
    assert linear == pytest.approx([-0.09969216, -0.10297115], abs=5.1e-9)
    away = 0.1 - np.pi
    runaway = [np.pi + away * np.cosh(w) + 0.1 / w * np.sinh(w), 0.1 * np.cosh(w) + away * w * np.sinh(w)]
    assert runaway == pytest.approx([-31.41904, -107.82711], abs=1.1e-5)  # cut, not rounded
    state = sb.linearize(eqs, at={"theta": 0.0}, parameters=numbers)
    assert sorted(state.eigenvalues.imag) == pytest.approx([-3.132091953, 3.132091953], abs=5.1e-10)


def test_energies() -> None:
    body = pendulum(0, 0, iz)
    assert same(mb.kinetic_energy(body), (m * L**2 + iz) * theta.diff() ** 2 / 2)
    assert same(mb.gravitational_energy({body}), -m * g * L * cos(theta))
    mb.set_gravity(None)
    assert mb.gravitational_energy([body]) == 0
