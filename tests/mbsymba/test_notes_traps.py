"""Where the notes mislead: the right result is computed, with a note where that can be detected."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from tests.mbsymba.spots import same, t

theta = dynamicsymbols("theta")
L, m, iz, g, theta0 = sp.symbols("L m iz g theta0")


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -g, 0))
    yield
    mb.set_gravity(None)


def test_linear_is_value_and_slope() -> None:
    """N-90: not ``f(x0) (x - x0)``."""
    (found,) = mb.linearize([sp.sin(theta)], {theta: theta0})
    assert same(found, sp.sin(theta0) + sp.cos(theta0) * (theta - theta0))
    assert not same(found, sp.sin(theta0) * (theta - theta0))


def test_the_fourth_argument_is_iyy() -> None:
    """N-91: kept as it is, with a warning that says what to write."""
    G1 = mb.make_POINT(mb.rotate("Z", theta), 0, -L, 0)
    with pytest.warns(UserWarning, match=r"write make_BODY\(G, m, 0, 0, Izz\)"):
        body = mb.make_BODY(G1, m, 0, iz)
    assert body.inertia == sp.diag(0, iz, 0) and not mb.kinetic_energy(body).has(iz)
    assert mb.kinetic_energy(mb.make_BODY(G1, m, 0, 0, iz)).has(iz)


def test_signs_of_the_state_space() -> None:
    """N-92: aa x' = bb x - cc; the sum printed in the notes does not vanish."""
    x, y = dynamicsymbols("x y")
    rows = [y.diff(t) + 3 * x - 2, x.diff(t) - y]
    aa, bb, cc = mb.state_space(rows, t, [x, y])
    z = sp.Matrix([x, y])
    assert sp.simplify(aa * z.diff(t) - bb * z + cc - sp.Matrix(rows)) == sp.zeros(2, 1)
    assert sp.simplify(aa * z.diff(t) + bb * z + cc - sp.Matrix(rows)) != sp.zeros(2, 1)


def test_imaginary_eigenvalues_are_marginal() -> None:
    """N-95: a pendulum that hangs is not called stable, one that stands is unstable."""
    pendulum = mb.make_BODY(mb.make_POINT(mb.rotate("Z", theta), 0, -L, 0), m)
    eqs = mb.equation_set([pendulum], [theta], parameters={"L": 1, "m": 0.1, "g": 9.81})
    assert [sb.linearize(eqs, at={"theta": at}).verdict for at in (0.0, "pi")] == ["marginal", "unstable"]
    assert sb.find_equilibrium(eqs, {"theta": 0.1}).stable is None


def test_multipliers_of_a_rod() -> None:
    """N-94: with the squared length the multiplier is no force, with the length it is."""
    x, y, pull = dynamicsymbols("x y pull")
    mb.set_gravity(None)
    body = mb.make_BODY(mb.translate(x, y, 0), m, 0, 0, 1)
    v = mb.join_points(mb.origin(mb.ground), mb.CoM(body))
    shapes = {
        "squared": mb.dot_prod(v, v) - L**2,
        "length": sp.sqrt(mb.dot_prod(v, v)) - L,
    }
    found = {}
    for name, Phi in shapes.items():
        (row, *_) = mb.lagrange_equations([body, mb.make_CONSTRAINT([Phi], [pull])], [x, y, pull], t)
        found[name] = -row.diff(pull)
    assert same(found["squared"], 2 * x) and same(found["length"], x / sp.sqrt(x**2 + y**2))


def test_a_revolute_reaction_without_its_other_body() -> None:
    """N-98: left out, B2 is ground, and the second body feels nothing."""
    s, beta, Rx, Ry = dynamicsymbols("s beta Rx Ry")
    mb.set_gravity(None)
    RF1 = mb.rotate("Z", theta)
    RF2 = RF1 * mb.translate(L, 0, 0) * mb.rotate("Z", beta)
    B1 = mb.make_BODY(mb.make_POINT(RF1, L / 2, 0, 0), m, 0, 0, iz)
    B2 = mb.make_BODY(mb.make_POINT(RF2, L / 2, 0, 0), m, 0, 0, iz)
    P1 = mb.origin(RF2)
    alone, mutual = (
        mb.make_FORCE(mb.ground, Rx, Ry, 0, P1, B1),
        mb.make_FORCE(mb.ground, Rx, Ry, 0, P1, B1, B2),
    )
    for force, felt in ((alone, 0), (mutual, 1)):
        second = mb.newton_equations([B2, force])
        assert same(mb.comp_X(second).diff(Rx), felt) and same(mb.comp_Y(second).diff(Ry), felt)
        both = mb.newton_equations([B1, B2, force])  # as a whole they feel a force from outside, or none
        assert same(mb.comp_X(both).diff(Rx), felt - 1)
