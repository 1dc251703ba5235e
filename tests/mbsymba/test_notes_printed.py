"""What the notes print, line by line: chapters 1 and 2 at 20 points each, and the small formulas of chapter 4."""

from __future__ import annotations

import sympy as sp
from sympy import cos, sin
from sympy.physics.vector import dynamicsymbols

from symbody import mbsymba as mb
from tests.mbsymba.spots import all_same, same, t

x10, y10, th1, x20, y20, th2, x30, y30, th3, x40, y40, th4, s = dynamicsymbols(
    "x10 y10 theta1 x20 y20 theta2 x30 y30 theta3 x40 y40 theta4 s"
)
beta1, beta2, L = sp.symbols("beta1 beta2 L")
RF1, RF2, RF3, RF4 = (
    mb.translate(x, y, 0) * mb.rotate("Z", angle)
    for x, y, angle in ((x10, y10, th1), (x20, y20, th2), (x30, y30, th3), (x40, y40, th4))
)
VEC1 = [
    -1 + (0.5 * cos(th2) - 0.5 * sin(th2) + x20 - x10) * cos(th1)
    + (0.5 * sin(th2) + 0.5 * cos(th2) + y20 - y10) * sin(th1),
    -1 + (0.5 * sin(th2) + 0.5 * cos(th2) + y20 - y10) * cos(th1)
    + (-0.5 * cos(th2) + 0.5 * sin(th2) - x20 + x10) * sin(th1),
    0,
]  # fmt: skip
VEC2 = [
    (-2 * sin(th2) - x10 + x20 + 3 * cos(th2)) * cos(th1)
    + 3 * sin(th1) * (sin(th2) - y10 / 3 + y20 / 3 + 2 * cos(th2) / 3),
    (3 * sin(th2) - y10 + y20 + 2 * cos(th2)) * cos(th1)
    + 2 * sin(th1) * (sin(th2) + x10 / 2 - x20 / 2 - 3 * cos(th2) / 2),
    0,
]


def test_joined_points() -> None:
    """N-10, N-11: (1.4.1.1) to (1.4.2.1)."""
    vec1 = mb.join_points(mb.make_POINT(RF1, 1, 1, 0), mb.make_POINT(RF2, 0.5, 0.5, 0))
    vec2 = mb.join_points(mb.make_POINT(RF1, 0, 0, 0), mb.make_POINT(RF2, 3, 2, 0))
    assert vec1.obj == vec2.obj == "VECTOR" and vec1.frame == vec2.frame == RF1
    assert vec1.comps[3] == vec2.comps[3] == 0
    assert all_same(mb.comp_XYZ(vec1), VEC1) and all_same(mb.comp_XYZ(vec2), VEC2)
    assert same(mb.comp_X(vec1), VEC1[0])
    assert same(mb.dot_prod(vec1, vec2), VEC1[0] * VEC2[0] + VEC1[1] * VEC2[1])
    across = [0, 0, VEC1[0] * VEC2[1] - VEC1[1] * VEC2[0]]
    assert all_same(mb.comp_XYZ(mb.cross_prod(vec1, vec2)), across)


def test_constraints_as_lists_and_all_of_them() -> None:
    """N-20 to N-24: (2.1.1.1) to (2.1.3.2), (2.1.5.1), (2.1.1) and (2.1.2)."""
    vec1 = mb.project(mb.join_points(mb.make_POINT(RF1, -1, 0, 0), mb.make_POINT(RF2, 1, 0, 0)), mb.ground)
    revolute = [mb.comp_X(vec1), mb.comp_Y(vec1)]
    RF2aux, RF3aux = RF2 * mb.rotate("Z", beta1), RF3 * mb.rotate("Z", beta2)
    along = mb.join_points(mb.origin(RF2aux), mb.origin(RF3aux))
    prismatic = [mb.dot_prod(mb.uvec_Y(RF2aux), mb.uvec_X(RF3aux)), mb.dot_prod(mb.uvec_Y(RF2aux), along)]
    v45 = mb.project(mb.join_points(mb.make_POINT(RF3, 1, 0, 0), mb.make_POINT(RF4, 2, 3, 0)), mb.ground)
    rod = [mb.dot_prod(v45, v45) - L**2]
    between = [
        2 * cos(th4) - 3 * sin(th4) + x40 - x30 - cos(th3),
        3 * cos(th4) + 2 * sin(th4) + y40 - y30 - sin(th3),
    ]
    assert v45.frame == mb.ground and all_same(mb.comp_XYZ(v45), [*between, 0])
    Phi = revolute + prismatic + rod
    assert len(Phi) == 5
    printed = [
        cos(th2) + x20 - x10 + cos(th1),
        sin(th2) + y20 - y10 + sin(th1),
        (-cos(th2) * sin(beta1) - sin(th2) * cos(beta1)) * (cos(th3) * cos(beta2) - sin(th3) * sin(beta2))
        + (cos(th2) * cos(beta1) - sin(th2) * sin(beta1)) * (sin(th3) * cos(beta2) + cos(th3) * sin(beta2)),
        ((-y20 + y30) * cos(beta1) + sin(beta1) * (x20 - x30)) * cos(th2)
        + sin(th2) * ((x20 - x30) * cos(beta1) + sin(beta1) * (y20 - y30)),
        between[0] ** 2 + between[1] ** 2 - L**2,
    ]
    assert all_same(Phi, printed)
    ux, uy, x1, y1 = dynamicsymbols("u1_x u1_y x1 y1")
    natural = sp.Matrix([[ux, -uy, 0, x1], [uy, ux, 0, y1], [0, 0, 1, 0], [0, 0, 0, 1]])
    first = mb.project(mb.uvec_X(natural), mb.ground)
    assert same(mb.dot_prod(first, first) - 1, ux**2 + uy**2 - 1)


def test_a_spring_and_a_damper() -> None:
    """N-41, N-42: a force by components or as a vector; s is the elongation, the spring pulls it back."""
    Ls0, Ks, Cs, m = sp.symbols("Ls0 Ks Cs m")
    body = mb.make_BODY(mb.translate(Ls0 + s, 0, 0), m, 0, 0, 1)
    PC = mb.make_POINT(mb.ground, Ls0 + s, 0, 0)
    pull = -s * Ks - Cs * s.diff(t)
    by_components = mb.make_FORCE(mb.ground, pull, 0, 0, PC, body)
    by_vector = mb.make_FORCE(mb.make_VECTOR(mb.ground, pull, 0, 0), PC, body)
    for force in (by_components, by_vector):
        (row,) = mb.lagrange_equations([body, force], [s], t)
        assert same(row, m * s.diff(t, 2) + Ks * s + Cs * s.diff(t))
    twist = mb.make_TORQUE(mb.ground, 0, 0, L, body)
    assert same(mb.comp_Z(mb.euler_equations([body, twist], body)), -L)


def test_equations_of_index_three() -> None:
    """N-45, step 6: velocities as variables, M^-1 (V R + Fe) - v' with x' - v, and the constraints."""
    theta, rx, ry = dynamicsymbols("theta rx ry")
    m, J, g = sp.symbols("m J g")
    RF = mb.translate(x10, y10, 0) * mb.rotate("Z", theta)
    body = mb.make_BODY(RF, m, 0, 0, J)
    pin = mb.make_POINT(RF, 0, L, 0)
    forces = [
        mb.make_FORCE(mb.ground, 0, -m * g, 0, body, body),
        mb.make_FORCE(mb.ground, rx, ry, 0, pin, body),
    ]
    newton, euler = mb.newton_equations([body, *forces]), mb.euler_equations([body, *forces], mb.origin(RF))
    q, R = [x10, y10, theta], [rx, ry]
    eq = [mb.comp_X(newton), mb.comp_Y(newton), mb.comp_Z(euler)]
    M, a = mb.GenerateMatrix(eq, mb.diff(q, t, t))
    V, rest = mb.GenerateMatrix(list(a), R)
    v = list(dynamicsymbols("v1:4"))
    # GenerateMatrix gives A x = b: M q'' = a, and a = V R - rest, so that Fe of the notes is -rest.
    first = [rate - x.diff(t) for rate, x in zip(v, q, strict=True)]
    second = list(M.inv() * (V * sp.Matrix(R) - rest) - sp.Matrix(v).diff(t))
    at = mb.project(pin, mb.ground)
    complete = first + second + [mb.comp_X(at), mb.comp_Y(at)]
    assert len(complete) == len(v + q + R)
    arm = [-L * sin(theta), L * cos(theta)]
    wanted = [rx / m, ry / m - g, (arm[0] * ry - arm[1] * rx) / J]
    assert all_same(second, [w - x.diff(t) for w, x in zip(wanted, v, strict=True)])
    # The same by first_order, which calls the velocities x10_dot and has motion first, then -x_dot + x'.
    newvars, eq_first = mb.first_order(eq, q)
    dots = list(dynamicsymbols("x10_dot y10_dot theta_dot"))
    assert newvars == [*q, *dots]
    assert all_same(eq_first[3:], [x.diff(t) - dot for x, dot in zip(q, dots, strict=True)])
    masses = zip((m, m, J), dots, wanted, strict=True)
    assert all_same(eq_first[:3], [mass * (dot.diff(t) - w) for mass, dot, w in masses])


def test_analytic_solution_of_the_linear_equation() -> None:
    """N-50: dsolve of what `linearize` leaves, from (4.10.6), is the oscillation of the hanging pendulum."""
    theta = dynamicsymbols("theta")
    g, m = sp.symbols("g m", positive=True)
    length = sp.Symbol("L", positive=True)
    linear = m * length**2 * theta.diff(t, 2) + m * g * length * theta
    found = sp.dsolve(linear, theta, ics={theta.subs(t, 0): 0.1, theta.diff(t).subs(t, 0): 0.1}).rhs
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -g, 0))
    try:
        bob = mb.make_BODY(mb.make_POINT(mb.rotate("Z", theta), 0, -length, 0), m)
        (row,) = mb.linearize(mb.lagrange_equations([bob], [theta], t), {theta: 0})
    finally:
        mb.set_gravity(None)
    # Symbols are symbols by name: ours have no assumptions.
    plain = {symbol: sp.Symbol(symbol.name) for symbol in (g, m, length)}
    assert same(row.xreplace(plain), linear.xreplace(plain))
    end = found.subs({g: 9.81, length: 1}).subs(t, 1)
    assert abs(float(end) + 0.09969216) < 5.1e-9


def test_small_deviations_as_variables() -> None:
    """N-57: x = x0 + delta leaves no constant at an equilibrium, and the matrices of `state_space`."""
    theta, omega, d, e = dynamicsymbols("theta omega d e")
    k = sp.Symbol("k")
    rows = [omega.diff(t) + k * sin(theta), theta.diff(t) - omega]
    linear = mb.linearize(rows, {theta: sp.pi, omega: 0})
    aa, bb, cc = mb.state_space(linear, t, [theta, omega])
    small = [row.subs({theta: sp.pi + d, omega: e}).doit() for row in linear]
    assert all_same(small, [e.diff(t) - k * d, d.diff(t) - e])
    found = mb.state_space(small, t, [d, e])
    assert found[0] == aa and all_same(found[1], bb) and list(found[2]) == [0, 0]
    assert same(cc[0], k * sp.pi)
